//! `snowgrain measure` as typed.

use super::{MachineArguments, SceneArguments, values};
use clap::{ArgGroup, Args, Subcommand, ValueEnum};
use snowgrain_grains::{DepositRule, LatticeKind};
use snowgrain_render::measure::Incidence;
use std::path::PathBuf;

/// Measures snow as a material, against the exact identities of snow optics.
#[derive(Debug, Args)]
#[command(after_help = "Examples:\n  \
    snowgrain measure slab --lattice sc --layers 20\n  \
    snowgrain measure slab --rule stick --width 60mm --grains 100000 --incidence 60\n  \
    snowgrain measure slab --file pack.ply --period 60mm,60mm --json\n  \
    snowgrain measure cube --lit-all-around --lattice sc --counts 32,32,32")]
pub(crate) struct MeasureArguments {
    #[command(subcommand)]
    pub(crate) kind: MeasureKind,
}

#[derive(Debug, Subcommand)]
pub(crate) enum MeasureKind {
    Slab(Box<SlabArguments>),
    Cube(Box<CubeArguments>),
    Search(Box<LightSearchArguments>),
    Glints(Box<GlintsArguments>),
}

/// A level slab of snow that repeats for ever along x and z, lit on one face.
///
/// Prints reflectance and transmittance, grain visits against 2 tau, interface events, path in ice,
/// mean chord in air against (4/3) r (1 - phi) / phi, each with its standard error, and the
/// histogram by order. tau = N pi r^2 / A; phi is the solid fraction between the faces, overlaps
/// counted twice. The expected values hold for grains that do not overlap, Lambertian light and, for
/// deposits, the mean over both faces (--from both).
#[derive(Debug, Args)]
#[command(group = ArgGroup::new("snow").required(true).args(["lattice", "rule", "file"]))]
#[command(after_help = "Examples:\n  \
    snowgrain measure slab --lattice sc --layers 20\n  \
    snowgrain measure slab --rule stick --width 60mm --grains 100000 --from both\n  \
    snowgrain measure slab --file pack.ply --period 60mm,60mm --json")]
pub(crate) struct SlabArguments {
    /// Crystal of touching grains: sc, bcc, fcc or hcp
    #[arg(long, value_name = "NAME", value_parser = values::lattice, requires = "layers")]
    pub(crate) lattice: Option<LatticeKind>,

    /// Conventional cells of the crystal from the lower face to the upper one
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(1..),
          requires = "lattice")]
    pub(crate) layers: Option<u32>,

    /// Grains that fall on a level floor: ray, stick or roll
    #[arg(long, value_name = "NAME", value_parser = values::rule,
          requires_all = ["width", "grains"])]
    pub(crate) rule: Option<DepositRule>,

    /// Period of the floor along x and z, as 60mm; rounded to whole cells
    #[arg(long, value_name = "LENGTH", value_parser = values::length, requires = "rule")]
    pub(crate) width: Option<f64>,

    /// Grains that fall in one period
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u64).range(1..),
          requires = "rule")]
    pub(crate) grains: Option<u64>,

    /// Half-width of the uniform distribution of radii of falling grains
    #[arg(long, value_name = "LENGTH", value_parser = values::length, requires = "rule")]
    pub(crate) variation: Option<f64>,

    /// Grains of a file
    #[arg(long, value_name = "GRAINS.ply", requires = "period")]
    pub(crate) file: Option<PathBuf>,

    /// Periods of the grains of the file along x and z, as 60mm,60mm; rounded to whole cells
    #[arg(long, value_name = "X,Z", value_parser = values::period, requires = "file")]
    pub(crate) period: Option<[f64; 2]>,

    /// Light: lambertian, or parallel at so many degrees from the normal
    #[arg(long, value_name = "lambertian|DEGREES", default_value = "lambertian",
          value_parser = values::incidence)]
    pub(crate) incidence: Incidence,

    /// The face that is lit; both: the mean of the two
    #[arg(long, value_enum, default_value = "above")]
    pub(crate) from: Side,

    /// Grey absorption of the ice, 1/m
    #[arg(long, value_name = "1/M", default_value_t = 0.0, value_parser = values::not_negative)]
    pub(crate) absorption: f64,

    #[command(flatten)]
    pub(crate) tracing: TracingArguments,
}

/// Faces of a slab that light comes from.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum Side {
    /// The upper face
    Above,
    /// The lower face
    Below,
    /// The mean of both, each with all the paths
    Both,
}

/// A block of snow, lit from all around by cosine-distributed light over its box.
///
/// Prints grain visits a path against (total grain surface) / (4 x mean projected area of the box),
/// paths that miss every grain included. This holds for grains that do not overlap, whatever the
/// index of refraction.
#[derive(Debug, Args)]
#[command(group = ArgGroup::new("snow").required(true).args(["lattice", "file"]))]
#[command(after_help = "Examples:\n  \
    snowgrain measure cube --lit-all-around --lattice sc --counts 32,32,32\n  \
    snowgrain measure cube --lit-all-around --file grains.ply --json")]
pub(crate) struct CubeArguments {
    /// Light enters all over the box, cosine-distributed
    #[arg(long, required = true)]
    pub(crate) lit_all_around: bool,

    /// Crystal of touching grains: sc, bcc, fcc or hcp
    #[arg(long, value_name = "NAME", value_parser = values::lattice, requires = "counts")]
    pub(crate) lattice: Option<LatticeKind>,

    /// Conventional cells of the crystal along x, y, z
    #[arg(long, value_name = "X,Y,Z", value_parser = values::counts, requires = "lattice")]
    pub(crate) counts: Option<[u32; 3]>,

    /// Grains of a file
    #[arg(long, value_name = "GRAINS.ply")]
    pub(crate) file: Option<PathBuf>,

    #[command(flatten)]
    pub(crate) tracing: TracingArguments,
}

/// How far off light is that is looked for in a scene (integrator.light = "sampled").
///
/// Uniform light that a search finds is compared with what paths meet, which is exact, by the number
/// of grains on the way, the elevation of the light and its angle from the way back to the camera: what a
/// sun in such a direction would be wrong by. By way of the first two grains that the camera sees a sun is solved
/// exactly, so that the rows of one and two grains tell of lamps and maps only. The paths are others than those that the search is
/// calibrated by, so that the error of that shows, too.
#[derive(Debug, Args)]
#[command(after_help = "Examples:\n  \
    snowgrain measure search shot.toml\n  \
    snowgrain measure search snowy-teapot --set light.kind=sun --set light.elevation=20 --paths 4000000")]
pub(crate) struct LightSearchArguments {
    #[command(flatten)]
    pub(crate) scene: SceneArguments,

    /// Paths to trace
    #[arg(long, value_name = "N", default_value_t = 1 << 22,
          value_parser = clap::value_parser!(u64).range(1_024..=10_000_000_000))]
    pub(crate) paths: u64,

    #[command(flatten)]
    pub(crate) machine: MachineArguments,

    /// Prints JSON
    #[arg(long)]
    pub(crate) json: bool,

    /// Tells nothing but results and errors
    #[arg(short, long)]
    pub(crate) quiet: bool,
}

/// Glints: crystals of a scene that send the image of a sun into the camera.
///
/// For each sun, faces that mirror it into the camera are counted one by one and compared with the number that faces
/// in all directions alike make, Omega / (16 pi cos theta_h) of them, which has a Poisson error; those that nothing
/// hides from sun or camera are counted apart, and so are ways through crystals, refracted and reflected within.
/// Sharp crystals of one body count, as the middle of the lens sees them.
#[derive(Debug, Args)]
#[command(after_help = "Example:\n  \
    snowgrain measure glints shot.toml --rays 64")]
pub(crate) struct GlintsArguments {
    #[command(flatten)]
    pub(crate) scene: SceneArguments,

    /// Rays through each crystal, by which refracted and inner glints are found
    #[arg(long, value_name = "N", default_value_t = 32,
          value_parser = clap::value_parser!(u32).range(1..=1_000_000))]
    pub(crate) rays: u32,

    #[command(flatten)]
    pub(crate) machine: MachineArguments,

    /// Prints JSON
    #[arg(long)]
    pub(crate) json: bool,

    /// Tells nothing but results and errors
    #[arg(short, long)]
    pub(crate) quiet: bool,
}

/// What every measure needs.
#[derive(Debug, Args)]
pub(crate) struct TracingArguments {
    /// Radius of the grains of a crystal or a deposit [default: 0.5mm]
    #[arg(long, value_name = "LENGTH", value_parser = values::length, conflicts_with = "file")]
    pub(crate) radius: Option<f64>,

    /// Index of refraction of the grains
    #[arg(long, value_name = "N", default_value_t = 1.31, value_parser = values::ior)]
    pub(crate) ior: f64,

    /// Paths to trace
    #[arg(long, value_name = "N", default_value_t = 1_000_000,
          value_parser = clap::value_parser!(u64).range(1..=10_000_000_000))]
    pub(crate) paths: u64,

    /// Seed of the random numbers, of falling grains too
    #[arg(long, value_name = "N", default_value_t = 0)]
    pub(crate) seed: u64,

    #[command(flatten)]
    pub(crate) machine: MachineArguments,

    /// Prints JSON
    #[arg(long)]
    pub(crate) json: bool,

    /// Tells nothing but results and errors
    #[arg(short, long)]
    pub(crate) quiet: bool,
}
