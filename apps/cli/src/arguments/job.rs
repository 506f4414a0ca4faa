//! `snowgrain job` as typed.

use super::{MachineArguments, SceneArguments, Size, values};
use clap::{Args, Subcommand};
use std::ops::RangeInclusive;
use std::path::PathBuf;

/// Cuts a large render into tasks that any number of machines can do in any order.
///
/// A job is a JSON file. Each task renders some samples of one picture to a film in NAME-parts beside it, by a name
/// of point of the sweep, frame (0 where there are none) and first sample; `snowgrain merge` adds them. A task that
/// was stopped or killed goes on where it was, one that is finished ends at once, and one that another machine is at
/// work on ends with exit code 75.
#[derive(Debug, Args)]
#[command(after_help = "Examples:\n  \
    snowgrain job plan scene.toml --samples 1024 --per-task 16 -o job.json\n  \
    snowgrain job plan scene.toml --samples 256 --per-task 64 --sweep sweep.toml --frames 1-48 -o job.json\n  \
    snowgrain job run job.json --task 7\n  \
    snowgrain job status job.json\n  \
    snowgrain merge job-parts/p00000-f00000-*.film --require 0..1024 -o picture.exr")]
pub(crate) struct JobArguments {
    #[command(subcommand)]
    pub(crate) kind: JobKind,
}

#[derive(Debug, Subcommand)]
pub(crate) enum JobKind {
    Plan(PlanArguments),
    Run(RunArguments),
    Status(StatusArguments),
}

/// Writes a job. Every value of the sweep is tried: a scene that cannot be loaded is refused.
#[derive(Debug, Args)]
pub(crate) struct PlanArguments {
    #[command(flatten)]
    pub(crate) scene: SceneArguments,

    /// Samples of each pixel
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u64).range(1..=1 << 40))]
    pub(crate) samples: u64,

    /// Samples of each pixel in a task
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u64).range(1..=1 << 40))]
    pub(crate) per_task: u64,

    /// Scenes to be rendered: a TOML file of keys, as for --set, with lists of values; all combinations
    /// are taken
    #[arg(long, value_name = "FILE")]
    pub(crate) sweep: Option<PathBuf>,

    /// Frames to be rendered, as 1-48, of a scene with keys of `animate`
    #[arg(long, value_name = "FIRST-LAST", value_parser = values::frames)]
    pub(crate) frames: Option<RangeInclusive<u32>>,

    /// Seed of the random numbers of light, instead of the scene's
    #[arg(long, value_name = "N")]
    pub(crate) seed: Option<u64>,

    /// Size of the pictures in pixels, instead of the scene's
    #[arg(long, value_name = "WxH")]
    pub(crate) size: Option<Size>,

    /// Where the job goes
    #[arg(short, long, value_name = "FILE.json")]
    pub(crate) output: PathBuf,
}

/// Does one task of a job.
#[derive(Debug, Args)]
pub(crate) struct RunArguments {
    /// The job
    pub(crate) job: PathBuf,

    /// Number of the task, from 0
    #[arg(long, value_name = "K")]
    pub(crate) task: u64,

    /// Tells nothing but errors
    #[arg(short, long)]
    pub(crate) quiet: bool,

    #[command(flatten)]
    pub(crate) machine: MachineArguments,
}

/// Lists the tasks of a job that are not finished; exit code 75 where there are any.
#[derive(Debug, Args)]
pub(crate) struct StatusArguments {
    /// The job
    pub(crate) job: PathBuf,
}
