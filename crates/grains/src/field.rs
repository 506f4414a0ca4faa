//! A pack of grains.

use crate::FieldShapes;
use snowgrain_accel::{
    GrainGrid, GrainParts, GrainStacks, GridError, Packing, ShapedGrains, Surfaces,
};
use snowgrain_geometry::{Grain, GrainShape, Quantisation, QuantisedGrain, Shape};
use snowgrain_math::Aabb;
use std::borrow::Cow;

/// Grains of a part that is cut from a list.
const GRAINS_PER_PART: usize = 1 << 16;

/// Grains on one quantisation lattice, in a deterministic order.
///
/// They are held as they were made: those that fell stay in the stacks on which they fell, without
/// a copy. [`Self::part`] walks them in parts that lie together in space, on as many threads as one
/// likes; the parts one after another give the order of [`Self::quantised`].
#[derive(Clone, Debug)]
pub struct GrainField {
    /// The lattice that all positions are multiples of.
    pub quantisation: Quantisation,
    stacks: Vec<GrainStacks>,
    listed: Vec<QuantisedGrain>,
    len: usize,
    shapes: Option<FieldShapes>,
}

impl GrainField {
    /// The grains of a list, in its order.
    #[must_use]
    pub fn new(quantisation: Quantisation, grains: Vec<QuantisedGrain>) -> Self {
        Self::of_stacks(quantisation, Vec::new(), grains)
    }

    /// Grains that lie on stacks, and then those of a list.
    #[must_use]
    pub fn of_stacks(
        quantisation: Quantisation,
        stacks: Vec<GrainStacks>,
        listed: Vec<QuantisedGrain>,
    ) -> Self {
        let fallen: u64 = stacks.iter().map(GrainStacks::len).sum();
        let len = fallen as usize + listed.len();
        Self { quantisation, stacks, listed, len, shapes: None }
    }

    /// The same grains with shapes, one for each in the order of [`Self::quantised`].
    ///
    /// # Panics
    /// If there are not as many shapes as grains, or a prototype is missing.
    #[must_use]
    pub fn with_shapes(mut self, mut shapes: FieldShapes) -> Self {
        assert_eq!(shapes.of_grains.len(), self.len, "a shape for each grain");
        let known = |shape: &GrainShape| shape.prototype() < shapes.prototypes.len();
        assert!(shapes.of_grains.iter().all(known), "a prototype for each shape");
        // A list that was collected may hold three times as much as it needs.
        shapes.of_grains.shrink_to_fit();
        self.shapes = Some(shapes);
        self
    }

    /// The shapes of the grains; `None` where all are spheres.
    #[must_use]
    pub fn shapes(&self) -> Option<&FieldShapes> {
        self.shapes.as_ref()
    }

    /// Number of grains.
    #[must_use]
    pub fn len(&self) -> usize {
        self.len
    }

    /// Whether there are no grains.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.len == 0
    }

    /// Memory held, bytes.
    #[must_use]
    pub fn bytes(&self) -> usize {
        self.stacks.iter().map(GrainStacks::bytes).sum::<usize>()
            + self.listed.capacity() * size_of::<QuantisedGrain>()
            + self.shapes.as_ref().map_or(0, FieldShapes::bytes)
    }

    /// Number of parts.
    #[must_use]
    pub fn parts(&self) -> usize {
        let fallen: usize = self.stacks.iter().map(GrainStacks::parts).sum();
        fallen + self.listed.len().div_ceil(GRAINS_PER_PART)
    }

    /// Appends the grains of a part to `out`: some rows of the plan of what fell, seen along the
    /// direction of fall, or a run of what was listed.
    pub fn part(&self, part: usize, out: &mut Vec<QuantisedGrain>) {
        let mut index = part;
        for stacks in &self.stacks {
            let parts = stacks.parts();
            if index < parts {
                return stacks.part(index, out);
            }
            index -= parts;
        }
        let first = (index * GRAINS_PER_PART).min(self.listed.len());
        let last = (first + GRAINS_PER_PART).min(self.listed.len());
        out.extend_from_slice(&self.listed[first..last]);
    }

    /// Packs the grains for light, beside `surfaces`, part by part from where they lie.
    ///
    /// # Errors
    /// As [`GrainGrid::build`].
    pub fn pack(&self, surfaces: &Surfaces, packing: Packing) -> Result<GrainGrid, GridError> {
        self.pack_in_strata(surfaces, packing, &[])
    }

    /// The same, with the stratum of each grain in the order of [`Self::quantised`], if there are any.
    ///
    /// # Errors
    /// As [`GrainGrid::build`].
    ///
    /// # Panics
    /// If there are not as many strata as grains.
    pub fn pack_in_strata(
        &self,
        surfaces: &Surfaces,
        packing: Packing,
        strata: &[u8],
    ) -> Result<GrainGrid, GridError> {
        if let Some(FieldShapes { prototypes, of_grains }) = &self.shapes {
            let grains = (&*self.grains(), ShapedGrains { prototypes, of_grains });
            return GrainGrid::build_shaped(
                self.quantisation,
                grains,
                (surfaces, strata),
                None,
                packing,
            );
        }
        let read = |part: usize, out: &mut Vec<QuantisedGrain>| self.part(part, out);
        let grains = GrainParts::Parts { count: self.parts(), read: &read };
        GrainGrid::build_in_strata(self.quantisation, grains, surfaces, packing, strata)
    }

    /// All grains, part by part.
    pub fn quantised(&self) -> impl Iterator<Item = QuantisedGrain> + '_ {
        (0..self.parts()).flat_map(|part| {
            let mut grains = Vec::new();
            self.part(part, &mut grains);
            grains
        })
    }

    /// All grains as a slice: a copy of them, where they fell.
    #[must_use]
    pub fn grains(&self) -> Cow<'_, [QuantisedGrain]> {
        if self.stacks.is_empty() {
            return Cow::Borrowed(&self.listed);
        }
        let mut all = Vec::with_capacity(self.len);
        all.extend(self.quantised());
        Cow::Owned(all)
    }

    /// All grains as a list; where they fell, both exist for a moment.
    #[must_use]
    pub fn into_grains(self) -> Vec<QuantisedGrain> {
        if self.stacks.is_empty() { self.listed } else { self.grains().into_owned() }
    }

    /// The grains in metres.
    pub fn iter(&self) -> impl Iterator<Item = Grain> + '_ {
        self.quantised().map(|g| self.quantisation.grain(g))
    }

    /// The smallest box around all grains, in metres.
    #[must_use]
    pub fn bounds(&self) -> Aabb {
        bounds_of(self.quantised(), &self.quantisation)
    }

    /// Radius of the largest grain in quanta; 0 where there is none.
    #[must_use]
    pub fn largest_radius_quanta(&self) -> u16 {
        self.quantised().map(|g| g.radius).max().unwrap_or(0)
    }
}

impl GrainField {
    /// How far the grain that reaches farthest reaches from its centre, metres.
    #[must_use]
    pub fn largest_reach(&self) -> f64 {
        let quanta = match &self.shapes {
            None => f64::from(self.largest_radius_quanta()),
            Some(FieldShapes { prototypes, of_grains }) => {
                let reaches: Vec<f64> = prototypes.iter().map(Shape::bounding_radius).collect();
                let reach = |(grain, shape): (QuantisedGrain, &GrainShape)| {
                    f64::from(grain.radius) * reaches[shape.prototype()]
                };
                self.quantised().zip(of_grains).map(reach).fold(0.0, f64::max)
            }
        };
        quanta * self.quantisation.quantum()
    }
}

/// The same grains of the same shapes in the same order on the same lattice, however they are held.
impl PartialEq for GrainField {
    fn eq(&self, other: &Self) -> bool {
        self.quantisation == other.quantisation
            && self.len == other.len
            && self.quantised().eq(other.quantised())
            && self.shapes == other.shapes
    }
}

/// The smallest box around all of `grains`, in metres.
pub(crate) fn bounds_of(
    grains: impl Iterator<Item = QuantisedGrain>,
    quantisation: &Quantisation,
) -> Aabb {
    grains.map(|grain| quantisation.grain(grain)).fold(Aabb::EMPTY, |bounds, grain| {
        bounds.union(&Aabb::new(grain.center - grain.radius, grain.center + grain.radius))
    })
}
