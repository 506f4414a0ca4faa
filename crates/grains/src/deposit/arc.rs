//! The circles along which a rolling grain moves.

use snowgrain_math::{DVec3, trig};

/// Speed into a contact that counts as rounding.
pub(super) const SPEED_MARGIN: f64 = 1e-9;
/// Quanta by which a grain may already overlap one that it does not count as touching.
pub(super) const TOUCH_MARGIN: f64 = 1e-6;

/// A circle that the rolling centre follows: `center + radius (u cos t + v sin t)` from t = 0.
#[derive(Clone, Copy, Debug)]
pub(super) struct Arc {
    pub(super) center: DVec3,
    pub(super) radius: f64,
    pub(super) u: DVec3,
    pub(super) v: DVec3,
}

impl Arc {
    pub(super) fn at(&self, angle: f64) -> DVec3 {
        let (sin, cos) = trig::sin_cos(angle);
        self.center + (self.u * cos + self.v * sin) * self.radius
    }

    /// Centre and radius of a ball that holds the arc up to `angle`, at most pi.
    pub(super) fn ball_around(&self, angle: f64) -> (DVec3, f64) {
        (self.at(0.5 * angle), 2.0 * self.radius * trig::sin_cos(0.25 * angle).0 + 1.0)
    }

    /// First angle in [0, 2 pi) at which the centre comes within `reach` of `other`, which it is
    /// not within at the start but for rounding; `None` where it never does.
    pub(super) fn meets(&self, other: DVec3, reach: f64) -> Option<f64> {
        let d = other - self.center;
        let (p, q) = (d.dot(self.u), d.dot(self.v));
        let k =
            (self.radius * self.radius + d.length_squared() - reach * reach) / (2.0 * self.radius);
        let amplitude = (p * p + q * q).sqrt();
        if k.abs() >= amplitude {
            return None;
        }
        if p >= k - TOUCH_MARGIN && q > SPEED_MARGIN * amplitude {
            // It touches already, and the motion leads into it.
            return Some(0.0);
        }
        // What it touches and leaves may be met again, from the other side, further along.
        let entry = trig::atan2(q, p) - trig::acos(k / amplitude);
        Some(if entry < 0.0 { entry + core::f64::consts::TAU } else { entry })
    }

    /// First angle at which the height of `w`, a vector that turns with the arc, falls to zero;
    /// it is positive at the start.
    pub(super) fn sinks(&self, w: DVec3) -> f64 {
        let axis = self.u.cross(self.v);
        let (along_u, along_v, along_axis) = (w.dot(self.u), w.dot(self.v), w.dot(axis));
        let p = along_u * self.u.y + along_v * self.v.y;
        let q = along_u * self.v.y - along_v * self.u.y;
        let k = -along_axis * axis.y;
        let amplitude = (p * p + q * q).sqrt();
        if k.abs() >= amplitude {
            return if p > k { core::f64::consts::PI } else { 0.0 };
        }
        if p <= k {
            return 0.0;
        }
        let exit = trig::atan2(q, p) + trig::acos(k / amplitude);
        exit.clamp(0.0, core::f64::consts::PI)
    }
}
