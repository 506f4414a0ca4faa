//! Liquid water: its refractive index and absorption, 300 to 2500 nm (Segelstein 1981, "The complex
//! refractive index of water", thesis, University of Missouri-Kansas City).

use crate::{Spectrum, table};
use core::f64::consts::PI;
use std::sync::LazyLock;

const TABLE: &str = include_str!("../data/water_nk_segelstein_1981.csv");

static REFRACTIVE_INDEX: LazyLock<Spectrum> = LazyLock::new(|| table::column(TABLE, "n"));
static IMAGINARY_INDEX: LazyLock<Spectrum> = LazyLock::new(|| table::column(TABLE, "k"));

/// The real part n of the refractive index.
#[must_use]
pub fn refractive_index(wavelength_nm: f64) -> f64 {
    REFRACTIVE_INDEX.at(wavelength_nm)
}

/// The absorption coefficient 4 pi k / lambda, 1/m.
#[must_use]
pub fn absorption_per_metre(wavelength_nm: f64) -> f64 {
    4.0 * PI * IMAGINARY_INDEX.at(wavelength_nm) / (wavelength_nm * 1e-9)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn water_bends_and_absorbs_as_is_known() {
        assert!((refractive_index(550.0) - 1.333).abs() < 4e-3);
        // Red light is halved by a few metres, infrared by millimetres.
        assert!((0.4..0.8).contains(&absorption_per_metre(700.0)));
        assert!((5.0..60.0).contains(&absorption_per_metre(970.0)));
        assert!(absorption_per_metre(1450.0) > 2000.0);
    }
}
