//! One round: group by group, the block tests of its paths, their steps or their whole update, then
//! the rare things one by one.

use super::paths::{GROUP, place_of};
use super::test::test_group;
use super::update::{Notes, step_group, update_group};
use super::{BlockFlight, FlightEvent, MAX_TURNS_IN_ICE};
use crate::flight::visit::VISITS_AT_ONCE;
use crate::grain_grid::{MEETS_SURFACE, Storage, within_brick};
use fearless_simd::Simd;

/// A group only steps while fewer of its paths wait to scatter, and at least so many are on their way to
/// the next grain: an update costs more than twice a step.
const FEWER_WAITING: u32 = 5;
const LEAST_STEPPING: u32 = 11;

/// Rounds until an event occurs or no path is left in flight.
#[inline(always)]
pub(super) fn run<S: Simd>(simd: S, flight: &mut BlockFlight<'_>) {
    let groups = flight.groups_in_use;
    let has_surfaces = !flight.surfaces.is_empty();
    while !flight.has_news() && flight.groups[..groups].iter().any(|g| g.flying() != 0) {
        for index in 0..groups {
            let group = &mut flight.groups[index];
            test_group(simd, (flight.grid.blocks(), flight.grid.strata()), group);
            if has_surfaces {
                flight.meet_surfaces_in_air(index);
            }
            let group = &mut flight.groups[index];
            let waiting = (group.waiting | group.inside).count_ones();
            let stepping = (group.air & !group.waiting).count_ones();
            let rare = if waiting < FEWER_WAITING && stepping >= LEAST_STEPPING {
                step_group(simd, &flight.shape, group)
            } else {
                let strata = !flight.grid.strata().is_empty();
                let notes = Notes {
                    first: &mut flight.first[index],
                    arrivals: &mut flight.arrivals,
                    first_lane: index * GROUP,
                };
                update_group(simd, &flight.shape, (flight.ice, strata), group, notes)
            };
            flight.stop_deep();
            if has_surfaces {
                flight.forget_departures(index);
            }
            flight.look_closer(index, rare);
            flight.prefetch_entries(index);
            if index > 0 {
                flight.fetch_entries(index - 1);
            }
        }
        flight.fetch_entries(groups - 1);
    }
}

impl BlockFlight<'_> {
    /// Whether there is something for the caller.
    #[inline(always)]
    fn has_news(&self) -> bool {
        !self.events.is_empty() || self.arrivals.noted.len() >= VISITS_AT_ONCE
    }

    /// Stops the paths that arrived deep in the snow.
    #[inline(always)]
    fn stop_deep(&mut self) {
        while let Some(visit) = self.arrivals.stopped.pop() {
            self.stop(visit.lane, FlightEvent::Deep(visit));
        }
    }

    /// Asks for what the cells of a group's paths hold.
    #[inline(always)]
    pub(super) fn prefetch_entries(&self, group: usize) {
        let Storage::Packed(cells) = self.grid.storage() else { return };
        let group = &self.groups[group];
        let mut lanes = (group.air | group.ice) & !group.waiting;
        while lanes != 0 {
            let at = lanes.trailing_zeros() as usize & (GROUP - 1);
            lanes &= lanes - 1;
            cells.prefetch_at(group.brick[at], group.within_brick[at]);
        }
    }

    /// Looks it up, and asks for the blocks.
    #[inline(always)]
    pub(super) fn fetch_entries(&mut self, group: usize) {
        let grid = self.grid;
        let group = &mut self.groups[group];
        let mut lanes = (group.air | group.ice) & !group.waiting;
        (group.near_surface, group.crowded) = (group.near_surface & !lanes, group.crowded & !lanes);
        while lanes != 0 {
            let at = lanes.trailing_zeros() as usize & (GROUP - 1);
            lanes &= lanes - 1;
            let entry = match grid.storage() {
                Storage::Packed(cells) => cells.entry_at(group.brick[at], group.within_brick[at]),
                Storage::Lattice(cells) => cells.entry(group.place(at).cell),
                Storage::Sites(_) => unreachable!("light in a crystal asks for no cells"),
            };
            grid.prefetch_blocks(entry);
            group.entry[at] = entry.0;
            group.near_surface |= u32::from(entry.has_surface()) << at;
            group.crowded |= u32::from(!entry.further_blocks().is_empty()) << at;
        }
    }

    /// After a round: which paths of the group no longer stand where they left a surface?
    #[inline(always)]
    fn forget_departures(&mut self, group: usize) {
        for left in &mut self.left[group * GROUP..(group + 1) * GROUP] {
            if left.is_some_and(|left| left.returns) {
                *left = None;
            }
        }
    }

    /// Looks at paths that may have met a surface inside their grain, left the grid, or been trapped.
    #[inline(always)]
    pub(super) fn look_closer(&mut self, group: usize, mut rare: u32) {
        while rare != 0 {
            let at = rare.trailing_zeros() as usize & (GROUP - 1);
            rare &= rare - 1;
            if self.groups[group].flying() >> at & 1 != 0 {
                self.look_at(group * GROUP + at);
            }
        }
    }

    /// After the caller has moved or turned a path: is it still in flight? Then its cell is asked for.
    pub(super) fn settle(&mut self, lane: usize) {
        self.look_at(lane);
        let (group, at) = place_of(lane);
        if self.groups[group].flying() >> at & 1 != 0 {
            let entry = self.grid.fetchable_entry(self.place(lane).cell);
            self.groups[group].set_entry(at, entry);
        }
    }

    #[inline(never)]
    fn look_at(&mut self, lane: usize) {
        let (index, at) = place_of(lane);
        let group = &self.groups[index];
        if group.ice >> at & 1 != 0 {
            if group.grain_radius[at] & u32::from(MEETS_SURFACE) != 0
                && self.meet_surface_in_ice(lane)
            {
                return;
            }
            if self.groups[index].turns[at] > MAX_TURNS_IN_ICE {
                self.stop(lane, FlightEvent::Trapped);
                return;
            }
        }
        let grid = self.grid;
        let group = &mut self.groups[index];
        for axis in 0..3 {
            let n = grid.cells[axis];
            let cell = group.cell[axis][at];
            if (0..n).contains(&cell) {
                continue;
            }
            if !grid.periodic[axis] {
                self.stop(lane, FlightEvent::Left);
                return;
            }
            group.cell[axis][at] = cell.rem_euclid(n);
            group.periods[axis][at] += cell.div_euclid(n);
        }
        if let Storage::Packed(cells) = grid.storage() {
            let cell = group.place(at).cell;
            group.brick[at] = cells.brick_of(cell) as u32;
            group.within_brick[at] = within_brick(cell) as u32;
        }
    }

    /// Takes a path out of flight and tells the caller why.
    pub(super) fn stop(&mut self, lane: usize, event: FlightEvent) {
        let (group, at) = place_of(lane);
        self.groups[group].pause(at);
        self.events.push((lane, event));
    }
}
