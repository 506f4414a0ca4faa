//! Straight rays through the pores: is anything in the way, and what?

use super::blocks::{BlockProbes, unit_f32};
use super::shapes::ShapeProbes;
use crate::grain_grid::GridPosition;
use crate::{GrainGrid, STRATA, SimdLevel, Surfaces};
use snowgrain_math::DVec3;

/// A straight ray to be followed. Lengths in quanta.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Probe {
    /// Where it starts.
    pub start: GridPosition,
    /// Unit direction.
    pub direction: [f32; 3],
    /// How far it goes.
    pub length: f32,
    /// Centre of the grain on whose surface it starts and that it leaves, relative to the cell of the
    /// start: it must not start within another one.
    pub leaves: Option<[f32; 3]>,
}

impl Probe {
    /// From the surface of a grain, where its outward normal is `normal`, along the unit vector
    /// `direction`. The grain's centre and radius are as [`ProbeAnswer::Met`] tells them. `None` beyond
    /// the grid, where no grain is.
    #[must_use]
    pub fn leaving(
        grid: &GrainGrid,
        (center, radius): (GridPosition, f32),
        normal: DVec3,
        direction: DVec3,
        length: f32,
    ) -> Option<Self> {
        let normal = unit_f32(normal);
        let local = [0, 1, 2].map(|axis: usize| center.local[axis] + normal[axis] * radius);
        let start = grid.settled(GridPosition { cell: center.cell, local })?;
        let leaves = [0, 1, 2].map(|axis: usize| {
            let cells = start.cell[axis] - center.cell[axis];
            center.local[axis] - cells as f32 * grid.side[axis] as f32
        });
        Some(Self { start, direction: unit_f32(direction), length, leaves: Some(leaves) })
    }

    /// From a place in air.
    #[must_use]
    pub fn through_air(start: GridPosition, direction: DVec3, length: f32) -> Self {
        Self { start, direction: unit_f32(direction), length, leaves: None }
    }
}

/// What a probe found.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ProbeAnswer {
    /// Nothing: it left the grid or reached its length.
    Clear,
    /// The same, after grains that it passed straight through, by faces that are parallel.
    Through(Passage),
    /// Another grain covers its start.
    Covered,
    /// A grain.
    Met {
        /// How far away, quanta.
        distance: f32,
        /// Which.
        grain: MetGrain,
    },
}

/// A grain that a probe met.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MetGrain {
    /// Its centre: a cell near it, and its place relative to that cell.
    pub center: GridPosition,
    /// Its radius, quanta; of the sphere of equal volume, where it has a shape.
    pub radius: f32,
    /// Its stratum.
    pub stratum: u8,
    /// Whether other grains overlap it.
    pub overlaps: bool,
    /// Whether a surface crosses it.
    pub meets_surface: bool,
}

/// What a straight ray met on its way through grains.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Passage {
    /// Part of the light that passes.
    pub transmittance: f32,
    /// Length in ice, quanta.
    pub ice_length: f32,
    /// Of it, that in grains of each stratum from 1 on.
    pub ice_in_strata: [f32; STRATA],
}

/// Follows straight rays among the grains of a grid.
#[derive(Debug)]
pub struct Probes<'a>(Engine<'a>);

#[derive(Debug)]
enum Engine<'a> {
    Blocks(BlockProbes<'a>),
    Shapes(ShapeProbes<'a>),
}

impl<'a> Probes<'a> {
    /// None in flight. `surfaces` are not looked at. Rays pass straight through faces of grains of relative
    /// index `eta` that are parallel.
    ///
    /// # Panics
    /// If the machine does not have `level`.
    #[must_use]
    pub fn new(grid: &'a GrainGrid, surfaces: &'a Surfaces, eta: f64, level: SimdLevel) -> Self {
        Self(match grid.shapes() {
            Some(shapes) => Engine::Shapes(ShapeProbes::new((grid, shapes), surfaces, eta, level)),
            None => Engine::Blocks(BlockProbes::new(grid, surfaces, level)),
        })
    }

    /// Follows all `probes`; `answer` is told the index and the answer of each, in no order.
    pub fn follow(&mut self, probes: &[Probe], answer: impl FnMut(usize, ProbeAnswer)) {
        match &mut self.0 {
            Engine::Blocks(engine) => engine.follow(probes, answer),
            Engine::Shapes(engine) => engine.follow(probes, answer),
        }
    }
}
