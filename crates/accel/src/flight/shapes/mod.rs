//! Light among packed grains of any shape.
//!
//! The bounding spheres of a block say which of its grains a path may meet (SIMD over the grains); each of
//! those is then met exactly, in double precision and in its own space, by one interval for each of its convex
//! parts. The interval decides both entering and leaving, as that of spheres does in `blocks`; ice is the
//! union of all parts. What a path stands on is known by identity: a part that was left is not met again (it
//! is convex), and the face on which a chord begins is not where it ends.

mod air;
mod axes;
mod boarding;
mod body;
mod candidates;
mod chain;
mod ice;
mod interface;
mod lane;
mod near;
mod probe;
mod round;
mod slabs;
mod stretches;
mod visits;

pub use chain::{Chain, LEAST_WEIGHT, MOST_INTERFACES, Outgoing, chain};

pub(super) use probe::ShapeProbes;

use super::deep_watch::{DeepAnswer, DeepWatch};
use super::visit::{ArrivalFrom, GrainVisit, ShapedArrival, VISITS_AT_ONCE};
use super::{FirstGrain, FlightEvent, Travelled};
use crate::grain_grid::{GridPosition, GridShapes, ShapeWord};
use crate::{GrainGrid, STRATA, SurfaceId, Surfaces};
use body::NOWHERE;
use candidates::{Candidates, Kinds, Scratch};
use fearless_simd::{Level, dispatch};
use interface::Interface;
use lane::{BodyPart, Cells, Inside, Lane, Phase};
use snowgrain_math::sampler::{PathKey, numbers};
use snowgrain_math::{DVec3, Ray};
use stretches::Stretches;
use visits::Visits;

/// Paths that move on together, while those of another group wait for memory.
const GROUP: usize = 16;

/// Paths in flight on one core. A visit takes so long that memory arrives while one other group is worked on, and what is
/// known of more of them would not stay in the nearest cache.
pub(super) const LANES: usize = 2 * GROUP;

/// A surface so little behind the end of a chord, quanta, is met before it: two distances from different
/// origins, metres rounded to doubles, are told apart to less.
const SURFACE_FIRST: f64 = 1e-3;

/// Paths in flight among shaped grains.
#[derive(Debug)]
pub(super) struct ShapeFlight<'a> {
    grid: &'a GrainGrid,
    shapes: &'a GridShapes,
    surfaces: &'a Surfaces,
    eta: f64,
    cells: Cells,
    kinds: Kinds<'a>,
    lanes: Box<[Lane; LANES]>,
    /// Of each group, the stretches of its paths in air, and those in grains between parallel faces.
    stretches: Box<[Stretches; LANES / GROUP]>,
    in_grains: Box<[Visits; LANES / GROUP]>,
    /// Of each group, its paths that are followed one by one, in ice.
    in_ice: [u32; LANES / GROUP],
    candidates: Box<[Candidates; LANES / GROUP]>,
    scratch: Box<Scratch>,
    events: Vec<(usize, FlightEvent)>,
    /// Arrivals at grains, where they are noted.
    visits: Option<Vec<GrainVisit>>,
    /// What is done deep in the snow.
    deep: Option<DeepWatch<'a>>,
    /// All paths in flight are in the first lanes.
    in_use: usize,
}

impl<'a> ShapeFlight<'a> {
    pub(super) fn new(
        grid: &'a GrainGrid,
        shapes: &'a GridShapes,
        surfaces: &'a Surfaces,
        eta: f64,
    ) -> Self {
        Self {
            grid,
            shapes,
            surfaces,
            eta,
            cells: Cells::of(grid),
            kinds: Kinds::of(shapes),
            lanes: Box::new([Lane::default(); LANES]),
            stretches: Box::default(),
            in_grains: Box::default(),
            in_ice: [0; LANES / GROUP],
            candidates: Box::default(),
            scratch: Box::default(),
            events: Vec::with_capacity(LANES),
            visits: None,
            deep: None,
            in_use: LANES,
        }
    }

    pub(super) fn launch(&mut self, lane: usize, key: PathKey, event: u32) {
        self.retire(lane);
        self.lanes[lane] = Lane::launched(key, event);
    }

    pub(super) fn enter(
        &mut self,
        index: usize,
        place: GridPosition,
        direction: DVec3,
        excluded: Option<SurfaceId>,
    ) {
        let lane = &mut self.lanes[index];
        lane.cell = place.cell;
        lane.periods = [0; 3];
        lane.offset = DVec3::ZERO;
        lane.origin = DVec3::from_array(place.local.map(f64::from));
        lane.begin_stretch(&self.cells, 0.0, direction);
        lane.left_surface = excluded;
        self.go_on_in_air(index);
        self.fetch_entry(index);
    }

    pub(super) fn release(&mut self, index: usize, direction: DVec3, event: u32) {
        let lane = &mut self.lanes[index];
        lane.event = event;
        lane.begin_stretch(&self.cells, lane.inside.leave, direction);
        lane.leaving = Some(lane.inside.body);
        self.go_on_in_air(index);
        self.fetch_entry(index);
    }

    /// Outward unit normal of the grain that the path of `lane` is in, at the end of its chord.
    pub(super) fn outward(&self, lane: usize) -> DVec3 {
        self.lanes[lane].outward(self.shapes)
    }

    pub(super) fn bounce(
        &mut self,
        index: usize,
        direction: DVec3,
        surface: SurfaceId,
        event: u32,
    ) {
        let lane = &mut self.lanes[index];
        lane.event = event;
        lane.begin_stretch(&self.cells, lane.travelled, direction);
        lane.left_surface = Some(surface);
        if !lane.in_ice {
            self.go_on_in_air(index);
        } else if self.begin_chord(index, NOWHERE) {
            let lane = &mut self.lanes[index];
            lane.seek_cell(&self.cells, lane.inside.leave);
            self.wait_in_ice(index);
        }
        self.fetch_entry(index);
    }

    pub(super) fn set_event(&mut self, lane: usize, event: u32) {
        self.lanes[lane].event = event;
    }

    pub(super) fn retire(&mut self, lane: usize) {
        self.stand_still(lane);
    }

    pub(super) fn relocate(&mut self, from: usize, to: usize) {
        self.lanes[to] = self.lanes[from];
        let ([group, at], [into, place]) = ([from / GROUP, from % GROUP], [to / GROUP, to % GROUP]);
        let source = self.in_grains[group].clone();
        self.in_grains[into].copy(place, &source, at);
        let source = self.stretches[group].clone();
        self.stretches[into].copy(place, &source, at);
        self.in_ice[into] &= !(1 << place);
        self.in_ice[into] |= (self.in_ice[group] >> at & 1) << place;
        self.retire(from);
    }

    pub(super) fn use_lanes(&mut self, lanes: usize) {
        self.in_use = lanes.min(LANES);
    }

    pub(super) fn note_visits(&mut self) {
        self.visits = Some(Vec::with_capacity(2 * VISITS_AT_ONCE));
    }

    pub(super) fn watch_deep(&mut self, watch: DeepWatch<'a>) {
        self.deep = Some(watch);
        if watch.answer == DeepAnswer::Note {
            self.note_visits();
        }
    }

    pub(super) fn take_visits(&mut self, visits: &mut Vec<GrainVisit>) {
        if let Some(noted) = &mut self.visits {
            visits.append(noted);
        }
    }

    /// Notes that a path arrives at the grain that it is about to be in, at `at` of its stretch.
    #[inline(never)]
    fn note(&mut self, index: usize, from: ArrivalFrom, inside: &Inside, at: f64) {
        if self.visits.is_some() {
            let visit = self.visit(index, from, inside, at);
            self.visits.get_or_insert_default().push(visit);
        }
    }

    /// Whether a path that has just arrived at a grain from air is deep in the snow and stops there.
    fn stops_deep(&self, lane: &Lane) -> bool {
        self.deep.is_some_and(|watch| {
            watch.answer == DeepAnswer::Stop && watch.is_deep(lane.visits - 1, lane.cell, lane.key)
        })
    }

    fn visit(&self, index: usize, from: ArrivalFrom, inside: &Inside, at: f64) -> GrainVisit {
        let lane = &self.lanes[index];
        let Inside { body, placement, .. } = inside;
        let place = lane.origin + lane.direction * at;
        let local = (body.center - lane.offset).to_array().map(|x| x as f32);
        GrainVisit {
            lane: index,
            from,
            center: GridPosition { cell: lane.cell, local },
            radius: placement.radius as f32,
            shaped: Some(ShapedArrival {
                shape: ShapeWord::of_slot(body.word).shape(),
                from_center: place - body.center,
            }),
            overlaps: inside.overlaps,
            meets_surface: inside.meets_surface,
            to_middle: (body.center - place).dot(lane.direction) as f32,
            direction: lane.direction.to_array().map(|x| x as f32),
            grain_visits: lane.visits,
            ice_length: lane.ice_length as f32,
            ice_in_strata: lane.ice_in_strata.map(|length| length as f32),
            stratum: inside.stratum,
            event: lane.event,
        }
    }

    /// Lets all paths travel until at least one needs its caller.
    pub(super) fn advance(&mut self, level: Level, events: &mut Vec<(usize, FlightEvent)>) {
        dispatch!(level, simd => self.run(simd));
        events.append(&mut self.events);
    }

    /// The ray along which a path travels, from where it stands, metres.
    pub(super) fn ray(&self, lane: usize) -> Ray {
        let lane = &self.lanes[lane];
        let stretch = lane.stretch(self.grid);
        let beyond = self.grid.beyond_first_period(lane.home_periods);
        Ray::new(stretch.at(lane.travelled * self.grid.quantum()) + beyond, stretch.direction)
    }

    pub(super) fn is_in_ice(&self, lane: usize) -> bool {
        self.lanes[lane].in_ice
    }

    pub(super) fn travelled(&self, lane: usize, quantum: f64) -> Travelled {
        let lane = &self.lanes[lane];
        Travelled {
            ice_length: lane.ice_length * quantum,
            air_length: lane.air_length * quantum,
            grain_visits: lane.visits,
            event: lane.event,
        }
    }

    pub(super) fn ice_in_strata(&self, lane: usize, quantum: f64) -> [f64; STRATA] {
        self.lanes[lane].ice_in_strata.map(|length| length * quantum)
    }

    pub(super) fn first_grain(&self, lane: usize) -> Option<FirstGrain> {
        self.lanes[lane].first.map(|[position, normal]| FirstGrain { position, normal })
    }

    /// The surface on which the present stretch began, unless the stretch has moved on and can meet it again.
    pub(super) fn excluded(&self, lane: usize) -> Option<SurfaceId> {
        let lane = &self.lanes[lane];
        let returns = |id: &SurfaceId| self.surfaces.is_met_again(&lane.stretch(self.grid), *id);
        lane.left_surface.filter(|id| lane.travelled == 0.0 || !returns(id))
    }

    /// Stops a path on the face of its grain, inside.
    #[inline(never)]
    fn stop_in_grain(&mut self, index: usize) {
        let departure = self.in_grains[index / GROUP].departure(index % GROUP);
        self.tell_where_inside(index);
        let lane = &mut self.lanes[index];
        let Inside { body, placement, .. } = &lane.inside;
        lane.origin = body.center + placement.rotation * departure.place * placement.radius;
        lane.travelled = 0.0;
        let direction = placement.rotation * departure.direction;
        lane.begin_stretch(&self.cells, 0.0, direction);
        lane.inside.leave = 0.0;
        self.hand_back(index, &departure);
        self.stop(index, FlightEvent::Trapped);
    }

    /// Stratum of a grain.
    #[inline(always)]
    fn stratum(&self, number: usize, slot: usize) -> u8 {
        self.grid.strata().get(number).map_or(0, |strata| strata[slot])
    }

    /// Takes a path out of flight and tells the caller why.
    fn stop(&mut self, index: usize, event: FlightEvent) {
        self.stand_still(index);
        self.events.push((index, event));
    }

    /// Takes a path out of flight.
    fn stand_still(&mut self, index: usize) {
        self.lanes[index].phase = Phase::Still;
        let (group, at) = (index / GROUP, index % GROUP);
        self.stretches[group].end(at);
        self.in_grains[group].end(at);
        self.in_ice[group] &= !(1 << at);
    }

    /// Lets a path wait for what its cell holds at the end of its chord.
    fn wait_in_ice(&mut self, index: usize) {
        self.lanes[index].phase = Phase::Ice;
        self.in_ice[index / GROUP] |= 1 << (index % GROUP);
    }
}

/// Whether the light of a path passes an interface, by its next random event.
#[inline(always)]
fn passes(lane: &mut Lane, interface: &Interface) -> bool {
    let [u, _, _] = numbers(lane.key, lane.event);
    lane.event += 1;
    interface.lets_pass(f64::from(u))
}
