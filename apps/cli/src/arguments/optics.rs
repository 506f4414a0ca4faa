//! `snowgrain optics` as typed.

mod brdf;
mod shape;
mod spread;

use super::laboratory_values::ImpurityLoads;
use super::{MachineArguments, PlotFile, Series, laboratory_values, values};
use clap::{ArgGroup, Args, Subcommand, ValueEnum};
use snowgrain_optics::sphere::Polarisation;
use snowgrain_optics::{IceAbsorption, Illuminant, Primaries, Substance};
use snowgrain_render::laboratory::Pack;
use std::path::PathBuf;

pub(crate) use brdf::{BrdfArguments, BrdfMethod};
pub(crate) use shape::ShapeArguments;
pub(crate) use spread::{SpreadArguments, SpreadMethod};

/// The snow laboratory: what flat layers of snow do to light at each wavelength.
#[derive(Debug, Args)]
#[command(after_help = "Example:\n  \
    snowgrain optics albedo --radius 200um --wavelengths 350:1290:10 --sza 60")]
pub(crate) struct OpticsArguments {
    #[command(subcommand)]
    pub(crate) kind: OpticsKind,
}

#[derive(Debug, Subcommand)]
pub(crate) enum OpticsKind {
    Albedo(Box<AlbedoArguments>),
    Brdf(Box<BrdfArguments>),
    Colour(Box<ColourArguments>),
    Phase(Box<PhaseArguments>),
    Profile(Box<ProfileArguments>),
    Spread(Box<SpreadArguments>),
    Wet(Box<super::WetArguments>),
}

/// Spectral reflectance, transmittance and absorptance of flat layers of snow.
///
/// One line for each method and each combination of radius, density, depth, light, impurities and
/// wavelength. R is the plane albedo of snow and ground, T the light that arrives at the ground
/// (direct light included), A what ice and impurities absorb, each as a part of the light that falls
/// on the snow.
#[derive(Debug, Args)]
#[command(group = ArgGroup::new("grains").required(true).args(["radius", "ssa", "layers"]))]
#[command(group = ArgGroup::new("light").args(["diffuse", "sza"]).multiple(true))]
#[command(after_help = "Examples:\n  \
    snowgrain optics albedo --radius 200um --wavelengths 350:1290:10\n  \
    snowgrain optics albedo --ssa 20 --sza 0,30,60 --impurity black-carbon=0ppb,100ppb\n  \
    snowgrain optics albedo --radius 150um --density 250 --depth 3cm --ground 0.2 \\\n    \
        --wavelengths 420,520,620 --method homogeneous,wiscombe-warren\n  \
    snowgrain optics albedo --radius 100um,1mm --sza 50 --broadband\n  \
    snowgrain optics albedo --layers pack.toml --diffuse --format json -o albedo.json\n\n\
    A file of layers, from the top down:\n  \
    [[layer]]\n  \
    bottom = \"3 cm\"        # of its lower face; \"inf\" for deep snow\n  \
    radius = \"100 um\"      # or ssa = 32.7, in m^2/kg\n  \
    shapes = \"fresh\"       # as --shapes, which is what layers without it have\n  \
    density = 250\n  \
    impurities = { black-carbon = \"100 ppb\", snow-algae = \"20000 cells/mL\" }")]
pub(crate) struct AlbedoArguments {
    #[command(flatten)]
    pub(crate) snow: SnowArguments,

    /// Wavelengths, nm: a list, or FIRST:LAST:STEP; 300 to 2500
    #[arg(long, value_name = "NM,...|FROM:TO:STEP", default_value = "350:1290:10",
          value_parser = laboratory_values::wavelengths)]
    pub(crate) wavelengths: Series,

    /// Bands instead of wavelengths: solar (300 to 2500 nm), visible (to 700) and near-infrared,
    /// under sun and sky of a clear day, or, for diffuse light, an overcast one
    #[arg(long, conflicts_with = "wavelengths")]
    pub(crate) broadband: bool,

    /// Light from all of the sky alike; so it is where no --sza is given
    #[arg(long)]
    pub(crate) diffuse: bool,

    /// Parallel light at these zenith angles, degrees
    #[arg(long, value_name = "DEGREES,...", value_parser = laboratory_values::zeniths)]
    pub(crate) sza: Vec<Series>,

    /// How it is found
    #[arg(long, value_name = "NAME,...", value_delimiter = ',', default_value = "homogeneous")]
    pub(crate) method: Vec<Method>,

    /// How `grains` are packed; the depth of a lattice becomes that of whole layers
    #[arg(long, value_enum, default_value = "random")]
    pub(crate) pack: PackName,

    /// Standard error of R and T to reach by Monte Carlo
    #[arg(long, value_name = "ERROR", default_value_t = 0.0005,
          value_parser = laboratory_values::standard_error)]
    pub(crate) stderr: f64,

    /// Draws it too, as SVG or PNG: R, and T where light comes through, over the wavelength
    #[arg(long, value_name = "FILE.svg|.png", conflicts_with = "broadband")]
    pub(crate) plot: Option<PlotFile>,

    #[command(flatten)]
    pub(crate) search: SearchArguments,
}

/// Colours of light on flat layers of snow and of light through them.
///
/// Two lines for each combination of radius, density, depth and impurities: R, seen from above, and T,
/// seen from below, under light from all of the sky alike. X, Y, Z are CIE 1931 tristimulus values
/// with Y = 1 for all of the light; x and y are empty where no light came through; red, green and blue
/// are linear, below 0 out of the gamut.
#[derive(Debug, Args)]
#[command(group = ArgGroup::new("grains").required(true).args(["radius", "ssa", "layers"]))]
#[command(after_help = "Examples:\n  \
    snowgrain optics colour --radius 500um --depth 10cm,50cm,1m\n  \
    snowgrain optics colour --radius 500um --depth 2cm,10cm,50cm \\\n    \
        --impurity black-carbon=0ppb,100ppb,1ppm --swatches snow.svg")]
pub(crate) struct ColourArguments {
    #[command(flatten)]
    pub(crate) snow: SnowArguments,

    /// Light: d65, d55, a, equal-energy, or sun-ZENITH or clear-sky-ZENITH (degrees, 0 to 75)
    #[arg(long, value_name = "NAME", default_value = "d65",
          value_parser = laboratory_values::illuminant)]
    pub(crate) illuminant: Illuminant,

    /// Primaries of red, green and blue: srgb or acescg
    #[arg(long, value_name = "NAME", default_value = "srgb",
          value_parser = laboratory_values::primaries)]
    pub(crate) primaries: Primaries,

    /// Writes a picture of all colours too, as SVG: those of T at their full brightness
    #[arg(long, value_name = "FILE.svg", value_parser = laboratory_values::svg_file)]
    pub(crate) swatches: Option<PathBuf>,

    /// Standard error of R and T at each wavelength to reach; of T, 2 % of it as well
    #[arg(long, value_name = "ERROR", default_value_t = 0.001,
          value_parser = laboratory_values::standard_error)]
    pub(crate) stderr: f64,

    #[command(flatten)]
    pub(crate) search: SearchArguments,
}

/// Scattering by one grain, or a mix of shapes, without diffraction: g, B, and the phase function; of a sphere, the
/// energy of each order too.
///
/// Comma-separated values follow lines of remarks: g is the mean cosine of the scattering angle, B the
/// mean length in the grain over the mean chord 4r/3, E0, E1, ... the energy that is reflected outside
/// and that which leaves after 1, 2, ... chords. The phase function has the mean 1 over all directions.
///
/// A sphere is computed in closed form. Other shapes are traced in all orientations alike, by the kernel that
/// traces snow, and B is the mean length in ice of light that meets the grain, times its mean projected area, by
/// its volume; figures and bins then come with their standard errors.
#[derive(Debug, Args)]
#[command(after_help = "Examples:\n  \
    snowgrain optics phase --wavelength 550\n  \
    snowgrain optics phase --ior 1.32 --bins 18 --polarisation tracked\n  \
    snowgrain optics phase --material salt --shape cube\n  \
    snowgrain optics phase --shape hexagonal-column --aspect 2 --plot column.svg\n  \
    snowgrain optics phase --shapes faceted")]
pub(crate) struct PhaseArguments {
    /// Wavelength, nm, of the refractive index
    #[arg(long, value_name = "NM", default_value = "550",
          value_parser = laboratory_values::wavelength)]
    pub(crate) wavelength: f64,

    /// What the grain is made of: ice, salt, sugar, soda-lime-glass, borosilicate-glass, quartz or fused-silica
    #[arg(long, value_name = "NAME", default_value = "ice",
          value_parser = laboratory_values::substance)]
    pub(crate) material: Substance,

    /// Measured refractive indices instead: lines of a wavelength in nm, n and, if known, k
    #[arg(long, value_name = "FILE.csv", conflicts_with_all = ["material", "ior"])]
    pub(crate) indices: Option<PathBuf>,

    /// Refractive index instead
    #[arg(long, value_name = "N", value_parser = values::ior, conflicts_with_all = ["wavelength", "material"])]
    pub(crate) ior: Option<f64>,

    /// Equal bins of the scattering angle, from 0 to 180 degrees
    #[arg(long, value_name = "N", default_value_t = 180,
          value_parser = clap::value_parser!(u16).range(1..=18_000))]
    pub(crate) bins: u16,

    /// Whether light is unpolarised at every interface, or keeps its polarisation within a grain
    #[arg(long, value_enum, default_value = "redrawn")]
    pub(crate) polarisation: PolarisationName,

    #[command(flatten)]
    pub(crate) shape: ShapeArguments,

    /// Draws it too, as SVG or PNG: the phase function over the scattering angle
    #[arg(long, value_name = "FILE.svg|.png")]
    pub(crate) plot: Option<PlotFile>,

    /// What is printed
    #[arg(long, value_enum, default_value = "csv")]
    pub(crate) format: TableFormat,

    /// Writes it to a file instead
    #[arg(short, long, value_name = "FILE")]
    pub(crate) output: Option<PathBuf>,
}

/// Fluxes inside snow: how much of the light goes down and up at depths below the surface.
///
/// One layer over a black ground, grains met at random. Fluxes are parts of the light that falls on
/// the snow. efold_m is the depth over which the downward flux falls to 1/e, from this depth to the
/// next; it no longer changes once the light is diffuse.
#[derive(Debug, Args)]
#[command(group = ArgGroup::new("grains").required(true).args(["radius", "ssa", "layers"]))]
#[command(after_help = "Example:\n  \
    snowgrain optics profile --radius 500um --at 0,1cm,5cm,10cm,20cm --wavelengths 600,800")]
pub(crate) struct ProfileArguments {
    #[command(flatten)]
    pub(crate) snow: SnowArguments,

    /// Depths below the surface, from the top down, as 0,1cm,5cm or 0:10cm:1cm
    #[arg(long, value_name = "LENGTH,...", required = true,
          value_parser = laboratory_values::depths_below)]
    pub(crate) at: Vec<Series>,

    /// Wavelengths, nm: a list, or FIRST:LAST:STEP; 300 to 2500
    #[arg(long, value_name = "NM,...|FROM:TO:STEP", default_value = "400:900:100",
          value_parser = laboratory_values::wavelengths)]
    pub(crate) wavelengths: Series,

    /// Parallel light at these zenith angles, degrees [default: light from all of the sky alike]
    #[arg(long, value_name = "DEGREES,...", value_parser = laboratory_values::zeniths)]
    pub(crate) sza: Vec<Series>,

    /// Standard error of each downward flux to reach; 1 % of it as well
    #[arg(long, value_name = "ERROR", default_value_t = 0.005,
          value_parser = laboratory_values::standard_error)]
    pub(crate) stderr: f64,

    /// Draws it too, as SVG or PNG: fluxes over the depth
    #[arg(long, value_name = "FILE.svg|.png")]
    pub(crate) plot: Option<PlotFile>,

    #[command(flatten)]
    pub(crate) search: SearchArguments,
}

/// Layers of snow.
///
/// Numbers that may be several are written as a,b,c or as a range FROM:TO:STEP, lengths with their units.
#[derive(Debug, Args)]
pub(crate) struct SnowArguments {
    /// Radius of the grains, as 150um; several, as 100um,1mm or 100um:1mm:100um, make as many cases, as
    /// for every option that takes several
    #[arg(long, value_name = "LENGTH,...", value_parser = laboratory_values::radii)]
    pub(crate) radius: Vec<Series>,

    /// What the grains are, met at random in all orientations alike: spheres, the shapes of a kind of snow (fresh,
    /// faceted, depth-hoar, ...), or a file of [[shapes]] tables with the keys of [[snow.shapes]] of a scene. Their
    /// radius is that of spheres of equal volume
    #[arg(
        long,
        value_name = "NAME|FILE.toml,...",
        value_delimiter = ',',
        default_value = "spheres"
    )]
    pub(crate) shapes: Vec<String>,

    /// Specific surface area of the grains instead, m^2/kg: 3 / (917 r) for spheres
    #[arg(long, value_name = "M2/KG,...",
          value_parser = laboratory_values::specific_surface_areas)]
    pub(crate) ssa: Vec<Series>,

    /// Layers from a file instead (see below)
    #[arg(long, value_name = "FILE.toml", conflicts_with_all = ["density", "depth", "impurity"])]
    pub(crate) layers: Option<PathBuf>,

    /// Density, kg/m^3
    #[arg(long, value_name = "KG/M3,...", default_value = "300",
          value_parser = laboratory_values::densities)]
    pub(crate) density: Vec<Series>,

    /// Depth, as 3cm; inf: deep enough that no light comes back from below
    #[arg(long, value_name = "LENGTH|inf,...", default_value = "inf",
          value_parser = laboratory_values::depths)]
    pub(crate) depth: Vec<Series>,

    /// Albedo of the ground below, which is diffuse
    #[arg(long, value_name = "0..1,...", default_value = "0",
          value_parser = laboratory_values::albedos)]
    pub(crate) ground: Vec<Series>,

    /// Impurity between the grains and how much of it, as black-carbon=100ppb, snow-algae=20000cells/mL
    /// or dust-sahara=5e-6vol (volume per volume of ice); several loads make as many cases; repeatable
    #[arg(long, value_name = "NAME=LOAD,...")]
    pub(crate) impurity: Vec<ImpurityLoads>,

    /// Measurements of the absorption of ice: picard-2016 or warren-brandt-2008
    #[arg(long, value_name = "NAME", default_value = "picard-2016",
          value_parser = laboratory_values::ice_absorption)]
    pub(crate) ice_k: IceAbsorption,
}

/// How results are found and where they go.
#[derive(Debug, Args)]
pub(crate) struct SearchArguments {
    /// Whether light is unpolarised at every interface, or keeps its polarisation within a grain
    #[arg(long, value_enum, default_value = "redrawn")]
    pub(crate) polarisation: PolarisationName,

    /// Paths, for each refractive index, at which Monte Carlo ends before that
    #[arg(long, value_name = "N", default_value_t = 10_000_000,
          value_parser = clap::value_parser!(u64).range(1..=10_000_000_000))]
    pub(crate) max_paths: u64,

    /// Seed of the random numbers
    #[arg(long, value_name = "N", default_value_t = 0)]
    pub(crate) seed: u64,

    /// What is printed
    #[arg(long, value_enum, default_value = "csv")]
    pub(crate) format: TableFormat,

    /// Writes it to a file instead
    #[arg(short, long, value_name = "FILE")]
    pub(crate) output: Option<PathBuf>,

    #[command(flatten)]
    pub(crate) machine: MachineArguments,

    /// Tells nothing but results and errors
    #[arg(short, long)]
    pub(crate) quiet: bool,
}

/// Ways to find an albedo.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum Method {
    /// Monte Carlo through grains that are met at random, by the closed form of a sphere, or by what other shapes do
    /// when they are traced
    Homogeneous,
    /// Exact Monte Carlo through packed grains, of finite depth: up to seven layers at random places, one in
    /// a lattice (see --pack)
    Grains,
    /// Wiscombe and Warren 1980, delta-Eddington
    WiscombeWarren,
    /// Two streams, delta-Eddington
    TwoStream,
    /// Kokhanovsky and Zege 2004
    KokhanovskyZege,
    /// Bohren and Barkstrom 1974: deep snow under diffuse light
    BohrenBarkstrom,
}

/// How grains are packed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum PackName {
    /// At random places, none touching another; up to 321 kg/m^3
    Random,
    /// Simple cubic lattice, up to 480 kg/m^3
    Sc,
    /// Face-centred cubic lattice, up to 679 kg/m^3
    Fcc,
}

impl From<PackName> for Pack {
    fn from(name: PackName) -> Self {
        match name {
            PackName::Random => Self::Random,
            PackName::Sc => Self::SimpleCubic,
            PackName::Fcc => Self::FaceCentredCubic,
        }
    }
}

/// Polarisation within a grain.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum PolarisationName {
    /// Mean reflectance at every interface, as the paper has it
    Redrawn,
    /// One polarisation from the entry to the exit
    Tracked,
}

impl From<PolarisationName> for Polarisation {
    fn from(name: PolarisationName) -> Self {
        match name {
            PolarisationName::Redrawn => Self::Redrawn,
            PolarisationName::Tracked => Self::Tracked,
        }
    }
}

/// Forms of a table.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum TableFormat {
    /// Comma-separated values under a line of names
    Csv,
    /// A JSON list of objects
    Json,
}
