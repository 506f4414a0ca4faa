//! Light among packed grains: one block of sixteen grains a path and round.
//!
//! In each round every path tests ONE block of 16 grains (SIMD over the grains), then 16 paths step or are
//! updated at once (SIMD over the paths): layout before width, no gathers, no branch a path. While
//! one group of 16 is worked on, the cells and blocks of the other groups arrive from memory.

mod arrivals;
mod exit;
mod paths;
mod probe;
mod round;
mod surface;
mod test;
mod update;

use super::sphere::Ice;
use super::{DeepWatch, FirstGrain, FlightEvent, GrainVisit, LANES, MAX_TURNS_IN_ICE, Travelled};
use crate::grain_grid::GridPosition;
use crate::{GrainGrid, STRATA, SurfaceId, Surfaces};
use arrivals::Arrivals;
use exit::CellShape;
use fearless_simd::{Level, dispatch};
use paths::{FirstGrains, GROUPS, Group, get, place_of, set};
pub(super) use probe::BlockProbes;
use snowgrain_math::sampler::PathKey;
use snowgrain_math::{DVec3, Ray};

/// The piece of surface on which a straight stretch began.
#[derive(Clone, Copy, Debug)]
struct Departure {
    id: SurfaceId,
    /// The random event that the path had then reached: the next interface ends the stretch.
    event: u32,
    /// Whether the stretch can meet the piece again farther on (it crosses a sphere or a box from
    /// within): the piece is then excluded only as long as the path stands on it.
    returns: bool,
}

/// Paths in flight among packed grains.
#[derive(Debug)]
pub(super) struct BlockFlight<'a> {
    grid: &'a GrainGrid,
    surfaces: &'a Surfaces,
    ice: Ice,
    shape: CellShape,
    groups: Box<[Group; GROUPS]>,
    first: Box<[FirstGrains; GROUPS]>,
    /// The piece of surface that a path left.
    left: Box<[Option<Departure>; LANES]>,
    events: Vec<(usize, FlightEvent)>,
    arrivals: Arrivals<'a>,
    /// Groups that are looked at: all paths in flight are in the first ones.
    groups_in_use: usize,
}

impl<'a> BlockFlight<'a> {
    pub(super) fn new(grid: &'a GrainGrid, surfaces: &'a Surfaces, eta: f64) -> Self {
        Self {
            grid,
            surfaces,
            ice: Ice::new(eta),
            shape: CellShape::of(grid),
            groups: Box::default(),
            first: Box::default(),
            left: Box::new([None; LANES]),
            events: Vec::with_capacity(LANES),
            arrivals: Arrivals::default(),
            groups_in_use: GROUPS,
        }
    }

    pub(super) fn launch(&mut self, lane: usize, key: PathKey, event: u32) {
        let (group, at) = self.lane_mut(lane);
        group.launch(at, key, event);
        self.left[lane] = None;
    }

    pub(super) fn release(&mut self, lane: usize, direction: DVec3, event: u32) {
        let (group, at) = self.lane_mut(lane);
        set(&mut group.direction, at, unit_f32(direction));
        group.set_event(at, event);
        group.turns[at] = 0;
        group.pause(at);
        group.air |= 1 << at;
        self.settle(lane);
    }

    /// Outward unit normal of the grain that the path of `lane` is in, at the end of its chord.
    pub(super) fn outward(&self, lane: usize) -> DVec3 {
        let (group, at) = self.lane(lane);
        let position = DVec3::from_array(get(&group.position, at).map(f64::from));
        let center = DVec3::from_array(get(&group.grain, at).map(f64::from));
        (position - center).normalize()
    }

    pub(super) fn enter(
        &mut self,
        lane: usize,
        place: GridPosition,
        direction: DVec3,
        excluded: Option<SurfaceId>,
    ) {
        let entry = self.grid.fetchable_entry(place.cell);
        let (group, at) = self.lane_mut(lane);
        set(&mut group.position, at, place.local);
        set(&mut group.cell, at, place.cell);
        set(&mut group.periods, at, [0; 3]);
        set(&mut group.direction, at, unit_f32(direction));
        group.cos_outside[at] = -1.0;
        group.turns[at] = 0;
        group.pause(at);
        group.air |= 1 << at;
        group.set_entry(at, entry);
        self.left[lane] = excluded.map(|id| self.departure(lane, id));
    }

    pub(super) fn set_event(&mut self, lane: usize, event: u32) {
        let (group, at) = self.lane_mut(lane);
        group.set_event(at, event);
    }

    pub(super) fn bounce(&mut self, lane: usize, direction: DVec3, surface: SurfaceId, event: u32) {
        let (group, at) = self.lane_mut(lane);
        set(&mut group.direction, at, unit_f32(direction));
        group.set_event(at, event);
        self.left[lane] = Some(self.departure(lane, surface));
        let shape = self.shape;
        let (group, at) = self.lane_mut(lane);
        group.pause(at);
        if group.turns[at] == 0 {
            group.air |= 1 << at;
        } else {
            surface::begin_chord(&shape, group, at);
        }
        self.settle(lane);
    }

    pub(super) fn retire(&mut self, lane: usize) {
        let (group, at) = self.lane_mut(lane);
        group.pause(at);
    }

    pub(super) fn relocate(&mut self, from: usize, to: usize) {
        let ((group_from, i), (group_to, j)) = (place_of(from), place_of(to));
        let source = self.groups[group_from].clone();
        self.groups[group_to].copy_path(j, &source, i);
        let first = self.first[group_from].clone();
        let target = &mut self.first[group_to];
        set(&mut target.normal, j, get(&first.normal, i));
        set(&mut target.position, j, get(&first.position, i));
        set(&mut target.cell, j, get(&first.cell, i));
        self.left[to] = self.left[from];
        self.retire(from);
    }

    pub(super) fn use_lanes(&mut self, lanes: usize) {
        self.groups_in_use = lanes.min(LANES).div_ceil(paths::GROUP);
    }

    /// Lets all paths travel until at least one needs its caller.
    pub(super) fn advance(&mut self, level: Level, events: &mut Vec<(usize, FlightEvent)>) {
        dispatch!(level, simd => round::run(simd, self));
        events.append(&mut self.events);
    }

    /// Notes arrivals at grains from now on.
    pub(super) fn note_visits(&mut self) {
        self.arrivals.all = true;
    }

    /// Stops paths that arrive deep in the snow, or notes these arrivals.
    pub(super) fn watch_deep(&mut self, watch: DeepWatch<'a>) {
        self.arrivals.deep = Some(watch);
    }

    /// Moves the arrivals since the last call to `visits`, in the order of each path.
    pub(super) fn take_visits(&mut self, visits: &mut Vec<GrainVisit>) {
        visits.append(&mut self.arrivals.noted);
    }

    pub(super) fn place(&self, lane: usize) -> GridPosition {
        let (group, at) = self.lane(lane);
        group.place(at)
    }

    /// Periods that the path of `lane` has crossed along each axis.
    pub(super) fn periods(&self, lane: usize) -> [i32; 3] {
        let (group, at) = self.lane(lane);
        get(&group.periods, at)
    }

    pub(super) fn direction(&self, lane: usize) -> [f32; 3] {
        let (group, at) = self.lane(lane);
        get(&group.direction, at)
    }

    pub(super) fn travelled(&self, lane: usize, quantum: f64) -> Travelled {
        let (group, at) = self.lane(lane);
        Travelled {
            ice_length: f64::from(group.ice_length[at]) * quantum,
            air_length: f64::from(group.air_length[at]) * quantum,
            grain_visits: group.visits[at],
            event: group.event(at),
        }
    }

    pub(super) fn ice_in_strata(&self, lane: usize, quantum: f64) -> [f64; STRATA] {
        let (group, at) = self.lane(lane);
        group.ice_in_strata.map(|lengths| f64::from(lengths[at]) * quantum)
    }

    pub(super) fn first_grain(
        &self,
        lane: usize,
        world: impl Fn(GridPosition) -> DVec3,
    ) -> Option<FirstGrain> {
        let (group, at) = self.lane(lane);
        (group.visits[at] > 0).then(|| {
            let first = &self.first[lane / paths::GROUP];
            FirstGrain {
                position: world(GridPosition {
                    cell: get(&first.cell, at),
                    local: get(&first.position, at),
                }),
                normal: DVec3::from_array(get(&first.normal, at).map(f64::from)).normalize(),
            }
        })
    }

    /// Whether the path of `lane` has met interfaces since it was last in air.
    pub(super) fn is_in_ice(&self, lane: usize) -> bool {
        let (group, at) = self.lane(lane);
        group.turns[at] > 0
    }

    pub(super) fn excluded(&self, lane: usize) -> Option<SurfaceId> {
        let (group, at) = self.lane(lane);
        self.left[lane].filter(|left| left.event == group.event(at)).map(|left| left.id)
    }

    /// The departure of the path of `lane` from a surface on which it stands.
    fn departure(&self, lane: usize, id: SurfaceId) -> Departure {
        let (group, at) = self.lane(lane);
        let returns = self.surfaces.is_met_again(&self.ray(lane), id);
        Departure { id, event: group.event(at), returns }
    }

    /// The ray along which the path of `lane` travels, from where it stands (metres).
    fn ray(&self, lane: usize) -> Ray {
        let direction = DVec3::from_array(self.direction(lane).map(f64::from)).normalize();
        Ray::new(self.grid.world(self.place(lane)), direction)
    }

    fn lane(&self, lane: usize) -> (&Group, usize) {
        let (group, at) = place_of(lane);
        (&self.groups[group], at)
    }

    fn lane_mut(&mut self, lane: usize) -> (&mut Group, usize) {
        let (group, at) = place_of(lane);
        (&mut self.groups[group], at)
    }
}

/// A direction rounded to single precision, which the kernels keep at unit length.
pub(super) fn unit_f32(direction: DVec3) -> [f32; 3] {
    direction.to_array().map(|v| v as f32)
}
