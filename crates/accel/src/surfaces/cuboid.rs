//! Boxes in `f32`, and the query for what overlaps one.

use super::tree::WIDTH;
use fearless_simd::{Simd, f32x8, prelude::*};
use snowgrain_math::{Aabb, DVec3};

/// A box relative to the middle of a hierarchy. The fourth lane is there for alignment and is
/// ignored.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(16))]
pub(super) struct Bounds {
    pub(super) min: [f32; 4],
    pub(super) max: [f32; 4],
}

impl Bounds {
    pub(super) const EMPTY: Self = Self { min: [f32::INFINITY; 4], max: [f32::NEG_INFINITY; 4] };

    /// The box around `bounds - center`, rounded outwards.
    pub(super) fn around(bounds: &Aabb, center: DVec3) -> Self {
        let [x, y, z] = (bounds.min - center).to_array().map(round_down);
        let [u, v, w] = (bounds.max - center).to_array().map(round_up);
        Self { min: [x, y, z, 0.0], max: [u, v, w, 0.0] }
    }

    #[inline(always)]
    pub(super) fn union(&self, other: &Self) -> Self {
        Self {
            min: std::array::from_fn(|i| lesser(self.min[i], other.min[i])),
            max: std::array::from_fn(|i| greater(self.max[i], other.max[i])),
        }
    }

    #[inline(always)]
    pub(super) fn half_area(&self) -> f32 {
        let [x, y, z] = [0, 1, 2].map(|i| self.max[i] - self.min[i]);
        x * y + y * z + z * x
    }

    /// Twice the middle.
    #[inline(always)]
    pub(super) fn middle(&self) -> [f32; 4] {
        std::array::from_fn(|i| self.min[i] + self.max[i])
    }

    /// Least and greatest corner without the idle lane.
    pub(super) fn corners(&self) -> [[f32; 3]; 2] {
        [self.min, self.max].map(|[x, y, z, _]| [x, y, z])
    }
}

/// `min` as one instruction, without care for what is not a number.
#[inline(always)]
pub(super) fn lesser<T: PartialOrd>(a: T, b: T) -> T {
    if a < b { a } else { b }
}

/// `max` as one instruction.
#[inline(always)]
pub(super) fn greater<T: PartialOrd>(a: T, b: T) -> T {
    if a > b { a } else { b }
}

/// The nearest `f32` not above `x`.
#[inline(always)]
pub(super) fn round_down(x: f64) -> f32 {
    let nearest = x as f32;
    if f64::from(nearest) > x { nearest.next_down() } else { nearest }
}

/// The nearest `f32` not below `x`.
#[inline(always)]
pub(super) fn round_up(x: f64) -> f32 {
    -round_down(-x)
}

/// A box that is asked for, relative to the middle of a hierarchy.
pub(super) struct BoxQuery {
    min: [f32; 3],
    max: [f32; 3],
}

impl BoxQuery {
    /// The box `center - half ..= center + half`, rounded outwards.
    #[inline(always)]
    pub(super) fn new(center: DVec3, half: DVec3) -> Self {
        let (low, high) = ((center - half).to_array(), (center + half).to_array());
        let mut query = Self { min: [0.0; 3], max: [0.0; 3] };
        for axis in 0..3 {
            // Finite, so that no query reaches the boxes of absent children.
            query.min[axis] = round_down(low[axis]).max(f32::MIN);
            query.max[axis] = round_up(high[axis]).min(f32::MAX);
        }
        query
    }

    /// Which of a node's children overlap it.
    #[inline(always)]
    pub(super) fn meet<S: Simd>(&self, simd: S, corners: &[[[f32; WIDTH]; 3]; 2]) -> u64 {
        let mut hits = u64::from(u8::MAX);
        let [low, high] = corners;
        for (axis, (min, max)) in low.iter().zip(high).enumerate() {
            let min = f32x8::from_slice(simd, min);
            let max = f32x8::from_slice(simd, max);
            hits &= min.simd_le(f32x8::splat(simd, self.max[axis])).to_bitmask();
            hits &= max.simd_ge(f32x8::splat(simd, self.min[axis])).to_bitmask();
        }
        hits
    }
}
