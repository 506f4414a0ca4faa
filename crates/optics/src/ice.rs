//! Ice: its refractive index and absorption, 300 to 2500 nm.

use crate::{Spectrum, Substance, table};
use core::f64::consts::PI;
use std::sync::LazyLock;

/// Density of ice, kg/m^3.
pub const ICE_DENSITY: f64 = 917.0;

/// Wavelengths for which ice is tabulated, nm.
pub const WAVELENGTHS_NM: [f64; 2] = [300.0, 2500.0];

static REFRACTIVE_INDEX: LazyLock<Spectrum> = LazyLock::new(|| table::column(TABLE, "n"));
static PICARD_2016: LazyLock<Spectrum> = LazyLock::new(|| table::column(TABLE, "k_p2016"));
static WARREN_BRANDT_2008: LazyLock<Spectrum> = LazyLock::new(|| table::column(TABLE, "k_wb2008"));

const TABLE: &str = include_str!("../data/ice_nk_1nm.csv");

/// Measurements of the imaginary part of the refractive index. They differ below 600 nm only, there
/// by up to a factor of 40: snow of clean grains reflects .993 or .981 of the blue light (r = .5 mm,
/// 450 nm).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum IceAbsorption {
    /// Picard, Libois and Arnaud 2016, "Refinement of the ice absorption spectrum in the visible
    /// using radiance profile measurements in Antarctic snow", The Cryosphere 10, 2655, the cleanest
    /// site, below 600 nm; above, Warren and Brandt 2008.
    #[default]
    Picard2016,
    /// Warren and Brandt 2008, "Optical constants of ice from the ultraviolet to the microwave: A
    /// revised compilation", J. Geophys. Res. 113, D14220.
    WarrenBrandt2008,
}

impl IceAbsorption {
    /// All sources.
    pub const ALL: [Self; 2] = [Self::Picard2016, Self::WarrenBrandt2008];

    /// The name by which users choose it.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Picard2016 => "picard-2016",
            Self::WarrenBrandt2008 => "warren-brandt-2008",
        }
    }

    /// The imaginary part k of the refractive index.
    #[must_use]
    pub fn imaginary_index(self, wavelength_nm: f64) -> f64 {
        match self {
            Self::Picard2016 => PICARD_2016.at(wavelength_nm),
            Self::WarrenBrandt2008 => WARREN_BRANDT_2008.at(wavelength_nm),
        }
    }

    /// The absorption coefficient gamma = 4 pi k / lambda, 1/m.
    #[must_use]
    pub fn per_metre(self, wavelength_nm: f64) -> f64 {
        4.0 * PI * self.imaginary_index(wavelength_nm) / (wavelength_nm * 1e-9)
    }
}

/// What the grains of a scene absorb.
#[derive(Clone, Debug, PartialEq)]
pub enum Absorption {
    /// Ice that absorbs the same at every wavelength, 1/m, at least 0.
    Grey(f64),
    /// Ice as measured.
    Measured(IceAbsorption),
    /// Another substance.
    Of(Substance),
}

impl Absorption {
    /// The absorption coefficient, 1/m.
    #[must_use]
    pub fn per_metre(&self, wavelength_nm: f64) -> f64 {
        match self {
            Self::Grey(per_metre) => *per_metre,
            Self::Measured(source) => source.per_metre(wavelength_nm),
            Self::Of(substance) => substance.per_metre(wavelength_nm),
        }
    }

    /// That of the same substance if it absorbed nothing.
    #[must_use]
    pub fn none(&self) -> Self {
        match self {
            Self::Grey(_) | Self::Measured(_) => Self::Grey(0.0),
            Self::Of(substance) => Self::Of(substance.without_absorption()),
        }
    }

    /// Density of the substance by that of ice; 1 where it is not known.
    #[must_use]
    pub fn density_ratio(&self) -> f64 {
        self.substance().density().map_or(1.0, |density| density / ICE_DENSITY)
    }

    /// What it is the absorption of.
    #[must_use]
    pub fn substance(&self) -> Substance {
        match self {
            Self::Grey(_) | Self::Measured(_) => Substance::Ice,
            Self::Of(substance) => substance.clone(),
        }
    }
}

impl Default for Absorption {
    fn default() -> Self {
        Self::Measured(IceAbsorption::default())
    }
}

/// The real part n of the refractive index (Warren and Brandt 2008).
#[must_use]
pub fn refractive_index(wavelength_nm: f64) -> f64 {
    REFRACTIVE_INDEX.at(wavelength_nm)
}

/// Specific surface area of spheres of this radius (metres), m^2/kg: 3 / (917 r).
#[must_use]
pub fn specific_surface_area(radius: f64) -> f64 {
    3.0 / (ICE_DENSITY * radius)
}

/// Radius of the spheres of this specific surface area (m^2/kg), metres.
#[must_use]
pub fn radius_of_specific_surface_area(area: f64) -> f64 {
    3.0 / (ICE_DENSITY * area)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ice_absorbs_what_its_sources_say() {
        let [picard, warren] = IceAbsorption::ALL;
        for (wavelength, gamma) in
            [(600.0, 0.120), (700.0, 0.521), (800.0, 2.105), (900.0, 5.864), (1300.0, 127.6)]
        {
            for source in IceAbsorption::ALL {
                assert!((source.per_metre(wavelength) / gamma - 1.0).abs() < 2e-3, "{wavelength}");
            }
        }
        assert!((picard.per_metre(450.0) - 0.0179).abs() < 1e-4);
        assert!((warren.per_metre(450.0) - 0.0026).abs() < 1e-4);
        assert!((refractive_index(589.0) - 1.3097).abs() < 1e-3);
        assert!((specific_surface_area(200e-6) - 16.357).abs() < 1e-3);
        assert!((radius_of_specific_surface_area(16.357_688) - 200e-6).abs() < 1e-11);
    }
}
