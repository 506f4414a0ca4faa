//! A scene as plain data: what a scene file means once units are converted, references loaded and
//! defaults filled in. [`crate::Scene::build`] turns it into what light can travel through.

use crate::Strata;
pub use crate::light::{LightDescription, LightKind};
pub use crate::surface::Surface;
use crate::transport::deep::DeepSettings;
use crate::transport::medium::{MediumKind, ProxyStart};
pub use crate::transport::seek::Sought;
pub use snowgrain_accel::Packing;
use snowgrain_geometry::TriangleMesh;
use snowgrain_grains::{
    DepositSettings, FieldShapes, FillSettings, GrainField, LatticeSettings, ShapeMix,
};
use snowgrain_math::{DAffine3, DVec3};
use snowgrain_optics::{Absorption, Impurity, Primaries};
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
    /// Solid objects.
    pub objects: Vec<ObjectDescription>,
    /// Snow, in the order in which it falls or is placed.
    pub snow: Vec<SnowDescription>,
    /// Shapes of the grains of each body of snow, in the order of `snow`; `None`, or none for it, where they
    /// are spheres or, of grains from a file, what the file says.
    pub shapes: Vec<Option<ShapeMix>>,
    /// Impurities of single bodies of snow, beside those of the ice.
    pub strata: Strata,
    /// How light is traced.
    pub integrator: IntegratorKind,
    /// How lights are found.
    pub light_finding: LightFinding,
    /// Where paths end deep in the snow; `None`: nowhere, which is exact.
    pub deep: Option<DeepSettings>,
    /// How densely grains are packed for light; `None`: fast, where nothing else decides.
    pub packing: Option<Packing>,
    /// Whether snow of packs is made of tiles that are kept once; `None`: where it has very many grains, and can be.
    pub tiled: Option<bool>,
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
    /// Where in its pixel, and on the lens, each sample begins.
    pub sampler: Sampler,
    /// Primaries of the picture; everything else in a scene is linear sRGB.
    pub primaries: Primaries,
    /// Whether the film keeps each pixel's light by length in ice, so that ice and impurities can be
    /// chosen after the render.
    pub keep_ice_paths: bool,
    /// Exposure at which the picture is meant to be shown, stops; it changes no sums.
    pub exposure_stops: f64,
    /// Whether the film keeps the light of each group of lights apart even where there is only one; where
    /// there are several it always does.
    pub keep_light_groups: bool,
}

impl FilmDescription {
    /// A film of sRGB that keeps nothing but the picture.
    #[must_use]
    pub fn new(width: u32, height: u32, samples_per_pixel: u32, seed: u64) -> Self {
        Self {
            width,
            height,
            samples_per_pixel,
            seed,
            sampler: Sampler::default(),
            primaries: Primaries::Srgb,
            keep_ice_paths: false,
            keep_light_groups: false,
            exposure_stops: 0.0,
        }
    }
}

/// The closed set of ways to choose the first numbers of a path: where in its pixel, and on the lens, it
/// begins. All that follows is independent whatever this is.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Sampler {
    /// Independent samples, whose spread says exactly how uncertain their mean is.
    #[default]
    Independent,
    /// An Owen-scrambled Sobol sequence for each pixel ([`snowgrain_math::sobol`]).
    Sobol,
}

/// A camera.
#[derive(Clone, Debug, PartialEq)]
pub struct CameraDescription {
    /// Position, metres: the middle of the lens, or of the plane in which parallel rays start.
    pub from: DVec3,
    /// Point looked at, metres.
    pub at: DVec3,
    /// Up direction.
    pub up: DVec3,
    /// How points come to the picture.
    pub projection: Projection,
    /// Radiance that a camera ray sees where it meets nothing and no visible light.
    pub backdrop: [f32; 3],
}

/// The closed set of projections.
#[derive(Clone, Debug, PartialEq)]
pub enum Projection {
    /// Rays spread from a point or a lens.
    Perspective {
        /// Vertical field of view, degrees, in (0, 180); that of a lens focused at infinity.
        vertical_fov_degrees: f64,
        /// The lens; `None` for a pinhole, to which all is sharp.
        lens: Option<Lens>,
    },
    /// Parallel rays, from the plane through the camera's position.
    Orthographic {
        /// How much of the world the picture is high, metres, above 0.
        height: f64,
    },
}

impl Projection {
    /// A pinhole with this vertical field of view.
    #[must_use]
    pub fn pinhole(vertical_fov_degrees: f64) -> Self {
        Self::Perspective { vertical_fov_degrees, lens: None }
    }

    /// Whether it is focused on what it sees.
    #[must_use]
    pub fn finds_focus(&self) -> bool {
        match self {
            Self::Perspective { lens: Some(lens), .. } => lens.focus == Focus::Surface,
            Self::Perspective { lens: None, .. } | Self::Orthographic { .. } => false,
        }
    }
}

/// What a lens is focused on.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Focus {
    /// The plane at this distance along the view, metres, above 0.
    Distance(f64),
    /// What the middle of the picture shows, found once all snow lies.
    Surface,
}

/// A thin lens.
#[derive(Clone, Debug, PartialEq)]
pub struct Lens {
    /// Diameter of the entrance pupil, metres, above 0.
    pub diameter: f64,
    /// What is sharp.
    pub focus: Focus,
    /// Blades of the diaphragm: 0 (round), or at least 3 (a regular polygon with its corners on the
    /// circle of the diameter).
    pub blades: u32,
    /// Rotation of the polygon, degrees counter-clockwise; at 0 a corner is up.
    pub blade_rotation_degrees: f64,
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

/// Optical constants of the grains, of ice or of another substance.
#[derive(Clone, Debug, PartialEq)]
pub struct IceDescription {
    /// Index of refraction of all colours, in [1, 4].
    pub ior: f64,
    /// Whether each colour is refracted by its own measured index instead.
    pub disperses: bool,
    /// What lies between the grains, and around them.
    pub pores: Pores,
    /// What it is, and absorbs.
    pub absorption: Absorption,
    /// What lies between the grains, everywhere alike.
    pub impurities: Vec<Impurity>,
}

impl Pores {
    /// Index of refraction of what fills them.
    #[must_use]
    pub fn ior(self) -> f64 {
        match self {
            Self::Air => 1.0,
            Self::Water => WATER_IOR,
        }
    }
}

impl IceDescription {
    /// Ice of this index of refraction that absorbs nothing, clean.
    #[must_use]
    pub fn clear(ior: f64) -> Self {
        let (absorption, impurities) = (Absorption::Grey(0.0), Vec::new());
        Self { ior, disperses: false, pores: Pores::Air, absorption, impurities }
    }

    /// Index of refraction relative to what fills the pores.
    #[must_use]
    pub fn eta(&self) -> f64 {
        match self.pores {
            Pores::Air => self.ior,
            Pores::Water => self.ior / WATER_IOR,
        }
    }

    /// Index of refraction of a wavelength relative to what fills the pores.
    #[must_use]
    pub fn eta_at(&self, wavelength_nm: f64) -> f64 {
        self.absorption.substance().index_relative_to(self.pores == Pores::Water, wavelength_nm)
    }
}

/// A solid object.
#[derive(Clone, Debug)]
pub struct ObjectDescription {
    /// Name for messages (`object.0`, or the file's name).
    pub name: String,
    /// Shape in its own space.
    pub shape: ObjectShape,
    /// What it is made of.
    pub surface: Surface,
    /// What the camera sees of it directly.
    pub direct_view: DirectView,
    /// Own space to world: scale, then rotate, then translate.
    pub transform: DAffine3,
}

/// What the camera sees where its ray meets an object first. To all other light the object is as it is.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum DirectView {
    /// The object.
    #[default]
    Seen,
    /// Nothing: black, of alpha 0.
    Holdout,
    /// The plate behind the picture, with the shadows and the light of snow and objects upon it
    /// ([`snowgrain_film::shadow_catcher`]).
    ShadowCatcher,
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

impl SceneDescription {
    /// The shapes that grains of a body of snow are given, where they are not all spheres.
    #[must_use]
    pub fn shapes_of(&self, body: usize) -> Option<&ShapeMix> {
        let mix = self.shapes.get(body)?.as_ref()?;
        (!mix.is_all_spheres()).then_some(mix)
    }

    /// Whether any grain has a shape other than a sphere.
    #[must_use]
    pub fn has_shapes(&self) -> bool {
        (0..self.snow.len())
            .any(|body| self.shapes_of(body).is_some() || self.snow[body].has_shapes())
    }

    /// Whether a picture is rendered with the arrivals of light at grains noted, or something else asks for each grain.
    #[must_use]
    pub fn notes_visits(&self) -> bool {
        self.light_finding != LightFinding::Exact
            || self.deep.is_some()
            || self.integrator != IntegratorKind::Grains
    }

    /// How far grains of a body of snow may reach, in their radii.
    #[must_use]
    pub fn reach_of(&self, body: usize) -> f64 {
        match (self.shapes_of(body), &self.snow[body]) {
            (Some(mix), _) => mix.largest_reach(),
            (None, SnowDescription::Grains(field)) => {
                field.shapes().map_or(1.0, FieldShapes::largest_reach)
            }
            (
                None,
                SnowDescription::Deposit(_)
                | SnowDescription::Filled(_)
                | SnowDescription::Lattice(_),
            ) => 1.0,
        }
    }
}

/// One body of snow.
#[derive(Clone, Debug)]
pub enum SnowDescription {
    /// A snowfall on objects and earlier snow.
    Deposit(DepositSettings),
    /// A body of packed grains.
    Filled(FillSettings),
    /// A crystal lattice.
    Lattice(LatticeSettings),
    /// Grains as they are (from a file).
    Grains(Arc<GrainField>),
}

impl SnowDescription {
    /// Whether its grains come with shapes.
    #[must_use]
    pub fn has_shapes(&self) -> bool {
        match self {
            Self::Deposit(_) | Self::Filled(_) | Self::Lattice(_) => false,
            Self::Grains(field) => field.shapes().is_some(),
        }
    }
}

/// The closed set of integrators.
#[derive(Clone, Copy, Debug, PartialEq, Default)]
pub enum IntegratorKind {
    /// Every grain is met.
    #[default]
    Grains,
    /// Grains are met at random in a smoothed density ([`crate::transport::medium`]).
    Medium(MediumKind),
    /// Every grain is met, but deep in the snow they are met at random.
    ProxyInDepth(ProxyStart),
}

impl IntegratorKind {
    /// Whether grains are met as the proxy, everywhere or deep in the snow.
    #[must_use]
    pub fn is_proxy(&self) -> bool {
        matches!(self, Self::Medium(MediumKind::Proxy) | Self::ProxyInDepth(_))
    }
}

/// How light is found by paths among grains.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Default)]
pub enum LightFinding {
    /// Exact: where a path escapes or meets it, and nowhere else.
    #[default]
    Exact,
    /// Looked for at every grain and surface ([`crate::transport::seek`]).
    Sampled(SearchSettings),
}

/// How light is looked for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct SearchSettings {
    /// Which lights.
    pub sought: Sought,
    /// Paths by which is measured what a search forgets ([`crate::transport::seek::calibrate`]).
    pub calibration_paths: u64,
}

impl SearchSettings {
    /// For these lights, with enough paths that the light of a sun is known to half a percent.
    #[must_use]
    pub fn of(sought: Sought) -> Self {
        Self { sought, calibration_paths: 1 << 20 }
    }
}
