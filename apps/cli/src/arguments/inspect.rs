//! `snowgrain inspect` as typed.

use super::{MachineArguments, PlotFile, ReportArguments, SceneArguments, values};
use clap::Args;

/// Measures the structure of snow: of a file of grains (.ply) given as SCENE, or of the snow of a scene.
///
/// Density (union of the ice, and with overlaps counted twice), its profile by depth, porosity, specific
/// surface area, sizes, contacts and overlaps, what hangs together, mean chords and their distribution,
/// two-point correlation and anisotropy: between 20 and 80 % of the depth that the snow has at each
/// place.
#[derive(Debug, Args)]
#[command(after_help = "Examples:\n  \
    snowgrain inspect grains.ply\n  \
    snowgrain inspect scene.toml --set snow.density=120 --plot structure.svg\n  \
    snowgrain inspect pack.ply --period 60mm,60mm --json")]
pub(crate) struct InspectArguments {
    #[command(flatten)]
    pub(crate) scene: SceneArguments,

    /// The grains repeat along x and z with these periods, as 60mm,60mm
    #[arg(long, value_name = "X,Z", value_parser = values::period, conflicts_with = "block")]
    pub(crate) period: Option<[f64; 2]>,

    /// The grains fill a box: measures its middle 60 % along each axis
    #[arg(long)]
    pub(crate) block: bool,

    /// Prints all figures and distributions as JSON
    #[arg(long)]
    pub(crate) json: bool,

    /// Draws profile, sizes, chords and correlation: .svg or .png
    #[arg(long, value_name = "FILE")]
    pub(crate) plot: Option<PlotFile>,

    #[command(flatten)]
    pub(crate) machine: MachineArguments,

    #[command(flatten)]
    pub(crate) report: ReportArguments,
}
