//! Straight rays among shaped grains, one after another.

use super::ShapeFlight;
use super::lane::{Lane, Phase};
use crate::flight::{Probe, ProbeAnswer};
use crate::grain_grid::{GridPosition, GridShapes};
use crate::{GrainGrid, SimdLevel, Surfaces};
use fearless_simd::{Level, Simd, dispatch};
use snowgrain_math::DVec3;

/// Follows straight rays.
#[derive(Debug)]
pub(in super::super) struct ShapeProbes<'a> {
    flight: ShapeFlight<'a>,
    level: Level,
}

impl<'a> ShapeProbes<'a> {
    pub(in super::super) fn new(
        (grid, shapes): (&'a GrainGrid, &'a GridShapes),
        surfaces: &'a Surfaces,
        level: SimdLevel,
    ) -> Self {
        Self {
            flight: ShapeFlight::new(grid, shapes, surfaces, 1.0),
            level: level.token().expect("the SIMD level was checked when it was chosen"),
        }
    }

    pub(in super::super) fn follow(
        &mut self,
        probes: &[Probe],
        mut answer: impl FnMut(usize, ProbeAnswer),
    ) {
        let Self { flight, level } = self;
        for (index, probe) in probes.iter().enumerate() {
            answer(index, dispatch!(*level, simd => flight.probe(simd, probe)));
        }
    }
}

impl ShapeFlight<'_> {
    /// Follows a straight ray in the first lane.
    #[inline(always)]
    fn probe<S: Simd>(&mut self, simd: S, probe: &Probe) -> ProbeAnswer {
        let grid = self.grid;
        let vector = |v: [f32; 3]| DVec3::from_array(v.map(f64::from));
        self.lanes[0] = Lane {
            phase: Phase::Air,
            cell: probe.start.cell,
            home: probe.start.cell,
            origin: vector(probe.start.local),
            direction: vector(probe.direction).normalize(),
            shadowless: probe.leaves.map(vector),
            ..Lane::default()
        };
        let length = f64::from(probe.length);
        loop {
            self.lanes[0].entry = grid.entry(self.lanes[0].cell);
            let lane = &self.lanes[0];
            let exit = self.exit(lane);
            if let Some(entry) = self.next_entry(simd, lane, exit.distance.min(length)) {
                let body = entry.inside.body;
                return if entry.begins_inside && probe.leaves.is_some() {
                    ProbeAnswer::Covered
                } else {
                    let local = (body.center - lane.offset).to_array().map(|x| x as f32);
                    ProbeAnswer::Met {
                        distance: entry.at as f32,
                        center: GridPosition { cell: lane.cell, local },
                        radius: entry.inside.placement.radius as f32,
                    }
                };
            }
            if exit.distance >= length {
                return ProbeAnswer::Clear;
            }
            self.leave_cell(0, &exit);
            if self.lanes[0].phase == Phase::Still {
                self.events.clear();
                return ProbeAnswer::Clear;
            }
        }
    }
}
