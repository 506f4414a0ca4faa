//! `snowgrain optics spread` as typed.

use super::{PackName, SearchArguments, SnowArguments};
use crate::arguments::{PlotFile, Series, laboratory_values};
use clap::{ArgGroup, Args, ValueEnum};

/// How far snow spreads light that enters it at a point, and how long that light takes.
///
/// One layer over a black ground. One line for each figure, at each wavelength of each combination of
/// radius, density, depth, light, impurities and method. T stands for what is let through where R
/// is written here for what is reflected; `from` and `to` are the bounds of a bin:
///
///   R                   part of the light
///   R_per_area          per m^2, in rings about the point of entry (below it), radii in m
///   R_within            within the radius `to`
///   R_per_width         where a line along the light is lit: per m, across the line
///   R_per_path          per m of optical path: index times length in ice, and length in air
///   R_per_time          per ps that it takes (at the phase velocity)
///   R_median_radius_m   radius within which half of what leaves does
///   R_radius_90_m       the same for 90 %
///   R_mean_path_m       mean optical path of what leaves
///   R_mean_time_ps      mean time of it
///   transport_length_m  4 r / (3 phi (1 - g)), for comparison
///
/// Bins without light are left out.
#[derive(Debug, Args)]
#[command(group = ArgGroup::new("grains").required(true).args(["radius", "ssa", "layers"]))]
#[command(group = ArgGroup::new("light").args(["diffuse", "sza"]).multiple(true))]
#[command(verbatim_doc_comment)]
#[command(after_help = "Examples:\n  \
    snowgrain optics spread --radius 500um --density 275\n  \
    snowgrain optics spread --radius 500um --density 275 --depth 2cm --method homogeneous,grains \\\n    \
        --wavelengths 800 -o spread.csv")]
pub(crate) struct SpreadArguments {
    #[command(flatten)]
    pub(crate) snow: SnowArguments,

    /// Wavelengths, nm: a list, or FIRST:LAST:STEP; 300 to 2500; each is traced for itself
    #[arg(long, value_name = "NM,...|FROM:TO:STEP", default_value = "550",
          value_parser = laboratory_values::wavelengths)]
    pub(crate) wavelengths: Series,

    /// Light from all of the sky alike, at the point
    #[arg(long)]
    pub(crate) diffuse: bool,

    /// A beam at these zenith angles, degrees [default: 0, where --diffuse is not given]
    #[arg(long, value_name = "DEGREES,...", value_parser = laboratory_values::zeniths)]
    pub(crate) sza: Vec<Series>,

    /// How it is found
    #[arg(long, value_name = "NAME,...", value_delimiter = ',', default_value = "homogeneous")]
    pub(crate) method: Vec<SpreadMethod>,

    /// How `grains` are packed; the depth of a lattice becomes that of whole layers
    #[arg(long, value_enum, default_value = "random")]
    pub(crate) pack: PackName,

    /// Standard error to reach of R and T within every radius
    #[arg(long, value_name = "ERROR", default_value_t = 0.003,
          value_parser = laboratory_values::standard_error)]
    pub(crate) stderr: f64,

    /// Draws it too, as SVG or PNG: R and T per area over the radius, and per time
    #[arg(long, value_name = "FILE.svg|.png")]
    pub(crate) plot: Option<PlotFile>,

    #[command(flatten)]
    pub(crate) search: SearchArguments,
}

/// Ways to find how light spreads.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum SpreadMethod {
    /// Monte Carlo through grains that are met at random, but take room: void chords of the mean length
    /// of packed grains, and the way through each sphere
    Homogeneous,
    /// Exact Monte Carlo through packed grains: a finite depth (see --pack)
    Grains,
}
