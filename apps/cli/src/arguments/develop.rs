//! `snowgrain develop` as typed.

use super::{DenoiseArguments, PictureFile, Series, laboratory_values, values};
use clap::Args;
use snowgrain_optics::{Absorption, Impurity, Primaries};
use std::path::PathBuf;

/// Makes pictures of a film, with other ice, impurities or primaries if wanted; nothing is traced.
///
/// Ice and impurities can be changed where the film keeps ice paths (render --keep ice-paths). What is
/// not named stays as the film was rendered.
#[derive(Debug, Args)]
#[command(after_help = "Examples:\n  \
    snowgrain render snowy-teapot --keep ice-paths -o teapot.film\n  \
    snowgrain develop teapot.film --impurity soot=200ppb -o sooty.png\n  \
    snowgrain develop teapot.film --impurity dust-sahara=100ppm --ice-k warren-brandt-2008 -o dusty.png\n  \
    snowgrain develop teapot.film --denoise -o smooth.png\n  \
    snowgrain develop teapot.film --wavelengths 400:700:20 -o teapot.exr")]
pub(crate) struct DevelopArguments {
    /// Film (.film)
    pub(crate) film: PathBuf,

    /// Where the picture goes, several times if wanted: .png (sRGB, 8 bit) or .exr (scene-linear, all
    /// layers)
    #[arg(short, long, value_name = "FILE", required = true)]
    pub(crate) output: Vec<PictureFile>,

    /// Load of an impurity between the grains, as black-carbon=200ppb (soot is the same),
    /// dust-sahara=50ppm or snow-algae=20000cells/mL; it replaces the film's load of that impurity;
    /// repeatable
    #[arg(long, value_name = "NAME=LOAD", value_parser = laboratory_values::impurity)]
    pub(crate) impurity: Vec<Impurity>,

    /// Takes away the impurities that the film was rendered with
    #[arg(long)]
    pub(crate) clean: bool,

    /// Absorption of the ice: picard-2016, warren-brandt-2008, or a number of 1/m for all wavelengths
    #[arg(long, value_name = "SOURCE", allow_negative_numbers = true,
          value_parser = laboratory_values::absorption)]
    pub(crate) ice_k: Option<Absorption>,

    /// Primaries of .exr files: srgb or acescg [default: those of the film]
    #[arg(long, value_name = "NAME", value_parser = laboratory_values::primaries)]
    pub(crate) primaries: Option<Primaries>,

    /// Adds spectral layers to .exr files, in the layout of Fichet et al. 2021: radiance at
    /// wavelengths in nm, 380 to 780, as 450,550,650 or 400:700:20
    #[arg(long, value_name = "NM,...|FROM:TO:STEP",
          value_parser = laboratory_values::visible_wavelengths)]
    pub(crate) wavelengths: Option<Series>,

    /// Brightness of PNG files in stops: +1 doubles it
    #[arg(long, value_name = "STOPS", default_value_t = 0.0, allow_negative_numbers = true,
          value_parser = values::finite)]
    pub(crate) exposure: f64,

    #[command(flatten)]
    pub(crate) denoise: DenoiseArguments,
}
