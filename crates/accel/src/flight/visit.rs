//! Arrivals at grains, noted for a caller that looks for light at each.

use crate::STRATA;
use crate::grain_grid::GridPosition;
use snowgrain_geometry::GrainShape;
use snowgrain_math::DVec3;

/// Where light that arrives at a grain came from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ArrivalFrom {
    /// What lies between the grains.
    Air,
    /// The ice of a grain that overlaps this one: no interface is met on the way in.
    Ice,
}

/// What is told of an arrival at a grain of a shape of its own.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ShapedArrival {
    /// Prototype and orientation of the grain.
    pub shape: GrainShape,
    /// From its centre to where light arrives, quanta.
    pub from_center: DVec3,
}

/// An arrival at a grain. Lengths in quanta.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GrainVisit {
    /// Lane of the path.
    pub lane: usize,
    /// From where it comes.
    pub from: ArrivalFrom,
    /// Centre of the grain: a cell near it, and its place relative to that cell, which it may lie
    /// outside of.
    pub center: GridPosition,
    /// Radius of the grain; of the sphere of equal volume, where it has a shape.
    pub radius: f32,
    /// Shape of the grain, where grains have any.
    pub shaped: Option<ShapedArrival>,
    /// Whether other grains overlap it.
    pub overlaps: bool,
    /// Whether a surface crosses it.
    pub meets_surface: bool,
    /// How far it is, along the direction, to the plane through its centre across the direction.
    pub to_middle: f32,
    /// Unit direction in which light arrives, within the grain where it comes from ice.
    pub direction: [f32; 3],
    /// Arrivals of the path at grains from air, with this one.
    pub grain_visits: u32,
    /// Length in ice before.
    pub ice_length: f32,
    /// Of it, that in grains of each stratum from 1 on.
    pub ice_in_strata: [f32; STRATA],
    /// Stratum of the grain.
    pub stratum: u8,
    /// Next random event of the path before it.
    pub event: u32,
}

/// Arrivals after which a flight hands them over.
pub(super) const VISITS_AT_ONCE: usize = 64;
