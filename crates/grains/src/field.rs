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
        self.iter()
            .fold(Aabb::EMPTY, |b, g| b.union(&Aabb::new(g.center - g.radius, g.center + g.radius)))
    }

    /// Radius of the largest grain in quanta; 0 where there is none.
    #[must_use]
    pub fn largest_radius_quanta(&self) -> u16 {
        self.grains.iter().map(|g| g.radius).max().unwrap_or(0)
    }
}
