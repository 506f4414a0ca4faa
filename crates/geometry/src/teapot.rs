//! Newell's teapot.

use crate::TriangleMesh;

/// Newell's teapot as triangles, each of its 32 Bezier patches diced into `divisions` x `divisions`
/// quads; in his units, turned y up and standing on y = 0.
#[must_use]
pub fn teapot(_divisions: u32) -> TriangleMesh {
    todo!()
}
