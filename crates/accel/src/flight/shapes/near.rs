//! Which grains of a block a ray may meet: by their bounding spheres, SIMD over the grains.

use crate::flight::meeting::{Meeting, meet};
use crate::grain_grid::Block;
use fearless_simd::f32x16;
use fearless_simd::prelude::*;

/// How far, quanta, single precision may move the end of a chord of a sphere that is 2 quanta larger than a body
/// that the line meets: so near to the rim, 5e-2 across the line are less than 4 along it.
pub(super) const TOLERANCE: f32 = 8.0;

/// Grains whose bounding spheres a line meets.
pub(super) struct Near {
    /// A bit for each slot.
    pub(super) slots: u32,
    /// From the point to where the line enters each sphere, quanta, to [`TOLERANCE`].
    pub(super) enter: [f32; 16],
}

/// The line through `position` (cell quanta) along `direction`, from a little before the position on.
#[inline(always)]
pub(super) fn near<S: Simd>(
    simd: S,
    block: &Block,
    position: [f32; 3],
    direction: [f32; 3],
) -> Near {
    let Meeting { met, middle, half } = meet(simd, block, position, direction);
    let (enter, leave) = (middle - half, middle + half);
    let ahead = met & leave.simd_gt(f32x16::splat(simd, -TOLERANCE));
    let mut near = Near { slots: ahead.to_bitmask() as u32, enter: [0.0; 16] };
    enter.store_slice(&mut near.enter);
    near
}
