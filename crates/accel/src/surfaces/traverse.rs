//! The nearest triangle along a ray.

use super::SurfaceId;
use super::bvh::{Bvh, Node, Stack, Step, WIDTH};
use super::triangle::{ROUNDING, ShearedRay, Triangle, main_axis};
use fearless_simd::{Level, Simd, dispatch, prelude::*};
use snowgrain_math::Ray;

/// Relative room for the roundings of a slab test in `f32` (four of half a unit in the last place).
const SLAB_ROUNDING: f32 = 1.0 / (1 << 20) as f32;

/// What the ray's origin is moved outwards by, relative to the size of the scene: more than its
/// own rounding to `f32`.
const ORIGIN_SLACK: f64 = 1.0 / (1 << 22) as f64;

/// Direction components nearer to zero count as this: their slabs are then still either missed or
/// crossed for longer than the scene is wide, and nothing divides by zero.
const LEAST_DIRECTION: f32 = 1e-20;

/// A ray as the boxes see it, from where it enters the box around everything.
struct BoxRay {
    /// Distance from the ray's own origin to where it enters, metres.
    enter: f64,
    /// Index into [`Node::corners`] of the nearer plane of each axis.
    near: [usize; 3],
    /// The origin moved along the ray for nearer planes (met earlier), against it for farther ones.
    near_origin: [f32; 3],
    far_origin: [f32; 3],
    inverse: [f32; 3],
}

impl Bvh {
    /// The nearest triangle with `0 < t <= t_max` other than `exclude`; of several at the same
    /// distance the one with the lowest id.
    pub(super) fn intersect(
        &self,
        level: Level,
        ray: &Ray,
        t_max: f64,
        exclude: Option<SurfaceId>,
    ) -> Option<(f64, &Triangle)> {
        if self.nodes.is_empty() {
            return None;
        }
        let size = (self.bounds.size() * 0.5).max_element();
        let slack = size * ORIGIN_SLACK + self.center.abs().max_element() * ROUNDING;
        let (enter, _) = self.bounds.expanded(slack).intersect(ray)?;
        if enter > t_max {
            return None;
        }
        let boxes = BoxRay::new(self, ray, enter, slack);
        match main_axis(ray.direction) {
            0 => {
                let sheared = ShearedRay::<0>::new(ray);
                dispatch!(level, simd => self.nearest(simd, &sheared, &boxes, t_max, exclude))
            }
            1 => {
                let sheared = ShearedRay::<1>::new(ray);
                dispatch!(level, simd => self.nearest(simd, &sheared, &boxes, t_max, exclude))
            }
            _ => {
                let sheared = ShearedRay::<2>::new(ray);
                dispatch!(level, simd => self.nearest(simd, &sheared, &boxes, t_max, exclude))
            }
        }
    }

    #[inline(always)]
    fn nearest<S: Simd, const MAIN: usize>(
        &self,
        simd: S,
        sheared: &ShearedRay<MAIN>,
        boxes: &BoxRay,
        t_max: f64,
        exclude: Option<SurfaceId>,
    ) -> Option<(f64, &Triangle)> {
        let mut nearest: Option<(f64, &Triangle)> = None;
        let mut limit = box_limit(t_max - boxes.enter);
        let mut stack = Stack::new();
        while let Some((key, child)) = stack.pop() {
            // Keys are negative distances; the root's is infinite.
            if -key > limit {
                continue;
            }
            match child.step() {
                Step::Inner(node) => boxes.push_hit(simd, &self.nodes[node], limit, &mut stack),
                Step::Leaf(range) => {
                    for triangle in &self.triangles[range] {
                        let Some(t) = triangle.intersect(sheared) else { continue };
                        let closer = match nearest {
                            Some((best, held)) => (t, triangle.id) < (best, held.id),
                            None => t <= t_max,
                        };
                        if closer && Some(triangle.id) != exclude {
                            nearest = Some((t, triangle));
                            limit = box_limit(t - boxes.enter);
                        }
                    }
                }
            }
        }
        nearest
    }
}

/// The farthest at which a box may start and yet hold a hit at this distance.
fn box_limit(distance: f64) -> f32 {
    distance.max(0.0) as f32 * (1.0 + SLAB_ROUNDING)
}

impl BoxRay {
    fn new(bvh: &Bvh, ray: &Ray, enter: f64, slack: f64) -> Self {
        let origin = (ray.at(enter) - bvh.center).to_array();
        let direction = ray.direction.to_array().map(|d| {
            let d = d as f32;
            if d.abs() < LEAST_DIRECTION { LEAST_DIRECTION.copysign(d) } else { d }
        });
        let shifted = |sign: f64| {
            std::array::from_fn(|i| {
                let along = if direction[i] > 0.0 { slack } else { -slack };
                (origin[i] + sign * along) as f32
            })
        };
        Self {
            enter,
            near: direction.map(|d| usize::from(d < 0.0)),
            near_origin: shifted(1.0),
            far_origin: shifted(-1.0),
            inverse: direction.map(|d| 1.0 / d),
        }
    }

    /// Pushes the children whose boxes the ray meets before `limit`, the nearest last.
    #[inline(always)]
    fn push_hit<S: Simd>(&self, simd: S, node: &Node, limit: f32, stack: &mut Stack) {
        use fearless_simd::f32x8;
        let mut start = f32x8::splat(simd, 0.0);
        let mut end = f32x8::splat(simd, limit);
        for axis in 0..3 {
            let side = self.near[axis];
            let inverse = f32x8::splat(simd, self.inverse[axis]);
            let near = f32x8::from_slice(simd, &node.corners[side][axis]);
            let far = f32x8::from_slice(simd, &node.corners[1 - side][axis]);
            start = start.max((near - f32x8::splat(simd, self.near_origin[axis])) * inverse);
            end = end.min((far - f32x8::splat(simd, self.far_origin[axis])) * inverse);
        }
        let mut hits = start.simd_le(end * f32x8::splat(simd, 1.0 + SLAB_ROUNDING)).to_bitmask();
        let mut starts = [0.0; WIDTH];
        start.store_slice(&mut starts);
        let base = stack.len();
        while hits != 0 {
            let lane = hits.trailing_zeros() as usize;
            hits &= hits - 1;
            stack.push(-starts[lane], node.children[lane], base);
        }
    }
}
