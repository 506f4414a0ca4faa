//! A transparent medium.

use crate::fresnel;

/// A smooth transparent medium in air (or, with `eta` below 1, a bubble in it).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Dielectric {
    /// Index of refraction relative to the surroundings, > 0: ice in air 1.31 at 500 nm; 1.32 in
    /// the paper; ice in water .983.
    pub eta: f64,
}

impl Dielectric {
    /// Reflectance of light that arrives from the surroundings; cosine of incidence in [0, 1].
    #[must_use]
    pub fn reflectance_from_outside(self, cos_theta_i: f64) -> f64 {
        fresnel::reflectance(cos_theta_i, self.eta)
    }

    /// Reflectances from the surroundings of light polarised across the plane of incidence and along
    /// it.
    #[must_use]
    pub fn polarised_reflectances_from_outside(self, cos_theta_i: f64) -> [f64; 2] {
        fresnel::polarised_reflectances(cos_theta_i, self.eta)
    }

    /// Reflectance of light that arrives from the medium's inside; cosine of incidence in [0, 1].
    #[must_use]
    pub fn reflectance_from_inside(self, cos_theta_i: f64) -> f64 {
        fresnel::reflectance(cos_theta_i, 1.0 / self.eta)
    }
}
