//! Paths in air: to the next grain, surface or cell.

use super::body::{entered, interval};
use super::interface::Interface;
use super::lane::{BodyPart, Entry, Inside, Lane, Phase, SurfaceAnswer};
use super::near::{TOLERANCE, near};
use super::{SURFACE_FIRST, ShapeFlight, passes};
use crate::flight::{ArrivalFrom, FlightEvent};
use crate::grain_grid::{CellEntry, MEETS_SURFACE, OVERLAPS, Placement, ShapeWord};
use fearless_simd::Simd;
use snowgrain_math::DVec3;

/// The way out of a cell, or of an empty brick.
pub(super) struct Exit {
    pub(super) distance: f64,
    axis: usize,
    /// Cells that crossing the face moves.
    steps: i32,
    /// Least and greatest move along each other axis: within an empty brick, else none.
    within: [[i32; 2]; 3],
}

impl ShapeFlight<'_> {
    /// Follows a path in air through its cell.
    #[inline(always)]
    pub(super) fn step_in_air<S: Simd>(&mut self, simd: S, index: usize) {
        let exit = self.exit(&self.lanes[index]);
        let nearest = self.nearest(simd, &self.lanes[index], exit.distance);
        self.lanes[index].nearest = nearest;
        let entry = nearest.filter(|entry| entry.at <= exit.distance);
        if self.lanes[index].entry.has_surface() && self.meets_surface(index, &exit, entry.as_ref())
        {
            return;
        }
        match entry {
            Some(entry) => self.arrive(simd, index, &entry),
            None => self.leave_cell(index, &exit),
        }
    }

    /// The way out of the cell of a path. The same numbers in each cell that shares the face.
    #[inline(always)]
    pub(super) fn exit(&self, lane: &Lane) -> Exit {
        let cells = &self.cells;
        let is_brick = lane.entry == CellEntry::EMPTY_BRICK;
        let mut exit = Exit { distance: f64::INFINITY, axis: 0, steps: 0, within: [[0; 2]; 3] };
        for axis in 0..3 {
            let cell = lane.cell[axis];
            // The last brick may reach beyond the grid, where surfaces must be asked for.
            let (below, above) = if is_brick {
                (cell & 7, (7 - (cell & 7)).min(cells.counts[axis] - 1 - cell))
            } else {
                (0, 0)
            };
            exit.within[axis] = [-below, above];
            let side = cells.side[axis];
            let low = cells.margin + lane.offset[axis];
            let direction = lane.direction[axis];
            let (face, steps) = if direction > 0.0 {
                (low + side * f64::from(1 + above), above + 1)
            } else {
                (low - side * f64::from(below), -below - 1)
            };
            let distance = (face - lane.origin[axis]) * lane.inverse_direction[axis];
            if direction != 0.0 && distance < exit.distance {
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
        if lane.entry == CellEntry::EMPTY_BRICK {
            return nearest;
        }
        let position = lane.local(lane.travelled).to_array().map(|x| x as f32);
        let direction = lane.direction.to_array().map(|x| x as f32);
        let before = if lane.travelled > 0.0 { -TOLERANCE } else { f32::NEG_INFINITY };
        for number in lane.entry.blocks() {
            let block = &self.grid.blocks()[number];
            let near = near(simd, block, position, direction);
            let mut slots = near.slots;
            while slots != 0 {
                let slot = slots.trailing_zeros() as usize & 15;
                slots &= slots - 1;
                let sphere = near.enter[slot];
                let best = nearest.map_or(limit, |nearest| nearest.at.min(limit));
                if sphere < before || lane.travelled + f64::from(sphere - TOLERANCE) > best {
                    continue;
                }
                let word = self.shapes.blocks[number][slot];
                let placement = Placement::of(ShapeWord::of_slot(word));
                let center = self.center(lane, number, slot);
                if lane.shadowless == Some(center) {
                    continue;
                }
                let ray = lane.ray_to(center, &placement);
                for (at, part) in self.shapes.of(&placement).parts.iter().enumerate() {
                    let body = BodyPart { center, word, part: at as u16 };
                    if lane.leaving == Some(body) {
                        continue;
                    }
                    let Some([enter, leave]) = interval(part, &ray) else { continue };
                    let entry = Entry {
                        at: enter * placement.radius,
                        at_radii: enter,
                        body,
                        block: number,
                        slot,
                    };
                    let is_ahead = leave * placement.radius > lane.travelled;
                    if is_ahead && nearest.is_none_or(|nearest| entry.at < nearest.at) {
                        nearest = Some(entry);
                    }
                }
            }
        }
        nearest
    }

    /// The ice that a path meets where it enters a grain.
    #[inline(always)]
    pub(super) fn entered(&self, lane: &Lane, entry: &Entry) -> Inside {
        let placement = Placement::of(ShapeWord::of_slot(entry.body.word));
        let ray = lane.ray_to(entry.body.center, &placement);
        let parts = &self.shapes.of(&placement).parts;
        let flags = self.grid.blocks()[entry.block].radius[entry.slot];
        Inside {
            body: entry.body,
            placement,
            leave: entry.at.max(lane.travelled),
            through: entered(&parts[usize::from(entry.body.part)], &ray, entry.at_radii),
            meets_surface: flags & MEETS_SURFACE != 0,
            overlaps: flags & OVERLAPS != 0 || parts.len() > 1,
            stratum: self.stratum(entry.block, entry.slot),
        }
    }

    /// Centre of a grain of a block of the path's cell, from the corner of its home cell.
    #[inline(always)]
    pub(super) fn center(&self, lane: &Lane, number: usize, slot: usize) -> DVec3 {
        let block = &self.grid.blocks()[number];
        DVec3::new(block.x[slot].into(), block.y[slot].into(), block.z[slot].into()) + lane.offset
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
        let cells = &self.cells;
        let lane = &mut self.lanes[index];
        lane.inside = inside;
        let outward = lane.outward(shapes);
        if lane.first.is_none() {
            let place = grid.world_of(lane.cell, lane.local(at));
            lane.first = Some([place, outward]);
        }
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

    /// The path goes on in air from the origin of a new stretch.
    #[inline(always)]
    pub(super) fn go_on_in_air(&mut self, index: usize) {
        let lane = &mut self.lanes[index];
        lane.in_ice = false;
        lane.turns = 0;
        lane.phase = Phase::Air;
    }
}
