//! Flat layers of snow and what lights them.

use snowgrain_optics::ice::{self, ICE_DENSITY, IceAbsorption};
use snowgrain_optics::{Dielectric, Impurity, sphere};

/// How light arrives.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Incidence {
    /// The same radiance from all directions above.
    Diffuse,
    /// Parallel light at this angle from the vertical, degrees, in [0, 90).
    Sun {
        /// Angle from the vertical, degrees.
        zenith_degrees: f64,
    },
}

/// A layer of equal grains of ice.
#[derive(Clone, Debug, PartialEq)]
pub struct SnowLayer {
    /// Radius of the grains, metres.
    pub radius: f64,
    /// Density, kg/m^3, above 0 and at most 917.
    pub density: f64,
    /// Depth, metres; infinite for the last layer of deep snow.
    pub depth: f64,
    /// What lies between the grains.
    pub impurities: Vec<Impurity>,
}

/// Layers from the top down, on a ground.
#[derive(Clone, Debug, PartialEq)]
pub struct SnowStack {
    /// From the top down; only the last may be infinite.
    pub layers: Vec<SnowLayer>,
    /// Albedo of the ground, 0 to 1, which reflects light diffusely.
    pub ground_albedo: f64,
    /// Which measurements of the absorption of ice.
    pub ice: IceAbsorption,
}

impl SnowLayer {
    /// Extinction by grains, 1/m: the projected area of all grains in a volume.
    #[must_use]
    pub fn extinction_per_metre(&self) -> f64 {
        0.75 * (self.density / ICE_DENSITY) / self.radius
    }

    /// Optical depth.
    #[must_use]
    pub fn optical_depth(&self) -> f64 {
        self.extinction_per_metre() * self.depth
    }

    /// Absorption a metre of ice, with that of the impurities.
    #[must_use]
    pub fn absorption_per_metre(&self, ice: IceAbsorption, wavelength_nm: f64) -> f64 {
        if self.impurities.is_empty() {
            return ice.per_metre(wavelength_nm);
        }
        let eta = ice::refractive_index(wavelength_nm);
        let enhancement = sphere::absorption_enhancement(Dielectric { eta });
        let impurities = self.impurities.iter();
        ice.per_metre(wavelength_nm)
            + impurities.map(|i| i.per_metre_of_ice(wavelength_nm, enhancement)).sum::<f64>()
    }
}

impl SnowStack {
    /// Whether no light reaches the ground.
    #[must_use]
    pub fn is_deep(&self) -> bool {
        self.layers.last().is_some_and(|layer| layer.depth.is_infinite())
    }
}
