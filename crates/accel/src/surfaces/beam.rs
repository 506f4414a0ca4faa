//! A ray with a width, as boxes see it: the path of a point or of a falling sphere.

use super::cuboid::{greater, lesser};
use super::tree::WIDTH;
use fearless_simd::{Simd, f32x8, prelude::*};
use snowgrain_math::DVec3;

/// Relative room for the roundings of a slab test in `f32` (four of half a unit in the last place).
const SLAB_ROUNDING: f32 = 1.0 / (1 << 20) as f32;

/// What the origin is moved outwards by, relative to the size of the hierarchy: more than its own
/// rounding to `f32`.
const ORIGIN_SLACK: f64 = 1.0 / (1 << 22) as f64;

/// Direction components nearer to zero, relative to the largest, count as this: their slabs are
/// then still either missed or crossed for longer than the scene is wide, and nothing divides by
/// zero.
const LEAST_DIRECTION: f64 = 1e-20;

/// A beam from where it enters the box around everything.
pub(super) struct Beam {
    /// Largest component of the direction: distances in here are `t` times this.
    measure: f64,
    /// Distance from the beam's own origin to where it enters.
    enter: f64,
    /// Index of the corner that holds the nearer plane of each axis.
    near: [usize; 3],
    /// The origin moved along the beam for nearer planes (met earlier), against it for farther ones.
    near_origin: [f32; 3],
    far_origin: [f32; 3],
    inverse: [f32; 3],
}

impl Beam {
    /// The path `origin + t * direction` for `0 <= t <= t_max`, `spread` wide to either side along
    /// each axis, through a hierarchy that spans `-half ..= half`; `None` where it misses that.
    #[inline(always)]
    pub(super) fn new(
        half: DVec3,
        origin: DVec3,
        direction: DVec3,
        spread: DVec3,
        t_max: f64,
    ) -> Option<Self> {
        let spread = spread + half.max_element() * ORIGIN_SLACK;
        let measure = direction.abs().max_element();
        let mut direction = (direction / measure).to_array();
        for d in &mut direction {
            if d.abs() < LEAST_DIRECTION {
                *d = LEAST_DIRECTION.copysign(*d);
            }
        }
        let (mut enter, mut leave) = (0.0f64, t_max * measure);
        let mut inverse = [0.0; 3];
        for axis in 0..3 {
            inverse[axis] = 1.0 / direction[axis];
            let reach = (half[axis] + spread[axis]).copysign(inverse[axis]);
            enter = greater(enter, (-reach - origin[axis]) * inverse[axis]);
            leave = lesser(leave, (reach - origin[axis]) * inverse[axis]);
        }
        // Where it only grazes, roundings decide; the spread has room for them.
        if enter > leave {
            return None;
        }
        let mut beam = Self {
            measure,
            enter,
            near: [0; 3],
            near_origin: [0.0; 3],
            far_origin: [0.0; 3],
            inverse: [0.0; 3],
        };
        for axis in 0..3 {
            let at = origin[axis] + direction[axis] * enter;
            let shift = spread[axis].copysign(direction[axis]);
            beam.near[axis] = usize::from(direction[axis] < 0.0);
            beam.near_origin[axis] = (at + shift) as f32;
            beam.far_origin[axis] = (at - shift) as f32;
            beam.inverse[axis] = inverse[axis] as f32;
        }
        Some(beam)
    }

    /// The farthest at which a box may start and yet hold something at this distance from the
    /// beam's origin.
    #[inline(always)]
    pub(super) fn limit(&self, t: f64) -> f32 {
        (t * self.measure - self.enter).max(0.0) as f32 * (1.0 + SLAB_ROUNDING)
    }

    /// The children whose boxes the beam meets before `limit`, and where it meets each.
    #[inline(always)]
    pub(super) fn meet<S: Simd>(
        &self,
        simd: S,
        corners: &[[[f32; WIDTH]; 3]; 2],
        limit: f32,
    ) -> (u64, [f32; WIDTH]) {
        let mut start = f32x8::splat(simd, 0.0);
        let mut end = f32x8::splat(simd, limit);
        for (axis, &inverse) in self.inverse.iter().enumerate() {
            let side = self.near[axis];
            let inverse = f32x8::splat(simd, inverse);
            let near = f32x8::from_slice(simd, &corners[side][axis]);
            let far = f32x8::from_slice(simd, &corners[1 - side][axis]);
            let near = near - f32x8::splat(simd, self.near_origin[axis]);
            let far = far - f32x8::splat(simd, self.far_origin[axis]);
            start = start.max(near * inverse);
            end = end.min(far * inverse);
        }
        let hits = start.simd_le(end * f32x8::splat(simd, 1.0 + SLAB_ROUNDING)).to_bitmask();
        let mut starts = [0.0; WIDTH];
        start.store_slice(&mut starts);
        (hits, starts)
    }
}
