//! Axis-aligned boxes.

use crate::{DVec3, Ray};

/// An axis-aligned box, in metres. Empty where a component of `min` exceeds that of `max`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Aabb {
    /// Least corner.
    pub min: DVec3,
    /// Greatest corner.
    pub max: DVec3,
}

impl Aabb {
    /// The box that holds nothing; the neutral element of [`Aabb::union`].
    pub const EMPTY: Self =
        Self { min: DVec3::splat(f64::INFINITY), max: DVec3::splat(f64::NEG_INFINITY) };

    /// The box with these corners.
    #[must_use]
    pub fn new(min: DVec3, max: DVec3) -> Self {
        Self { min, max }
    }

    /// Whether it holds no point.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        !(self.min.cmple(self.max).all())
    }

    /// The smallest box that holds both.
    #[must_use]
    pub fn union(&self, other: &Self) -> Self {
        Self { min: self.min.min(other.min), max: self.max.max(other.max) }
    }

    /// The smallest box that holds this one and `point`.
    #[must_use]
    pub fn including(&self, point: DVec3) -> Self {
        Self { min: self.min.min(point), max: self.max.max(point) }
    }

    /// This box grown by `margin` metres on every side.
    #[must_use]
    pub fn expanded(&self, margin: f64) -> Self {
        Self { min: self.min - margin, max: self.max + margin }
    }

    /// Edge lengths, in metres.
    #[must_use]
    pub fn size(&self) -> DVec3 {
        self.max - self.min
    }

    /// The middle.
    #[must_use]
    pub fn center(&self) -> DVec3 {
        (self.min + self.max) * 0.5
    }

    /// The stretch `t0..t1` of the ray (from `t = 0`) inside the box, `None` where they do not meet.
    #[inline]
    #[must_use]
    pub fn intersect(&self, ray: &Ray) -> Option<(f64, f64)> {
        let (mut t0, mut t1) = (0.0f64, f64::INFINITY);
        for axis in 0..3 {
            let (o, d) = (ray.origin[axis], ray.direction[axis]);
            if d == 0.0 {
                if o < self.min[axis] || o > self.max[axis] {
                    return None;
                }
                continue;
            }
            let (a, b) = ((self.min[axis] - o) / d, (self.max[axis] - o) / d);
            t0 = t0.max(a.min(b));
            t1 = t1.min(a.max(b));
        }
        (t0 <= t1).then_some((t0, t1))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_ray_through_the_middle_is_clipped_at_both_faces() {
        let b = Aabb::new(DVec3::splat(-1.0), DVec3::splat(1.0));
        let ray = Ray::new(DVec3::new(-3.0, 0.0, 0.0), DVec3::X);
        assert_eq!(b.intersect(&ray), Some((2.0, 4.0)));
        assert_eq!(b.intersect(&Ray::new(DVec3::new(-3.0, 2.0, 0.0), DVec3::X)), None);
        assert_eq!(b.intersect(&Ray::new(DVec3::ZERO, DVec3::Y)), Some((0.0, 1.0)));
    }
}
