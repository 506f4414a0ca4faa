//! Straight rays among shaped grains, one after another.

use super::ShapeFlight;
use super::chain::{Straight, straight};
use super::lane::{Entry, Inside, Lane, Phase};
use crate::flight::{MetGrain, Passage, Probe, ProbeAnswer};
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
        let vector = |v: [f32; 3]| DVec3::from_array(v.map(f64::from));
        self.lanes[0] = Lane {
            phase: Phase::Air,
            cell: probe.start.cell,
            origin: vector(probe.start.local),
            ..Lane::default()
        };
        let lane = &mut self.lanes[0];
        lane.inside.body.center = probe.leaves.map_or(DVec3::ZERO, vector);
        lane.begin_stretch(&self.cells, 0.0, vector(probe.direction).normalize());
        lane.shadowless = probe.leaves.map(|_| lane.inside.body.center);
        let mut length = f64::from(probe.length);
        let mut passage = None;
        let clear =
            |passage: Option<Passage>| passage.map_or(ProbeAnswer::Clear, ProbeAnswer::Through);
        loop {
            self.look_up_cell(0);
            let exit = self.exit(&self.lanes[0]);
            let nearest = self.nearest(simd, &self.lanes[0], exit.distance);
            self.lanes[0].nearest = nearest;
            if let Some(entry) = nearest.filter(|entry| entry.at <= exit.distance.min(length)) {
                if entry.at < 0.0 && probe.leaves.is_some() {
                    return ProbeAnswer::Covered;
                }
                let inside = self.entered(&self.lanes[0], &entry);
                let Some(straight) = self.straight(&inside, &entry) else {
                    return self.met(&inside);
                };
                self.pass(&inside, &straight, passage.get_or_insert(UNHINDERED));
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

    fn met(&self, inside: &Inside) -> ProbeAnswer {
        let lane = &self.lanes[0];
        let local = (inside.body.center - lane.offset).to_array().map(|x| x as f32);
        ProbeAnswer::Met {
            distance: inside.leave as f32,
            grain: MetGrain {
                center: GridPosition { cell: lane.cell, local },
                radius: inside.placement.radius as f32,
                stratum: inside.stratum,
                overlaps: inside.overlaps,
                meets_surface: inside.meets_surface,
            },
        }
    }

    /// How the ray goes straight through a lone convex grain, if it does.
    #[inline(always)]
    fn straight(&self, inside: &Inside, entry: &Entry) -> Option<Straight> {
        let Inside { body, placement, meets_surface, overlaps, .. } = *inside;
        if meets_surface || overlaps {
            return None;
        }
        let part = &self.shapes.of(&placement).parts[usize::from(body.part)];
        let ray = self.lanes[0].ray_to(body.center, &placement);
        straight(part, &ray, entry.at_radii, self.eta)
    }

    /// Goes on behind a grain, along the same direction.
    fn pass(&mut self, inside: &Inside, straight: &Straight, passage: &mut Passage) {
        let Inside { body, placement, stratum, .. } = *inside;
        let ice_length = (straight.length * placement.radius) as f32;
        passage.transmittance *= straight.transmittance as f32;
        passage.ice_length += ice_length;
        if let Some(stratum) = usize::from(stratum).checked_sub(1) {
            passage.ice_in_strata[stratum] += ice_length;
        }
        let lane = &mut self.lanes[0];
        let direction = lane.direction;
        lane.origin = body.center + placement.rotation * straight.leaves * placement.radius;
        lane.travelled = 0.0;
        lane.inside.body = body;
        lane.begin_stretch(&self.cells, 0.0, direction);
        lane.shadowless = Some(lane.inside.body.center);
    }
}

const UNHINDERED: Passage =
    Passage { transmittance: 1.0, ice_length: 0.0, ice_in_strata: [0.0; STRATA] };
