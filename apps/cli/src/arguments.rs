//! The command line as typed.

mod compare;
mod denoise;
mod deposit;
mod develop;
mod display;
mod groups;
mod inspect;
mod job;
mod laboratory_values;
mod measure;
mod merge;
mod optics;
mod render;
mod series;
mod values;
mod wet;

use clap::{Args, Parser, Subcommand};
use snowgrain_accel::SimdLevel;
use snowgrain_formats::scene::document::SnowKindName;
use snowgrain_formats::scene::{MeshUnits, UpAxis};
use std::path::PathBuf;
use std::process::ExitCode;

pub(crate) use compare::CompareArguments;
pub(crate) use denoise::DenoiseArguments;
pub(crate) use deposit::DepositArguments;
pub(crate) use develop::DevelopArguments;
pub(crate) use display::{Bits, DisplayArguments};
pub(crate) use groups::GroupFactor;
pub(crate) use inspect::InspectArguments;
pub(crate) use job::{JobArguments, JobKind, PlanArguments, RunArguments, StatusArguments};
pub(crate) use measure::{
    CubeArguments, GlintsArguments, LightSearchArguments, MeasureArguments, MeasureKind, Side,
    SlabArguments,
};
pub(crate) use merge::MergeArguments;
pub(crate) use optics::{
    AlbedoArguments, BrdfArguments, BrdfMethod, ColourArguments, Method, OpticsArguments,
    OpticsKind, PackName, PhaseArguments, PolarisationName, ProfileArguments, SearchArguments,
    SnowArguments, SpreadArguments, SpreadMethod, TableFormat,
};
pub(crate) use render::RenderArguments;
pub(crate) use series::Series;
pub(crate) use values::{PictureFile, PictureFormat, PlotFile, PlotFormat, Size};
pub(crate) use wet::WetArguments;

/// Snowgrain renders snow that is made of real, discrete grains of ice.
#[derive(Debug, Parser)]
#[command(
    name = "snowgrain",
    version,
    propagate_version = true,
    after_help = "Examples:\n  \
        snowgrain render snowy-teapot -o teapot.png      a built-in scene\n  \
        snowgrain render model.obj -o model.png          your own model in the snow\n  \
        snowgrain scenes snowy-teapot --print > my.toml  a scene to start from\n\n\
        Exit codes: 0 done, 2 usage, 65 bad input, 66 input missing, 69 refused (memory, limits), \
        70 fault of the program, 73 cannot create output, 74 I/O error or disk full, \
        75 incomplete but resumable, \
        130/143 stopped by a signal."
)]
pub(crate) struct Arguments {
    #[command(subcommand)]
    pub(crate) command: Command,
}

#[derive(Debug, Subcommand)]
pub(crate) enum Command {
    Render(Box<RenderArguments>),
    Deposit(DepositArguments),
    Develop(DevelopArguments),
    Merge(MergeArguments),
    Job(JobArguments),
    Inspect(Box<InspectArguments>),
    Scenes(ScenesArguments),
    Compare(CompareArguments),
    Measure(MeasureArguments),
    Optics(OpticsArguments),
    /// Prints the JSON Schema of scene files, for editors.
    #[command(after_help = "Example:\n  snowgrain schema > scene.schema.json")]
    Schema,
}

/// Which scene, and how it is changed.
#[derive(Clone, Debug, Args)]
pub(crate) struct SceneArguments {
    /// Built-in scene, scene file (.toml), mesh (.obj, .ply) or shot (.gltf, .glb)
    pub(crate) scene: PathBuf,

    /// Changes a key of the scene, as snow.0.radius=0.3mm, or snow.radius=0.3mm where there is one
    /// snow; adds to a list by +=, as film.keep+=ice-paths; repeatable
    #[arg(long = "set", value_name = "PATH=VALUE")]
    pub(crate) overrides: Vec<String>,

    /// Unit of a mesh file given as SCENE: mm, cm, m or in
    #[arg(long, value_name = "UNIT", value_parser = values::units)]
    pub(crate) units: Option<MeshUnits>,

    /// Up axis of a mesh file given as SCENE: y or z
    #[arg(long, value_name = "AXIS", value_parser = values::up_axis)]
    pub(crate) up: Option<UpAxis>,

    /// Longest side of a mesh or model given as SCENE, as 20cm
    #[arg(long, value_name = "LENGTH", value_parser = values::length)]
    pub(crate) object_size: Option<f64>,

    /// Kind of snow on a mesh or shot given as SCENE: fresh, wind-slab, old, corn, melt-freeze-crust, firn,
    /// faceted, depth-hoar, surface-hoar or graupel
    #[arg(long, value_name = "KIND", value_parser = values::kind)]
    pub(crate) kind: Option<SnowKindName>,

    /// Renders the scene at this frame: keys of `animate` have their values there, and #### in names of
    /// files (-o render.####.exr) becomes its number
    #[arg(long, value_name = "N")]
    pub(crate) frame: Option<u32>,
}

/// What of the machine may be used.
#[derive(Clone, Debug, Args)]
pub(crate) struct MachineArguments {
    /// Threads; the result does not depend on them [default: all processors]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=4096))]
    pub(crate) threads: Option<u16>,

    /// Instruction set: sse2, sse4.2, avx2, avx512 or neon; the result does not depend on it
    /// [default: the best]
    #[arg(long, value_name = "LEVEL")]
    pub(crate) simd: Option<SimdLevel>,

    /// Refuses scenes that would need more memory than this, as 4GiB [default: what is free]
    #[arg(long, value_name = "SIZE", value_parser = values::bytes)]
    pub(crate) max_memory: Option<u64>,
}

/// What is told of the work.
#[derive(Clone, Debug, Args)]
pub(crate) struct ReportArguments {
    /// Writes the figures of the run as JSON
    #[arg(long, value_name = "FILE")]
    pub(crate) json_stats: Option<PathBuf>,

    /// Tells nothing but errors
    #[arg(short, long, conflicts_with = "verbose")]
    pub(crate) quiet: bool,

    /// Tells more
    #[arg(short, long)]
    pub(crate) verbose: bool,
}

/// Lists the built-in scenes, or prints one to start from.
#[derive(Debug, Args)]
#[command(after_help = "Examples:\n  \
    snowgrain scenes\n  \
    snowgrain scenes snowy-teapot --print > my.toml")]
pub(crate) struct ScenesArguments {
    /// Name of a built-in scene
    pub(crate) name: Option<String>,

    /// Prints the scene file (as a name alone does)
    #[arg(long, requires = "name")]
    pub(crate) print: bool,
}

/// Prints what clap has to say: help on standard output, a misuse in one line.
pub(crate) fn answer(error: &clap::Error) -> ExitCode {
    if !error.use_stderr() {
        // A reader that has seen enough (`--help | head`) is no failure.
        let _ = error.print();
        return ExitCode::SUCCESS;
    }
    if error.kind() == clap::error::ErrorKind::DisplayHelpOnMissingArgumentOrSubcommand {
        let _ = error.print();
        return ExitCode::from(crate::failure::exit::USAGE);
    }
    let text = error.to_string();
    let lines = text.lines().map(str::trim).take_while(|line| !line.starts_with("Usage:"));
    let said: Vec<_> = lines
        .filter(|line| !line.is_empty() && !line.starts_with("For more information"))
        .collect();
    let message = said.join(" ");
    let message = message.strip_prefix("error: ").unwrap_or(&message);
    let failure = crate::failure::Failure::usage(format!("{message}; --help says more"));
    crate::output::tell(&failure.to_string());
    ExitCode::from(failure.code)
}
