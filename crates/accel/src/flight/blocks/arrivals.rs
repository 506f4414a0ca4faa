//! Arrivals of paths at grains, noted for the caller.

use super::paths::{GROUP, Group, get};
use crate::flight::deep_watch::{DeepAnswer, DeepWatch};
use crate::flight::visit::{ArrivalFrom, GrainVisit};
use crate::grain_grid::{GridPosition, MEETS_SURFACE, OVERLAPS, RADIUS_MASK};

/// What of arrivals is wanted, and what there was.
#[derive(Debug, Default)]
pub(super) struct Arrivals<'a> {
    /// Whether all are noted.
    pub(super) all: bool,
    /// What is done with those deep in the snow.
    pub(super) deep: Option<DeepWatch<'a>>,
    /// Those that the caller has not seen.
    pub(super) noted: Vec<GrainVisit>,
    /// Those of this round where paths are to stop.
    pub(super) stopped: Vec<GrainVisit>,
}

impl Arrivals<'_> {
    #[inline(always)]
    pub(super) fn are_wanted(&self) -> bool {
        self.all || self.deep.is_some()
    }

    /// Notes arrivals at the grains that were found, of the paths in each set, from air and from ice.
    #[inline(never)]
    pub(super) fn note(
        &mut self,
        group: &Group,
        first_lane: usize,
        [mut from_air, mut from_ice]: [u32; 2],
    ) {
        if let Some(watch) = self.deep {
            let deep = deep_among(group, watch, from_air);
            if watch.answer == DeepAnswer::Stop {
                each(deep, |at| self.stopped.push(visit(group, first_lane, at, ArrivalFrom::Air)));
                from_air &= !deep;
            } else if !self.all {
                from_air = deep;
            }
            if !self.all {
                from_ice = 0;
                from_air = if watch.answer == DeepAnswer::Note { from_air } else { 0 };
            }
        }
        each(from_air | from_ice, |at| {
            let from = if from_air >> at & 1 == 1 { ArrivalFrom::Air } else { ArrivalFrom::Ice };
            self.noted.push(visit(group, first_lane, at, from));
        });
    }
}

/// Those of a set that arrive deep in the snow.
#[inline(always)]
fn deep_among(group: &Group, watch: DeepWatch<'_>, set: u32) -> u32 {
    let mut deep = 0;
    each(set, |at| {
        let is_deep = watch.is_deep(group.visits[at], get(&group.cell, at), group.path_key(at));
        deep |= u32::from(is_deep) << at;
    });
    deep
}

/// Tells the places of a set.
#[inline(always)]
fn each(mut set: u32, mut tell: impl FnMut(usize)) {
    while set != 0 {
        let at = set.trailing_zeros() as usize & (GROUP - 1);
        set &= set - 1;
        tell(at);
    }
}

/// The arrival of a path at the grain that was found.
fn visit(group: &Group, first_lane: usize, at: usize, from: ArrivalFrom) -> GrainVisit {
    let (position, direction) = (get(&group.position, at), get(&group.direction, at));
    let center = get(&group.found_grain, at).map(f32::from);
    let along = |axis: usize| (center[axis] - position[axis]) * direction[axis];
    let bits = group.found_radius[at];
    GrainVisit {
        lane: first_lane + at,
        from,
        center: GridPosition { cell: get(&group.cell, at), local: center },
        radius: f32::from(bits & RADIUS_MASK),
        shaped: None,
        overlaps: bits & OVERLAPS != 0,
        meets_surface: bits & MEETS_SURFACE != 0,
        to_middle: along(0) + along(1) + along(2),
        direction,
        grain_visits: group.visits[at] + u32::from(from == ArrivalFrom::Air),
        ice_length: group.ice_length[at],
        ice_in_strata: group.ice_in_strata.map(|lengths| lengths[at]),
        stratum: group.found_stratum[at],
        event: group.event(at),
    }
}
