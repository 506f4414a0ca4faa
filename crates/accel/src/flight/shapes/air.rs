//! Paths in air: to the next grain, surface or cell.

use super::body::{NOWHERE, entered, interval, is_met};
use super::candidates::part_of;
use super::interface::Interface;
use super::lane::{BodyPart, Entry, Inside, Lane, Phase, SurfaceAnswer};
use super::near::{self, Window, near};
use super::visits::Departure;
use super::{GROUP, SURFACE_FIRST, ShapeFlight, passes};
use crate::flight::{ArrivalFrom, FlightEvent};
use crate::grain_grid::{CellEntry, MEETS_SURFACE, OVERLAPS, Prototype, ShapeWord};
use fearless_simd::prelude::*;
use snowgrain_math::DVec3;

/// The way out of a cell, or of an empty brick.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Exit {
    pub(super) distance: f64,
    axis: usize,
    /// Cells that crossing the face moves.
    steps: i32,
    /// Least and greatest move along each other axis: within an empty brick, else none.
    within: [[i32; 2]; 3],
}

impl ShapeFlight<'_> {
    /// Follows a path in air, of which the nearest grain is known, through its cell.
    #[inline(always)]
    pub(super) fn step_alone<S: Simd>(&mut self, simd: S, index: usize) {
        let exit = self.exit(&self.lanes[index]);
        let entry = self.lanes[index].nearest.filter(|entry| entry.at <= exit.distance);
        if self.lanes[index].entry.has_surface() && self.meets_surface(index, &exit, entry.as_ref())
        {
            return;
        }
        match entry {
            Some(entry) => self.arrive(simd, index, &entry),
            None => self.leave_cell(index, &exit),
        }
    }

    /// Tells a path in air, that is followed with others, where it is and what it may meet.
    #[inline(always)]
    pub(super) fn land(&mut self, index: usize) {
        let (group, at) = (index / GROUP, index % GROUP);
        let lane = &mut self.lanes[index];
        self.stretches[group].land(at, lane, &self.in_grains[group], self.kinds);
    }

    /// The way out of the cell of a path. The same numbers in each cell that shares the face.
    #[inline(always)]
    pub(super) fn exit(&self, lane: &Lane) -> Exit {
        let cells = &self.cells;
        let is_brick = lane.entry == CellEntry::EMPTY_BRICK;
        let mut exit = Exit { distance: f64::INFINITY, axis: 0, steps: 0, within: [[0; 2]; 3] };
        for axis in 0..3 {
            let (side, low) = (cells.side[axis], cells.margin + lane.offset[axis]);
            let forward = lane.direction[axis] > 0.0;
            let (face, steps) = if is_brick {
                let cell = lane.cell[axis];
                // The last brick may reach beyond the grid, where surfaces must be asked for.
                let below = cell & 7;
                let above = (7 - below).min(cells.counts[axis] - 1 - cell);
                exit.within[axis] = [-below, above];
                let steps = if forward { above + 1 } else { -below - 1 };
                (low + side * f64::from(if forward { steps } else { -below }), steps)
            } else {
                (if forward { low + side } else { low }, if forward { 1 } else { -1 })
            };
            let distance = (face - lane.origin[axis]) * lane.inverse_direction[axis];
            if lane.direction[axis] != 0.0 && distance < exit.distance {
                (exit.distance, exit.axis, exit.steps) = (distance, axis, steps);
            }
        }
        exit.distance = exit.distance.max(lane.travelled);
        exit
    }

    /// The nearest of the grains that the stretch enters and whose bounding spheres it enters before `limit`,
    /// where it leaves the cell; the first in the cell of two that are entered in one point. Those whose spheres it
    /// entered in an earlier cell were looked at there.
    #[inline(always)]
    pub(super) fn nearest<S: Simd>(&self, simd: S, lane: &Lane, limit: f64) -> Option<Entry> {
        let mut nearest = lane.nearest;
        self.for_each_near(simd, lane, limit, |block, slot| {
            if lane.shadowless != Some(self.center(lane, block, slot)) {
                nearest = self.nearer(lane, (block, slot), nearest);
            }
            nearest
        });
        nearest
    }

    /// Looks at block and slot of each grain whose bounding sphere the stretch enters in its cell, before `limit` and
    /// before the nearest grain that is known, which looking tells anew.
    #[inline(always)]
    pub(super) fn for_each_near<S: Simd>(
        &self,
        simd: S,
        lane: &Lane,
        limit: f64,
        mut look: impl FnMut(usize, usize) -> Option<Entry>,
    ) {
        if lane.entry == CellEntry::EMPTY_BRICK {
            return;
        }
        let position = lane.local(lane.travelled).to_array().map(|x| x as f32);
        let direction = lane.direction.to_array().map(|x| x as f32);
        let last = |nearest: Option<Entry>| {
            (nearest.map_or(limit, |nearest| nearest.at.min(limit)) - lane.travelled) as f32
        };
        let begins = lane.travelled <= 0.0;
        let mut window = Window { begins, last: last(lane.nearest) };
        for number in lane.entry.blocks() {
            let block = &self.grid.blocks()[number];
            let near = near(simd, block, (position, direction), window, near::NOWHERE);
            let mut slots = near.to_bitmask() as u32;
            while slots != 0 {
                let slot = slots.trailing_zeros() as usize & 15;
                slots &= slots - 1;
                window.last = last(look(number, slot));
            }
        }
    }

    /// The nearer of the nearest grain so far and that of a slot.
    #[inline(always)]
    pub(super) fn nearer(
        &self,
        lane: &Lane,
        (block, slot): (usize, usize),
        mut nearest: Option<Entry>,
    ) -> Option<Entry> {
        let word = self.shapes.blocks[block][slot];
        let bounding = self.grid.blocks()[block].radius[slot];
        let placement = self.shapes.placement(word, bounding);
        let radius = placement.radius;
        let center = self.center(lane, block, slot);
        let ray = lane.ray_to(center, &placement);
        for (at, part) in self.shapes.of(&placement).parts.iter().enumerate() {
            let body = BodyPart { center, radius, word, part: at as u16 };
            if lane.leaving == Some(body) {
                continue;
            }
            let Some(ends) = interval(part, &ray) else { continue };
            let enter = ends[0];
            let at = enter * placement.radius;
            let ends = ends.map(|end| end * placement.radius);
            let is_met = is_met(ends, lane.travelled, lane.leaving.is_some());
            if is_met && nearest.is_none_or(|nearest| at < nearest.at) {
                nearest = Some(Entry { at, at_radii: enter, body, block, slot, face: None });
            }
        }
        nearest
    }

    /// The ice that a path meets where it enters a grain.
    #[inline(always)]
    pub(super) fn entered(&self, lane: &Lane, entry: &Entry) -> Inside {
        let placement = entry.body.placement();
        let ray = lane.ray_to(entry.body.center, &placement);
        let Prototype { parts, slabs, .. } = self.shapes.of(&placement);
        let through = match (slabs, entry.face) {
            (Some(slabs), Some(face)) => part_of(slabs, face),
            _ => entered(&parts[usize::from(entry.body.part)], &ray, entry.at_radii),
        };
        let flags = self.grid.blocks()[entry.block].radius[entry.slot];
        Inside {
            body: entry.body,
            placement,
            leave: entry.at.max(lane.travelled),
            through,
            meets_surface: flags & MEETS_SURFACE != 0,
            overlaps: flags & OVERLAPS != 0 || parts.len() > 1,
            stratum: self.stratum(entry.block, entry.slot),
        }
    }

    /// Centre of a grain of a block of the path's cell, from the corner of its home cell.
    #[inline(always)]
    pub(super) fn center(&self, lane: &Lane, number: usize, slot: usize) -> DVec3 {
        self.grid.blocks()[number].center(slot) + lane.offset
    }

    /// Whether the path meets a surface in its cell, before it enters a grain; then it stands there. A surface
    /// in the very place where a grain that reaches it begins is met first: from the inside of that grain
    /// rounding might hide it.
    #[inline(never)]
    fn meets_surface(&mut self, index: usize, exit: &Exit, entry: Option<&Entry>) -> bool {
        let (grid, surfaces) = (self.grid, self.surfaces);
        let lane = &mut self.lanes[index];
        let hit = match lane.surface {
            SurfaceAnswer::Told(hit) => hit,
            SurfaceAnswer::NotAsked => {
                let ray = lane.stretch(grid);
                let hit = surfaces.intersect(&ray, f64::INFINITY, lane.left_surface);
                lane.surface = SurfaceAnswer::Told(hit);
                hit
            }
        };
        let Some(hit) = hit else { return false };
        let at = hit.t / grid.quantum();
        let limit = match entry {
            Some(entry) if self.reaches_surface(entry) => entry.at + SURFACE_FIRST,
            Some(entry) => entry.at,
            None => exit.distance + SURFACE_FIRST,
        };
        if at > limit {
            return false;
        }
        let lane = &mut self.lanes[index];
        lane.count_air(at);
        lane.travelled = at;
        self.stop(index, FlightEvent::Surface(hit));
        true
    }

    fn reaches_surface(&self, entry: &Entry) -> bool {
        self.grid.blocks()[entry.block].radius[entry.slot] & MEETS_SURFACE != 0
    }

    /// Goes on to the next cell, or out of the grid.
    #[inline(always)]
    pub(super) fn leave_cell(&mut self, index: usize, exit: &Exit) {
        let cells = &self.cells;
        let lane = &mut self.lanes[index];
        lane.travelled = exit.distance;
        let local = lane.local(exit.distance);
        for axis in 0..3 {
            if axis == exit.axis {
                lane.step_cells(cells, axis, exit.steps);
            } else if exit.within[axis] != [0; 2] {
                let [least, most] = exit.within[axis];
                lane.step_cells(cells, axis, cells.steps(local, axis).clamp(least, most));
            }
        }
        let outside = !(0..cells.counts[exit.axis]).contains(&lane.cell[exit.axis]);
        if outside && !cells.periodic[exit.axis] {
            lane.count_air(exit.distance);
            self.stop(index, FlightEvent::Left);
            return;
        }
        lane.stay_inside(cells);
    }

    /// Light arrives at a grain from air: in, or off.
    #[inline(always)]
    fn arrive<S: Simd>(&mut self, simd: S, index: usize, entry: &Entry) {
        let (grid, shapes, ratio) = (self.grid, self.shapes, 1.0 / self.eta);
        let inside = self.entered(&self.lanes[index], entry);
        let lane = &mut self.lanes[index];
        let at = inside.leave;
        lane.count_air(at);
        lane.visits += 1;
        if self.stops_deep(&self.lanes[index]) {
            let visit = self.visit(index, ArrivalFrom::Air, &inside, at);
            self.stop(index, FlightEvent::Deep(visit));
            return;
        }
        self.note(index, ArrivalFrom::Air, &inside, at);
        let lane = &mut self.lanes[index];
        lane.inside = inside;
        let outward = lane.outward(shapes);
        if lane.first.is_none() {
            let place = grid.world_of(lane.cell, lane.local(at));
            lane.first = Some([place, outward]);
        }
        if self.begin_visit(simd, index, entry) {
            return;
        }
        let (cells, lane) = (&self.cells, &mut self.lanes[index]);
        let interface = Interface::new(lane.direction, outward, ratio);
        if passes(lane, &interface) {
            lane.begin_stretch(cells, at, interface.refracted());
            lane.in_ice = true;
            lane.turns = 1;
            self.go_on_in_ice(simd, index, Some(inside.through));
        } else {
            lane.begin_stretch(cells, at, interface.reflected());
            lane.leaving = Some(lane.inside.body);
            self.go_on_in_air(index);
        }
    }

    /// Takes a path out of a grain that other ice covers where it stands; it goes on from there as those in other grains
    /// do.
    #[inline(never)]
    pub(super) fn leave_visit(&mut self, index: usize) {
        let departure = self.in_grains[index / GROUP].departure(index % GROUP);
        self.tell_where_inside(index);
        self.hand_back(index, &departure);
        self.wait_in_ice(index);
    }

    /// Tells a path that visits a grain, with others, where it is.
    pub(super) fn tell_where_inside(&mut self, index: usize) {
        let (group, at) = (index / GROUP, index % GROUP);
        let (lane, grains) = (&mut self.lanes[index], &self.in_grains[group]);
        self.stretches[group].tell_place(at, lane);
        let body = grains.body(at);
        lane.inside = Inside {
            body,
            placement: body.placement(),
            leave: lane.travelled,
            through: NOWHERE,
            meets_surface: false,
            overlaps: grains.overlaps(at),
            stratum: lane.inside.stratum,
        };
        lane.in_ice = true;
        (lane.nearest, lane.leaving) = (None, None);
        lane.begin_afresh();
        lane.counted = lane.travelled;
    }

    /// Takes a path back that visits a grain, and has been told where it is.
    pub(super) fn hand_back(&mut self, index: usize, departure: &Departure) {
        self.in_grains[index / GROUP].end(index % GROUP);
        let lane = &mut self.lanes[index];
        if let Some(slabs) = &self.shapes.of(&lane.inside.placement).slabs {
            lane.inside.through = part_of(slabs, departure.face);
        }
        lane.add_ice(departure.ice * lane.inside.placement.radius);
        lane.event = departure.event;
        lane.turns = departure.turns;
    }

    /// Hands a path that has arrived over to [`Visits`](super::visits::Visits), where its grain is one for them.
    #[inline(always)]
    fn begin_visit<S: Simd>(&mut self, simd: S, index: usize, entry: &Entry) -> bool {
        let lane = &mut self.lanes[index];
        let Inside { meets_surface, .. } = &lane.inside;
        // Of a path that begins within the grain the place is not on the face.
        if entry.face.is_none() || *meets_surface || entry.at < lane.travelled {
            return false;
        }
        lane.phase = Phase::Visit;
        let reached = ShapeWord::of_slot(entry.body.word).reached();
        let grains = &mut self.in_grains[index / GROUP];
        grains.begin(index % GROUP, lane.key, lane.event, reached);
        grains.arrive(simd, 1 << (index % GROUP));
        true
    }

    /// The path goes on in air from the origin of a new stretch.
    #[inline(always)]
    pub(super) fn go_on_in_air(&mut self, index: usize) {
        let lane = &mut self.lanes[index];
        lane.in_ice = false;
        lane.turns = 0;
        lane.phase = Phase::Air;
        self.stretches[index / GROUP].board(index % GROUP, lane, self.kinds);
    }
}
