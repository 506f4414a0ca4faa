//! Which grains of a block a ray may meet: by their bounding spheres, SIMD over the grains.

use crate::grain_grid::{Block, RADIUS_MASK};
use crate::words::floats;
use fearless_simd::prelude::*;
use fearless_simd::{f32x16, u16x16};

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
    let splat = |v: f32| f32x16::splat(simd, v);
    let (dx, dy, dz) = (splat(direction[0]), splat(direction[1]), splat(direction[2]));
    let x = floats(simd, u16x16::from_slice(simd, &block.x)) - splat(position[0]);
    let y = floats(simd, u16x16::from_slice(simd, &block.y)) - splat(position[1]);
    let z = floats(simd, u16x16::from_slice(simd, &block.z)) - splat(position[2]);
    let radius_bits = u16x16::from_slice(simd, &block.radius) & u16x16::splat(simd, RADIUS_MASK);
    let radius = floats(simd, radius_bits);
    let middle = x * dx + y * dy + z * dz;
    let (rx, ry, rz) = (x - middle * dx, y - middle * dy, z - middle * dz);
    let inside = radius * radius - (rx * rx + ry * ry + rz * rz);
    let zero = splat(0.0);
    let met = inside.simd_gt(zero);
    let half = met.select(inside, zero).sqrt();
    let (enter, leave) = (middle - half, middle + half);
    let ahead = met & leave.simd_gt(splat(-TOLERANCE));
    let mut near = Near { slots: ahead.to_bitmask() as u32, enter: [0.0; 16] };
    enter.store_slice(&mut near.enter);
    near
}
