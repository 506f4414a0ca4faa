//! The triangles of a primitive (glTF 2.0, section 3.7.2).

use super::container::Container;
use super::document::{MEND, Primitive};
use super::texture_transform::TextureTransform;
use super::{accessor, document};
use crate::error::{Fault, room};
use snowgrain_geometry::{GeometryError, TriangleMesh};

/// How the corners of a primitive join.
#[derive(Clone, Copy)]
enum Mode {
    Triangles,
    Strip,
    Fan,
}

/// Texture coordinates: an accessor, and what is done to them.
#[derive(Clone, Copy)]
pub(super) struct Coordinates {
    pub(super) accessor: usize,
    pub(super) transform: TextureTransform,
}

/// The primitive's mesh in its own space, metres; `None` for points and lines, and where no triangle
/// has an area, with these texture coordinates. `owner` is how messages call it.
pub(super) fn mesh(
    container: &Container,
    primitive: &Primitive,
    coordinates: Option<Coordinates>,
    owner: &str,
) -> Result<Option<TriangleMesh>, Fault> {
    let mode = match primitive.mode {
        0..=3 => return Ok(None),
        4 => Mode::Triangles,
        5 => Mode::Strip,
        6 => Mode::Fan,
        other => return Err(Fault::whole(format!("{owner} has the unknown mode {other}"), MEND)),
    };
    let Some(position) = primitive.attributes.position else {
        return Err(Fault::whole(format!("{owner} has no POSITION"), MEND));
    };
    let positions = accessor::positions(container, position, owner)?;
    let vertices = positions.len();
    let corners = match primitive.indices {
        Some(index) => accessor::indices(container, index, owner)?,
        None => {
            let count = u32::try_from(positions.len())
                .map_err(|_| Fault::TooLarge(format!("{owner} with 2^32 vertices")))?;
            let mut corners = room(positions.len(), "corners")?;
            corners.extend(0..count);
            corners
        }
    };
    let triangles = triangles(mode, &corners)?;
    // Triangles of vertices that are not there are refused with the mesh.
    let in_range = |t: &[u32; 3]| t.iter().all(|&vertex| (vertex as usize) < vertices);
    let mut of_corners = Vec::new();
    if let Some(coordinates) = coordinates.filter(|_| triangles.iter().all(in_range)) {
        let Coordinates { accessor, transform } = coordinates;
        let places = accessor::places(container, accessor, &transform, owner)?;
        if places.len() != vertices {
            let what = format!("{owner} has {} TEXCOORD of {vertices} vertices", places.len());
            return Err(Fault::whole(what, MEND));
        }
        of_corners = room(triangles.len(), "texture coordinates")?;
        of_corners.extend(triangles.iter().map(|t| t.map(|vertex| places[vertex as usize])));
    }
    match TriangleMesh::with_coordinates(positions, triangles, of_corners) {
        Ok(mesh) => Ok(Some(mesh)),
        Err(GeometryError::EmptyMesh) => Ok(None),
        Err(error) => Err(Fault::whole(format!("{owner}: {error}"), document::MEND)),
    }
}

/// Corners left over at the end are passed over, as the specification says.
fn triangles(mode: Mode, corners: &[u32]) -> Result<Vec<[u32; 3]>, Fault> {
    let count = match mode {
        Mode::Triangles => corners.len() / 3,
        Mode::Strip | Mode::Fan => corners.len().saturating_sub(2),
    };
    let mut triangles = room(count, "triangles")?;
    match mode {
        Mode::Triangles => triangles.extend(corners.chunks_exact(3).map(|c| [c[0], c[1], c[2]])),
        // Every other triangle of a strip is turned over, so that all face the same way.
        Mode::Strip => triangles.extend(
            corners
                .windows(3)
                .enumerate()
                .map(|(i, c)| if i % 2 == 0 { [c[0], c[1], c[2]] } else { [c[0], c[2], c[1]] }),
        ),
        Mode::Fan => triangles.extend(
            corners.get(1..).unwrap_or_default().windows(2).map(|c| [corners[0], c[0], c[1]]),
        ),
    }
    Ok(triangles)
}
