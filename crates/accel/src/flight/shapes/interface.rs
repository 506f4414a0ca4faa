//! One interface between ice and what lies around it.

use snowgrain_math::DVec3;

/// Light at an interface: what passes, and where to.
#[derive(Clone, Copy, Debug)]
pub(super) struct Interface {
    /// Fraction that passes, of unpolarised light, `passes / of`; 0 where all is reflected.
    passes: f64,
    of: f64,
    direction: DVec3,
    facing: DVec3,
    ratio: f64,
    /// Cosines of the angles on this side and beyond.
    cosine: f64,
    beyond: f64,
}

impl Interface {
    /// Of light along `direction` that meets a surface whose unit normal `facing` points to where it comes
    /// from; `ratio` is the index there over that beyond. With c and c' the cosines here and beyond, n the ratio,
    /// a = n c + c' and b = c + n c', the mean of both polarisations passes 2 n c c' (1/a^2 + 1/b^2) (Born & Wolf,
    /// "Principles of Optics", 7th ed., section 1.5.3), a fraction that need not be divided out.
    #[inline(always)]
    pub(super) fn new(direction: DVec3, facing: DVec3, ratio: f64) -> Self {
        let cosine = (-direction.dot(facing)).clamp(0.0, 1.0);
        let beyond2 = 1.0 - ratio * ratio * (1.0 - cosine * cosine);
        let beyond = beyond2.max(0.0).sqrt();
        let (a, b) = (ratio * cosine + beyond, cosine + ratio * beyond);
        let (a2, b2) = (a * a, b * b);
        let passes = 2.0 * ratio * (cosine * beyond) * (a2 + b2);
        Self { passes, of: a2 * b2, direction, facing, ratio, cosine, beyond }
    }

    /// Fraction that passes.
    #[inline(always)]
    pub(super) fn transmittance(&self) -> f64 {
        if self.passes > 0.0 { self.passes / self.of } else { 0.0 }
    }

    /// Whether light passes, by a random number in `[0, 1)`.
    #[inline(always)]
    pub(super) fn lets_pass(&self, random: f64) -> bool {
        random * self.of < self.passes
    }

    /// Unit direction of what is reflected.
    #[inline(always)]
    pub(super) fn reflected(&self) -> DVec3 {
        straightened(self.direction + self.facing * (2.0 * self.cosine))
    }

    /// Unit direction of what passes; without meaning where nothing does.
    #[inline(always)]
    pub(super) fn refracted(&self) -> DVec3 {
        let bend = self.ratio * self.cosine - self.beyond;
        straightened(self.direction * self.ratio + self.facing * bend)
    }
}

/// A vector of nearly unit length brought closer to it by one step of Newton's method for the inverse square root: a
/// deviation of `e` becomes one of 1.5 e^2.
#[inline(always)]
fn straightened(v: DVec3) -> DVec3 {
    v * (1.5 - 0.5 * v.dot(v))
}
