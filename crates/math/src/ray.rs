//! Rays.

use crate::DVec3;

/// A half-line from `origin` along the unit vector `direction`, in metres.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ray {
    /// Where it starts.
    pub origin: DVec3,
    /// Unit vector along it.
    pub direction: DVec3,
}

impl Ray {
    /// The ray from `origin` along `direction`, which must have unit length.
    #[must_use]
    pub fn new(origin: DVec3, direction: DVec3) -> Self {
        Self { origin, direction }
    }

    /// The point at distance `t` metres.
    #[must_use]
    pub fn at(&self, t: f64) -> DVec3 {
        self.origin + self.direction * t
    }
}
