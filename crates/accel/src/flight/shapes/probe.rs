//! Straight rays among shaped grains, one after another.

use super::ShapeFlight;
use super::air::Entry;
use super::chain::{Straight, straight};
use super::lane::{Inside, Lane, Phase};
use crate::flight::{Passage, Probe, ProbeAnswer};
use crate::grain_grid::{GridPosition, GridShapes};
use crate::{GrainGrid, STRATA, SimdLevel, Surfaces};
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
        eta: f64,
        level: SimdLevel,
    ) -> Self {
        Self {
            flight: ShapeFlight::new(grid, shapes, surfaces, eta),
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
        let mut length = f64::from(probe.length);
        let mut passage = None;
        let clear =
            |passage: Option<Passage>| passage.map_or(ProbeAnswer::Clear, ProbeAnswer::Through);
        loop {
            self.lanes[0].entry = grid.entry(self.lanes[0].cell);
            let lane = &self.lanes[0];
            let exit = self.exit(lane);
            if let Some(entry) = self.next_entry(simd, lane, exit.distance.min(length)) {
                if entry.begins_inside && probe.leaves.is_some() {
                    return ProbeAnswer::Covered;
                }
                let Some(straight) = self.straight(&entry) else { return self.met(&entry) };
                self.pass(&entry, &straight, passage.get_or_insert(UNHINDERED));
                length -= entry.at;
                continue;
            }
            if exit.distance >= length {
                return clear(passage);
            }
            self.leave_cell(0, &exit);
            if self.lanes[0].phase == Phase::Still {
                self.events.clear();
                return clear(passage);
            }
        }
    }

    fn met(&self, entry: &Entry) -> ProbeAnswer {
        let lane = &self.lanes[0];
        let local = (entry.inside.body.center - lane.offset).to_array().map(|x| x as f32);
        ProbeAnswer::Met {
            distance: entry.at as f32,
            center: GridPosition { cell: lane.cell, local },
            radius: entry.inside.placement.radius as f32,
        }
    }

    /// How the ray goes straight through a lone convex grain, if it does.
    #[inline(always)]
    fn straight(&self, entry: &Entry) -> Option<Straight> {
        let Inside { body, placement, meets_surface, overlaps, .. } = entry.inside;
        if meets_surface || overlaps {
            return None;
        }
        let part = &self.shapes.of(&placement).parts[usize::from(body.part)];
        let ray = self.lanes[0].ray_to(body.center, &placement);
        straight(part, &ray, entry.at / placement.radius, self.eta)
    }

    /// Goes on behind a grain, along the same direction.
    fn pass(&mut self, entry: &Entry, straight: &Straight, passage: &mut Passage) {
        let Inside { body, placement, stratum, .. } = entry.inside;
        let ice_length = (straight.length * placement.radius) as f32;
        passage.transmittance *= straight.transmittance as f32;
        passage.ice_length += ice_length;
        if let Some(stratum) = usize::from(stratum).checked_sub(1) {
            passage.ice_in_strata[stratum] += ice_length;
        }
        let grid = self.grid;
        let lane = &mut self.lanes[0];
        let direction = lane.direction;
        lane.origin = body.center + placement.rotation * straight.leaves * placement.radius;
        lane.travelled = 0.0;
        lane.inside.body = body;
        lane.begin_stretch(grid, 0.0, direction);
        lane.shadowless = Some(lane.inside.body.center);
    }
}

const UNHINDERED: Passage =
    Passage { transmittance: 1.0, ice_length: 0.0, ice_in_strata: [0.0; STRATA] };
