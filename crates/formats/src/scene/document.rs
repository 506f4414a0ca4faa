//! The scene file as written: one struct a table, one field a key.
//!
//! The doc comments here are the manual of the format: the JSON Schema and the error messages quote
//! them. [`super::resolve`] says what a document means.

mod animate;
mod camera;
mod kind;
mod light;
mod material;
mod shapes;
mod snow;
mod substance;

pub use animate::{AnimateTable, AnimatedValue, BetweenName};
pub use camera::{CameraKind, CameraTable, ImportTable};
pub use kind::SnowKindName;
pub use light::{LightKindName, LightTable, SpectrumName, UnitsName};
pub use material::{MaterialName, MetalName};
pub use shapes::{OrientationName, ShapeName, ShapeTable};
pub use snow::{DepositRuleName, LatticeName, SnowSource, SnowTable};
pub use substance::{MaterialTable, SubstanceName};

use super::quantity::{Absorption, Length, LoadText, Triple};
use schemars::JsonSchema;
use serde::Deserialize;
use std::collections::BTreeMap;

/// A Snowgrain scene, version 1. Lengths are numbers (metres) or strings with a unit ("0.5 mm");
/// y is up; colours are linear sRGB.
#[derive(Clone, Debug, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SceneDocument {
    /// Version of the format: 1.
    pub version: u32,
    /// The picture.
    #[serde(default)]
    pub film: FilmTable,
    /// A shot made elsewhere, of which objects, camera and lights are taken over.
    #[serde(default)]
    pub import: Option<ImportTable>,
    /// The camera; may be left out where `import` has one.
    #[serde(default)]
    pub camera: Option<CameraTable>,
    /// What grains are made of.
    #[serde(default)]
    pub material: MaterialTable,
    /// The ice that grains are made of, and what lies between them.
    #[serde(default)]
    pub ice: IceTable,
    /// The lights; their radiances add. At least one, or an object with `emission`, or a light of `import`.
    #[serde(default)]
    pub light: Vec<LightTable>,
    /// Solid objects.
    #[serde(default)]
    pub object: Vec<ObjectTable>,
    /// Bodies of snow and snowfalls, in the order in which they come.
    #[serde(default)]
    pub snow: Vec<SnowTable>,
    /// How light is traced.
    #[serde(default)]
    pub integrator: IntegratorTable,
    /// Keys that change from frame to frame; without --frame the scene is as it is written.
    #[serde(default)]
    pub animate: Vec<AnimateTable>,
}

/// Size and sampling of the picture.
#[derive(Clone, Debug, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct FilmTable {
    /// Pixels across: a whole number, 1 to 65536; default 512.
    pub width: u32,
    /// Pixels down: a whole number, 1 to 65536; default 512.
    pub height: u32,
    /// Samples per pixel: a whole number, at least 1; default 64.
    pub samples_per_pixel: u32,
    /// Seed of the random numbers of light: a whole number; default 0.
    pub seed: u64,
    /// Where in its pixel, and through its lens, each sample looks: "independent" (at random, so that the layers of variance
    /// say exactly how uncertain the picture is) or "sobol" (spread evenly: less noise at edges, where
    /// the layers of variance then say too much); default "independent".
    pub sampler: SamplerName,
    /// Primaries of the picture: "srgb" or "acescg"; default "srgb". All colours in a scene are of
    /// sRGB whatever they are.
    pub primaries: PrimariesName,
    /// What a .film file keeps beside the picture: "ice-paths", each pixel's light by length in
    /// ice, so that ice and impurities can be chosen after the render (768 bytes a pixel for each
    /// group and spectrum of lights); "light-groups", the light of each group of lights, so that they can
    /// be mixed after the render (48 bytes a pixel for each group; always kept where there are several);
    /// default [], nothing.
    pub keep: Vec<KeepName>,
}

/// Primaries of pictures.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum PrimariesName {
    /// sRGB and Rec. 709.
    #[default]
    Srgb,
    /// ACEScg (AP1).
    Acescg,
}

/// Ways to choose where in its pixel each sample looks.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum SamplerName {
    /// At random.
    #[default]
    Independent,
    /// Along an Owen-scrambled Sobol sequence.
    Sobol,
}

/// What a film may keep.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum KeepName {
    /// Light by length in ice.
    IcePaths,
    /// Light by group of lights.
    LightGroups,
}

impl Default for FilmTable {
    fn default() -> Self {
        Self {
            width: 512,
            height: 512,
            samples_per_pixel: 64,
            seed: 0,
            sampler: SamplerName::default(),
            primaries: PrimariesName::default(),
            keep: Vec::new(),
        }
    }
}

/// The ice, and what lies between its grains.
#[derive(Clone, Debug, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct IceTable {
    /// Index of refraction, 1 to 4; default 1.31 (the paper uses 1.32).
    pub ior: f64,
    /// What lies between the grains: "air", or "water" (saturated snow, seen from within the water: its
    /// surface reflects nothing); default "air".
    pub pores: PoresName,
    /// What the ice absorbs: "picard-2016" or "warren-brandt-2008" (as measured, with its colour;
    /// they differ below 600 nm), or one number for all wavelengths, in 1/m, at least 0; default
    /// "picard-2016".
    pub absorption: Absorption,
    /// Impurities between all grains, { black-carbon = "200 ppb" }: a load for each name. Loads are
    /// by mass of ice (ppb, ng/g, ppm, ug/g, mg/kg), by volume of ice (vol, the paper's P), or for
    /// algae in cells/mL of melt water; default none.
    pub impurities: BTreeMap<String, LoadText>,
}

impl Default for IceTable {
    fn default() -> Self {
        Self {
            ior: 1.31,
            pores: PoresName::default(),
            absorption: Absorption::default(),
            impurities: BTreeMap::new(),
        }
    }
}

/// What lies between grains.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum PoresName {
    /// Dry snow.
    #[default]
    Air,
    /// Saturated snow.
    Water,
}

fn one() -> Triple {
    Triple([1.0; 3])
}

/// A solid object. It is scaled, then rotated, then translated.
#[derive(Clone, Debug, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ObjectTable {
    /// "sphere" (radius 1 at the origin), "box" ([-1,1]^3), "plane" (y = 0, infinite), "teapot"
    /// (Newell's units: 6.43 long, standing on y = 0, spout along +x) or "mesh" (from `file`).
    pub shape: ShapeKind,
    /// Name used in messages: a string; default the file's name or `object.N`.
    #[serde(default)]
    pub name: Option<String>,
    /// Mesh file (.obj, .ply, .gltf or .glb), relative to the scene file; only for shape = "mesh".
    #[serde(default)]
    pub file: Option<String>,
    /// "diffuse" (reflects light evenly), "conductor" (a metal) or "dielectric" (a clear solid, as glass;
    /// a mesh must be closed); default "diffuse".
    #[serde(default)]
    pub material: MaterialName,
    /// Albedo: one number or [r, g, b], each 0 to 1; default 0.5; diffuse.
    #[serde(default = "half")]
    pub albedo: Triple,
    /// Picture that gives the albedo or the reflectance by place (.png, .jpg, .exr or .hdr), relative to the
    /// scene file; diffuse (instead of `albedo`), conductor (instead of `metal` and `reflectance`). A mesh
    /// needs texture coordinates; a sphere has longitude and latitude, each face of a box and each patch of
    /// the teapot the whole picture.
    #[serde(default)]
    pub albedo_texture: Option<String>,
    /// Width and height of the picture on a plane: a length above 0; default 1 m; plane.
    #[serde(default)]
    pub texture_scale: Option<Length>,
    /// "aluminium", "chromium", "copper", "gold", "iron" or "silver", of measured reflectance;
    /// conductor (this or `reflectance`).
    #[serde(default)]
    pub metal: Option<MetalName>,
    /// Reflectance of a metal at normal incidence: one number or [r, g, b], each 0 to 1; conductor (this or
    /// `metal`).
    #[serde(default)]
    pub reflectance: Option<Triple>,
    /// Roughness, 0 to 1: the slope of the microfacets (GGX) is its square, below 0.05 the surface is smooth;
    /// default 0.3 for a conductor, 0 for a dielectric; conductor, dielectric.
    #[serde(default)]
    pub roughness: Option<f64>,
    /// Index of refraction, 1 to 4; default 1.5 (window glass); dielectric.
    #[serde(default)]
    pub ior: Option<f64>,
    /// Whether it is cut out where the camera sees it directly: black, of alpha 0; it throws shadows, is
    /// mirrored and carries snow as ever; default false.
    #[serde(default)]
    pub holdout: bool,
    /// Whether it stands for a surface of another picture: where the camera sees it directly, the picture
    /// holds only the shadow and the light that snow and objects throw upon it, to be put over that
    /// picture; default false.
    #[serde(default)]
    pub shadow_catcher: bool,
    /// Radiance that it sends out on both sides, as a lamp: one number or [r, g, b], at least 0; it is black
    /// then and takes no material; not for a plane; default none.
    #[serde(default)]
    pub emission: Option<Triple>,
    /// Spectrum of the emission, as `light.spectrum`; default "d65".
    #[serde(default)]
    pub emission_spectrum: Option<SpectrumName>,
    /// Group of the emission, as `light.group`; default "lamps".
    #[serde(default)]
    pub emission_group: Option<String>,
    /// Scale: one number or [x, y, z], none of them 0; default 1.
    #[serde(default = "one")]
    pub scale: Triple,
    /// Rotation in degrees about x, then y, then z: [x, y, z]; default [0, 0, 0].
    #[serde(default)]
    pub rotate: [f64; 3],
    /// Translation: [x, y, z], lengths; default [0, 0, 0].
    #[serde(default = "nowhere")]
    pub translate: [Length; 3],
    /// Where the object stands, for one that stands in several places:
    /// [{ translate = [1, 0, 0] }, { translate = [2, 0, 0], rotate = [0, 90, 0] }]. Each moves the
    /// object as the keys above have placed it; a mesh is held in memory once; default one place,
    /// that of the keys above.
    #[serde(default)]
    pub instances: Option<Vec<InstanceTable>>,
}

/// One of several places of an object. The object is scaled, then rotated, then translated once
/// more.
#[derive(Clone, Debug, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct InstanceTable {
    /// Scale: one number or [x, y, z], none of them 0; default 1.
    #[serde(default = "one")]
    pub scale: Triple,
    /// Rotation in degrees about x, then y, then z: [x, y, z]; default [0, 0, 0].
    #[serde(default)]
    pub rotate: [f64; 3],
    /// Translation: [x, y, z], lengths; default [0, 0, 0].
    #[serde(default = "nowhere")]
    pub translate: [Length; 3],
    /// Albedo of a diffuse object: one number or [r, g, b], each 0 to 1; default that of the object.
    #[serde(default)]
    pub albedo: Option<Triple>,
}

fn half() -> Triple {
    Triple([0.5; 3])
}

fn nowhere() -> [Length; 3] {
    [Length { metres: 0.0 }; 3]
}

/// Shapes of objects.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum ShapeKind {
    /// Radius 1 at the origin.
    Sphere,
    /// The box [-1, 1]^3.
    Box,
    /// The infinite plane y = 0.
    Plane,
    /// Newell's teapot.
    Teapot,
    /// Triangles from a file.
    Mesh,
}

/// How light is traced.
#[derive(Clone, Debug, PartialEq, Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct IntegratorTable {
    /// "grains" (every grain is met), or for comparison "volume" (volume path tracing) "proxy" (grains that are met at
    /// random) or "dipole" (diffusion below its surface), see docs/roads.md; default "grains".
    pub kind: IntegratorName,
    /// How lights are found: "exact" (where a path escapes or meets them, and nowhere else), "sampled"
    /// (suns, lamps and maps are looked for at every grain and surface: far less noise, and right within what
    /// `snowgrain measure search` tells; docs/lights.md), "all-sampled" (skies too) or "auto" (exact where all lights are skies, else
    /// sampled); default "auto".
    pub light: LightFindingName,
    /// Paths by which is measured, before the picture, what light that is looked for differs by from light
    /// that is met: an error of 300 % over its square root is left in the light of a sun. Default
    /// 1048576, 5 to 20 s of one core.
    pub calibration_paths: Option<u64>,
    /// What becomes of light deep in the snow: "exact" (it is followed to its end) or "learnt" (it ends there with
    /// what other paths brought from there: ten times faster and more, see docs/deep.md), "proxy" (there it meets grains at
    /// random, see docs/roads.md) or "shells" (as "proxy", but where it has room it jumps over spheres of snow); default "exact".
    pub deep: DeepName,
    /// Part by which learnt light may be wrong on average over a block of 16 x 16 pixels, from 0.001: it chooses the
    /// following three; default 0.01.
    pub lod_error: Option<f64>,
    /// Grains that a path meets exactly before it may end, of spheres of ice (of others as many as turn light as much); default 4 (4 and
    /// 8 for errors of .003 and .001), and half as many where a pixel is wider than 1.5 radii of the grains, in between
    /// where it is wider than half of one.
    pub deep_after_grains: Option<u32>,
    /// How far from open air and surfaces it must then be, in transport lengths (11.6 mm for grains of .5 mm
    /// at 275 kg/m^3); default 0.25 (0.5 and 1), at least 0.5 where small lights are looked for.
    pub deep_depth: Option<f64>,
    /// Paths by which it is learnt; default 786432 (1572864 and 3145728), twice as many where small
    /// lights are looked for.
    pub learning_paths: Option<u64>,
    /// "fast", or "compact" (grains take half the memory or less, at two thirds of the speed; light is
    /// rounded otherwise); default "fast", or what --max-memory has room for.
    pub packing: Option<PackingName>,
    /// Whether snow of `source` "pack" and "fill" is made of tiles that are kept once, so that memory grows with its
    /// surface alone; absent: where the scene has more than four million grains, all of spheres of one pack without
    /// masks, density maps or impurities of their own.
    pub tiled: Option<bool>,
}

/// What becomes of light deep in the snow.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum DeepName {
    /// It is followed to its end.
    #[default]
    Exact,
    /// It ends with what others brought.
    Learnt,
    /// It goes on from sphere to sphere met at random.
    Proxy,
    /// As the proxy, but it jumps over spheres of uniform snow.
    Shells,
}

/// How lights are found.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum LightFindingName {
    /// Sampled where there is a small light.
    #[default]
    Auto,
    /// By chance.
    Exact,
    /// Small lights are looked for.
    Sampled,
    /// All lights are looked for.
    AllSampled,
}

/// Packings of grains.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum PackingName {
    /// Fastest.
    Fast,
    /// Less memory.
    Compact,
}

/// Integrators.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum IntegratorName {
    /// Exact.
    #[default]
    Grains,
    /// Points in a smoothed density.
    Volume,
    /// Spheres in a smoothed density.
    Proxy,
    /// Diffusion from the surface of a smoothed density.
    Dipole,
}
