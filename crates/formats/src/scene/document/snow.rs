//! `[[snow]]` as written.

use super::super::quantity::{Length, LoadText, Triple};
use super::{ShapeTable, SnowKindName};
use schemars::JsonSchema;
use serde::Deserialize;
use std::collections::BTreeMap;

/// A body of snow or a snowfall. Which keys may be used depends on `source`.
#[derive(Clone, Debug, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SnowTable {
    /// "deposit" (grains fall on objects and earlier snow), "pack" (a box of packed grains), "fill" (the
    /// inside of a closed mesh, or what lies under a surface or a picture of heights, of packed grains), "lattice" (a
    /// block of a crystal lattice) or "file" (grains as they are, from `file`).
    pub source: SnowSource,
    /// Kind of snow: "fresh", "wind-slab", "old", "corn", "melt-freeze-crust", "firn", "faceted", "depth-hoar",
    /// "surface-hoar" or "graupel", which says `radius`, `spread`, `density` and `shapes` where they are not written
    /// (docs/snows.md); default none; deposit, pack, fill.
    #[serde(default)]
    pub kind: Option<SnowKindName>,
    /// Grain radius r: a length above 0, as "0.5 mm"; the mean, or the median where `spread` is given;
    /// deposit, pack, fill, lattice.
    #[serde(default)]
    pub radius: Option<Length>,
    /// Water in the snow, volume of liquid by volume of ice (the paper's W), 0 to 1: the water joins the
    /// grains, whose radii grow by the cube root of 1 + wetness; default 0; deposit, pack,
    /// fill, lattice.
    #[serde(default)]
    pub wetness: Option<f64>,
    /// Impurities between the grains of this snow beside those of `ice.impurities`, { dust-sahara =
    /// "50 ppm" }, loads as there; dust on top is a thin snowfall that has it; default none; all
    /// sources.
    #[serde(default)]
    pub impurities: BTreeMap<String, LoadText>,
    /// Shapes of the grains, [[snow.shapes]], of which each grain has one at random; default spheres, or what
    /// the file says; all sources.
    #[serde(default)]
    pub shapes: Vec<ShapeTable>,
    /// Half-width of the uniform distribution of radii: a length, 0 to `radius`; default 0; deposit, pack,
    /// fill.
    #[serde(default)]
    pub variation: Option<Length>,
    /// Geometric standard deviation of log-normal radii, above 1 and at most 3, as 1.3; cut off at three
    /// deviations; deposit, pack, fill (this, `variation` or `sizes`).
    #[serde(default)]
    pub spread: Option<f64>,
    /// File of measured radii, relative to the scene file: lines of a radius (metres, or with a unit as
    /// 0.2mm) and a number of grains, radii rising; instead of `radius`; deposit, pack, fill.
    #[serde(default)]
    pub sizes: Option<String>,
    /// How many grains lie in the end: a whole number, at least 1, as 1_000_000; deposit (this or
    /// `depth`).
    #[serde(default)]
    pub grains: Option<u64>,
    /// How deep the snow lies on level ground: a length above 0, as "3 cm"; deposit (this or
    /// `grains`).
    #[serde(default)]
    pub depth: Option<Length>,
    /// Density of the snow in kg/m^3, above 0 and at most 917 (solid ice; of another `material.kind` its own):
    /// mid-depth, overlaps once; of ice about 15 to 800 for deposit (by aggregates, sticking, rolling and sintering, unless `rule` says
    /// otherwise), 20 to 750 for pack and fill, which need it; default what the rule or lattice gives;
    /// deposit, pack, fill, lattice.
    #[serde(default)]
    pub density: Option<f64>,
    /// Where a falling grain stays: "ray" (the paper's; also "chrisman"), "stick" (at its first
    /// contact) or "roll" (rolls to a stable rest); default "ray", or with `density` whatever reaches it;
    /// deposit.
    #[serde(default)]
    pub rule: Option<DepositRuleName>,
    /// Grains that meet something steeper than this many degrees are discarded, 0 to 90; default 80
    /// for rule = "ray", else 90 (none); deposit.
    #[serde(default)]
    pub max_slope: Option<f64>,
    /// Direction in which grains fall, as a steady wind drives them: [x, y, z], three numbers of
    /// any length with y below 0 and at least a tenth of it; default [0, -1, 0], straight down;
    /// what rolls does so by gravity alone; deposit.
    #[serde(default)]
    pub direction: Option<[f64; 3]>,
    /// Rectangle that grains fall on: [x0, z0, x1, z1], lengths with x0 < x1 and z0 < z1, where
    /// their lines of fall cross y = 0; default the box of the finite objects, seen along the fall,
    /// plus a margin; deposit. Rectangle over which the pictures of `file`, `mask` and `density_map`
    /// lie, the top of a picture at z0; fill.
    #[serde(default)]
    pub area: Option<[Length; 4]>,
    /// Seed of the snow: a whole number; default the position in the list of snow for deposit, 0 for pack
    /// and fill, whose grains fit those of other bodies of the same seed, sizes and density.
    #[serde(default)]
    pub seed: Option<u64>,
    /// "sc" (simple cubic), "bcc" (body-centred), "fcc" (face-centred, tightest) or "hcp"
    /// (hexagonal, tightest); lattice.
    #[serde(default)]
    pub lattice: Option<LatticeName>,
    /// Conventional cells along x, y, z (1, 2, 4, 4 grains each for sc, bcc, fcc, hcp): three whole
    /// numbers, at least 1; lattice.
    #[serde(default)]
    pub counts: Option<[u32; 3]>,
    /// Distance between nearest neighbours: a length above 0; default 2 radius (touching); lattice
    /// (this or `density`).
    #[serde(default)]
    pub spacing: Option<Length>,
    /// Grain file (.ply with x, y, z, radius), relative to the scene file; file. Mesh (.obj, .ply,
    /// .gltf, .glb), closed or with a `base`, or picture of heights (.png, .jpg, .exr, .hdr; of grey values as they stand); fill.
    #[serde(default)]
    pub file: Option<String>,
    /// Box that is filled: [x0, y0, z0, x1, y1, z1], lengths; grains whose centres lie in it; pack.
    #[serde(default, rename = "box")]
    pub block: Option<[Length; 6]>,
    /// Scale of the mesh: a number or three; default 1; fill.
    #[serde(default)]
    pub scale: Option<Triple>,
    /// Rotation of the mesh in degrees about x, then y, then z; default none; fill.
    #[serde(default)]
    pub rotate: Option<[f64; 3]>,
    /// Where the origin of the mesh goes: three lengths; default [0, 0, 0]; fill.
    #[serde(default)]
    pub translate: Option<[Length; 3]>,
    /// Height of white in a picture of heights: a length above 0; fill.
    #[serde(default)]
    pub height: Option<Length>,
    /// Height of the level on which the snow of a picture of heights lies: a length; default 0. With a mesh that is a
    /// surface of heights, open at its rim: the level that it is filled down to; fill.
    #[serde(default)]
    pub base: Option<Length>,
    /// Picture that says where snow is at all: over `area`, where it is at least half white; fill.
    #[serde(default)]
    pub mask: Option<String>,
    /// Picture that says what part of `density` there is: over `area`, white all of it, black none, by taking
    /// grains away at random; fill.
    #[serde(default)]
    pub density_map: Option<String>,
}

/// Where snow comes from.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum SnowSource {
    /// Grains fall.
    Deposit,
    /// A block of a crystal lattice.
    Lattice,
    /// Packed grains in a box.
    Pack,
    /// Packed grains in a mesh or under heights.
    Fill,
    /// Grains from a file.
    File,
}

impl SnowSource {
    /// The name as written.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Deposit => "deposit",
            Self::Lattice => "lattice",
            Self::Pack => "pack",
            Self::Fill => "fill",
            Self::File => "file",
        }
    }
}

/// Where a falling grain stays.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum DepositRuleName {
    /// The paper's rule.
    #[serde(alias = "chrisman")]
    Ray,
    /// At its first contact.
    Stick,
    /// Rolls to a stable rest.
    Roll,
}

/// Crystal lattices.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum LatticeName {
    /// Simple cubic.
    Sc,
    /// Body-centred cubic.
    Bcc,
    /// Face-centred cubic.
    Fcc,
    /// Hexagonal close packed.
    Hcp,
}
