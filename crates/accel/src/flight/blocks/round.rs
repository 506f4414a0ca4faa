//! One round: a block test for every path, the update of all, then the rare things one by one.

use super::block_test::{BlockRay, NOTHING, test_block};
use super::lanes::{Lanes, mode};
use super::update::{EXIT_TOLERANCE, GROUP, update_group};
use super::{BlockFlight, FlightEvent, MAX_TURNS_IN_ICE};
use crate::grain_grid::{CellEntry, GrainGrid, MEETS_SURFACE, RADIUS_MASK};
use fearless_simd::Simd;
use snowgrain_math::Ray;

/// Rounds until an event occurs or no path is left in flight.
#[inline(always)]
pub(super) fn run<S: Simd>(simd: S, flight: &mut BlockFlight<'_>) {
    let has_surfaces = !flight.surfaces.is_empty();
    while flight.events.is_empty() {
        let mut flying = false;
        for lane in 0..flight.in_use {
            let now = flight.lanes.mode[lane];
            if now == mode::PAUSED {
                continue;
            }
            flying = true;
            test_lane(simd, flight.grid, &mut flight.lanes, lane, now == mode::ICE);
            if has_surfaces && now == mode::AIR && CellEntry(flight.lanes.entry[lane]).has_surface()
            {
                meet_surface_in_air(flight, lane);
            }
        }
        if !flying {
            return;
        }
        for at in (0..flight.in_use).step_by(GROUP) {
            update_group(simd, flight.grid, flight.ice, &mut flight.lanes, at);
        }
        // Two passes: the entries of all cells are on their way before the first is needed, and the
        // blocks that they name before the next round.
        for lane in 0..flight.in_use {
            if flight.lanes.mode[lane] != mode::PAUSED {
                if has_surfaces && flight.left[lane].is_some_and(|left| left.returns) {
                    flight.left[lane] = None;
                }
                settle(flight, lane);
            }
        }
        for lane in 0..flight.in_use {
            if flight.lanes.mode[lane] != mode::PAUSED {
                flight.fetch_entry(lane);
            }
        }
    }
}

/// Asks the blocks of the path's cell for the next grain.
#[inline(always)]
fn test_lane<S: Simd>(simd: S, grid: &GrainGrid, lanes: &mut Lanes, lane: usize, in_ice: bool) {
    let entry = CellEntry(lanes.entry[lane]);
    if entry == CellEntry::EMPTY_BRICK {
        lanes.found[lane] = NOTHING;
        return;
    }
    let ray = BlockRay {
        position: lanes.position.get(lane),
        direction: lanes.direction.get(lane),
        in_ice,
        grain: lanes.grain.get(lane),
    };
    let mut best = NOTHING;
    for index in entry.blocks() {
        let block = &grid.blocks[index];
        let (value, slot) = test_block(simd, block, &ray);
        if value < best || index == entry.blocks().start {
            best = value;
            let center = [block.x[slot], block.y[slot], block.z[slot]];
            lanes.found_grain.set(lane, center.map(f32::from));
            lanes.found_radius[lane] = u32::from(block.radius[slot]);
        }
    }
    lanes.found[lane] = best;
}

/// In a cell that a surface crosses: is the surface met before the next grain or the cell's exit?
#[inline(never)]
fn meet_surface_in_air(flight: &mut BlockFlight<'_>, lane: usize) {
    let exit = exit_distance(flight.grid, &flight.lanes, lane);
    let found = flight.lanes.found[lane];
    // A surface within the rounding of where the stretch ends is met in this cell, and before a grain
    // that reaches it: from the far side of the face or of the entry it could be missed.
    let stretch = if found > exit + EXIT_TOLERANCE {
        exit + EXIT_TOLERANCE
    } else if flight.lanes.found_radius[lane] & u32::from(MEETS_SURFACE) != 0 {
        found + EXIT_TOLERANCE
    } else {
        found
    };
    let ray = flight.ray(lane);
    let quantum = flight.grid.quantum();
    let t_max = f64::from(stretch) * quantum;
    let Some(hit) = flight.surfaces.intersect(&ray, t_max, flight.excluded(lane)) else { return };
    let lanes = &mut flight.lanes;
    let t = (hit.t / quantum) as f32;
    lanes.air_length[lane] += t;
    move_to(flight.grid, lanes, lane, t);
    keep_inside(flight.grid, lanes, lane);
    lanes.mode[lane] = mode::PAUSED;
    flight.events.push((lane, FlightEvent::Surface(hit)));
}

/// Brings a path that stands on a surface at an outer face of the grid back into the grid: where it
/// goes next is not yet known.
fn keep_inside(grid: &GrainGrid, lanes: &mut Lanes, lane: usize) {
    for axis in 0..3 {
        if grid.periodic[axis] {
            continue;
        }
        let cell = lanes.cell.0[axis][lane];
        let inside = cell.clamp(0, grid.cells[axis] - 1);
        let shift = (cell - inside) as f32 * grid.side[axis] as f32;
        lanes.cell.0[axis][lane] = inside;
        lanes.position.0[axis][lane] += shift;
        lanes.grain.0[axis][lane] += shift;
    }
}

/// Distance to the exit of the cell: the same arithmetic as in the vector update.
fn exit_distance(grid: &GrainGrid, lanes: &Lanes, lane: usize) -> f32 {
    let mut least = NOTHING;
    for axis in 0..3 {
        let (p, d) = (lanes.position.0[axis][lane], lanes.direction.0[axis][lane]);
        if d.abs() < 1.0e-20 {
            continue;
        }
        let low = grid.margin as f32;
        let face = if d > 0.0 { low + grid.side[axis] as f32 } else { low };
        least = least.min((face - p) / d);
    }
    least.max(0.0)
}

/// Moves a path along its ray by `t` quanta, within its cell or across faces.
fn move_to(grid: &GrainGrid, lanes: &mut Lanes, lane: usize, t: f32) {
    for axis in 0..3 {
        lanes.position.0[axis][lane] += lanes.direction.0[axis][lane] * t;
    }
    recenter(grid, lanes, lane);
}

/// Moves a path to the cell that holds its position, with the centre of its grain.
fn recenter(grid: &GrainGrid, lanes: &mut Lanes, lane: usize) {
    for axis in 0..3 {
        let side = grid.side[axis] as f32;
        let shift = ((lanes.position.0[axis][lane] - grid.margin as f32) / side).floor();
        lanes.position.0[axis][lane] -= shift * side;
        lanes.grain.0[axis][lane] -= shift * side;
        lanes.cell.0[axis][lane] += shift as i32;
    }
}

/// Starts a chord inside the current grain from where the path stands: to the far side of the grain.
pub(super) fn begin_chord(grid: &GrainGrid, lanes: &mut Lanes, lane: usize) {
    let p = lanes.position.get(lane);
    let d = lanes.direction.get(lane);
    let g = lanes.grain.get(lane);
    let radius = (lanes.grain_radius[lane] & u32::from(RADIUS_MASK)) as f32;
    let c = [g[0] - p[0], g[1] - p[1], g[2] - p[2]];
    let t = c[0] * d[0] + c[1] * d[1] + c[2] * d[2];
    let residual: [f32; 3] = std::array::from_fn(|axis| c[axis] - t * d[axis]);
    let h2 = residual[0] * residual[0] + residual[1] * residual[1] + residual[2] * residual[2];
    let length = (t + (radius * radius - h2).max(0.0).sqrt()).max(0.0);
    lanes.chord[lane] = length;
    lanes.ice_length[lane] += length;
    lanes.cos_outside[lane] = -1.0;
    lanes.mode[lane] = mode::ICE;
    move_to(grid, lanes, lane, length);
}

/// After a move: has the path met a surface inside its grain, left the grid, or been trapped? Else
/// its new cell is asked for.
#[inline(always)]
pub(super) fn settle(flight: &mut BlockFlight<'_>, lane: usize) {
    let lanes = &mut flight.lanes;
    if lanes.mode[lane] == mode::ICE {
        if lanes.grain_radius[lane] & u32::from(MEETS_SURFACE) != 0
            && meet_surface_in_ice(flight, lane)
        {
            return;
        }
        if flight.lanes.turns[lane] > MAX_TURNS_IN_ICE {
            flight.lanes.mode[lane] = mode::PAUSED;
            flight.events.push((lane, FlightEvent::Trapped));
            return;
        }
    }
    let grid = flight.grid;
    let lanes = &mut flight.lanes;
    let mut cell = lanes.cell.get(lane);
    for (axis, index) in cell.iter_mut().enumerate() {
        let n = grid.cells[axis];
        if (0..n).contains(index) {
            continue;
        }
        if grid.periodic[axis] {
            *index = index.rem_euclid(n);
            lanes.cell.0[axis][lane] = *index;
        } else {
            lanes.mode[lane] = mode::PAUSED;
            flight.events.push((lane, FlightEvent::Left));
            return;
        }
    }
    grid.prefetch_entry(cell);
}

/// In a grain that reaches a surface: does the chord that was just made meet it?
#[inline(never)]
fn meet_surface_in_ice(flight: &mut BlockFlight<'_>, lane: usize) -> bool {
    let quantum = flight.grid.quantum();
    let chord = flight.lanes.chord[lane];
    let end = flight.ray(lane);
    let length = f64::from(chord) * quantum;
    let start = Ray::new(end.at(-length), end.direction);
    let Some(hit) = flight.surfaces.intersect(&start, length, flight.excluded(lane)) else {
        return false;
    };
    let lanes = &mut flight.lanes;
    let back = (hit.t / quantum) as f32 - chord;
    lanes.ice_length[lane] += back;
    move_to(flight.grid, lanes, lane, back);
    lanes.turns[lane] += 1;
    lanes.mode[lane] = mode::PAUSED;
    flight.events.push((lane, FlightEvent::Surface(hit)));
    true
}

impl BlockFlight<'_> {
    /// Looks up the cell that the path of `lane` is in.
    #[inline(always)]
    pub(super) fn fetch_entry(&mut self, lane: usize) {
        self.lanes.entry[lane] = self.fetchable_entry(self.lanes.cell.get(lane));
    }

    /// The entry of a cell, its first block already on the way from memory. A periodic grid does
    /// not cross bricks in one step: they need not divide its period.
    #[inline(always)]
    pub(super) fn fetchable_entry(&self, cell: [i32; 3]) -> u32 {
        let entry = self.grid.entry(cell);
        if entry == CellEntry::EMPTY_BRICK {
            return if self.grid.periodic == [false; 3] { entry.0 } else { CellEntry::EMPTY.0 };
        }
        self.grid.blocks[entry.blocks().start].prefetch();
        entry.0
    }
}
