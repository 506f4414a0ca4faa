//! A scene as plain data: what a scene file means once units are converted, references loaded and
//! defaults filled in. [`crate::Scene::build`] turns it into what light can travel through.

use crate::Strata;
pub use snowgrain_accel::Packing;
use snowgrain_geometry::TriangleMesh;
use snowgrain_grains::{DepositSettings, GrainField, LatticeSettings};
use snowgrain_math::{DAffine3, DVec3};
use snowgrain_optics::{Absorption, Illuminant, Impurity, Primaries};
use std::sync::Arc;

/// Everything that decides a picture. Metres, radians only where named, y up.
#[derive(Clone, Debug)]
pub struct SceneDescription {
    /// The film.
    pub film: FilmDescription,
    /// The camera.
    pub camera: CameraDescription,
    /// The ice.
    pub ice: IceDescription,
    /// The lights; their radiances add.
    pub lights: Vec<LightDescription>,
    /// Solid diffuse objects.
    pub objects: Vec<ObjectDescription>,
    /// Snow, in the order in which it falls or is placed.
    pub snow: Vec<SnowDescription>,
    /// Impurities of single bodies of snow, beside those of the ice.
    pub strata: Strata,
    /// How light is traced.
    pub integrator: IntegratorKind,
    /// How densely grains are packed for light; `None`: fast, where nothing else decides.
    pub packing: Option<Packing>,
}

/// Size and sampling of the picture.
#[derive(Clone, Debug, PartialEq)]
pub struct FilmDescription {
    /// Pixels across, 1..=65536.
    pub width: u32,
    /// Pixels down, 1..=65536.
    pub height: u32,
    /// Samples per pixel, >= 1.
    pub samples_per_pixel: u32,
    /// Seed of the sampler.
    pub seed: u64,
    /// Where in its pixel each sample looks.
    pub sampler: Sampler,
    /// Primaries of the picture; everything else in a scene is linear sRGB.
    pub primaries: Primaries,
    /// Whether the film keeps each pixel's light by length in ice, so that ice and impurities can be
    /// chosen after the render.
    pub keep_ice_paths: bool,
}

impl FilmDescription {
    /// A film of sRGB that keeps nothing but the picture.
    #[must_use]
    pub fn new(width: u32, height: u32, samples_per_pixel: u32, seed: u64) -> Self {
        let (sampler, primaries) = (Sampler::default(), Primaries::Srgb);
        Self { width, height, samples_per_pixel, seed, sampler, primaries, keep_ice_paths: false }
    }
}

/// The closed set of ways to choose the first numbers of a path: where in its pixel it begins. All that
/// follows is independent whatever this is.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Sampler {
    /// Independent samples, whose spread says exactly how uncertain their mean is.
    #[default]
    Independent,
    /// An Owen-scrambled Sobol sequence for each pixel ([`snowgrain_math::sobol`]).
    Sobol,
}

/// A pinhole camera.
#[derive(Clone, Debug, PartialEq)]
pub struct CameraDescription {
    /// Position, metres.
    pub from: DVec3,
    /// Point looked at, metres.
    pub at: DVec3,
    /// Up direction.
    pub up: DVec3,
    /// Vertical field of view, degrees, in (0, 180).
    pub vertical_fov_degrees: f64,
    /// Radiance that a camera ray sees where it meets nothing and no visible light.
    pub backdrop: [f32; 3],
}

/// Index of refraction of water: 1.333 at 550 nm (Hale and Querry 1973, Appl. Opt. 12, 555).
pub const WATER_IOR: f64 = 1.333;

/// What lies between grains.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Pores {
    /// Dry snow.
    #[default]
    Air,
    /// Saturated snow, seen from within the water: its surface is not there, nor its absorption.
    Water,
}

/// Optical constants of the grains.
#[derive(Clone, Debug, PartialEq)]
pub struct IceDescription {
    /// Index of refraction, in [1, 4].
    pub ior: f64,
    /// What lies between the grains, and around them.
    pub pores: Pores,
    /// What it absorbs.
    pub absorption: Absorption,
    /// What lies between the grains, everywhere alike.
    pub impurities: Vec<Impurity>,
}

impl IceDescription {
    /// Ice of this index of refraction that absorbs nothing, clean.
    #[must_use]
    pub fn clear(ior: f64) -> Self {
        let (absorption, impurities) = (Absorption::Grey(0.0), Vec::new());
        Self { ior, pores: Pores::Air, absorption, impurities }
    }

    /// Index of refraction relative to what fills the pores.
    #[must_use]
    pub fn eta(&self) -> f64 {
        match self.pores {
            Pores::Air => self.ior,
            Pores::Water => self.ior / WATER_IOR,
        }
    }
}

/// The closed set of lights.
#[derive(Clone, Debug, PartialEq)]
pub enum LightDescription {
    /// The paper's diffuse hemisphere above y = 0 at infinity.
    Sky {
        /// Radiance, linear sRGB, as a colour and brightness of the spectrum.
        radiance: [f32; 3],
        /// Spectrum.
        spectrum: Illuminant,
        /// Whether a camera ray that meets nothing sees it (else it sees the backdrop).
        visible_to_camera: bool,
    },
    /// The whole sphere at infinity.
    Uniform {
        /// Radiance, linear sRGB, as a colour and brightness of the spectrum.
        radiance: [f32; 3],
        /// Spectrum.
        spectrum: Illuminant,
        /// Whether a camera ray that meets nothing sees it (else it sees the backdrop).
        visible_to_camera: bool,
    },
}

impl LightDescription {
    /// Its spectrum.
    #[must_use]
    pub fn spectrum(&self) -> Illuminant {
        match *self {
            Self::Sky { spectrum, .. } | Self::Uniform { spectrum, .. } => spectrum,
        }
    }

    /// Whether a camera ray that meets nothing sees it.
    #[must_use]
    pub fn visible_to_camera(&self) -> bool {
        match *self {
            Self::Sky { visible_to_camera, .. } | Self::Uniform { visible_to_camera, .. } => {
                visible_to_camera
            }
        }
    }
}

/// A solid diffuse object.
#[derive(Clone, Debug)]
pub struct ObjectDescription {
    /// Name for messages (`object.0`, or the file's name).
    pub name: String,
    /// Shape in its own space.
    pub shape: ObjectShape,
    /// Diffuse albedo, linear RGB, each in [0, 1].
    pub albedo: [f32; 3],
    /// Own space to world: scale, then rotate, then translate.
    pub transform: DAffine3,
}

/// The closed set of object shapes.
#[derive(Clone, Debug)]
pub enum ObjectShape {
    /// Radius 1 at the origin.
    Sphere,
    /// The box [-1, 1]^3.
    Box,
    /// The infinite plane y = 0.
    Plane,
    /// Newell's teapot in his units, turned y up, standing on y = 0.
    Teapot,
    /// Triangles.
    Mesh(Arc<TriangleMesh>),
}

/// One body of snow.
#[derive(Clone, Debug)]
pub enum SnowDescription {
    /// A snowfall on objects and earlier snow.
    Deposit(DepositSettings),
    /// A crystal lattice.
    Lattice(LatticeSettings),
    /// Grains as they are (from a file).
    Grains(Arc<GrainField>),
}

/// The closed set of integrators.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Default)]
pub enum IntegratorKind {
    /// Exact: every grain is met, light is found by escape only.
    #[default]
    Grains,
}
