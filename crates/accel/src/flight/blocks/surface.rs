//! Where light among grains meets surfaces: one path at a time, in the few cells that they cross.

use super::exit::CellShape;
use super::paths::{GROUP, Group, NOTHING, get, place_of};
use super::update::EXIT_TOLERANCE;
use super::{BlockFlight, FlightEvent};
use crate::grain_grid::{MEETS_SURFACE, RADIUS_MASK};
use snowgrain_math::Ray;

impl BlockFlight<'_> {
    /// Before the update: which paths in air meet a surface before the next grain and the end of
    /// their cell?
    #[inline(always)]
    pub(super) fn meet_surfaces_in_air(&mut self, group: usize) {
        let Group { near_surface, air, waiting, .. } = self.groups[group];
        let mut lanes = near_surface & air & !waiting;
        while lanes != 0 {
            let at = lanes.trailing_zeros() as usize & (GROUP - 1);
            lanes &= lanes - 1;
            self.meet_surface_in_air(group * GROUP + at);
        }
    }

    /// In a cell that a surface crosses: is the surface met before the next grain or the cell's exit?
    #[inline(never)]
    fn meet_surface_in_air(&mut self, lane: usize) {
        let (index, at) = place_of(lane);
        let group = &self.groups[index];
        let exit = exit_distance(&self.shape, group, at);
        let found = group.found[at];
        // A surface within the rounding of where the stretch ends is met in this cell, and before a
        // grain that reaches it: from the far side of the face or of the entry it could be missed.
        let stretch = if found > exit + EXIT_TOLERANCE {
            exit + EXIT_TOLERANCE
        } else if group.found_radius[at] & MEETS_SURFACE != 0 {
            found + EXIT_TOLERANCE
        } else {
            found
        };
        let ray = self.ray(lane);
        let quantum = self.grid.quantum();
        let t_max = f64::from(stretch) * quantum;
        let Some(hit) = self.surfaces.intersect(&ray, t_max, self.excluded(lane)) else { return };
        let shape = self.shape;
        let group = &mut self.groups[index];
        let t = (hit.t / quantum) as f32;
        group.air_length[at] += t;
        move_to(&shape, group, at, t);
        self.keep_inside(lane);
        self.stop(lane, FlightEvent::Surface(hit));
    }

    /// Brings a path that stands on a surface at an outer face of the grid back into the grid: where
    /// it goes next is not yet known.
    fn keep_inside(&mut self, lane: usize) {
        let (index, at) = place_of(lane);
        let (grid, group) = (self.grid, &mut self.groups[index]);
        for axis in 0..3 {
            if grid.periodic[axis] {
                continue;
            }
            let cell = group.cell[axis][at];
            let inside = cell.clamp(0, grid.cells[axis] - 1);
            let shift = (cell - inside) as f32 * grid.side[axis] as f32;
            group.cell[axis][at] = inside;
            group.position[axis][at] += shift;
            group.grain[axis][at] += shift;
        }
    }

    /// In a grain that reaches a surface: does the chord that was just made meet it?
    #[inline(never)]
    pub(super) fn meet_surface_in_ice(&mut self, lane: usize) -> bool {
        let (index, at) = place_of(lane);
        let quantum = self.grid.quantum();
        let chord = self.groups[index].chord[at];
        let end = self.ray(lane);
        let length = f64::from(chord) * quantum;
        let start = Ray::new(end.at(-length), end.direction);
        let Some(hit) = self.surfaces.intersect(&start, length, self.excluded(lane)) else {
            return false;
        };
        let shape = self.shape;
        let group = &mut self.groups[index];
        let back = (hit.t / quantum) as f32 - chord;
        group.add_ice(at, back);
        move_to(&shape, group, at, back);
        group.turns[at] += 1;
        self.stop(lane, FlightEvent::Surface(hit));
        true
    }
}

/// Distance to the exit of the cell: the same arithmetic as in the vector update.
fn exit_distance(shape: &CellShape, group: &Group, at: usize) -> f32 {
    let mut least = NOTHING;
    for axis in 0..3 {
        let (p, d) = (group.position[axis][at], group.direction[axis][at]);
        if d.abs() < 1.0e-20 {
            continue;
        }
        let face = if d > 0.0 { shape.margin + shape.side[axis] } else { shape.margin };
        least = least.min((face - p) / d);
    }
    least.max(0.0)
}

/// Moves a path along its ray by `t` quanta, within its cell or across faces, with the centre of its
/// grain.
fn move_to(shape: &CellShape, group: &mut Group, at: usize, t: f32) {
    for axis in 0..3 {
        let side = shape.side[axis];
        let position = group.position[axis][at] + group.direction[axis][at] * t;
        let shift = ((position - shape.margin) / side).floor();
        group.position[axis][at] = position - shift * side;
        group.grain[axis][at] -= shift * side;
        group.cell[axis][at] += shift as i32;
    }
}

/// Starts a chord inside the current grain from where the path stands: to the far side of the grain.
pub(super) fn begin_chord(shape: &CellShape, group: &mut Group, at: usize) {
    let p = get(&group.position, at);
    let d = get(&group.direction, at);
    let g = get(&group.grain, at);
    let radius = (group.grain_radius[at] & u32::from(RADIUS_MASK)) as f32;
    let c = [g[0] - p[0], g[1] - p[1], g[2] - p[2]];
    let t = c[0] * d[0] + c[1] * d[1] + c[2] * d[2];
    let residual: [f32; 3] = std::array::from_fn(|axis| c[axis] - t * d[axis]);
    let h2 = residual[0] * residual[0] + residual[1] * residual[1] + residual[2] * residual[2];
    let length = (t + (radius * radius - h2).max(0.0).sqrt()).max(0.0);
    group.chord[at] = length;
    group.add_ice(at, length);
    group.cos_outside[at] = -1.0;
    group.ice |= 1 << at;
    move_to(shape, group, at, length);
}
