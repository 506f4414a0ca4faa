//! `snowgrain compare` as typed.

use super::values;
use clap::Args;
use snowgrain_film::compare::flip;
use std::path::PathBuf;

/// Says how far a picture is from a reference: RMSE, relative RMSE, z-test, FLIP.
///
/// The z-test needs variance layers in both (.exr or .film with at least two samples) and different
/// seeds: renders of one seed share their noise.
#[derive(Debug, Args)]
#[command(after_help = "Examples:\n  \
    snowgrain compare new.exr reference.exr\n  \
    snowgrain compare new.exr reference.exr --json --max-flip 0.05\n\n\
    The exit code is 0 whatever the difference, unless a threshold is given: then 1 where it is \
    exceeded.")]
pub(crate) struct CompareArguments {
    /// Picture: .png, .exr or .film
    pub(crate) picture: PathBuf,

    /// Reference: .png, .exr or .film of the same pixels
    pub(crate) reference: PathBuf,

    /// Prints JSON
    #[arg(long)]
    pub(crate) json: bool,

    /// Exit code 1 where the root mean square difference exceeds this
    #[arg(long, value_name = "X", value_parser = values::not_negative)]
    pub(crate) max_rmse: Option<f64>,

    /// Exit code 1 where the mean FLIP error exceeds this
    #[arg(long, value_name = "X", value_parser = values::not_negative)]
    pub(crate) max_flip: Option<f64>,

    /// Exit code 1 where noise explains the pixels or the mean only with less than this probability
    #[arg(long, value_name = "P", value_parser = values::probability)]
    pub(crate) significance: Option<f64>,

    /// Exposure for FLIP in stops
    #[arg(long, value_name = "STOPS", default_value_t = 0.0, allow_negative_numbers = true,
          value_parser = values::finite)]
    pub(crate) exposure: f64,

    /// Resolution at which FLIP looks: pixels per degree of the observer's field of view
    #[arg(long, value_name = "N", default_value_t = flip::PIXELS_PER_DEGREE,
          value_parser = values::pixels_per_degree)]
    pub(crate) pixels_per_degree: f64,
}
