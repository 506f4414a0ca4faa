//! One ray against the sixteen grains of a block.
//!
//! The test is the perpendicular form: with `c` the vector to the grain's centre and `t = c . d`,
//! the residual `c - t d` is squared directly, so that nothing cancels for grains far along the ray
//! (Haines et al. 2019, "Precision Improvements for Ray/Sphere Intersection", Ray Tracing Gems 7).

use crate::grain_grid::{Block, RADIUS_MASK};
use fearless_simd::prelude::*;
use fearless_simd::{f32x16, i32x16, mask32x16, u16x16};

/// "No grain": larger than any distance inside a grid.
pub(crate) const NOTHING: f32 = 1.0e30;

/// A ray as the block test sees it.
#[derive(Clone, Copy)]
pub(crate) struct BlockRay {
    /// In cell quanta.
    pub(crate) position: [f32; 3],
    pub(crate) direction: [f32; 3],
    /// Whether the ray is at the end of a chord in ice.
    pub(crate) in_ice: bool,
    /// Centre of the grain whose chord ended (ice only).
    pub(crate) grain: [f32; 3],
}

/// Sixteen 16-bit words as floats.
#[inline(always)]
pub(crate) fn floats<S: Simd>(simd: S, words: u16x16<S>) -> f32x16<S> {
    let (low, high) = simd.widen_u16x16(words);
    let words: i32x16<S> = simd.combine_u32x8(low, high).bitcast();
    simd.cvt_f32_i32x16(words)
}

/// In air: the least distance at which the ray enters a grain, and the slot of that grain. Grains
/// whose centre lies behind are left, not entered: a ray that starts on a sphere and leaves it is
/// excluded by convexity, without an epsilon.
///
/// In ice, at the end of a chord: the greatest distance at which the ray leaves a grain that also
/// covers this point, negated (so that both cases look for a minimum). The same interval
/// `[t - s, t + s]` of a grain decides entering and leaving.
///
/// [`NOTHING`] where there is none.
#[inline(always)]
pub(crate) fn test_block<S: Simd>(simd: S, block: &Block, ray: &BlockRay) -> (f32, usize) {
    let [px, py, pz] = ray.position.map(|v| f32x16::splat(simd, v));
    let [dx, dy, dz] = ray.direction.map(|v| f32x16::splat(simd, v));
    let x = floats(simd, u16x16::from_slice(simd, &block.x));
    let y = floats(simd, u16x16::from_slice(simd, &block.y));
    let z = floats(simd, u16x16::from_slice(simd, &block.z));
    let radius_bits = u16x16::from_slice(simd, &block.radius) & u16x16::splat(simd, RADIUS_MASK);
    let radius = floats(simd, radius_bits);

    let (cx, cy, cz) = (x - px, y - py, z - pz);
    let t = cx * dx + cy * dy + cz * dz;
    let (rx, ry, rz) = (cx - t * dx, cy - t * dy, cz - t * dz);
    let discriminant = radius * radius - (rx * rx + ry * ry + rz * rz);
    let zero = f32x16::splat(simd, 0.0);
    let met = discriminant.simd_gt(zero);
    let half = met.select(discriminant, zero).sqrt();
    let (enter, leave) = (t - half, t + half);

    let in_ice = mask32x16::splat(simd, ray.in_ice);
    let [gx, gy, gz] = ray.grain.map(|v| f32x16::splat(simd, v));
    let itself = x.simd_eq(gx) & y.simd_eq(gy) & z.simd_eq(gz);
    let covers = enter.simd_le(zero) & leave.simd_gt(zero) & !itself;
    let ahead = t.simd_gt(zero);
    let valid = met & ((in_ice & covers) | (!in_ice & ahead));
    let value = in_ice.select(-leave, enter);
    let value = valid.select(value, f32x16::splat(simd, NOTHING));
    let least = value.reduce_min();
    let slot = value.simd_eq(f32x16::splat(simd, least)).to_bitmask().trailing_zeros() as usize;
    (least, slot & 15)
}
