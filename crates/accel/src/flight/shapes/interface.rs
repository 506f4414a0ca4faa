//! One interface between ice and what lies around it.

use snowgrain_math::DVec3;

/// What becomes of light at an interface.
#[derive(Clone, Copy, Debug)]
pub(super) struct Interface {
    /// Fraction that passes, of unpolarised light; 0 where all is reflected.
    pub(super) transmittance: f64,
    /// Unit direction of what is reflected.
    pub(super) reflected: DVec3,
    /// Unit direction of what passes; without meaning where nothing does.
    pub(super) refracted: DVec3,
}

impl Interface {
    /// Of light along `direction` that meets a surface whose unit normal `facing` points to where it comes
    /// from; `ratio` is the index there over that beyond (Born & Wolf, "Principles of Optics", 7th ed.,
    /// section 1.5).
    #[inline(always)]
    pub(super) fn new(direction: DVec3, facing: DVec3, ratio: f64) -> Self {
        let cosine = (-direction.dot(facing)).clamp(0.0, 1.0);
        let reflected = (direction + facing * (2.0 * cosine)).normalize();
        let beyond2 = 1.0 - ratio * ratio * (1.0 - cosine * cosine);
        if beyond2 <= 0.0 {
            return Self { transmittance: 0.0, reflected, refracted: direction };
        }
        let beyond = beyond2.sqrt();
        let across = (ratio * cosine - beyond) / (ratio * cosine + beyond);
        let along = (cosine - ratio * beyond) / (cosine + ratio * beyond);
        Self {
            transmittance: 1.0 - 0.5 * (across * across + along * along),
            reflected,
            refracted: (direction * ratio + facing * (ratio * cosine - beyond)).normalize(),
        }
    }
}
