//! One round: of each group what its paths may meet, their steps in air and in grains, then the rare things one by one.

use super::body::{ELLIPSOID, normal};
use super::candidates::part_of;
use super::stretches::next;
use super::{GROUP, Phase, ShapeFlight, VISITS_AT_ONCE};
use crate::flight::MAX_TURNS_IN_ICE;
use crate::grain_grid::{MEETS_SURFACE, Prototype, ShapeWord, Storage};
use fearless_simd::Simd;
use snowgrain_math::DVec3;

impl ShapeFlight<'_> {
    /// Rounds until an event occurs or no path is left in flight.
    #[inline(always)]
    pub(super) fn run<S: Simd>(&mut self, simd: S) {
        let groups = self.in_use.div_ceil(GROUP);
        while self.events.is_empty()
            && self.visits.as_ref().is_none_or(|noted| noted.len() < VISITS_AT_ONCE)
        {
            // While one group waits for memory, another is worked on.
            for group in 0..groups {
                self.look_around(simd, group);
            }
            let mut flying = false;
            for group in 0..groups {
                flying |= self.go_on(simd, group);
                self.fetch_entries(group);
            }
            if !flying {
                return;
            }
        }
    }

    /// Asks the blocks of a group's paths.
    #[inline(always)]
    fn look_around<S: Simd>(&mut self, simd: S, group: usize) {
        self.stretches[group].look_ahead(simd, &self.cells, self.shapes.concentric);
        self.gather(simd, group * GROUP);
    }

    /// One step of the paths of a group; whether any is in flight.
    #[inline(always)]
    fn go_on<S: Simd>(&mut self, simd: S, group: usize) -> bool {
        let first = group * GROUP;
        self.meet(simd, first);
        let mut ice = self.in_ice[group];
        let flying = self.stretches[group].air != 0 || self.in_grains[group].any() || ice != 0;
        self.step_in_air(simd, first);
        while let Some(at) = next(&mut ice) {
            self.in_ice[group] &= !(1 << at);
            self.go_on_in_ice(simd, first + at, None);
        }
        self.cross(first);
        self.step_in_grains(simd, first);
        self.prefetch_entries(simd, group);
        flying
    }

    /// Lets the paths of a group that are in air arrive at grains, or go on to their next cells.
    #[inline(always)]
    fn step_in_air<S: Simd>(&mut self, simd: S, first: usize) {
        let stretches = &self.stretches[first / GROUP];
        let hits = stretches.hits(simd);
        let rare = stretches.rare(simd);
        let (mut arriving, mut alone) = (0, rare);
        let mut meeting = hits & !rare;
        while let Some(at) = next(&mut meeting) {
            let arrives = self.arrives_with_others(first + at);
            arriving |= u32::from(arrives) << at;
            alone |= u32::from(!arrives) << at;
        }
        self.in_grains[first / GROUP].arrive(simd, arriving);
        let stretches = &mut self.stretches[first / GROUP];
        let leaving = stretches.air & !(hits | rare);
        stretches.air &= !arriving;
        alone |= stretches.leave_cells(simd, &self.cells, leaving);
        while let Some(at) = next(&mut alone) {
            let index = first + at;
            self.land(index);
            self.stretches[first / GROUP].end(at);
            self.step_alone(simd, index);
            if self.lanes[index].phase == Phase::Air {
                self.go_on_in_air(index);
            }
        }
    }

    /// Whether a path that meets a grain arrives there as most do, with others; then that is booked.
    #[inline(always)]
    fn arrives_with_others(&mut self, index: usize) -> bool {
        let (group, at) = (index / GROUP, index % GROUP);
        let (stretches, grains) = (&self.stretches[group], &self.in_grains[group]);
        let lane = &self.lanes[index];
        let (block, slot) = grains.slot(at);
        let flags = self.grid.blocks()[block].radius[slot & 15];
        let is_rare = flags & MEETS_SURFACE != 0
            || self.visits.is_some()
            || self.deep.is_some()
            // Of a path that begins within the grain the place is not on the face.
            || stretches.nearest[at] < stretches.travelled[at]
            || !self.kinds.has_slabs(grains.word(at));
        if is_rare || (lane.first.is_none() && !self.note_first(index)) {
            return false;
        }
        let (stretches, grains) = (&self.stretches[group], &mut self.in_grains[group]);
        let reached = ShapeWord::of_slot(grains.word(at)).reached();
        let lane = &mut self.lanes[index];
        lane.count_air(stretches.nearest[at]);
        lane.visits += 1;
        lane.phase = Phase::Visit;
        lane.inside.stratum = self.grid.strata().get(block).map_or(0, |strata| strata[slot & 15]);
        grains.begin(at, lane.key, lane.event, reached);
        true
    }

    /// Notes the first grain that a path meets, where it does so on a flat face.
    fn note_first(&mut self, index: usize) -> bool {
        let (group, at) = (index / GROUP, index % GROUP);
        let (stretches, grains) = (&self.stretches[group], &self.in_grains[group]);
        let placement = grains.body(at).placement();
        let Prototype { parts, slabs: Some(slabs), .. } = self.shapes.of(&placement) else {
            return false;
        };
        let through = part_of(slabs, grains.face(at));
        if through == ELLIPSOID {
            return false;
        }
        let place = stretches.local(at, stretches.nearest[at]);
        let place = self.grid.world_of(stretches.cell_of(at), place);
        // All of a face has one normal.
        let normal = placement.rotation * normal(&parts[0], through, DVec3::ZERO);
        self.lanes[index].first = Some([place, normal]);
        true
    }

    /// One step of the paths of a group that are in grains between parallel faces.
    #[inline(always)]
    fn step_in_grains<S: Simd>(&mut self, simd: S, first: usize) {
        let group = first / GROUP;
        self.stretches[group].asking = 0;
        if !self.in_grains[group].any() {
            return;
        }
        let out = self.in_grains[group].turn(simd, self.kinds, self.eta);
        let mut trapped = self.in_grains[group].longer_than(simd, MAX_TURNS_IN_ICE);
        while let Some(at) = next(&mut trapped) {
            self.stop_in_grain(first + at);
        }
        let crossing = self.in_grains[group].crossing();
        let off = self.in_grains[group].travel(simd, self.kinds, self.eta);
        let grains = &mut self.in_grains[group];
        let asking = grains.may_be_covered();
        let (mut out, stretches) = (out | off, &mut self.stretches[group]);
        let mut strayed = stretches.begin(simd, &self.cells, out | (asking & !crossing), grains);
        stretches.asking = asking;
        stretches.air |= out;
        while let Some(at) = next(&mut strayed) {
            self.stay_inside(first + at);
        }
        while let Some(at) = next(&mut out) {
            self.end_visit(first + at);
        }
    }

    /// Asks for what the cells of a group's paths hold.
    #[inline(always)]
    fn prefetch_entries<S: Simd>(&mut self, simd: S, group: usize) {
        let Storage::Packed(cells) = self.grid.storage() else { return };
        let stretches = &mut self.stretches[group];
        stretches.find_bricks(simd, cells.brick_steps());
        let mut lanes = stretches.moved;
        while let Some(at) = next(&mut lanes) {
            cells.prefetch_at(stretches.brick[at], stretches.within_brick[at]);
        }
    }

    /// Looks it up, and asks for the blocks.
    #[inline(always)]
    fn fetch_entries(&mut self, group: usize) {
        let stretches = &mut self.stretches[group];
        let mut lanes = std::mem::take(&mut stretches.moved);
        while let Some(at) = next(&mut lanes) {
            let entry = match self.grid.storage() {
                Storage::Packed(cells) => {
                    cells.entry_at(stretches.brick[at], stretches.within_brick[at])
                }
                Storage::Lattice(_) | Storage::Sites(_) => self.grid.entry(stretches.cell_of(at)),
            };
            stretches.entry[at] = entry.0;
            for number in entry.blocks() {
                self.grid.blocks()[number].prefetch();
            }
        }
        let mut lanes = self.in_ice[group];
        while let Some(at) = next(&mut lanes) {
            self.look_up_cell(group * GROUP + at);
        }
    }

    /// Looks up what the cell of a path holds that the caller has moved.
    pub(super) fn fetch_entry(&mut self, index: usize) {
        let (group, at) = (index / GROUP, index % GROUP);
        self.look_up_cell(index);
        self.stretches[group].entry[at] = self.lanes[index].entry.0;
    }

    /// Looks up what the cell of a path that is followed alone holds.
    #[inline(always)]
    pub(super) fn look_up_cell(&mut self, index: usize) {
        let lane = &mut self.lanes[index];
        (lane.entry, lane.entry_of) = (self.grid.entry(lane.cell), lane.cell);
    }

    /// Brings a path back into the grid that begins a stretch.
    #[inline(never)]
    fn stay_inside(&mut self, index: usize) {
        let (group, at) = (index / GROUP, index % GROUP);
        let (lane, grains) = (&mut self.lanes[index], &mut self.in_grains[group]);
        self.stretches[group].stay_inside(&self.cells, at, lane, grains);
    }

    /// A path goes on in air after its visit.
    #[inline(always)]
    fn end_visit(&mut self, index: usize) {
        let (length, event) = self.in_grains[index / GROUP].outcome(index % GROUP);
        let lane = &mut self.lanes[index];
        lane.add_ice(length);
        lane.event = event;
        lane.in_ice = false;
        lane.phase = Phase::Air;
        lane.begin_afresh();
    }
}
