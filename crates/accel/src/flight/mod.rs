//! Light among grains, many paths at a time.
//!
//! [`Flight`] keeps up to 64 paths in the air, in one of three ways: among packed spheres (`blocks`), in a
//! perfect lattice of spheres (`crystal`), or among packed grains of any shape (`shapes`). What the kernels cannot decide comes back as a
//! [`FlightEvent`]: the path left the grid, met a surface, or seems trapped. The caller answers
//! with [`Flight::launch`], [`Flight::bounce`] or [`Flight::retire`].

mod blocks;
mod crystal;
mod deep_watch;
mod meeting;
mod probe;
pub(crate) mod random;
mod shapes;
mod sphere;
pub(crate) mod vector;
mod visit;

use crate::grain_grid::{GridPosition, Storage};
use crate::{GrainGrid, STRATA, SimdLevel, SurfaceHit, SurfaceId, Surfaces};
pub use deep_watch::{DeepAnswer, DeepWatch, GrainsBefore};
pub use probe::{MetGrain, Passage, Probe, ProbeAnswer, Probes};
pub use shapes::{Chain, LEAST_WEIGHT, MOST_INTERFACES, Outgoing, chain};
pub use visit::{ArrivalFrom, GrainVisit, ShapedArrival};

use blocks::BlockFlight;
use crystal::CrystalFlight;
use fearless_simd::Level;
use shapes::ShapeFlight;
use snowgrain_math::sampler::PathKey;
use snowgrain_math::{DVec3, Ray};

/// Paths in flight on one core, at most: enough that the memory that some wait for arrives while the others
/// are worked on.
pub const LANES: usize = 64;

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
    /// It arrived at a grain deep in the snow ([`Flight::watch_deep`]), and cannot go on.
    Deep(GrainVisit),
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

/// Up to 64 paths among the grains of one grid. See the module's page.
#[derive(Debug)]
pub struct Flight<'a> {
    grid: &'a GrainGrid,
    level: Level,
    engine: Engine<'a>,
}

#[derive(Debug)]
enum Engine<'a> {
    Blocks(BlockFlight<'a>),
    Crystal(CrystalFlight<'a>),
    Shapes(ShapeFlight<'a>),
}

/// Calls a method that all engines have.
macro_rules! each {
    ($engine:expr, $flight:ident => $call:expr) => {
        match $engine {
            Engine::Blocks($flight) => $call,
            Engine::Crystal($flight) => $call,
            Engine::Shapes($flight) => $call,
        }
    };
}

impl<'a> Flight<'a> {
    /// No path in flight. `eta` is the relative index of the grains, > 0.
    ///
    /// # Panics
    /// If the machine does not have `level`.
    #[must_use]
    pub fn new(grid: &'a GrainGrid, surfaces: &'a Surfaces, eta: f64, level: SimdLevel) -> Self {
        let engine = match (grid.shapes(), grid.storage()) {
            (Some(shapes), _) => Engine::Shapes(ShapeFlight::new(grid, shapes, surfaces, eta)),
            (None, Storage::Sites(sites)) => Engine::Crystal(CrystalFlight::new(sites, eta)),
            (None, Storage::Packed(_) | Storage::Lattice(_)) => {
                Engine::Blocks(BlockFlight::new(grid, surfaces, eta))
            }
        };
        let level = level.token().expect("the SIMD level was checked when it was chosen");
        Self { grid, level, engine }
    }

    /// Paths that are best in flight at once, at most [`LANES`].
    #[must_use]
    pub fn lanes(&self) -> usize {
        match self.engine {
            Engine::Blocks(_) | Engine::Crystal(_) => LANES,
            Engine::Shapes(_) => shapes::LANES,
        }
    }

    /// Makes `lane`, below [`Self::lanes`], the lane of a new path whose next random event is `event`; [`Self::enter`] then
    /// puts it into the grid.
    #[inline]
    pub fn launch(&mut self, lane: usize, key: PathKey, event: u32) {
        each!(&mut self.engine, flight => flight.launch(lane, key, event));
    }

    /// Puts the path of `lane` into the grid: in air at `place`, along the unit vector
    /// `direction`, having left the surface `excluded`.
    #[inline]
    pub fn enter(
        &mut self,
        lane: usize,
        place: GridPosition,
        direction: DVec3,
        excluded: Option<SurfaceId>,
    ) {
        match &mut self.engine {
            Engine::Blocks(flight) => flight.enter(lane, place, direction, excluded),
            // No surface crosses a crystal.
            Engine::Crystal(flight) => flight.enter(lane, place, direction),
            Engine::Shapes(flight) => flight.enter(lane, place, direction, excluded),
        }
    }

    /// Lets the path of `lane`, which circles in ice, leave where it stands along `direction`, its
    /// next random event being `event`.
    pub fn release(&mut self, lane: usize, direction: DVec3, event: u32) {
        match &mut self.engine {
            Engine::Blocks(flight) => flight.release(lane, direction, event),
            Engine::Shapes(flight) => flight.release(lane, direction, event),
            Engine::Crystal(_) => no_such_event(),
        }
    }

    /// Outward unit normal of the grain that the path of `lane`, which circles in ice, is in, at the
    /// end of its chord.
    pub fn outward(&mut self, lane: usize) -> DVec3 {
        match &self.engine {
            Engine::Blocks(flight) => flight.outward(lane),
            Engine::Shapes(flight) => flight.outward(lane),
            Engine::Crystal(_) => no_such_event(),
        }
    }

    /// Sends a path that stands at a surface on along `direction`, in the medium in which it came;
    /// its next random event is `event`.
    pub fn bounce(&mut self, lane: usize, direction: DVec3, surface: SurfaceId, event: u32) {
        match &mut self.engine {
            Engine::Blocks(flight) => flight.bounce(lane, direction, surface, event),
            Engine::Shapes(flight) => flight.bounce(lane, direction, surface, event),
            Engine::Crystal(_) => no_such_event(),
        }
    }

    /// Tells that the caller has used the random events before `event`.
    pub fn set_event(&mut self, lane: usize, event: u32) {
        each!(&mut self.engine, flight => flight.set_event(lane, event));
    }

    /// Ends the path of `lane`.
    #[inline]
    pub fn retire(&mut self, lane: usize) {
        each!(&mut self.engine, flight => flight.retire(lane));
    }

    /// Moves the path of lane `from` to the free lane `to`.
    pub fn relocate(&mut self, from: usize, to: usize) {
        each!(&mut self.engine, flight => flight.relocate(from, to));
    }

    /// Tells that only the first `lanes` lanes hold paths, so that a few last paths do not cost as
    /// much as all.
    pub fn use_lanes(&mut self, lanes: usize) {
        each!(&mut self.engine, flight => flight.use_lanes(lanes));
    }

    /// Lets all paths travel until at least one needs its caller; adds `(lane, event)` of each that
    /// does to `events`, none if no path is in flight.
    #[inline]
    pub fn advance(&mut self, events: &mut Vec<(usize, FlightEvent)>) {
        each!(&mut self.engine, flight => flight.advance(self.level, events));
    }

    /// Notes arrivals at grains from now on: [`Self::advance`] also returns when there are many, and
    /// they are to be taken before its events are answered.
    ///
    /// # Panics
    /// In a lattice of grains apart that stores nothing: build it by [`GrainGrid::lattice_in_cells`].
    pub fn note_visits(&mut self) {
        match &mut self.engine {
            Engine::Shapes(flight) => flight.note_visits(),
            Engine::Blocks(_) | Engine::Crystal(_) => self.blocks().note_visits(),
        }
    }

    /// Stops paths that arrive deep in the snow from now on, or notes these arrivals (from air).
    ///
    /// # Panics
    /// As [`Self::note_visits`].
    pub fn watch_deep(&mut self, watch: DeepWatch<'a>) {
        match &mut self.engine {
            Engine::Shapes(flight) => flight.watch_deep(watch),
            Engine::Blocks(_) | Engine::Crystal(_) => self.blocks().watch_deep(watch),
        }
    }

    /// Moves the arrivals since the last call to `visits`, in the order of each path.
    pub fn take_visits(&mut self, visits: &mut Vec<GrainVisit>) {
        match &mut self.engine {
            Engine::Shapes(flight) => flight.take_visits(visits),
            Engine::Blocks(_) | Engine::Crystal(_) => self.blocks().take_visits(visits),
        }
    }

    /// Whether the path of `lane`, which stands at a surface, is in ice.
    #[must_use]
    pub fn is_in_ice(&self, lane: usize) -> bool {
        match &self.engine {
            Engine::Blocks(flight) => flight.is_in_ice(lane),
            Engine::Shapes(flight) => flight.is_in_ice(lane),
            Engine::Crystal(_) => false,
        }
    }

    /// The ray along which the path of `lane` travels, from where it stands (metres): in a grid that
    /// repeats, as far from where it entered the first period as it has come.
    #[inline]
    #[must_use]
    pub fn ray(&self, lane: usize) -> Ray {
        let (place, direction, beyond) = match &self.engine {
            Engine::Shapes(flight) => return flight.ray(lane),
            Engine::Blocks(flight) => {
                let beyond = self.grid.beyond_first_period(flight.periods(lane));
                (flight.place(lane), flight.direction(lane), beyond)
            }
            Engine::Crystal(flight) => {
                let beyond = flight.beyond_first_period(lane) * self.grid.quantum();
                (flight.place(lane), flight.direction(lane), beyond)
            }
        };
        let direction = DVec3::from_array(direction.map(f64::from)).normalize();
        Ray::new(self.grid.world(place) + beyond, direction)
    }

    /// Length in ice of grains of each stratum from 1 on that the path of `lane` has travelled, metres.
    #[inline]
    #[must_use]
    pub fn ice_in_strata(&self, lane: usize) -> [f64; STRATA] {
        match &self.engine {
            Engine::Blocks(flight) if !self.grid.strata().is_empty() => {
                flight.ice_in_strata(lane, self.grid.quantum())
            }
            Engine::Shapes(flight) => flight.ice_in_strata(lane, self.grid.quantum()),
            Engine::Blocks(_) | Engine::Crystal(_) => [0.0; STRATA],
        }
    }

    /// What the path of `lane` has done so far.
    #[inline]
    #[must_use]
    pub fn travelled(&self, lane: usize) -> Travelled {
        let quantum = self.grid.quantum();
        each!(&self.engine, flight => flight.travelled(lane, quantum))
    }

    /// The first grain that the path of `lane` met, if it met one.
    #[inline]
    #[must_use]
    pub fn first_grain(&self, lane: usize) -> Option<FirstGrain> {
        match &self.engine {
            Engine::Blocks(flight) => flight.first_grain(lane, |place| self.grid.world(place)),
            Engine::Crystal(flight) => flight.first_grain(lane, |place| self.grid.world(place)),
            Engine::Shapes(flight) => flight.first_grain(lane),
        }
    }

    /// The surface on which the present stretch of the path of `lane` began, if it began on one.
    #[inline]
    #[must_use]
    pub fn excluded(&self, lane: usize) -> Option<SurfaceId> {
        match &self.engine {
            Engine::Blocks(flight) => flight.excluded(lane),
            Engine::Shapes(flight) => flight.excluded(lane),
            Engine::Crystal(_) => None,
        }
    }

    /// The engine that notes arrivals at grains.
    fn blocks(&mut self) -> &mut BlockFlight<'a> {
        match &mut self.engine {
            Engine::Blocks(flight) => flight,
            Engine::Crystal(_) | Engine::Shapes(_) => unreachable!("no arrivals are noted there"),
        }
    }
}

/// No surface crosses a crystal, and light circles in none of its grains.
fn no_such_event() -> ! {
    unreachable!("no such event occurs in a crystal")
}
