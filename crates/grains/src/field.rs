//! A pack of grains.

use snowgrain_geometry::{Grain, Quantisation, QuantisedGrain};
use snowgrain_math::Aabb;

/// Grains on one quantisation lattice, in a deterministic order.
#[derive(Clone, Debug, PartialEq)]
pub struct GrainField {
    /// The lattice that all positions are multiples of.
    pub quantisation: Quantisation,
    /// The grains.
    pub grains: Vec<QuantisedGrain>,
}

impl GrainField {
    /// Number of grains.
    #[must_use]
    pub fn len(&self) -> usize {
        self.grains.len()
    }

    /// Whether there are no grains.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.grains.is_empty()
    }

    /// The grains in metres.
    pub fn iter(&self) -> impl Iterator<Item = Grain> + '_ {
        self.grains.iter().map(|&g| self.quantisation.grain(g))
    }

    /// The smallest box around all grains, in metres.
    #[must_use]
    pub fn bounds(&self) -> Aabb {
        bounds_of(self.grains.iter().copied(), &self.quantisation)
    }

    /// Radius of the largest grain in quanta; 0 where there is none.
    #[must_use]
    pub fn largest_radius_quanta(&self) -> u16 {
        self.grains.iter().map(|g| g.radius).max().unwrap_or(0)
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
