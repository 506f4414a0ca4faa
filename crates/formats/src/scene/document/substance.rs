//! `[material]` as written.

use schemars::JsonSchema;
use serde::Deserialize;
use snowgrain_optics::Substance;

/// What the grains are made of.
#[derive(Clone, Debug, Default, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct MaterialTable {
    /// "ice", "salt" (NaCl), "sugar" (sucrose), "soda-lime-glass" (also "glass"), "borosilicate-glass" (N-BK7; also
    /// "bk7"), "quartz" (SiO2, as sand), "fused-silica" or "measured" (from `file`); default "ice", of which
    /// `ice.ior` and the other keys there say more.
    pub kind: SubstanceName,
    /// File of measured indices, relative to the scene file: lines of a wavelength (nm, or with a unit as 0.38um), n
    /// and, if it is known, k, from 380 to 780 nm or farther; measured.
    pub file: Option<String>,
    /// Density of the substance, kg/m^3, above 0: what `snow.density` is counted by; measured.
    pub density: Option<f64>,
    /// Whether colours are refracted each by its own index (halos, sparkle); else all are by that of sodium light,
    /// 589.3 nm, or by `ice.ior`; default false.
    pub dispersion: bool,
}

/// Substances.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum SubstanceName {
    /// H2O.
    #[default]
    Ice,
    /// NaCl.
    Salt,
    /// Sucrose.
    Sugar,
    /// Window glass.
    #[serde(alias = "glass")]
    SodaLimeGlass,
    /// N-BK7.
    #[serde(alias = "bk7")]
    BorosilicateGlass,
    /// SiO2, crystalline.
    Quartz,
    /// SiO2, glassy.
    FusedSilica,
    /// From a file.
    Measured,
}

impl SubstanceName {
    /// The substance of this name, where it is built in.
    #[must_use]
    pub fn built_in(self) -> Option<Substance> {
        match self {
            Self::Ice => Some(Substance::Ice),
            Self::Salt => Some(Substance::Salt),
            Self::Sugar => Some(Substance::Sugar),
            Self::SodaLimeGlass => Some(Substance::SodaLimeGlass),
            Self::BorosilicateGlass => Some(Substance::BorosilicateGlass),
            Self::Quartz => Some(Substance::Quartz),
            Self::FusedSilica => Some(Substance::FusedSilica),
            Self::Measured => None,
        }
    }
}
