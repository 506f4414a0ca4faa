//! What the grains of a world are, all together: their shapes and their sizes, how they lie, and how much of them is in others.

mod lying;
mod overlap;

pub(super) use lying::Lying;
pub(super) use overlap::Overlap;

use core::f64::consts::PI;
use lying::Looked;
use snowgrain_accel::{GrainGrid, GridGrain, STRATA};
use snowgrain_geometry::{GrainShape, Shape};
use snowgrain_grains::{GrainsError, MixedShape, Orientation, Radii, ShapeMix};
use std::sync::Arc;

/// Classes by which sizes are told.
const CLASSES: usize = 32;
/// Largest radius over the least one of grains that count as equal.
const EQUAL: f64 = 1.1;
/// Seed by which shapes are dealt out anew.
const SEED: u64 = 0xc0_4905;

/// Strata, and none.
const STRATA_AND_NONE: usize = STRATA + 1;

/// A number of the prototype and the stratum of a grain.
fn number_of(grain: &GridGrain) -> usize {
    let prototype = grain.shape.map_or(0, GrainShape::prototype);
    prototype * STRATA_AND_NONE + usize::from(grain.stratum)
}

/// The shapes and sizes of grains.
#[derive(Clone, Debug)]
pub(super) struct Composition {
    kinds: Vec<Kind>,
    /// The kind of each prototype of the grid and each stratum, where there are grains of both.
    kind_of: Vec<Option<usize>>,
    /// Radii, metres, and how many grains have each, in rising order.
    radii: Vec<(f64, u64)>,
    overlap: Overlap,
}

/// Grains of one shape in one stratum.
#[derive(Clone, Debug)]
struct Kind {
    /// `None`: spheres in a world of spheres.
    shape: Option<Arc<Shape>>,
    /// Mean area of a shadow, in squares of the radius.
    shadow: f64,
    grains: u64,
    stratum: u8,
    /// `None` where they lie in all orientations alike.
    lying: Option<Lying>,
}

impl Composition {
    /// Of the grains of a grid that have the shapes of these prototypes, if any.
    pub(super) fn new(grid: &GrainGrid, prototypes: &[Shape]) -> Self {
        let mut counts = vec![0u64; prototypes.len().max(1) * STRATA_AND_NONE];
        let mut looked = vec![Looked::new(); counts.len()];
        let mut sizes: Vec<u64> = Vec::new();
        grid.for_each_grain(|grain| {
            let number = number_of(&grain);
            counts[number] += 1;
            if let Some(shape) = grain.shape {
                looked[number].add(shape);
            }
            let quanta = (grain.radius / grid.quantum()).round() as usize;
            if sizes.len() <= quanta {
                sizes.resize(quanta + 1, 0);
            }
            sizes[quanta] += 1;
        });
        let (mut kinds, mut kind_of) = (Vec::new(), Vec::new());
        for (number, (&grains, looked)) in counts.iter().zip(looked).enumerate() {
            kind_of.push((grains > 0).then_some(kinds.len()));
            if grains > 0 {
                let (prototype, stratum) = (number / STRATA_AND_NONE, number % STRATA_AND_NONE);
                let shape = prototypes.get(prototype).cloned().map(Arc::new);
                let shadow = shape.as_ref().map_or(PI, |shape| shape.mean_projected_area());
                let is_turned = shape.as_ref().is_some_and(|shape| !shape.is_sphere());
                let lying = is_turned.then(|| looked.lying()).flatten();
                kinds.push(Kind { shape, shadow, grains, stratum: stratum as u8, lying });
            }
        }
        let there_are = sizes.into_iter().enumerate().filter(|&(_, grains)| grains > 0);
        let radii = there_are.map(|(quanta, grains)| (quanta as f64 * grid.quantum(), grains));
        let overlap = Overlap::of(grid, prototypes, counts.iter().sum());
        Self { kinds, kind_of, radii: radii.collect(), overlap }
    }

    /// What of the grains is not within others.
    pub(super) fn overlap(&self) -> Overlap {
        self.overlap
    }

    /// How many kinds of grains there are.
    pub(super) fn kinds(&self) -> usize {
        self.kinds.len()
    }

    /// The kind of a grain.
    pub(super) fn kind(&self, grain: &GridGrain) -> usize {
        self.kind_of[number_of(grain)].unwrap_or(0)
    }

    /// The stratum of the grains of a kind; 0 is none.
    #[inline]
    pub(super) fn stratum(&self, kind: usize) -> u8 {
        self.kinds[kind].stratum
    }

    /// Mean area of the shadow of a grain, in squares of its radius.
    pub(super) fn shadow(&self, kind: usize) -> f64 {
        self.kinds[kind].shadow
    }

    /// The shapes of all kinds, and how they lie if not in all orientations alike; `None` where all are spheres in a world of spheres.
    pub(super) fn shapes(&self) -> Option<Vec<(&Shape, Option<&Lying>)>> {
        let kinds = self.kinds.iter();
        kinds.map(|kind| Some((kind.shape.as_deref()?, kind.lying.as_ref()))).collect()
    }

    fn is_of_one_size(&self) -> bool {
        match (self.radii.first(), self.radii.last()) {
            (Some(least), Some(largest)) => largest.0 <= EQUAL * least.0,
            _ => true,
        }
    }

    /// Sizes that are like those of the grains.
    pub(super) fn sizes(&self) -> Result<Radii, GrainsError> {
        let all: u64 = self.radii.iter().map(|&(_, grains)| grains).sum();
        let sum: f64 = self.radii.iter().map(|&(radius, grains)| radius * grains as f64).sum();
        if self.is_of_one_size() {
            return Ok(Radii::equal(sum / all.max(1) as f64));
        }
        let [(least, _), (largest, _)] = [self.radii[0], self.radii[self.radii.len() - 1]];
        let step = (largest - least) / CLASSES as f64;
        let mut classes: Vec<(f64, f64)> =
            (0..CLASSES).map(|class| (least + step * (class as f64 + 0.5), 0.0)).collect();
        for &(radius, grains) in &self.radii {
            let class = ((radius - least) / step) as usize;
            classes[class.min(CLASSES - 1)].1 += grains as f64;
        }
        Radii::measured(&classes)
    }

    /// The shapes as often as they are, as they lie; `None` where all are spheres.
    pub(super) fn mix(&self) -> Result<Option<ShapeMix>, GrainsError> {
        let mixed = self.kinds.iter().map(|kind| {
            let shape = Arc::clone(kind.shape.as_ref()?);
            let lying = kind.lying.as_ref();
            let orientation = lying.map_or(Orientation::Random, Lying::orientation);
            Some(MixedShape { shape, orientation, fraction: kind.grains as f64 })
        });
        mixed.collect::<Option<Vec<_>>>().map(|mixed| ShapeMix::new(mixed, SEED)).transpose()
    }
}
