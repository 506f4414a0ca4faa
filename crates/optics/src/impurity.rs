//! What darkens snow: particles and cells between its grains.
//!
//! They are an *external mixture*: beside the grains, not in them, and too few to scatter. Light
//! meets them along its whole path through the snow, of which a path in ice of length 1 is B phi / 1
//! (B: [`crate::sphere::absorption_enhancement`], phi: solid fraction), so that they act as an
//! absorption of the ice of `c 917 MAC / B` a metre, with `c` their mass per mass of ice; the same as
//! a co-albedo of `4 c MAC / SSA` a grain (PHYSICS of the project, section 4).

use crate::ice::ICE_DENSITY;
use crate::{Spectrum, table};
use std::sync::LazyLock;

/// Kinds of impurity.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum ImpurityKind {
    /// Uncoated black carbon, 1270 kg/m^3 (SNICAR-ADv3, Flanner et al. 2021, Geosci. Model Dev. 14,
    /// 7673).
    BlackCarbon,
    /// Black carbon of 7.5 m^2/g at 550 nm, as 1/lambda (Bond and Bergstrom 2006, Aerosol Sci.
    /// Technol. 40, 27).
    BlackCarbonBond2006,
    /// Black carbon coated with sulfate (SNICAR-ADv3).
    CoatedBlackCarbon,
    /// Brown carbon (Kirchstetter et al. 2004, in SNICAR-ADv3).
    BrownCarbon,
    /// Saharan dust, 2.5 to 5 um (Balkanski et al. 2007, in SNICAR-ADv3).
    DustSahara,
    /// Saharan dust, .1 to 1 um (Balkanski et al. 2007, in SNICAR-ADv3).
    FineDustSahara,
    /// Dust of the San Juan mountains, Colorado, 2.5 to 5 um (Skiles et al. 2017, in SNICAR-ADv3).
    DustColorado,
    /// Greenland dust, 2.5 to 5 um (Polashenski et al. 2015, in SNICAR-ADv3).
    DustGreenland,
    /// Dust of Libya below 10 um, 77 m^2/kg at 400 nm (Caponi et al. 2017, Atmos. Chem. Phys. 17,
    /// 7175).
    DustLibya,
    /// Volcanic ash of Eyjafjallajokull, 2.5 to 5 um (Flanner et al. 2014, in SNICAR-ADv3).
    VolcanicAsh,
    /// Cells of red snow algae (Chevrollier et al. 2023, J. Glaciol., doi 10.1017/jog.2022.64). Below
    /// 555 nm the table is flat, as its source has it.
    SnowAlgae,
    /// Cells of glacier algae (Chevrollier et al. 2023).
    GlacierAlgae,
}

/// How much of an impurity there is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Load {
    /// Mass of the impurity per mass of ice (1 ppb = 1 ng/g = 1e-9).
    MassFraction(f64),
    /// Cells per kilogram of ice; one cell in a millilitre of melt water is 1000 in a kilogram.
    CellsPerKilogram(f64),
}

/// An impurity and its load.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Impurity {
    /// What.
    pub kind: ImpurityKind,
    /// How much: a mass fraction for particles, cells for algae.
    pub load: Load,
}

const PARTICLES: &str = include_str!("../data/impurity_mass_cross_sections.csv");
const ALGAE: &str = include_str!("../data/snow_algae_cross_sections.csv");

/// A table column that is read once.
type Column = LazyLock<Spectrum>;

static BLACK_CARBON: Column = LazyLock::new(|| table::column(PARTICLES, "bc_MAC_m2_per_kg"));
static COATED: Column =
    LazyLock::new(|| table::column(PARTICLES, "sulfate_coated_bc_MAC_m2_per_kg"));
static BROWN_CARBON: Column =
    LazyLock::new(|| table::column(PARTICLES, "brown_carbon_MAC_m2_per_kg"));
static SAHARA: Column = LazyLock::new(|| table::column(PARTICLES, "dust_saharan_s3_MAC_m2_per_kg"));
static FINE_SAHARA: Column =
    LazyLock::new(|| table::column(PARTICLES, "dust_saharan_s1_MAC_m2_per_kg"));
static COLORADO: Column =
    LazyLock::new(|| table::column(PARTICLES, "dust_colorado_s3_MAC_m2_per_kg"));
static GREENLAND: Column =
    LazyLock::new(|| table::column(PARTICLES, "dust_greenland_s3_MAC_m2_per_kg"));
static ASH: Column = LazyLock::new(|| table::column(PARTICLES, "ash_eyja_s3_MAC_m2_per_kg"));
static SNOW_ALGAE: Column = LazyLock::new(|| table::column(ALGAE, "snow_algae_abs_m2_per_cell"));
static GLACIER_ALGAE: Column =
    LazyLock::new(|| table::column(ALGAE, "glacier_algae_abs_m2_per_cell"));

impl ImpurityKind {
    /// All kinds.
    pub const ALL: [Self; 12] = [
        Self::BlackCarbon,
        Self::BlackCarbonBond2006,
        Self::CoatedBlackCarbon,
        Self::BrownCarbon,
        Self::DustSahara,
        Self::FineDustSahara,
        Self::DustColorado,
        Self::DustGreenland,
        Self::DustLibya,
        Self::VolcanicAsh,
        Self::SnowAlgae,
        Self::GlacierAlgae,
    ];

    /// The name by which users choose it.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::BlackCarbon => "black-carbon",
            Self::BlackCarbonBond2006 => "black-carbon-bond-2006",
            Self::CoatedBlackCarbon => "coated-black-carbon",
            Self::BrownCarbon => "brown-carbon",
            Self::DustSahara => "dust-sahara",
            Self::FineDustSahara => "fine-dust-sahara",
            Self::DustColorado => "dust-colorado",
            Self::DustGreenland => "dust-greenland",
            Self::DustLibya => "dust-libya",
            Self::VolcanicAsh => "volcanic-ash",
            Self::SnowAlgae => "snow-algae",
            Self::GlacierAlgae => "glacier-algae",
        }
    }

    /// Whether it is counted in cells rather than weighed.
    #[must_use]
    pub fn is_counted(self) -> bool {
        matches!(self, Self::SnowAlgae | Self::GlacierAlgae)
    }

    /// Density of the particles, kg/m^3, for loads by volume; `None` for cells.
    #[must_use]
    pub fn density(self) -> Option<f64> {
        match self {
            Self::BlackCarbon | Self::CoatedBlackCarbon => Some(1270.0),
            Self::BlackCarbonBond2006 => Some(1800.0),
            Self::BrownCarbon => Some(1270.0),
            Self::DustSahara
            | Self::FineDustSahara
            | Self::DustColorado
            | Self::DustGreenland
            | Self::DustLibya => Some(2600.0),
            Self::VolcanicAsh => Some(2600.0),
            Self::SnowAlgae | Self::GlacierAlgae => None,
        }
    }

    /// Absorption cross-section: m^2 per kilogram, or per cell of what is counted.
    #[must_use]
    pub fn absorption_cross_section(self, wavelength_nm: f64) -> f64 {
        match self {
            Self::BlackCarbon => BLACK_CARBON.at(wavelength_nm),
            Self::BlackCarbonBond2006 => 7500.0 * 550.0 / wavelength_nm,
            Self::CoatedBlackCarbon => COATED.at(wavelength_nm),
            Self::BrownCarbon => BROWN_CARBON.at(wavelength_nm),
            Self::DustSahara => SAHARA.at(wavelength_nm),
            Self::FineDustSahara => FINE_SAHARA.at(wavelength_nm),
            Self::DustColorado => COLORADO.at(wavelength_nm),
            Self::DustGreenland => GREENLAND.at(wavelength_nm),
            Self::DustLibya => 77.0 * snowgrain_math::trig::pow(wavelength_nm / 400.0, -3.2),
            Self::VolcanicAsh => ASH.at(wavelength_nm),
            Self::SnowAlgae => SNOW_ALGAE.at(wavelength_nm),
            Self::GlacierAlgae => GLACIER_ALGAE.at(wavelength_nm),
        }
    }
}

impl Impurity {
    /// Absorption per metre of ice that the impurity of an external mixture amounts to, for grains
    /// whose absorption enhancement is `enhancement`, 1/m.
    #[must_use]
    pub fn per_metre_of_ice(&self, wavelength_nm: f64, enhancement: f64) -> f64 {
        let amount = match self.load {
            Load::MassFraction(amount) | Load::CellsPerKilogram(amount) => amount,
        };
        let cross_section = self.kind.absorption_cross_section(wavelength_nm);
        amount * ICE_DENSITY * cross_section / enhancement
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_impurity_absorbs_and_has_one_name() {
        for (index, kind) in ImpurityKind::ALL.into_iter().enumerate() {
            assert!(kind.absorption_cross_section(550.0) > 0.0, "{kind:?}");
            assert_eq!(kind.density().is_none(), kind.is_counted());
            assert!(!ImpurityKind::ALL[..index].iter().any(|other| other.name() == kind.name()));
        }
    }

    #[test]
    fn an_external_mixture_adds_the_co_albedo_of_the_tables() {
        // `albedo_soot.csv`: 1 - w = 3.06311e-6 clean, 1.56719e-5 with 10 ng/g of soot at 10.3125
        // m^2/g, r = 100 um, 400 nm.
        let (radius, enhancement) = (100e-6, 1.2535);
        let soot =
            Impurity { kind: ImpurityKind::BlackCarbonBond2006, load: Load::MassFraction(10e-9) };
        let gamma = soot.per_metre_of_ice(400.0, enhancement);
        let co_albedo = 4.0 / 3.0 * gamma * radius * enhancement;
        assert!((co_albedo / (1.56719e-5 - 3.06311e-6) - 1.0).abs() < 1e-3, "{co_albedo}");
    }
}
