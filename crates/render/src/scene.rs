//! A scene that light can travel through.

mod calibrated;
mod packed;
mod quantisation;
mod tiled;

use crate::bodies::KnownGrains;
use crate::camera::Camera;
use crate::catchers;
use crate::description::{IntegratorKind, LightFinding, ObjectShape, SceneDescription};
use crate::dispersion::{BandOptics, bands_of};
use crate::light::{BACKDROP_GROUP, LightSlot, Lights, LitSurfaces, slots_of};
use crate::scene_hash::{hash_scene, recipe};
use crate::surface::{Material, Place};
use crate::transport::deep::{LearntStore, OutcomeField};
use crate::transport::medium::{Medium, ProxyInDepth};
use crate::transport::seek::LightSearch;
use crate::{RenderError, World};
use calibrated::calibrated;
use packed::{Packed, build_grid, fall};
use snowgrain_accel::{SimdLevel, SurfaceShape, Surfaces};
use snowgrain_film::{FilmError, GLINTS, LightLayerNames};
use snowgrain_geometry::teapot::teapot;
use snowgrain_grains::{DepositReport, FillReport, GrainField};
use snowgrain_math::DAffine3;
use snowgrain_optics::{Dielectric, Grade, IceColour, StrataColour, sphere};
use std::cell::LazyCell;
use std::sync::Arc;
pub(crate) use tiled::tiled_bodies;

/// Quads along each edge of a patch of the built-in teapot: 65 536 triangles, 3 mm wide on a
/// teapot of .2 m.
const TEAPOT_DIVISIONS: u32 = 32;

/// What a build is about to do.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum BuildStage {
    /// The structure that finds surfaces.
    Surfaces,
    /// Snow number `index` falls or is placed.
    Snow {
        /// Index among the scene's snow, from 0.
        index: usize,
    },
    /// So many grains of snow number `index` lie; told about every tenth of a second or sooner.
    Fallen {
        /// Index among the scene's snow, from 0.
        index: usize,
        /// Grains of this snow that lie.
        grains: u64,
    },
    /// Grains are packed for light.
    Packing,
    /// What the search for light forgets is measured ([`crate::transport::seek::calibrate`]).
    Light,
    /// What light brings from deep in the snow is learnt ([`crate::transport::deep`]).
    Deep,
}

/// What was made of a body of snow.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum SnowReport {
    /// A snowfall.
    Fell(DepositReport),
    /// A body of packed grains.
    Filled(FillReport),
    /// Grains were put where they were told.
    Placed,
}

/// What a build made.
#[derive(Clone, Debug, Default)]
pub struct BuildReport {
    /// Of each body of snow, in order.
    pub snow: Vec<SnowReport>,
    /// Number of grains.
    pub grains: u64,
    /// Memory of the grains and their acceleration while rendering, bytes.
    pub grain_bytes: u64,
    /// Memory of the surfaces, bytes.
    pub surface_bytes: u64,
    /// What is learnt of light deep in the snow, where it is.
    pub learnt: Option<LearntReport>,
}

/// What was learnt of light deep in the snow.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LearntReport {
    /// Cells that are told apart.
    pub cells: u64,
    /// Memory that they take.
    pub bytes: u64,
    /// Relative standard error of the learnt light of the whole picture.
    pub relative_error: f64,
}

/// Everything between a description and a picture.
#[derive(Debug)]
pub struct Scene {
    /// What light can meet.
    pub world: World,
    /// The camera.
    pub camera: Camera,
    /// The lights.
    pub lights: Lights,
    /// What turns lengths in ice into colours.
    pub grade: Grade,
    /// The layers of light that the film keeps, if it keeps any.
    pub light_layers: Option<LightLayerNames>,
    /// Which of them is that of glints.
    pub glint_layer: Option<usize>,
    /// The colours of each slot of the lights after any length in ice.
    pub colours: Vec<IceColour>,
    /// The same after lengths in ice of several strata; empty where there are none.
    pub strata_colours: Vec<StrataColour>,
    /// How light is looked for; `None` where it is only met.
    pub search: Option<LightSearch>,
    /// What light from deep in the snow brings; `None` where it is followed to its end.
    pub outcomes: Option<OutcomeField>,
    /// The medium that stands for the grains, where one does.
    pub medium: Option<Medium>,
    /// Where grains are met at random instead, deep in the snow.
    pub proxy: Option<ProxyInDepth>,
    /// The same and the colours of each band of wavelengths, where grains disperse light; else empty.
    pub bands: Vec<BandOptics>,
    /// The shadow catchers and the lights alone, where there are shadow catchers.
    pub catchers_alone: Option<Box<Self>>,
    /// Size and sampling of the picture.
    pub film: crate::description::FilmDescription,
    /// Digest of all content that decides the pixels but the seed and the samples.
    pub hash: [u8; 32],
    /// Digest of what was asked for ([`crate::recipe`]).
    pub recipe: [u8; 32],
    /// What the build made.
    pub report: BuildReport,
}

impl Scene {
    /// Lets the snow fall and packs it, at the best SIMD level of the machine; `stage` is told what
    /// is about to be done.
    ///
    /// # Errors
    /// Snow that cannot be made or packed.
    pub fn build(
        description: &SceneDescription,
        stage: &mut dyn FnMut(BuildStage),
    ) -> Result<Self, RenderError> {
        Self::build_at(description, SimdLevel::detect(), stage)
    }

    /// As [`Self::build`], with snow that falls by the instructions of `level`, by which the surfaces
    /// are searched from then on; the same scene.
    ///
    /// # Errors
    /// As [`Self::build`].
    ///
    /// # Panics
    /// If the machine does not have the level.
    pub fn build_at(
        description: &SceneDescription,
        level: SimdLevel,
        stage: &mut dyn FnMut(BuildStage),
    ) -> Result<Self, RenderError> {
        Self::build_keeping(description, (level, None), stage)
    }

    /// As [`Self::build_at`]; what is learnt of light deep in the snow is taken from a store where it is there, and else
    /// put there: the same scene.
    ///
    /// # Errors
    /// As [`Self::build`].
    ///
    /// # Panics
    /// If the machine does not have the level.
    pub fn build_keeping(
        description: &SceneDescription,
        (level, mut store): (SimdLevel, Option<LearntStore<'_>>),
        stage: &mut dyn FnMut(BuildStage),
    ) -> Result<Self, RenderError> {
        let slots = slots_of(&description.lights, description.camera.backdrop);
        let light_layers = light_layers(description, &slots)?;
        let is_glints = |name: &String| name == GLINTS;
        let glint_layer =
            light_layers.as_ref().and_then(|layers| layers.names().iter().position(is_glints));
        stage(BuildStage::Surfaces);
        let objects = surfaces_of(description).with_level(level);
        let bounds = objects.bounds();
        let lit = LitSurfaces::new(shapes_of(description), &description.lights);
        let mut report = BuildReport::default();
        let Packed { grid, surfaces, digest, prototypes } =
            build_grid(description, (objects, &lit, level), &mut report, stage)?;
        let hash = hash_scene(description, &digest);
        report.grains = grid.grains();
        report.grain_bytes = grid.memory_bytes();
        report.surface_bytes = surfaces.memory_bytes() as u64;
        let bounds = bounds.union(&grid.bounds());
        let lights = Lights::new(&description.lights, &lit, description.camera.backdrop, &bounds);
        let grade = grade(description, lights.slots());
        let world = World {
            grid,
            surfaces,
            materials: materials(description, &lit),
            emitters: lit.emitters,
            eta: description.ice.eta(),
        };
        let film = &description.film;
        let mut camera = Camera::new(&description.camera, film);
        if description.camera.projection.finds_focus() {
            camera = camera.focused_on_surface(&world, level);
        }
        let medium = match description.integrator {
            IntegratorKind::Grains | IntegratorKind::ProxyInDepth(_) => None,
            IntegratorKind::Medium(kind) => {
                let looks = description.light_finding != LightFinding::Exact;
                let snowy = (&world, &*lit.shapes, &*prototypes);
                let medium = Medium::new(kind, snowy, (&lights, looks));
                let snow = (description, &*report.snow);
                let known = |medium| calibrated(medium, snow, store.as_mut(), stage);
                let medium = medium.map(known).transpose()?;
                let places: Vec<Place> = lit.shapes.iter().map(Place::new).collect();
                let ice = &grade.colours()[0];
                medium.map(|medium| medium.glowing((&world, &places), ice, film.seed))
            }
        };
        let proxy = match description.integrator {
            IntegratorKind::Grains | IntegratorKind::Medium(_) => None,
            IntegratorKind::ProxyInDepth(start) => {
                let snowy = (&world, &*lit.shapes, &*prototypes);
                let snow = (description, &*report.snow);
                let known = |medium| calibrated(medium, snow, store.as_mut(), stage);
                let looks = description.light_finding != LightFinding::Exact;
                ProxyInDepth::new(snowy, (&lights, looks), &start, known)?
            }
        };
        let search = match (description.light_finding, description.integrator) {
            (LightFinding::Exact, _) | (_, IntegratorKind::Medium(_)) => None,
            (
                LightFinding::Sampled(settings),
                IntegratorKind::Grains | IntegratorKind::ProxyInDepth(_),
            ) => {
                stage(BuildStage::Light);
                let size = [film.width, film.height];
                let search =
                    LightSearch::new(&lights, world.eta, settings.sought).among(&prototypes, level);
                let paths = (size, settings.calibration_paths);
                Some(search.calibrated((&world, &camera), paths, film.seed, level))
            }
        };
        let outcomes = description.deep.and_then(|settings| {
            stage(BuildStage::Deep);
            let picture = ([film.width, film.height], film.seed);
            let learn = || {
                let (world, lights) = ((&world, &*prototypes, &camera), (&lights, search.as_ref()));
                OutcomeField::learn(world, lights, &settings, picture, level)
            };
            let Some(store) = store else { return learn() };
            let key = learnt_key(&hash, picture);
            let kept = (store.load)(&key).and_then(|bytes| {
                let world = (&world, &*prototypes, &camera);
                OutcomeField::from_bytes(world, &lights, &settings, (&key, &bytes), level)
            });
            kept.or_else(|| {
                let learnt = learn()?;
                (store.save)(&key, &learnt.to_bytes(&key));
                Some(learnt)
            })
        });
        report.learnt = outcomes.as_ref().map(|field| LearntReport {
            cells: field.cells() as u64,
            bytes: field.memory_bytes(),
            relative_error: field.relative_error(),
        });
        let catchers_alone = match catchers::alone(description) {
            None => None,
            Some(alone) => {
                let alone = Self::build_at(&alone, level, &mut |_| {})?;
                let (camera, light_layers) = (camera.clone(), None);
                Some(Box::new(Self { camera, light_layers, glint_layer: None, ..alone }))
            }
        };
        Ok(Self {
            hash,
            recipe: recipe(description),
            world,
            camera,
            lights,
            bands: bands_of(description, &grade, search.as_ref()),
            search,
            outcomes,
            medium,
            proxy,
            catchers_alone,
            light_layers,
            glint_layer,
            colours: grade.colours(),
            strata_colours: grade.strata_colours(&description.strata.loads),
            grade,
            film: description.film.clone(),
            report,
        })
    }

    /// The index of the grains, and how light is looked for, of a band of wavelengths.
    pub(crate) fn optics_of(&self, band: usize) -> (f64, Option<&LightSearch>) {
        match self.bands.get(band) {
            Some(band) => (band.eta, band.search.as_ref()),
            None => (self.world.eta, self.search.as_ref()),
        }
    }

    /// The colours of light of a band of wavelengths after ice, and after that of several strata.
    pub(crate) fn colours_of(&self, band: usize) -> (&[IceColour], &[StrataColour]) {
        match self.bands.get(band) {
            Some(band) => (&band.colours, &band.strata_colours),
            None => (&self.colours, &self.strata_colours),
        }
    }

    /// Whether the light of paths is told by what was found on the way.
    pub(crate) fn finds_on_the_way(&self) -> bool {
        self.search.is_some() || self.outcomes.is_some() || self.medium.is_some()
    }

    /// Whether a ray of the camera may start in ice, as far as boxes tell.
    pub(crate) fn may_start_in_ice(&self) -> bool {
        let (starts, grains) = (self.camera.starts(), self.world.grid.bounds());
        self.world.grid.grains() > 0
            && starts.min.cmple(grains.max).all()
            && starts.max.cmpge(grains.min).all()
    }
}

/// What the objects of a scene do to light, in their order.
fn materials(description: &SceneDescription, lit: &LitSurfaces) -> Vec<Material> {
    let surroundings = description.ice.pores.ior();
    let objects = description.objects.iter().zip(&lit.shapes);
    objects
        .map(|(object, place)| {
            let material = Material::new(object.surface.clone(), place, surroundings);
            material.seen_as(object.direct_view)
        })
        .collect()
}

/// What turns lengths in ice into colours in this scene.
fn grade(description: &SceneDescription, slots: &[LightSlot]) -> Grade {
    let ice = &description.ice;
    Grade {
        primaries: description.film.primaries,
        lights: slots.iter().map(|slot| slot.spectrum).collect(),
        absorption: ice.absorption.clone(),
        impurities: ice.impurities.clone(),
        enhancement: sphere::absorption_enhancement(Dielectric { eta: ice.eta() }),
        exposure_stops: description.film.exposure_stops,
    }
}

/// The layers of light that the film of a scene keeps: where there are several groups of lights, or where
/// the scene asks for them.
///
/// # Errors
/// Names that a film cannot have, or too many.
pub(crate) fn light_layers(
    description: &SceneDescription,
    slots: &[LightSlot],
) -> Result<Option<LightLayerNames>, FilmError> {
    let mut names: Vec<String> = Vec::new();
    let mut layer_of_slot = Vec::new();
    for slot in slots {
        let known = names.iter().position(|name| *name == slot.group);
        layer_of_slot.push(known.unwrap_or(names.len()) as u32);
        if known.is_none() {
            names.push(slot.group.clone());
        }
    }
    let searched = description.light_finding != LightFinding::Exact;
    if searched && !description.film.keep_ice_paths {
        names.push(GLINTS.to_owned());
    }
    let lit = names.iter().filter(|name| *name != BACKDROP_GROUP).count();
    if lit < 2 && !description.film.keep_light_groups {
        return Ok(None);
    }
    LightLayerNames::new(names, layer_of_slot).map(Some)
}

/// Lets all snow of a scene fall and gives its grains (for `snowgrain deposit`).
///
/// # Errors
/// Snow that cannot be made.
pub fn deposit(
    description: &SceneDescription,
    stage: &mut dyn FnMut(BuildStage),
) -> Result<(GrainField, Vec<SnowReport>), RenderError> {
    deposit_at(description, SimdLevel::detect(), stage)
}

/// As [`deposit`], by the instructions of `level`; the same grains.
///
/// # Errors
/// As [`deposit`].
pub fn deposit_at(
    description: &SceneDescription,
    level: SimdLevel,
    stage: &mut dyn FnMut(BuildStage),
) -> Result<(GrainField, Vec<SnowReport>), RenderError> {
    stage(BuildStage::Surfaces);
    let surfaces = surfaces_of(description);
    let mut report = BuildReport::default();
    let mut known = KnownGrains::of_shapes(description);
    let field = fall(description, (&surfaces, level), &mut known, &mut report, stage)?;
    Ok((field, report.snow))
}

/// The surfaces of a scene's objects, in their order, without lamps. Objects with the same mesh share it.
#[must_use]
pub fn surfaces_of(description: &SceneDescription) -> Surfaces {
    Surfaces::new(&shapes_of(description))
}

/// The shapes of a scene's objects, in their order.
fn shapes_of(description: &SceneDescription) -> Vec<(SurfaceShape, DAffine3)> {
    let pot = LazyCell::new(|| Arc::new(teapot(TEAPOT_DIVISIONS)));
    description
        .objects
        .iter()
        .map(|object| {
            let shape = match &object.shape {
                ObjectShape::Sphere => SurfaceShape::Sphere,
                ObjectShape::Box => SurfaceShape::Box,
                ObjectShape::Plane => SurfaceShape::Plane,
                ObjectShape::Teapot => SurfaceShape::Mesh(Arc::clone(&pot)),
                ObjectShape::Mesh(mesh) => SurfaceShape::Mesh(Arc::clone(mesh)),
            };
            (shape, object.transform)
        })
        .collect()
}

/// What tells learnt light from that of another scene, seed or picture.
fn learnt_key(scene_hash: &[u8; 32], (size, seed): ([u32; 2], u64)) -> [u8; 32] {
    let mut hasher = blake3::Hasher::new();
    hasher.update(scene_hash).update(&seed.to_le_bytes());
    size.iter().for_each(|along| {
        hasher.update(&along.to_le_bytes());
    });
    *hasher.finalize().as_bytes()
}
