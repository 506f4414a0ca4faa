//! A layer as what it is: grains at random places or in a lattice, that repeat for ever, traced exactly.

use super::lengths::Ends;
use super::progress::Round;
use super::{AlbedoSettings, Incidence, Scatterers, SnowLayer, SnowStack, SpreadSettings};
use crate::measure::{self, SlabSettings};
use crate::transport::{NewPath, PathEnd, PathResult, PathSource, trace};
use crate::{RenderError, World};
use rayon::prelude::*;
use snowgrain_accel::{GrainGrid, Packing, STRATA, Surfaces};
use snowgrain_grains::{
    GrainField, GrainsError, ICE_DENSITY, LayerSettings, RandomLayer, Stacking, random_layers,
};
use std::ops::Range;

/// Period along x and z, in radii: light forgets where it entered over less.
const WIDTH_IN_RADII: f64 = 40.0;
/// Paths that a thread follows at a time.
const PATHS_PER_TASK: u64 = 1 << 12;

/// Layers of equal grains, packed for light.
#[derive(Debug)]
pub struct GrainLayer {
    world: World,
    period: [f64; 2],
    /// Height of the upper face; the lower one is at 0.
    depth: f64,
    /// Of the grains of each layer, from the top down.
    radii: Vec<f64>,
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
    /// About how many grains the layers of `stack` take; those of infinite depth are none.
    #[must_use]
    pub fn grains(stack: &SnowStack, pack: Pack) -> u64 {
        let width = width_of(stack);
        let of_layer = |layer: &SnowLayer| {
            if layer.depth.is_infinite() {
                return 0.0;
            }
            if pack != Pack::Random {
                return layer.depth / layer.radius;
            }
            let r = layer.radius;
            let ball = 4.0 / 3.0 * core::f64::consts::PI * r * r * r;
            layer.density / ICE_DENSITY * width * width * layer.depth / ball
        };
        stack.layers.iter().map(of_layer).sum::<f64>() as u64
    }

    /// The stack of which [`Self::new`] makes grains: the depth of a lattice becomes that of whole layers.
    ///
    /// # Errors
    /// Several layers, infinite depth, a density that the pack does not reach, grains that are no spheres.
    pub fn packed(stack: &SnowStack, pack: Pack) -> Result<SnowStack, RenderError> {
        if stack.layers.iter().any(|layer| layer.scatterers != Scatterers::Spheres) {
            let reason =
                "grains are packed as spheres; ask for --method homogeneous, or leave --shapes out";
            return Err(unfit("shapes", reason.into()));
        }
        let Some(stacking) = pack.stacking() else { return Ok(stack.clone()) };
        let layer = only_layer(stack)?;
        let layers = layer_settings(layer, stacking).layers()?;
        let depth = f64::from(layers.count) * layers.step;
        Ok(SnowStack { layers: vec![SnowLayer { depth, ..layer.clone() }], ..stack.clone() })
    }

    /// The layers of `stack`, packed (see `snowgrain_grains::{random, layers}`): several at random places,
    /// one in a lattice.
    ///
    /// # Errors
    /// Several layers of a lattice, more than [`STRATA`], infinite depth, a density that the pack does not
    /// reach.
    pub fn new(stack: &SnowStack, pack: Pack, seed: u64) -> Result<Self, RenderError> {
        let (field, period, depth, strata) = match pack.stacking() {
            None => random_places(stack, seed)?,
            Some(stacking) => {
                let layer = only_layer(stack)?;
                let settings = layer_settings(layer, stacking);
                let (field, period) = settings.slab()?;
                (field, period, settings.layers()?.depth(layer.radius), Vec::new())
            }
        };
        let quantum = field.quantisation.quantum();
        let (grains, quantisation) = (field.grains(), field.quantisation);
        let grid = GrainGrid::build_periodic_in_strata(
            quantisation,
            &*grains,
            period,
            Packing::Fast,
            &strata,
        )?;
        let surfaces = Surfaces::default();
        let world =
            World { grid, surfaces, materials: Vec::new(), emitters: Vec::new(), eta: 1.31 };
        let radii = stack.layers.iter().map(|layer| layer.radius).collect();
        Ok(Self { world, period: period.map(|length| length as f64 * quantum), depth, radii })
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
                let (ends, radii) = (Ends::of(self.radii.len()), &self.radii);
                let mut source = LengthSource { slab: &slab, next: first, end, radii, ends };
                trace(&self.world, settings.level, &mut source);
                round.add(end - first);
                source.ends
            })
            .collect();
        let mut all = Ends::of(self.radii.len());
        parts.iter().for_each(|ends| all.merge(ends));
        all
    }
}

fn unfit(key: &'static str, reason: String) -> RenderError {
    RenderError::from(GrainsError::Setting { key, reason })
}

fn not_deep() -> RenderError {
    unfit("depth", "grains need a depth; ask for one, as 10cm".into())
}

/// # Errors
/// Several layers, infinite depth.
fn only_layer(stack: &SnowStack) -> Result<&SnowLayer, RenderError> {
    match &stack.layers[..] {
        [layer] if layer.depth.is_finite() => Ok(layer),
        [_] => Err(not_deep()),
        _ => Err(unfit("layers", "a lattice is traced in one layer; ask for --pack random".into())),
    }
}

/// Period along x and z, metres.
fn width_of(stack: &SnowStack) -> f64 {
    WIDTH_IN_RADII * stack.layers.iter().map(|layer| layer.radius).fold(0.0, f64::max)
}

/// Grains, periods in quanta, depth in metres, and the stratum of each grain: from 1 for the top layer on,
/// and none where there is one layer.
type Placed = (GrainField, [i64; 2], f64, Vec<u8>);

/// # Errors
/// Too many layers, infinite depth, a density that random places do not reach.
fn random_places(stack: &SnowStack, seed: u64) -> Result<Placed, RenderError> {
    if stack.is_deep() {
        return Err(not_deep());
    }
    if stack.layers.len() > STRATA {
        let reason = format!("grains are traced in at most {STRATA} layers; ask for fewer");
        return Err(unfit("layers", reason));
    }
    let layer = |layer: &SnowLayer| {
        let SnowLayer { radius, density, depth, .. } = *layer;
        RandomLayer { radius, density, depth }
    };
    let layers: Vec<RandomLayer> = stack.layers.iter().map(layer).collect();
    let (field, period, numbers) = random_layers(&layers, width_of(stack), seed)?;
    let strata = match layers[..] {
        [_] => Vec::new(),
        _ => numbers.iter().map(|number| number + 1).collect(),
    };
    Ok((field, period, layers.iter().map(|layer| layer.depth).sum(), strata))
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
    /// Of the layers from the top down.
    radii: &'a [f64],
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
        if let [radius] = self.radii {
            return self.ends.add(1.0, through, &[path.ice_length / radius]);
        }
        let mut lengths: [f64; STRATA] = path.ice_in_strata;
        let lengths = &mut lengths[..self.radii.len()];
        lengths.iter_mut().zip(self.radii).for_each(|(length, radius)| *length /= radius);
        if self.slab.from_below {
            // Lengths are told in the order in which light meets the layers.
            lengths.reverse();
        }
        self.ends.add(1.0, through, lengths);
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
