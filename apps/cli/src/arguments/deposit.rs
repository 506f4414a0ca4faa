//! `snowgrain deposit` as typed.

use super::{MachineArguments, ReportArguments, SceneArguments, values};
use clap::Args;
use std::path::PathBuf;

/// Lets the snow of a scene fall and writes its grains.
///
/// The grains, measured: how much of space is ice (union, and with overlaps counted twice), what
/// touches and what overlaps, what hangs together with the objects. A scene with source = "file"
/// reads the grains back and gives the same picture, bit for bit.
#[derive(Debug, Args)]
#[command(after_help = "Examples:\n  \
    snowgrain deposit snowy-teapot -o grains.ply\n  \
    snowgrain deposit scene.toml --set snow.rule=roll --json-stats deposit.json -o grains.ply")]
pub(crate) struct DepositArguments {
    #[command(flatten)]
    pub(crate) scene: SceneArguments,

    /// Where the grains go: a binary .ply with x, y, z and radius in metres
    #[arg(short, long, value_name = "FILE", value_parser = values::grain_file)]
    pub(crate) output: PathBuf,

    #[command(flatten)]
    pub(crate) machine: MachineArguments,

    #[command(flatten)]
    pub(crate) report: ReportArguments,
}
