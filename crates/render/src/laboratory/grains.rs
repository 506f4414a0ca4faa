//! A layer as what it is: grains at random places or in a lattice, that repeat for ever, traced exactly.

use super::lengths::Ends;
use super::progress::Round;
use super::{AlbedoSettings, Incidence, SnowLayer, SnowStack, SpreadSettings};
use crate::measure::{self, SlabSettings};
use crate::transport::{NewPath, PathEnd, PathResult, PathSource, trace};
use crate::{RenderError, World};
use rayon::prelude::*;
use snowgrain_accel::{GrainGrid, Packing, Surfaces};
use snowgrain_grains::{
    GrainsError, ICE_DENSITY, LayerSettings, RandomSettings, Stacking, random_pack,
};
use std::ops::Range;

/// Period along x and z, in radii: light forgets where it entered over less.
const WIDTH_IN_RADII: f64 = 40.0;
/// Paths that a thread follows at a time.
const PATHS_PER_TASK: u64 = 1 << 12;

/// A layer of equal grains, packed for light.
#[derive(Debug)]
pub struct GrainLayer {
    world: World,
    period: [f64; 2],
    /// Height of the upper face; the lower one is at 0.
    depth: f64,
    radius: f64,
}

/// How grains are packed.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Pack {
    /// At random places without overlap (random sequential addition), in a period of 40 radii.
    Random,
    /// In the simple cubic lattice on (001), at distances that make the density. Parallel light goes along
    /// rows of neighbours.
    SimpleCubic,
    /// The same in the face-centred cubic lattice.
    FaceCentredCubic,
}

impl Pack {
    fn stacking(self) -> Option<Stacking> {
        match self {
            Self::Random => None,
            Self::SimpleCubic => Some(Stacking::SimpleCubic),
            Self::FaceCentredCubic => Some(Stacking::FaceCentredCubic),
        }
    }
}

impl GrainLayer {
    /// About how many grains the first layer of `stack` takes; those of infinite depth are none.
    #[must_use]
    pub fn grains(stack: &SnowStack, pack: Pack) -> u64 {
        let Some(layer) = stack.layers.first().filter(|layer| layer.depth.is_finite()) else {
            return 0;
        };
        if pack != Pack::Random {
            return (layer.depth / layer.radius) as u64;
        }
        let columns = WIDTH_IN_RADII * WIDTH_IN_RADII * layer.depth / layer.radius;
        (layer.density / ICE_DENSITY * columns / (4.0 / 3.0 * core::f64::consts::PI)) as u64
    }

    /// The stack of which [`Self::new`] makes grains: the depth of a lattice becomes that of whole layers.
    ///
    /// # Errors
    /// Several layers, infinite depth, a density that the pack does not reach.
    pub fn packed(stack: &SnowStack, pack: Pack) -> Result<SnowStack, RenderError> {
        let layer = only_layer(stack)?;
        let Some(stacking) = pack.stacking() else { return Ok(stack.clone()) };
        let layers = layer_settings(layer, stacking).layers()?;
        let depth = f64::from(layers.count) * layers.step;
        Ok(SnowStack { layers: vec![SnowLayer { depth, ..layer.clone() }], ..stack.clone() })
    }

    /// The only layer of `stack`, packed (see `snowgrain_grains::{random, layers}`).
    ///
    /// # Errors
    /// Several layers, infinite depth, a density that the pack does not reach.
    pub fn new(stack: &SnowStack, pack: Pack, seed: u64) -> Result<Self, RenderError> {
        let layer = only_layer(stack)?;
        let SnowLayer { radius, density, depth, .. } = *layer;
        let (field, period, depth) = match pack.stacking() {
            None => {
                let width = WIDTH_IN_RADII * radius;
                let settings = RandomSettings { radius, density, depth, width, seed };
                let (field, period) = random_pack(&settings)?;
                (field, period, depth)
            }
            Some(stacking) => {
                let settings = layer_settings(layer, stacking);
                let (field, period) = settings.slab()?;
                (field, period, settings.layers()?.depth(radius))
            }
        };
        let quantum = field.quantisation.quantum();
        let grains = field.grains();
        let grid = GrainGrid::build_periodic(field.quantisation, &*grains, period, Packing::Fast)?;
        let surfaces = Surfaces::default();
        let world = World { grid, surfaces, albedos: Vec::new(), eta: 1.31 };
        Ok(Self { world, period: period.map(|length| length as f64 * quantum), depth, radius })
    }

    /// The ice is of this refractive index from now on.
    pub(super) fn set_refractive_index(&mut self, eta: f64) {
        self.world.eta = eta;
    }

    /// Follows paths that enter from above all over the pack and shows where each leaves, on this thread.
    pub(super) fn trace_from_points(
        &self,
        settings: &SpreadSettings,
        paths: Range<u64>,
        left: &mut dyn FnMut(GrainExit),
    ) {
        let slab = SlabSettings {
            top: self.depth,
            bottom: 0.0,
            period: self.period,
            incidence: slab_incidence(settings.incidence),
            from_below: false,
            absorption_per_metre: 0.0,
            paths: paths.end - paths.start,
            seed: settings.seed,
            level: settings.level,
        };
        let mut source = PlaceSource { slab: &slab, paths, left };
        trace(&self.world, settings.level, &mut source);
    }

    /// Traces paths for one refractive index, lit from below or above.
    pub(super) fn trace(
        &mut self,
        eta: f64,
        settings: &AlbedoSettings,
        (from_below, paths): (bool, &Range<u64>),
        round: &Round<'_>,
    ) -> Ends {
        self.set_refractive_index(eta);
        let slab = SlabSettings {
            top: self.depth,
            bottom: 0.0,
            period: self.period,
            incidence: slab_incidence(settings.incidence),
            from_below,
            absorption_per_metre: 0.0,
            paths: paths.end - paths.start,
            seed: settings.seed,
            level: settings.level,
        };
        let tasks = (paths.end - paths.start).div_ceil(PATHS_PER_TASK);
        let parts: Vec<Ends> = (0..tasks)
            .into_par_iter()
            .map(|task| {
                let first = paths.start + task * PATHS_PER_TASK;
                let end = (first + PATHS_PER_TASK).min(paths.end);
                let (ends, radius) = (Ends::of(1), self.radius);
                let mut source = LengthSource { slab: &slab, next: first, end, radius, ends };
                trace(&self.world, settings.level, &mut source);
                round.add(end - first);
                source.ends
            })
            .collect();
        let mut all = Ends::of(1);
        parts.iter().for_each(|ends| all.merge(ends));
        all
    }
}

/// # Errors
/// Several layers, infinite depth.
fn only_layer(stack: &SnowStack) -> Result<&SnowLayer, RenderError> {
    let unfit = |key: &'static str, reason: &str| {
        Err(RenderError::from(GrainsError::Setting { key, reason: reason.into() }))
    };
    match &stack.layers[..] {
        [layer] if layer.depth.is_finite() => Ok(layer),
        [_] => unfit("depth", "grains need a depth; ask for one, as 10cm"),
        _ => unfit("layers", "grains are traced in one layer; ask for one"),
    }
}

fn layer_settings(layer: &SnowLayer, stacking: Stacking) -> LayerSettings {
    let SnowLayer { radius, density, depth, .. } = *layer;
    LayerSettings { stacking, radius, density, depth }
}

fn slab_incidence(incidence: Incidence) -> measure::Incidence {
    match incidence {
        Incidence::Diffuse => measure::Incidence::Lambertian,
        Incidence::Sun { zenith_degrees } => measure::Incidence::Collimated { zenith_degrees },
    }
}

/// Paths into a slab, of which the ends are kept.
struct LengthSource<'a> {
    slab: &'a SlabSettings,
    next: u64,
    end: u64,
    radius: f64,
    ends: Ends,
}

impl PathSource for LengthSource<'_> {
    type Tag = ();

    fn next_path(&mut self) -> Option<NewPath<()>> {
        let path = (self.next < self.end).then(|| self.slab.path(self.next));
        self.next += 1;
        path
    }

    fn finish(&mut self, (): (), path: &PathResult) {
        let PathEnd::Escaped(ray) = path.end else { return };
        let through = (ray.direction.y > 0.0) == self.slab.from_below;
        self.ends.add(1.0, through, &[path.ice_length / self.radius]);
    }
}

/// A path that leaves the pack. Lengths in metres.
#[derive(Clone, Copy, Debug)]
pub(super) struct GrainExit {
    pub(super) below: bool,
    /// From where it entered, along x, into which the light goes, and along z.
    pub(super) place: [f64; 2],
    pub(super) ice: f64,
    /// Between the faces.
    pub(super) air: f64,
}

/// Paths into a slab, of which it is shown where they leave.
struct PlaceSource<'a> {
    slab: &'a SlabSettings,
    paths: Range<u64>,
    left: &'a mut dyn FnMut(GrainExit),
}

impl PathSource for PlaceSource<'_> {
    /// Where it entered.
    type Tag = [f64; 2];

    fn next_path(&mut self) -> Option<NewPath<[f64; 2]>> {
        let NewPath { ray, key, event, .. } = self.slab.path(self.paths.next()?);
        Some(NewPath { tag: [ray.origin.x, ray.origin.z], ray, key, event })
    }

    fn finish(&mut self, [x, z]: [f64; 2], path: &PathResult) {
        let PathEnd::Escaped(ray) = path.end else { return };
        let below = ray.direction.y < 0.0;
        let face = if below { self.slab.bottom } else { self.slab.top };
        let beyond = (ray.origin.y - face) / ray.direction.y;
        let at = ray.at(-beyond);
        let place = [at.x - x, at.z - z];
        let air = path.air_length - beyond;
        (self.left)(GrainExit { below, place, ice: path.ice_length, air });
    }
}
