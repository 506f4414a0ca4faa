//! Light among packed grains: one block of sixteen grains a path and round.
//!
//! In each round every path tests ONE block of 16 grains (SIMD over the grains), then all paths are
//! updated at once (SIMD over the paths): layout before width, no gathers, no branch a path.

mod block_test;
mod lanes;
mod round;
mod update;

use super::{FirstGrain, FlightEvent, LANES, MAX_TURNS_IN_ICE, Travelled};
use crate::grain_grid::GridPosition;
use crate::{GrainGrid, SurfaceId, Surfaces};
use fearless_simd::{Level, dispatch};
use lanes::{Lanes, mode};
use snowgrain_math::sampler::PathKey;
use snowgrain_math::{DVec3, Ray};
use update::Ice;

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
    lanes: Box<Lanes>,
    /// The piece of surface that a path left.
    left: [Option<Departure>; LANES],
    events: Vec<(usize, FlightEvent)>,
    /// Lanes that are looked at: all paths in flight are in the first ones.
    in_use: usize,
}

impl<'a> BlockFlight<'a> {
    pub(super) fn new(grid: &'a GrainGrid, surfaces: &'a Surfaces, eta: f64) -> Self {
        Self {
            grid,
            surfaces,
            ice: Ice::new(eta),
            lanes: Lanes::new(),
            left: [None; LANES],
            events: Vec::with_capacity(LANES),
            in_use: LANES,
        }
    }

    /// Makes `lane` the lane of a new path whose next random event is `event`; [`Self::enter`] then
    /// puts it into the grid.
    pub(super) fn launch(&mut self, lane: usize, key: PathKey, event: u32) {
        let lanes = &mut self.lanes;
        lanes.key_lo[lane] = key.lo;
        lanes.key_hi[lane] = key.hi;
        lanes.event[lane] = event;
        lanes.ice_length[lane] = 0.0;
        lanes.air_length[lane] = 0.0;
        lanes.visits[lane] = 0;
        lanes.turns[lane] = 0;
        lanes.mode[lane] = mode::PAUSED;
        self.left[lane] = None;
    }

    /// Lets the path of `lane`, which circles in ice, leave where it stands along `direction`, its
    /// next random event being `event`.
    pub(super) fn release(&mut self, lane: usize, direction: DVec3, event: u32) {
        let lanes = &mut self.lanes;
        lanes.direction.set(lane, unit_f32(direction));
        lanes.event[lane] = event;
        lanes.turns[lane] = 0;
        lanes.mode[lane] = mode::AIR;
        round::settle(self, lane);
        if self.lanes.mode[lane] != mode::PAUSED {
            self.fetch_entry(lane);
        }
    }

    /// Outward unit normal of the grain that the path of `lane` is in, at the end of its chord.
    pub(super) fn outward(&self, lane: usize) -> DVec3 {
        let position = DVec3::from_array(self.lanes.position.get(lane).map(f64::from));
        let center = DVec3::from_array(self.lanes.grain.get(lane).map(f64::from));
        (position - center).normalize()
    }

    /// Puts the path of `lane` into the grid: in air at `place`, along the unit vector
    /// `direction`, having left the surface `excluded`.
    pub(super) fn enter(
        &mut self,
        lane: usize,
        place: GridPosition,
        direction: DVec3,
        excluded: Option<SurfaceId>,
    ) {
        let entry = self.fetchable_entry(place.cell);
        let lanes = &mut self.lanes;
        lanes.position.set(lane, place.local);
        lanes.cell.set(lane, place.cell);
        lanes.direction.set(lane, unit_f32(direction));
        lanes.cos_outside[lane] = -1.0;
        lanes.turns[lane] = 0;
        lanes.mode[lane] = mode::AIR;
        lanes.entry[lane] = entry;
        self.left[lane] = excluded.map(|id| self.departure(lane, id));
    }

    /// Tells that the caller has used the random events before `event`.
    pub(super) fn set_event(&mut self, lane: usize, event: u32) {
        self.lanes.event[lane] = event;
    }

    /// Sends a path that stands at a surface on along `direction`, in the medium in which it came;
    /// its next random event is `event`.
    pub(super) fn bounce(&mut self, lane: usize, direction: DVec3, surface: SurfaceId, event: u32) {
        let lanes = &mut self.lanes;
        lanes.direction.set(lane, unit_f32(direction));
        lanes.event[lane] = event;
        self.left[lane] = Some(self.departure(lane, surface));
        let lanes = &mut self.lanes;
        if lanes.turns[lane] == 0 {
            lanes.mode[lane] = mode::AIR;
        } else {
            round::begin_chord(self.grid, lanes, lane);
        }
        round::settle(self, lane);
        if self.lanes.mode[lane] != mode::PAUSED {
            self.fetch_entry(lane);
        }
    }

    /// Ends the path of `lane`.
    pub(super) fn retire(&mut self, lane: usize) {
        self.lanes.mode[lane] = mode::PAUSED;
    }

    /// Moves the path of lane `from` to the free lane `to`.
    pub(super) fn relocate(&mut self, from: usize, to: usize) {
        self.lanes.copy_lane(from, to);
        self.left[to] = self.left[from];
        self.lanes.mode[from] = mode::PAUSED;
    }

    /// Tells that only the first `lanes` lanes hold paths, so that a few last paths do not cost as
    /// much as 64.
    pub(super) fn use_lanes(&mut self, lanes: usize) {
        self.in_use = lanes.min(LANES);
    }

    /// Lets all paths travel until at least one needs its caller.
    pub(super) fn advance(&mut self, level: Level, events: &mut Vec<(usize, FlightEvent)>) {
        dispatch!(level, simd => round::run(simd, self));
        events.append(&mut self.events);
    }

    /// The ray along which the path of `lane` travels, from where it stands (metres).
    fn ray(&self, lane: usize) -> Ray {
        let direction = DVec3::from_array(self.direction(lane).map(f64::from)).normalize();
        Ray::new(self.grid.world(self.place(lane)), direction)
    }

    /// What the path of `lane` has done so far.
    pub(super) fn travelled(&self, lane: usize, quantum: f64) -> Travelled {
        Travelled {
            ice_length: f64::from(self.lanes.ice_length[lane]) * quantum,
            air_length: f64::from(self.lanes.air_length[lane]) * quantum,
            grain_visits: self.lanes.visits[lane],
            event: self.lanes.event[lane],
        }
    }

    /// The first grain that the path of `lane` met, if it met one.
    pub(super) fn first_grain(
        &self,
        lane: usize,
        world: impl Fn(GridPosition) -> DVec3,
    ) -> Option<FirstGrain> {
        (self.lanes.visits[lane] > 0).then(|| FirstGrain {
            position: world(GridPosition {
                cell: self.lanes.first_cell.get(lane),
                local: self.lanes.first_position.get(lane),
            }),
            normal: DVec3::from_array(self.lanes.first_normal.get(lane).map(f64::from)),
        })
    }

    /// The surface on which the present stretch of the path of `lane` began, if it began on one.
    pub(super) fn excluded(&self, lane: usize) -> Option<SurfaceId> {
        let event = self.lanes.event[lane];
        self.left[lane].filter(|left| left.event == event).map(|left| left.id)
    }

    /// The departure of the path of `lane` from a surface on which it stands.
    fn departure(&self, lane: usize, id: SurfaceId) -> Departure {
        let returns = self.surfaces.is_met_again(&self.ray(lane), id);
        Departure { id, event: self.lanes.event[lane], returns }
    }

    pub(super) fn place(&self, lane: usize) -> GridPosition {
        GridPosition {
            cell: self.lanes.cell_of(lane).to_array(),
            local: self.lanes.position.get(lane),
        }
    }

    pub(super) fn direction(&self, lane: usize) -> [f32; 3] {
        self.lanes.direction.get(lane)
    }
}

/// A direction rounded to single precision, which the kernels keep at unit length.
fn unit_f32(direction: DVec3) -> [f32; 3] {
    direction.to_array().map(|v| v as f32)
}
