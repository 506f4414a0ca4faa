//! Axes and radii of eight grains, from the words in which they are kept.

use super::slabs::{D, Truth, Vectors};
use crate::grain_grid::{Reach, SLACK};
use fearless_simd::prelude::*;
use fearless_simd::u64x8;
use snowgrain_geometry::GrainShape;

/// Whole numbers below 2^52 as doubles, less another whole number.
#[inline(always)]
fn numbers<S: Simd>(simd: S, words: u64x8<S>, less: f64) -> D<S> {
    /// 2^52, whose last bit is 1.
    const EVEN: f64 = 4_503_599_627_370_496.0;
    let bits: D<S> = (words | u64x8::splat(simd, EVEN.to_bits())).bitcast();
    bits - D::<S>::splat(simd, EVEN + less)
}

/// Radii of grains, quanta, of those of their spheres and the inverse of how far they reach, as [`Reach::radius`] tells one.
#[inline(always)]
pub(super) fn radii<S: Simd>(simd: S, bounding: D<S>, inverse_reach: D<S>) -> D<S> {
    let splat = |x: f64| D::<S>::splat(simd, x);
    ((bounding - splat(SLACK.into())) * inverse_reach + splat(Reach::ROUNDING)).floor()
}

/// A component of rotations, of those that are kept.
#[inline(always)]
fn component<S: Simd>(simd: S, words: u64x8<S>, place: u32) -> D<S> {
    let bits = words >> (GrainShape::COMPONENT_BITS * place)
        & u64x8::splat(simd, (1 << GrainShape::COMPONENT_BITS) - 1);
    numbers(simd, bits, GrainShape::STEPS) * D::<S>::splat(simd, GrainShape::STEP)
}

/// Whose bit is set.
#[inline(always)]
fn has_bit<S: Simd>(simd: S, words: u64x8<S>, shift: u32) -> Truth<S> {
    let one = u64x8::splat(simd, 1);
    (words >> shift & one).simd_eq(one)
}

/// Axes of grains in the world, as [`GrainShape::rotation`] decodes them.
#[inline(always)]
pub(super) fn axes<S: Simd>(simd: S, words: u64x8<S>) -> [Vectors<S>; 3] {
    let (zero, one) = (D::<S>::splat(simd, 0.0), D::<S>::splat(simd, 1.0));
    let [a, b, c] =
        [component(simd, words, 0), component(simd, words, 1), component(simd, words, 2)];
    let rest = one - (a * a + b * b + c * c);
    let rest = rest.simd_gt(zero).select(rest, zero).sqrt();
    // The others follow the largest in a ring: on by one place, by two.
    let by_one = has_bit(simd, words, GrainShape::LARGEST_SHIFT);
    let ring =
        [by_one.select(c, rest), by_one.select(rest, a), by_one.select(a, b), by_one.select(b, c)];
    let by_two = has_bit(simd, words, GrainShape::LARGEST_SHIFT + 1);
    let [x, y, z, w] = [
        by_two.select(ring[2], ring[0]),
        by_two.select(ring[3], ring[1]),
        by_two.select(ring[0], ring[2]),
        by_two.select(ring[1], ring[3]),
    ];
    let (x2, y2, z2) = (x + x, y + y, z + z);
    let (xx, yy, zz) = (x * x2, y * y2, z * z2);
    let (xy, xz, yz) = (x * y2, x * z2, y * z2);
    let (wx, wy, wz) = (w * x2, w * y2, w * z2);
    [
        Vectors(one - (yy + zz), xy + wz, xz - wy),
        Vectors(xy - wz, one - (xx + zz), yz + wx),
        Vectors(xz + wy, yz - wx, one - (xx + yy)),
    ]
}
