//! A shape of grains as typed.

use crate::arguments::{MachineArguments, values};
use clap::Args;
use snowgrain_formats::scene::document::ShapeName;

/// The shape of a grain; without one, a sphere.
#[derive(Debug, Args)]
#[command(next_help_heading = "Shape")]
pub(crate) struct ShapeArguments {
    /// Shape of the grain, whose c axis takes all directions alike: sphere (traced as the others are), spheroid,
    /// cube, hexagonal-plate, hexagonal-column, hexagonal-prism, truncated-octahedron, random-polyhedron or
    /// rosette (columns that grow from one point)
    #[arg(long, value_name = "NAME", value_parser = values::shape, conflicts_with = "polarisation")]
    pub(crate) shape: Option<ShapeName>,

    /// Several shapes instead, as snow of them scatters, each in all orientations alike: the shapes of a kind of snow
    /// (fresh, faceted, ...), or a file of [[shapes]] tables with the keys of [[snow.shapes]] of a scene
    #[arg(long, value_name = "NAME|FILE.toml", conflicts_with_all = ["shape", "polarisation"])]
    pub(crate) shapes: Option<String>,

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

    /// Lines to trace of each shape; those that meet the bounding sphere and not the grain count
    #[arg(long, value_name = "N", default_value_t = 1_000_000,
          value_parser = clap::value_parser!(u64).range(1000..=10_000_000_000))]
    pub(crate) paths: u64,

    /// Seed of the random numbers, and of a random polyhedron
    #[arg(long, value_name = "N", default_value_t = 0)]
    pub(crate) seed: u64,

    #[command(flatten)]
    pub(crate) machine: MachineArguments,
}
