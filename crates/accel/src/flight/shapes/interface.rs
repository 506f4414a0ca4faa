//! One interface between ice and what lies around it.

use snowgrain_math::DVec3;

/// Light at an interface: what passes, and where to.
#[derive(Clone, Copy, Debug)]
pub(super) struct Interface {
    /// Fraction that passes, of unpolarised light; 0 where all is reflected.
    pub(super) transmittance: f64,
    direction: DVec3,
    facing: DVec3,
    ratio: f64,
    /// Cosines of the angles on this side and beyond.
    cosine: f64,
    beyond: f64,
}

impl Interface {
    /// Of light along `direction` that meets a surface whose unit normal `facing` points to where it comes
    /// from; `ratio` is the index there over that beyond (Born & Wolf, "Principles of Optics", 7th ed.,
    /// section 1.5).
    #[inline(always)]
    pub(super) fn new(direction: DVec3, facing: DVec3, ratio: f64) -> Self {
        let cosine = (-direction.dot(facing)).clamp(0.0, 1.0);
        let beyond2 = 1.0 - ratio * ratio * (1.0 - cosine * cosine);
        let beyond = beyond2.max(0.0).sqrt();
        let across = (ratio * cosine - beyond) / (ratio * cosine + beyond);
        let along = (cosine - ratio * beyond) / (cosine + ratio * beyond);
        let passes = 1.0 - 0.5 * (across * across + along * along);
        let transmittance = if beyond2 > 0.0 { passes } else { 0.0 };
        Self { transmittance, direction, facing, ratio, cosine, beyond }
    }

    /// Unit direction of what is reflected.
    #[inline(always)]
    pub(super) fn reflected(&self) -> DVec3 {
        (self.direction + self.facing * (2.0 * self.cosine)).normalize()
    }

    /// Unit direction of what passes; without meaning where nothing does.
    #[inline(always)]
    pub(super) fn refracted(&self) -> DVec3 {
        let bend = self.ratio * self.cosine - self.beyond;
        (self.direction * self.ratio + self.facing * bend).normalize()
    }
}
