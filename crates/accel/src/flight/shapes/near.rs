//! Which grains of a block a ray may meet, or may hold a point: by their bounding spheres, SIMD over the grains.

use crate::grain_grid::{Block, GRAINS_PER_BLOCK, RADIUS_MASK};
use crate::words::floats;
use fearless_simd::prelude::*;
use fearless_simd::{f32x16, mask32x16, u16x16};

/// The centre of no grain.
pub(super) const NOWHERE: [f32; 3] = [-1.0; 3];

/// How far, quanta, single precision may move the end of a chord of a sphere that is 2 quanta larger than a body
/// that the line meets: so near to the rim, 5e-2 across the line are less than 4 along it.
pub(super) const TOLERANCE: f32 = 8.0;

/// From a point (cell quanta) to the centres of the spheres of a block, and their squared radii; and which have another
/// centre than `but`.
struct Around<S: Simd> {
    x: f32x16<S>,
    y: f32x16<S>,
    z: f32x16<S>,
    radius2: f32x16<S>,
    others: mask32x16<S>,
}

impl<S: Simd> Around<S> {
    #[inline(always)]
    fn new(simd: S, block: &Block, position: [f32; 3], but: [f32; 3]) -> Self {
        let splat = |x: f32| f32x16::splat(simd, x);
        let center =
            |words: &[u16; GRAINS_PER_BLOCK]| floats(simd, u16x16::from_slice(simd, words));
        let (x, y, z) = (center(&block.x), center(&block.y), center(&block.z));
        let is_itself =
            x.simd_eq(splat(but[0])) & y.simd_eq(splat(but[1])) & z.simd_eq(splat(but[2]));
        let bits = u16x16::from_slice(simd, &block.radius) & u16x16::splat(simd, RADIUS_MASK);
        let radius = floats(simd, bits);
        Self {
            x: x - splat(position[0]),
            y: y - splat(position[1]),
            z: z - splat(position[2]),
            radius2: radius * radius,
            others: !is_itself,
        }
    }
}

/// The part of a stretch that lies in a cell, from where it is told.
#[derive(Clone, Copy, Debug)]
pub(super) struct Window {
    /// Whether the stretch begins there: then spheres count that hold its beginning, else those alone that it enters in the cell.
    pub(super) begins: bool,
    /// Where it ends, quanta.
    pub(super) last: f32,
}

/// The slots whose bounding sphere the line through `position` (cell quanta) along `direction` meets in a window, to
/// [`TOLERANCE`]; none for a grain whose centre is `but`. Which of those within the tolerance may depend on the machine: who
/// asks must look at each exactly.
#[inline(always)]
pub(super) fn near<S: Simd>(
    simd: S,
    block: &Block,
    (position, direction): ([f32; 3], [f32; 3]),
    Window { begins, last }: Window,
    but: [f32; 3],
) -> mask32x16<S> {
    let splat = |x: f32| f32x16::splat(simd, x);
    let Around { x, y, z, radius2, others } = Around::new(simd, block, position, but);
    let (dx, dy, dz) = (splat(direction[0]), splat(direction[1]), splat(direction[2]));
    let dot =
        |a: [f32x16<S>; 3], b: [f32x16<S>; 3]| a[0].mul_add(b[0], a[1].mul_add(b[1], a[2] * b[2]));
    let middle = dot([x, y, z], [dx, dy, dz]);
    let back = -middle;
    let foot = [back.mul_add(dx, x), back.mul_add(dy, y), back.mul_add(dz, z)];
    // Half the chord, squared: no root is needed to compare it.
    let half2 = radius2 - dot(foot, foot);
    let zero = splat(0.0);
    let behind = middle + splat(TOLERANCE);
    let (is_ahead, holds) = (behind.simd_ge(zero), half2.simd_gt(behind * behind));
    let enters = is_ahead & !holds;
    let is_met = enters | (holds & mask32x16::splat(simd, begins));
    let to_last = middle - splat(last + TOLERANCE);
    let soon = to_last.simd_le(zero) | half2.simd_ge(to_last * to_last);
    half2.simd_gt(zero) & others & is_met & soon
}

/// The slots whose bounding sphere holds a point (cell quanta); none for a grain whose centre is `but`. Spheres are 2
/// quanta larger than bodies, which is more than rounding takes.
#[inline(always)]
pub(super) fn around<S: Simd>(
    simd: S,
    block: &Block,
    position: [f32; 3],
    but: [f32; 3],
) -> mask32x16<S> {
    let Around { x, y, z, radius2, others } = Around::new(simd, block, position, but);
    (x * x + y * y + z * z).simd_lt(radius2) & others
}
