//! Paths in air: to the next grain, surface or cell.

use super::body::{entered, interval};
use super::lane::{BodyPart, Inside, Lane, Phase, SurfaceAnswer};
use super::near::near;
use super::{SURFACE_FIRST, ShapeFlight};
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

/// The entry into a grain.
pub(super) struct Entry {
    pub(super) at: f64,
    /// Whether it lies behind the place where the path stands.
    pub(super) begins_inside: bool,
    pub(super) inside: Inside,
}

impl ShapeFlight<'_> {
    /// Follows a path in air through its cell.
    #[inline(always)]
    pub(super) fn step_in_air<S: Simd>(&mut self, simd: S, index: usize) {
        let exit = self.exit(&self.lanes[index]);
        let entry = self.next_entry(simd, &self.lanes[index], exit.distance);
        if self.lanes[index].entry.has_surface() && self.meets_surface(index, &exit, entry.as_ref())
        {
            return;
        }
        match entry {
            Some(Entry { at, inside, .. }) => self.arrive(index, at, inside),
            None => self.leave_cell(index, &exit),
        }
    }

    /// The way out of the cell of a path. The same numbers in each cell that shares the face.
    #[inline(always)]
    pub(super) fn exit(&self, lane: &Lane) -> Exit {
        let grid = self.grid;
        let is_brick = lane.entry == CellEntry::EMPTY_BRICK;
        let mut exit = Exit { distance: f64::INFINITY, axis: 0, steps: 0, within: [[0; 2]; 3] };
        for axis in 0..3 {
            let cell = lane.cell[axis];
            // The last brick may reach beyond the grid, where surfaces must be asked for.
            let (below, above) = if is_brick {
                (cell & 7, (7 - (cell & 7)).min(grid.cells[axis] - 1 - cell))
            } else {
                (0, 0)
            };
            exit.within[axis] = [-below, above];
            let side = f64::from(grid.side[axis]);
            let low = f64::from(grid.margin) + lane.offset[axis];
            let direction = lane.direction[axis];
            let (face, steps) = if direction > 0.0 {
                (low + side * f64::from(1 + above), above + 1)
            } else {
                (low - side * f64::from(below), -below - 1)
            };
            let distance = (face - lane.origin[axis]) / direction;
            if direction != 0.0 && distance < exit.distance {
                exit = Exit { distance, axis, steps, ..exit };
            }
        }
        exit.distance = exit.distance.max(lane.travelled);
        exit
    }

    /// The first grain that is entered up to `limit`: where its interval begins. Of grains that are entered at
    /// the same point the first in the cell.
    #[inline(always)]
    pub(super) fn next_entry<S: Simd>(&self, simd: S, lane: &Lane, limit: f64) -> Option<Entry> {
        if lane.entry == CellEntry::EMPTY_BRICK {
            return None;
        }
        let position = lane.local(lane.travelled).to_array().map(|x| x as f32);
        let direction = lane.direction.to_array().map(|x| x as f32);
        let mut best = limit;
        let mut found: Option<(usize, usize, u16, f64)> = None;
        for number in lane.entry.blocks() {
            let block = &self.grid.blocks()[number];
            let near = near(simd, block, position, direction);
            let mut slots = near.slots;
            while slots != 0 {
                let slot = slots.trailing_zeros() as usize & 15;
                slots &= slots - 1;
                if lane.travelled + f64::from(near.enter[slot]) - 1.0 > best {
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
                    let Some(ends) = interval(part, &ray) else { continue };
                    let [enter, leave] = ends.map(|end| end * placement.radius);
                    let enters = enter < best || (enter == best && found.is_none());
                    if leave > lane.travelled && enters {
                        best = enter;
                        found = Some((number, slot, at as u16, ends[0]));
                    }
                }
            }
        }
        let (number, slot, part, enter) = found?;
        let word = self.shapes.blocks[number][slot];
        let placement = Placement::of(ShapeWord::of_slot(word));
        let center = self.center(lane, number, slot);
        let ray = lane.ray_to(center, &placement);
        let parts = &self.shapes.of(&placement).parts;
        let flags = self.grid.blocks()[number].radius[slot];
        let inside = Inside {
            body: BodyPart { center, word, part },
            placement,
            leave: 0.0,
            through: entered(&parts[usize::from(part)], &ray, enter),
            meets_surface: flags & MEETS_SURFACE != 0,
            overlaps: flags & OVERLAPS != 0 || parts.len() > 1,
            stratum: self.stratum(number, slot),
        };
        let begins_inside = best < lane.travelled;
        Some(Entry { at: best.max(lane.travelled), begins_inside, inside })
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
        let grid = self.grid;
        let surfaces = self.surfaces;
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
            Some(entry) if entry.inside.meets_surface => entry.at + SURFACE_FIRST,
            Some(entry) => entry.at,
            None => exit.distance + SURFACE_FIRST,
        };
        if at > limit {
            return false;
        }
        lane.count_air(at);
        lane.travelled = at;
        self.stop(index, FlightEvent::Surface(hit));
        true
    }

    /// Goes on to the next cell, or out of the grid.
    #[inline(always)]
    pub(super) fn leave_cell(&mut self, index: usize, exit: &Exit) {
        let grid = self.grid;
        let lane = &mut self.lanes[index];
        lane.travelled = exit.distance;
        let local = lane.local(exit.distance);
        for axis in 0..3 {
            if axis == exit.axis {
                lane.step_cells(grid, axis, exit.steps);
            } else if exit.within[axis] != [0; 2] {
                let [least, most] = exit.within[axis];
                let side = f64::from(grid.side[axis]);
                let steps = ((local[axis] - f64::from(grid.margin)) / side).floor() as i32;
                lane.step_cells(grid, axis, steps.clamp(least, most));
            }
        }
        let outside = !(0..grid.cells[exit.axis]).contains(&lane.cell[exit.axis]);
        if outside && !grid.periodic[exit.axis] {
            lane.count_air(exit.distance);
            self.stop(index, FlightEvent::Left);
            return;
        }
        lane.stay_inside(grid);
    }

    /// Light arrives at a grain from air: in, or off.
    #[inline(always)]
    fn arrive(&mut self, index: usize, at: f64, inside: Inside) {
        let grid = self.grid;
        let (shapes, ratio) = (self.shapes, 1.0 / self.eta);
        let lane = &mut self.lanes[index];
        lane.count_air(at);
        lane.visits += 1;
        self.note(index, ArrivalFrom::Air, &inside, at);
        let lane = &mut self.lanes[index];
        lane.inside = Inside { leave: at, ..inside };
        let outward = lane.outward(shapes);
        if lane.first.is_none() {
            let place = grid.world_of(lane.cell, lane.local(at));
            lane.first = Some([place, outward]);
        }
        let interface = super::interface::Interface::new(lane.direction, outward, ratio);
        let passes = super::passes(lane, &interface);
        if passes {
            let on = inside.through;
            lane.begin_stretch(grid, at, interface.refracted);
            lane.in_ice = true;
            lane.turns = 1;
            self.begin_chord(index, on);
        } else {
            lane.begin_stretch(grid, at, interface.reflected);
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
