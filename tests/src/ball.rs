//! A ray and a ball.

use snowgrain_math::DVec3;

/// A ball of ice where the ray meets it: for periodic snow, the image of its grain.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Ball {
    /// Index of the grain.
    pub(crate) grain: usize,
    pub(crate) center: DVec3,
    pub(crate) radius: f64,
}

impl Ball {
    /// The stretch of the line through `origin` along the unit `direction` that lies inside.
    ///
    /// The distance from the line to the centre is taken from the perpendicular itself, not as a
    /// difference of squares, so that it stays right far from the ball.
    pub(crate) fn interval(&self, origin: DVec3, direction: DVec3) -> Option<(f64, f64)> {
        let from_center = origin - self.center;
        let along = from_center.dot(direction);
        let perpendicular = from_center - direction * along;
        let squared = self.radius * self.radius - perpendicular.length_squared();
        (squared > 0.0).then(|| (-along - squared.sqrt(), -along + squared.sqrt()))
    }

    /// Distance to the surface from a point outside (or on it) towards which the ray moves: `None`
    /// where it moves away, by which a grain just left is excluded without an epsilon.
    pub(crate) fn entry(&self, origin: DVec3, direction: DVec3) -> Option<f64> {
        if (origin - self.center).dot(direction) >= 0.0 {
            return None;
        }
        self.interval(origin, direction).map(|(t0, _)| t0.max(0.0))
    }

    /// Distance to the far surface from a point on the surface, along a direction that goes in.
    pub(crate) fn chord(&self, origin: DVec3, direction: DVec3) -> f64 {
        (-2.0 * (origin - self.center).dot(direction)).max(0.0)
    }

    /// Distance to the surface from a point inside.
    pub(crate) fn exit(&self, origin: DVec3, direction: DVec3) -> f64 {
        self.interval(origin, direction).map_or(0.0, |(_, t1)| t1.max(0.0))
    }

    /// Outward unit normal nearest to `point`.
    pub(crate) fn normal(&self, point: DVec3) -> DVec3 {
        (point - self.center).normalize()
    }

    /// The point of the surface nearest to `point`.
    pub(crate) fn on_surface(&self, point: DVec3) -> DVec3 {
        self.center + self.normal(point) * self.radius
    }
}
