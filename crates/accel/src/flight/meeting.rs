//! Where a ray meets the sixteen spheres of a block, SIMD over the spheres.
//!
//! The test is the perpendicular form: with `c` the vector to the sphere's centre and `t = c . d`,
//! the residual `c - t d` is squared directly, so that nothing cancels for spheres far along the ray
//! (Haines et al. 2019, "Precision Improvements for Ray/Sphere Intersection", Ray Tracing Gems 7).

use crate::grain_grid::{Block, RADIUS_MASK};
use crate::words::floats;
use fearless_simd::prelude::*;
use fearless_simd::{f32x16, mask32x16, u16x16};

/// Where a ray meets the grains of a block.
pub(super) struct Meeting<S: Simd> {
    /// Whether it meets them at all.
    pub(super) met: mask32x16<S>,
    /// From the point to the middle of the chord, `t`, quanta.
    pub(super) middle: f32x16<S>,
    /// Half the chord, `s`, quanta; 0 where there is none.
    pub(super) half: f32x16<S>,
}

/// The ray through `position` (cell quanta) along `direction`.
#[inline(always)]
pub(super) fn meet<S: Simd>(
    simd: S,
    block: &Block,
    position: [f32; 3],
    direction: [f32; 3],
) -> Meeting<S> {
    let splat = |v: f32| f32x16::splat(simd, v);
    let (dx, dy, dz) = (splat(direction[0]), splat(direction[1]), splat(direction[2]));
    let x = floats(simd, u16x16::from_slice(simd, &block.x)) - splat(position[0]);
    let y = floats(simd, u16x16::from_slice(simd, &block.y)) - splat(position[1]);
    let z = floats(simd, u16x16::from_slice(simd, &block.z)) - splat(position[2]);
    let radius_bits = u16x16::from_slice(simd, &block.radius) & u16x16::splat(simd, RADIUS_MASK);
    let radius = floats(simd, radius_bits);
    let middle = x * dx + y * dy + z * dz;
    let (rx, ry, rz) = (x - middle * dx, y - middle * dy, z - middle * dz);
    let discriminant = radius * radius - (rx * rx + ry * ry + rz * rz);
    let zero = splat(0.0);
    let met = discriminant.simd_gt(zero);
    Meeting { met, middle, half: met.select(discriminant, zero).sqrt() }
}
