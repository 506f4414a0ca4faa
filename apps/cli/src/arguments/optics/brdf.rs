//! `snowgrain optics brdf` as typed.

use super::{SearchArguments, SnowArguments};
use crate::arguments::{PlotFile, Series, laboratory_values};
use clap::{ArgGroup, Args, ValueEnum};

/// Into which directions flat layers of snow reflect parallel light.
///
/// BRF is the bidirectional reflectance factor, pi times the BRDF: 1 for a white diffuse surface,
/// whichever the directions. One line for each method, each combination of radius, density, depth,
/// ground, impurities and light, each wavelength and each direction from which the snow is seen. Its mean
/// over the hemisphere, weighted with the cosine, is the plane albedo. Azimuths are counted from where
/// the light goes: at 0 the snow is seen against the light (away from the sun, forward), at 180 with the
/// light in the back.
///
/// Light that one grain turns is exact, and has the rainbow of smooth spheres at 130 to 142 degrees from
/// the direction of the light, which natural snow has not.
#[derive(Debug, Args)]
#[command(group = ArgGroup::new("grains").required(true).args(["radius", "ssa", "layers"]))]
#[command(after_help = "Examples:\n  \
    snowgrain optics brdf --radius 200um --sza 60 --wavelengths 900\n  \
    snowgrain optics brdf --ssa 15 --sza 30,60 --vza 0:60:30 --azimuth 0,90,180 \\\n    \
        --method homogeneous,kokhanovsky-breon\n  \
    snowgrain optics brdf --radius 100um --depth 2cm --ground 0.2 --sza 50 --format json")]
pub(crate) struct BrdfArguments {
    #[command(flatten)]
    pub(crate) snow: SnowArguments,

    /// Wavelengths, nm: a list, or FIRST:LAST:STEP; 300 to 2500
    #[arg(long, value_name = "NM,...|FROM:TO:STEP", default_value = "550",
          value_parser = laboratory_values::wavelengths)]
    pub(crate) wavelengths: Series,

    /// Zenith angles of the light, degrees
    #[arg(long, value_name = "DEGREES,...", required = true,
          value_parser = laboratory_values::zeniths)]
    pub(crate) sza: Vec<Series>,

    /// Zenith angles from which the snow is seen, degrees
    #[arg(long, value_name = "DEGREES,...", default_value = "0:80:10",
          value_parser = laboratory_values::zeniths)]
    pub(crate) vza: Vec<Series>,

    /// Azimuths from which it is seen, degrees: 0 forward (away from the sun), 180 from the side of the
    /// sun
    #[arg(long, value_name = "DEGREES,...", default_value = "0:180:15", allow_hyphen_values = true,
          value_parser = laboratory_values::azimuths)]
    pub(crate) azimuth: Vec<Series>,

    /// How it is found
    #[arg(long, value_name = "NAME,...", value_delimiter = ',', default_value = "homogeneous")]
    pub(crate) method: Vec<BrdfMethod>,

    /// Standard error of each BRF to reach by Monte Carlo
    #[arg(long, value_name = "ERROR", default_value_t = 0.01,
          value_parser = laboratory_values::standard_error)]
    pub(crate) stderr: f64,

    /// Draws it too, as SVG or PNG: the hemisphere of directions, or, of less than three azimuths, lines
    /// over the zenith angle
    #[arg(long, value_name = "FILE.svg|.png")]
    pub(crate) plot: Option<PlotFile>,

    #[command(flatten)]
    pub(crate) search: SearchArguments,
}

/// Ways to find a BRDF.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum BrdfMethod {
    /// Monte Carlo through grains that are met at random, by the closed form of a sphere
    Homogeneous,
    /// Kokhanovsky and Breon 2012, a fit to natural snow: one layer of infinite depth
    KokhanovskyBreon,
}
