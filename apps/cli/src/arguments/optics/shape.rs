//! A shape of grains as typed.

use crate::arguments::MachineArguments;
use clap::{Args, ValueEnum};

/// The shape of a grain; without one, a sphere.
#[derive(Debug, Args)]
#[command(next_help_heading = "Shape")]
pub(crate) struct ShapeArguments {
    /// Shape of the grain, whose c axis takes all directions alike
    #[arg(long, value_enum, value_name = "NAME", conflicts_with = "polarisation")]
    pub(crate) shape: Option<ShapeName>,

    /// Length along the c axis by width across it, 0.02 to 50 [default: 0.2 for plates, 2 for columns and
    /// rosettes, else 1]
    #[arg(long, value_name = "RATIO", requires = "shape")]
    pub(crate) aspect: Option<f64>,

    /// How round edges and corners are, 0 to 1
    #[arg(long, value_name = "0..1", default_value_t = 0.0, requires = "shape")]
    pub(crate) rounding: f64,

    /// Faces of a random polyhedron, 6 to 32
    #[arg(long, value_name = "N", default_value_t = 14, requires = "shape")]
    pub(crate) faces: u32,

    /// Columns of a rosette, 2 to 12
    #[arg(long, value_name = "N", default_value_t = 6, requires = "shape")]
    pub(crate) arms: u32,

    /// Lines to trace; those that meet the bounding sphere and not the grain count
    #[arg(long, value_name = "N", default_value_t = 1_000_000, requires = "shape",
          value_parser = clap::value_parser!(u64).range(1000..=10_000_000_000))]
    pub(crate) paths: u64,

    /// Seed of the random numbers, and of a random polyhedron
    #[arg(long, value_name = "N", default_value_t = 0, requires = "shape")]
    pub(crate) seed: u64,

    #[command(flatten)]
    pub(crate) machine: MachineArguments,
}

/// Shapes that have a name.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub(crate) enum ShapeName {
    /// A ball, traced as the others are
    Sphere,
    /// An ellipsoid of revolution
    Spheroid,
    /// A cube
    Cube,
    /// A hexagonal prism, flat where nothing else is said
    HexagonalPlate,
    /// A hexagonal prism, long where nothing else is said
    HexagonalColumn,
    /// A hexagonal prism as high as wide
    HexagonalPrism,
    /// 8 hexagons and 6 squares
    TruncatedOctahedron,
    /// Faces in random directions
    RandomPolyhedron,
    /// Columns that grow from one point
    Rosette,
}
