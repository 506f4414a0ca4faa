//! Light among grains, many paths at a time.
//!
//! [`Flight`] keeps 64 paths in the air. In each round every path tests ONE block of 16 grains
//! (SIMD over the grains), then all paths are updated at once (SIMD over the paths): layout before
//! width, no gathers, no branch a path. What the kernels cannot decide comes back as a
//! [`FlightEvent`]: the path left the grid, met a surface, or seems trapped. The caller answers
//! with [`Flight::launch`], [`Flight::bounce`] or [`Flight::retire`].

mod block_test;
mod lanes;
mod round;
mod update;

pub use lanes::LANES;

use crate::{GrainGrid, SimdLevel, SurfaceHit, SurfaceId, Surfaces};
use fearless_simd::{Level, dispatch};
use lanes::{Lanes, mode};
use snowgrain_geometry::Quantisation;
use snowgrain_math::sampler::PathKey;
use snowgrain_math::{DVec3, Ray};
use update::Ice;

use crate::grain_grid::GridPosition;

/// A path that stays in one body of ice for more interfaces than this is counted as trapped. Not a
/// bounce cap: time in air starts the count anew. Total reflection can hold light in overlapping
/// grains for very long (an orbit that was entered also leaves, but by the narrow lens through which
/// it came); about one path in 10^6 of the paper's deposit stays for 10^5 turns.
pub const MAX_TURNS_IN_ICE: u32 = 1_000_000;

/// Why a path stands still.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum FlightEvent {
    /// It left the box of the grid, in air.
    Left,
    /// It met a surface, in air or in ice.
    Surface(SurfaceHit),
    /// It made [`MAX_TURNS_IN_ICE`] turns without coming out.
    Trapped,
}

/// What a path has done so far. Lengths in metres.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Travelled {
    /// Length in ice.
    pub ice_length: f64,
    /// Length in air inside the grid.
    pub air_length: f64,
    /// Arrivals at grains from outside.
    pub grain_visits: u32,
    /// Next event of the path's random numbers.
    pub event: u32,
}

/// The first grain that a path met.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FirstGrain {
    /// Where, metres.
    pub position: DVec3,
    /// Outward unit normal of the grain there.
    pub normal: DVec3,
}

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

/// 64 paths among the grains of one grid. See the module's page.
#[derive(Debug)]
pub struct Flight<'a> {
    grid: &'a GrainGrid,
    surfaces: &'a Surfaces,
    level: Level,
    ice: Ice,
    lanes: Box<Lanes>,
    /// The piece of surface that a path left.
    left: [Option<Departure>; LANES],
    events: Vec<(usize, FlightEvent)>,
    /// Lanes that are looked at: all paths in flight are in the first ones.
    in_use: usize,
}

impl<'a> Flight<'a> {
    /// No path in flight. `eta` is the relative index of the grains, >= 1.
    ///
    /// # Panics
    /// If the machine does not have `level`.
    #[must_use]
    pub fn new(grid: &'a GrainGrid, surfaces: &'a Surfaces, eta: f64, level: SimdLevel) -> Self {
        Self {
            grid,
            surfaces,
            level: level.token().expect("the SIMD level was checked when it was chosen"),
            ice: Ice::new(eta),
            lanes: Lanes::new(),
            left: [None; LANES],
            events: Vec::with_capacity(LANES),
            in_use: LANES,
        }
    }

    /// Makes `lane` the lane of a new path whose next random event is `event`; [`Self::enter`] then
    /// puts it into the grid.
    pub fn launch(&mut self, lane: usize, key: PathKey, event: u32) {
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
    pub fn release(&mut self, lane: usize, direction: DVec3, event: u32) {
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
    #[must_use]
    pub fn outward(&self, lane: usize) -> DVec3 {
        let position = DVec3::from_array(self.lanes.position.get(lane).map(f64::from));
        let center = DVec3::from_array(self.lanes.grain.get(lane).map(f64::from));
        (position - center).normalize()
    }

    /// Puts the path of `lane` into the grid: in air at `place`, along the unit vector
    /// `direction`, having left the surface `excluded`.
    pub fn enter(
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
    pub fn set_event(&mut self, lane: usize, event: u32) {
        self.lanes.event[lane] = event;
    }

    /// Sends a path that stands at a surface on along `direction`, in the medium in which it came;
    /// its next random event is `event`.
    pub fn bounce(&mut self, lane: usize, direction: DVec3, surface: SurfaceId, event: u32) {
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
    pub fn retire(&mut self, lane: usize) {
        self.lanes.mode[lane] = mode::PAUSED;
    }

    /// Moves the path of lane `from` to the free lane `to`.
    pub fn relocate(&mut self, from: usize, to: usize) {
        self.lanes.copy_lane(from, to);
        self.left[to] = self.left[from];
        self.lanes.mode[from] = mode::PAUSED;
    }

    /// Tells that only the first `lanes` lanes hold paths, so that a few last paths do not cost as
    /// much as 64.
    pub fn use_lanes(&mut self, lanes: usize) {
        self.in_use = lanes.min(LANES);
    }

    /// Lets all paths travel until at least one needs its caller; `(lane, event)` of each that
    /// does. Empty when no path is in flight.
    pub fn advance(&mut self) -> Vec<(usize, FlightEvent)> {
        let level = self.level;
        dispatch!(level, simd => round::run(simd, self));
        std::mem::take(&mut self.events)
    }

    /// The ray along which the path of `lane` travels, from where it stands (metres).
    #[must_use]
    pub fn ray(&self, lane: usize) -> Ray {
        Ray::new(self.grid.world(self.place(lane)), self.direction(lane))
    }

    /// What the path of `lane` has done so far.
    #[must_use]
    pub fn travelled(&self, lane: usize) -> Travelled {
        let quantum = self.grid.quantum();
        Travelled {
            ice_length: f64::from(self.lanes.ice_length[lane]) * quantum,
            air_length: f64::from(self.lanes.air_length[lane]) * quantum,
            grain_visits: self.lanes.visits[lane],
            event: self.lanes.event[lane],
        }
    }

    /// The first grain that the path of `lane` met, if it met one.
    #[must_use]
    pub fn first_grain(&self, lane: usize) -> Option<FirstGrain> {
        (self.lanes.visits[lane] > 0).then(|| FirstGrain {
            position: self.grid.world(GridPosition {
                cell: self.lanes.first_cell.get(lane),
                local: self.lanes.first_position.get(lane),
            }),
            normal: DVec3::from_array(self.lanes.first_normal.get(lane).map(f64::from)),
        })
    }

    /// The surface on which the present stretch of the path of `lane` began, if it began on one.
    #[must_use]
    pub fn excluded(&self, lane: usize) -> Option<SurfaceId> {
        let event = self.lanes.event[lane];
        self.left[lane].filter(|left| left.event == event).map(|left| left.id)
    }

    /// The departure of the path of `lane` from a surface on which it stands.
    fn departure(&self, lane: usize, id: SurfaceId) -> Departure {
        let returns = self.surfaces.is_met_again(&self.ray(lane), id);
        Departure { id, event: self.lanes.event[lane], returns }
    }

    fn place(&self, lane: usize) -> GridPosition {
        GridPosition {
            cell: self.lanes.cell_of(lane).to_array(),
            local: self.lanes.position.get(lane),
        }
    }

    fn direction(&self, lane: usize) -> DVec3 {
        DVec3::from_array(self.lanes.direction.get(lane).map(f64::from)).normalize()
    }

    /// The quantisation of the grid, for callers that convert places.
    #[must_use]
    pub fn quantisation(&self) -> Quantisation {
        self.grid.quantisation
    }
}

/// A direction rounded to single precision, which the kernels keep at unit length.
fn unit_f32(direction: DVec3) -> [f32; 3] {
    direction.to_array().map(|v| v as f32)
}
