//! What grains are made of: ice, or another clear substance, with its index of refraction and what it absorbs.
//!
//! Formulae hold at room temperature and from 380 to 780 nm at least. Where no absorption is named the visible
//! light that grains of millimetres absorb cannot be measured, and none is taken.

use crate::ice;
use crate::water;
use crate::{IceAbsorption, Spectrum};
use core::f64::consts::PI;
use std::sync::Arc;

/// Wavelength of the index of refraction that is traced where colours do not part, nm: the sodium D line, the
/// one that handbooks give.
pub const REFERENCE_WAVELENGTH_NM: f64 = 589.3;

/// Indices of refraction that can be traced.
pub const INDICES: [f64; 2] = [1.0, 4.0];

/// What grains are made of.
#[derive(Clone, Debug, Default, PartialEq)]
pub enum Substance {
    /// H2O, [`crate::ice`].
    #[default]
    Ice,
    /// NaCl, halite: Li 1976, "Refractive index of alkali halides and its wavelength and temperature
    /// derivatives", J. Phys. Chem. Ref. Data 5, 329; .2 to 30 um.
    Salt,
    /// Sucrose, biaxial: the mean of its three principal indices, 1.5376, 1.5651 and 1.5705 (sodium light; CRC
    /// Handbook of Chemistry and Physics), at all wavelengths. Double refraction is left out.
    Sugar,
    /// Clear window glass: Rubin 1985, "Optical properties of soda lime silica glasses", Solar Energy Materials
    /// 12, 275; its index above .31 um. The iron of greener glasses absorbs: give those as a table.
    SodaLimeGlass,
    /// Schott N-BK7, of the maker's data sheet; .3 to 2.5 um.
    BorosilicateGlass,
    /// SiO2, crystalline, as sand is: Ghosh 1999, "Dispersion-equation coefficients for the refractive index and
    /// birefringence of calcite and quartz crystals", Opt. Commun. 163, 95; the mean of two ordinary indices and
    /// the extraordinary one, which differ by .009. Double refraction is left out.
    Quartz,
    /// SiO2, glassy: Malitson 1965, "Interspecimen comparison of the refractive index of fused silica", J. Opt.
    /// Soc. Am. 55, 1205; .21 to 3.71 um.
    FusedSilica,
    /// As someone has measured.
    Measured(Arc<MeasuredSubstance>),
}

/// A substance known by measurements.
#[derive(Clone, Debug, PartialEq)]
pub struct MeasuredSubstance {
    /// Real part n of the index of refraction.
    pub index: Spectrum,
    /// Imaginary part k, at the same wavelengths.
    pub imaginary: Spectrum,
    /// Density of the substance, kg/m^3, if it is known.
    pub density: Option<f64>,
}

impl Substance {
    /// All that are built in.
    pub const BUILT_IN: [Self; 7] = [
        Self::Ice,
        Self::Salt,
        Self::Sugar,
        Self::SodaLimeGlass,
        Self::BorosilicateGlass,
        Self::Quartz,
        Self::FusedSilica,
    ];

    /// The name by which users choose it.
    #[must_use]
    pub fn name(&self) -> &'static str {
        match self {
            Self::Ice => "ice",
            Self::Salt => "salt",
            Self::Sugar => "sugar",
            Self::SodaLimeGlass => "soda-lime-glass",
            Self::BorosilicateGlass => "borosilicate-glass",
            Self::Quartz => "quartz",
            Self::FusedSilica => "fused-silica",
            Self::Measured(_) => "measured",
        }
    }

    /// The real part n of the index of refraction in air.
    #[must_use]
    pub fn refractive_index(&self, wavelength_nm: f64) -> f64 {
        let um = wavelength_nm / 1000.0;
        match self {
            Self::Ice => ice::refractive_index(wavelength_nm),
            Self::Salt => salt(um),
            Self::Sugar => (1.5376 + 1.5651 + 1.5705) / 3.0,
            Self::SodaLimeGlass => 1.5130 - 0.003_169 * (um * um) + 0.003_962 / (um * um),
            Self::BorosilicateGlass => borosilicate(um),
            Self::Quartz => {
                let [ordinary, extraordinary] = quartz(um);
                (2.0 * ordinary + extraordinary) / 3.0
            }
            Self::FusedSilica => fused_silica(um),
            Self::Measured(measured) => measured.index.at(wavelength_nm),
        }
    }

    /// The index relative to water between the grains, or to air.
    #[must_use]
    pub fn index_relative_to(&self, is_in_water: bool, wavelength_nm: f64) -> f64 {
        let index = self.refractive_index(wavelength_nm);
        if is_in_water { index / water::refractive_index(wavelength_nm) } else { index }
    }

    /// Whether its index is known to depend on the wavelength.
    #[must_use]
    pub fn disperses(&self) -> bool {
        match self {
            Self::Ice
            | Self::Salt
            | Self::SodaLimeGlass
            | Self::BorosilicateGlass
            | Self::Quartz
            | Self::FusedSilica => true,
            Self::Sugar => false,
            Self::Measured(measured) => {
                let mut values = measured.index.points().map(|(_, n)| n);
                let first = values.next();
                values.any(|n| Some(n) != first)
            }
        }
    }

    /// The absorption coefficient, 1/m; of ice that of its default measurements.
    #[must_use]
    pub fn per_metre(&self, wavelength_nm: f64) -> f64 {
        match self {
            Self::Ice => IceAbsorption::default().per_metre(wavelength_nm),
            Self::Salt
            | Self::Sugar
            | Self::SodaLimeGlass
            | Self::BorosilicateGlass
            | Self::Quartz
            | Self::FusedSilica => 0.0,
            Self::Measured(measured) => {
                4.0 * PI * measured.imaginary.at(wavelength_nm) / (wavelength_nm * 1e-9)
            }
        }
    }

    /// The same if it absorbed nothing.
    pub(crate) fn without_absorption(&self) -> Self {
        let Self::Measured(measured) = self else { return self.clone() };
        let imaginary = measured.imaginary.scaled(0.0);
        Self::Measured(Arc::new(MeasuredSubstance { imaginary, ..(**measured).clone() }))
    }

    /// Density of the substance, kg/m^3 (CRC Handbook of Chemistry and Physics; glasses: of the makers).
    #[must_use]
    pub fn density(&self) -> Option<f64> {
        match self {
            Self::Ice => Some(ice::ICE_DENSITY),
            Self::Salt => Some(2165.0),
            Self::Sugar => Some(1587.0),
            Self::SodaLimeGlass => Some(2500.0),
            Self::BorosilicateGlass => Some(2510.0),
            Self::Quartz => Some(2650.0),
            Self::FusedSilica => Some(2200.0),
            Self::Measured(measured) => measured.density,
        }
    }
}

/// The sum of b l^2 / (l^2 - c) over pairs (b, c), of the wavelength l in um.
fn sellmeier(um: f64, terms: &[[f64; 2]]) -> f64 {
    let square = um * um;
    terms.iter().map(|[b, c]| b * square / (square - c)).sum()
}

fn salt(um: f64) -> f64 {
    const TERMS: [[f64; 2]; 7] = [
        [0.198_00, 0.050 * 0.050],
        [0.483_98, 0.100 * 0.100],
        [0.386_96, 0.128 * 0.128],
        [0.259_98, 0.158 * 0.158],
        [0.087_96, 40.50 * 40.50],
        [3.170_64, 60.98 * 60.98],
        [0.300_38, 120.34 * 120.34],
    ];
    (1.000_55 + sellmeier(um, &TERMS)).sqrt()
}

fn borosilicate(um: f64) -> f64 {
    const TERMS: [[f64; 2]; 3] = [
        [1.039_612_12, 0.006_000_698_67],
        [0.231_792_344, 0.020_017_914_4],
        [1.010_469_45, 103.560_653],
    ];
    (1.0 + sellmeier(um, &TERMS)).sqrt()
}

/// Ordinary and extraordinary.
fn quartz(um: f64) -> [f64; 2] {
    const ORDINARY: [[f64; 2]; 2] = [[1.070_440_83, 0.010_058_599_7], [1.102_022_42, 100.0]];
    const EXTRAORDINARY: [[f64; 2]; 2] = [[1.095_099_24, 0.010_210_186_4], [1.156_624_75, 100.0]];
    [
        (1.286_041_41 + sellmeier(um, &ORDINARY)).sqrt(),
        (1.288_518_04 + sellmeier(um, &EXTRAORDINARY)).sqrt(),
    ]
}

fn fused_silica(um: f64) -> f64 {
    const TERMS: [[f64; 2]; 3] = [
        [0.696_166_3, 0.068_404_3 * 0.068_404_3],
        [0.407_942_6, 0.116_241_4 * 0.116_241_4],
        [0.897_479_4, 9.896_161 * 9.896_161],
    ];
    (1.0 + sellmeier(um, &TERMS)).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn indices_are_those_of_handbooks() {
        // CRC Handbook (salt and quartz, at 18 to 20 C; the formula of salt is of 24 C), data sheet of N-BK7 (F, d and C lines), Malitson's
        // table (F', d and C), Warren and Brandt.
        for (substance, nm, index, within) in [
            (Substance::Salt, 589.3, 1.5443, 3e-4),
            (Substance::Sugar, 589.3, 1.5577, 1e-4),
            (Substance::SodaLimeGlass, 589.3, 1.5233, 2e-4),
            (Substance::BorosilicateGlass, 486.13, 1.522_38, 1e-5),
            (Substance::BorosilicateGlass, 587.56, 1.516_80, 1e-5),
            (Substance::BorosilicateGlass, 656.27, 1.514_32, 1e-5),
            (Substance::FusedSilica, 486.13, 1.463_13, 1e-5),
            (Substance::FusedSilica, 587.56, 1.458_46, 1e-5),
            (Substance::FusedSilica, 656.27, 1.456_37, 1e-5),
            (Substance::Quartz, 589.3, (2.0 * 1.544_24 + 1.553_35) / 3.0, 1e-4),
            (Substance::Ice, 589.3, 1.3097, 1e-3),
        ] {
            let found = substance.refractive_index(nm);
            assert!((found - index).abs() < within, "{substance:?} {nm}: {found}");
        }
    }

    #[test]
    fn all_but_sugar_bend_blue_light_more_than_red() {
        for substance in Substance::BUILT_IN {
            let [violet, red] = [420.0, 680.0].map(|nm| substance.refractive_index(nm));
            assert_eq!(violet > red, substance.disperses(), "{substance:?}");
            assert!((INDICES[0]..INDICES[1]).contains(&red) && violet >= red);
            assert!(substance.density().unwrap() >= ice::ICE_DENSITY);
        }
    }

    #[test]
    fn a_measured_substance_absorbs_as_its_k_says() {
        let spectrum = |values: [f64; 2]| Spectrum::new(vec![380.0, 780.0], values.to_vec());
        let measured = MeasuredSubstance {
            index: spectrum([1.6, 1.5]).unwrap(),
            imaginary: spectrum([1e-6, 1e-6]).unwrap(),
            density: None,
        };
        let substance = Substance::Measured(Arc::new(measured));
        // 4 pi 1e-6 / 580e-9.
        assert!((substance.per_metre(580.0) - 21.666_2).abs() < 1e-3);
        assert!((substance.refractive_index(580.0) - 1.55).abs() < 1e-12);
        let in_water = substance.index_relative_to(true, 580.0);
        assert!((in_water * water::refractive_index(580.0) - 1.55).abs() < 1e-12);
    }
}
