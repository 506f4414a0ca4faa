//! `snowgrain develop` as typed.

use super::{
    DenoiseArguments, DisplayArguments, GroupFactor, PictureFile, Series, laboratory_values,
};
use clap::Args;
use snowgrain_optics::{Absorption, Impurity, Primaries};
use std::path::PathBuf;

/// Makes pictures of a film, with other lights, ice, impurities or display if wanted; nothing is traced.
///
/// Ice and impurities can be changed where the film keeps ice paths (render --keep ice-paths), lights mixed where
/// it keeps groups (several in the scene, or render --keep light-groups). What is not named stays as the film was
/// rendered.
#[derive(Debug, Args)]
#[command(after_help = "Examples:\n  \
    snowgrain render snowy-teapot --keep ice-paths -o teapot.film\n  \
    snowgrain develop teapot.film --impurity soot=200ppb -o sooty.png\n  \
    snowgrain develop teapot.film --impurity dust-sahara=100ppm --ice-k warren-brandt-2008 -o dusty.png\n  \
    snowgrain develop teapot.film --denoise -o smooth.png\n  \
    snowgrain develop winter.film --group sun=0.5 --group sky=2,#ffd0a0 -o dusk.png -o dusk.exr\n  \
    snowgrain develop winter.film --exposure auto --curve agx --glare eye --gamut compress -o shown.png\n  \
    snowgrain develop teapot.film --wavelengths 400:700:20 -o teapot.exr")]
pub(crate) struct DevelopArguments {
    /// Film (.film)
    pub(crate) film: PathBuf,

    /// Where the picture goes, several times if wanted: .png (sRGB) or .exr (scene-linear, all
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

    /// Mixes the light of a group of lights (or of glints) anew: a strength, and if wanted a colour as r,g,b
    /// (linear), #rrggbb or a temperature, as sun=0.5 or sky=2,#ffd0a0 or lamp=1,3200K; groups that are not
    /// named stay; repeatable
    #[arg(long, value_name = "NAME=STRENGTH[,COLOUR]")]
    pub(crate) group: Vec<GroupFactor>,

    #[command(flatten)]
    pub(crate) display: DisplayArguments,

    #[command(flatten)]
    pub(crate) denoise: DenoiseArguments,
}
