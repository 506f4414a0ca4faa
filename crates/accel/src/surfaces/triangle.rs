//! A triangle in world space: against rays, boxes, points and falling spheres.

use super::SurfaceId;
use super::contact::Touch;
use snowgrain_math::{Aabb, DVec3, Ray};

/// A triangle of a mesh, in metres.
#[derive(Clone, Copy, Debug)]
pub(super) struct Triangle {
    pub(super) corners: [DVec3; 3],
    pub(super) id: SurfaceId,
}

/// A ray in the form that triangles ask for: sheared so that it runs along the axis along which its
/// direction is largest (Woop, Benthin and Wald 2013, "Watertight Ray/Triangle Intersection", JCGT
/// 2(1), section 3).
#[derive(Clone, Copy, Debug)]
pub(super) struct ShearedRay {
    /// The axes, the main one last.
    pub(super) axes: [usize; 3],
    pub(super) origin: DVec3,
    pub(super) shear: [f64; 3],
}

impl ShearedRay {
    #[inline(always)]
    pub(super) fn new(ray: &Ray) -> Self {
        let d = ray.direction.abs();
        let axes = if d.x >= d.y && d.x >= d.z {
            [1, 2, 0]
        } else if d.y >= d.z {
            [2, 0, 1]
        } else {
            [0, 1, 2]
        };
        let direction = ray.direction.to_array();
        let [x, y, z] = [direction[axes[0]], direction[axes[1]], direction[axes[2]]];
        Self { axes, origin: ray.origin, shear: [x / z, y / z, 1.0 / z] }
    }

    /// A point seen along the ray: across it (two numbers) and along it.
    #[inline(always)]
    fn view(&self, p: DVec3) -> [f64; 3] {
        let p = (p - self.origin).to_array();
        let [x, y, z] = [p[self.axes[0]], p[self.axes[1]], p[self.axes[2]]];
        [x - self.shear[0] * z, y - self.shear[1] * z, z * self.shear[2]]
    }
}

impl Triangle {
    /// The distance along the ray at which it meets the triangle, `> 0`.
    ///
    /// Triangles that share two vertices compute the same products for their common edge, with
    /// opposite signs, and rounding is monotonic: an edge function is never negative where the
    /// exact one is positive. So a ray through an edge or a vertex hits at least one of the
    /// triangles around it.
    #[inline(always)]
    pub(super) fn intersect(&self, ray: &ShearedRay) -> Option<f64> {
        let [a, b, c] = self.corners;
        let (a, b, c) = (ray.view(a), ray.view(b), ray.view(c));
        let u = c[0] * b[1] - c[1] * b[0];
        let v = a[0] * c[1] - a[1] * c[0];
        let w = b[0] * a[1] - b[1] * a[0];
        if (u < 0.0 || v < 0.0 || w < 0.0) && (u > 0.0 || v > 0.0 || w > 0.0) {
            return None;
        }
        let sum = u + v + w;
        if sum == 0.0 {
            return None;
        }
        let t = (u * a[2] + v * b[2] + w * c[2]) / sum;
        (t > 0.0).then_some(t)
    }

    /// Unit normal, on the side from which the corners run counterclockwise.
    pub(super) fn normal(&self) -> DVec3 {
        let [a, b, c] = self.corners;
        (b - a).cross(c - a).normalize()
    }

    /// Whether it has a normal.
    #[inline(always)]
    pub(super) fn has_area(&self) -> bool {
        has_area(&self.corners)
    }

    /// Whether it has a point in the box, by separating axes (Akenine-Moller 2001, "Fast 3D
    /// Triangle-Box Overlap Testing"), in doubt yes.
    pub(super) fn overlaps(&self, bounds: &Aabb) -> bool {
        let (center, half) = (bounds.center(), bounds.size() * 0.5);
        let [a, b, c] = self.corners.map(|p| p - center);
        let size = self.corners.iter().fold(center.abs(), |size, p| size.max(p.abs()));
        let doubt = (size.max_element() + half.max_element()) * ROUNDING;
        let separates = |axis: DVec3| {
            let [p, q, r] = [a, b, c].map(|p| axis.dot(p));
            let reach = axis.abs().dot(half + doubt);
            p.min(q).min(r) > reach || p.max(q).max(r) < -reach
        };
        let edges = [b - a, c - b, a - c];
        let axes = [DVec3::X, DVec3::Y, DVec3::Z];
        !(axes.into_iter().any(separates)
            || separates(edges[0].cross(edges[1]))
            || edges.iter().any(|e| axes.iter().any(|x| separates(x.cross(*e)))))
    }

    /// The point of the triangle nearest to `p`.
    pub(super) fn closest_point(&self, p: DVec3) -> DVec3 {
        let [a, b, c] = self.corners;
        let normal = (b - a).cross(c - a);
        let edges = [(a, b), (b, c), (c, a)];
        if edges.iter().all(|&(from, to)| normal.cross(to - from).dot(p - from) >= 0.0) {
            return p - normal * (normal.dot(p - a) / normal.length_squared());
        }
        let [mut nearest, others @ ..] = edges.map(|(from, to)| closest_on_segment(from, to, p));
        for q in others {
            if q.distance_squared(p) < nearest.distance_squared(p) {
                nearest = q;
            }
        }
        nearest
    }

    /// Its nearest point as seen from `center`, and the distance to it. A centre that lies on the
    /// triangle itself gets the normal that points up.
    pub(super) fn touch(&self, center: DVec3) -> (Touch, f64) {
        let point = self.closest_point(center);
        let offset = center - point;
        let distance = offset.length();
        let normal = if distance > 0.0 { offset / distance } else { self.upward_normal() };
        (Touch { point, normal }, distance)
    }

    pub(super) fn upward_normal(&self) -> DVec3 {
        let normal = self.normal();
        if normal.y < 0.0 { -normal } else { normal }
    }
}

/// Whether a triangle has a normal: it is neither flat to a line nor outside the numbers.
#[inline(always)]
pub(super) fn has_area(&[a, b, c]: &[DVec3; 3]) -> bool {
    let area = (b - a).cross(c - a).length_squared();
    area > 0.0 && area.is_finite()
}

/// Relative rounding that comparisons of lengths allow for: a few hundred units in the last place.
pub(super) const ROUNDING: f64 = 1.0 / (1u64 << 44) as f64;

fn closest_on_segment(from: DVec3, to: DVec3, p: DVec3) -> DVec3 {
    let edge = to - from;
    let s = (p - from).dot(edge) / edge.length_squared();
    if s <= 0.0 {
        from
    } else if s >= 1.0 {
        to
    } else {
        from + edge * s
    }
}
