//! Measures of a pack: how much of space is ice, what touches what, what hangs together.

pub(crate) mod bodies;
pub(crate) mod buckets;
mod columns;
mod connections;
mod fractions;
mod lines;
pub(crate) mod meeting;
mod region;
mod structure;

pub use columns::solid_fractions_along_lines;
pub use connections::{Connections, TOUCH_TOLERANCE_QUANTA, connections, connections_of_pack};
pub use fractions::{
    Estimate, Slab, mean_surface_height, nominal_solid_fraction, solid_fraction_profile,
    union_solid_fraction, union_solid_fraction_of_pack,
};

pub use structure::{Directed, Sizes, Structure};

use crate::GrainField;
use snowgrain_geometry::Grain;
use std::fmt;

/// Points of the solid fraction in a report: standard error at most .0008.
const REPORT_POINTS: u32 = 400_000;

/// How a pack lies, which decides where its solid fraction is measured.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Extent {
    /// It repeats with these periods along x and z, metres: a slab of the whole period between 20
    /// and 80 % of the depth.
    Periodic([f64; 2]),
    /// It fills a box, as a lattice does: the middle 60 % of the box along each axis.
    Block,
    /// It fell on objects: between 20 and 80 % of the depth that it has at each place
    /// ([`solid_fractions_along_lines`]).
    Draped,
}

/// What is told of a pack after it was made.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PackReport {
    /// Number of grains.
    pub grains: u64,
    /// Fraction of space that is ice, union of the grains, where [`Extent`] says.
    pub union_solid_fraction: Estimate,
    /// Sum of the grains' volumes over that of space, there: overlaps count twice.
    pub nominal_solid_fraction: f64,
    /// Mean number of grains that a grain touches without overlap.
    pub contacts_per_grain: f64,
    /// Mean number of grains that a grain overlaps.
    pub overlaps_per_grain: f64,
    /// Part of the grains' volume that hangs together with the ground, or, where nothing touches
    /// the ground, in the largest cluster.
    pub connected_fraction: f64,
}

impl PackReport {
    /// Measures `field`; `touches_ground` says which grains the ground carries (`|_| false` where
    /// there is none).
    #[must_use]
    pub fn of(field: &GrainField, extent: Extent, touches_ground: &dyn Fn(&Grain) -> bool) -> Self {
        let period = match extent {
            Extent::Periodic(period) => Some(period),
            Extent::Block | Extent::Draped => None,
        };
        let (union_solid_fraction, nominal_solid_fraction) = match extent {
            Extent::Periodic(_) | Extent::Block => {
                let slab = Slab::between_parts_of_depth(field, period, [0.2, 0.8]);
                let union = union_solid_fraction(field, &slab, REPORT_POINTS, 0);
                (union, nominal_solid_fraction(field, &slab))
            }
            Extent::Draped => solid_fractions_along_lines(field, 0),
        };
        let connections = connections(field, period, touches_ground);
        Self {
            grains: field.len() as u64,
            union_solid_fraction,
            nominal_solid_fraction,
            contacts_per_grain: connections.contacts_per_grain,
            overlaps_per_grain: connections.overlaps_per_grain,
            connected_fraction: connections.connected_fraction,
        }
    }
}

impl fmt::Display for PackReport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(
            f,
            "{} grains, solid fraction {:.4} +- {:.4} (union), {:.4} (nominal), {:.2} contacts and \
             {:.2} overlaps a grain, {:.2} % connected",
            self.grains,
            self.union_solid_fraction.mean,
            self.union_solid_fraction.standard_error,
            self.nominal_solid_fraction,
            self.contacts_per_grain,
            self.overlaps_per_grain,
            100.0 * self.connected_fraction
        )
    }
}
