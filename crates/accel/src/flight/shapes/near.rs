//! Which grains of a block a ray may meet: by their bounding spheres, SIMD over the grains.

use crate::flight::meeting::{Meeting, meet};
use crate::grain_grid::{Block, GRAINS_PER_BLOCK};
use crate::words::floats;
use fearless_simd::prelude::*;
use fearless_simd::{f32x16, mask32x16, u16x16};

/// The centre of no grain.
pub(super) const NOWHERE: [f32; 3] = [-1.0; 3];

/// How far, quanta, single precision may move the end of a chord of a sphere that is 2 quanta larger than a body
/// that the line meets: so near to the rim, 5e-2 across the line are less than 4 along it.
pub(super) const TOLERANCE: f32 = 8.0;

/// The slots whose bounding sphere the line through `position` (cell quanta) along `direction` meets, from a
/// little before the position on, and enters within `[first, last]` of it, to [`TOLERANCE`]; none for a grain whose centre
/// is `but`.
#[inline(always)]
pub(super) fn near<S: Simd>(
    simd: S,
    block: &Block,
    (position, direction): ([f32; 3], [f32; 3]),
    [first, last]: [f32; 2],
    but: [f32; 3],
) -> mask32x16<S> {
    let splat = |x: f32| f32x16::splat(simd, x);
    let Meeting { met, middle, half } = meet(simd, block, position, direction);
    let (enter, leave) = (middle - half, middle + half);
    let ahead = leave.simd_gt(splat(-TOLERANCE));
    let within = enter.simd_ge(splat(first - TOLERANCE)) & enter.simd_le(splat(last + TOLERANCE));
    let is_at = |centers: &[u16; GRAINS_PER_BLOCK], at: f32| {
        floats(simd, u16x16::from_slice(simd, centers)).simd_eq(splat(at))
    };
    let itself = is_at(&block.x, but[0]) & is_at(&block.y, but[1]) & is_at(&block.z, but[2]);
    met & ahead & within & !itself
}
