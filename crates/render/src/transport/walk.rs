//! Drives a [`Flight`]: fills its lanes from a source and answers its events.

mod deep;

use super::deep::Deep;
use super::ice::IceLength;
use super::seek::{Bounce, Met, PathState, Seeker, Trail};
use super::{
    Contribution, FirstHit, MAX_BOUNCES_WITHOUT_LOSS, NewPath, PathEnd, PathResult, PathSource,
    ROULETTE_THRESHOLD, further_number,
};
use crate::World;
use crate::description::DirectView;
use crate::surface::Scatterer;
use snowgrain_accel::flight::LANES;
use snowgrain_accel::flight::Travelled;
use snowgrain_accel::{Flight, FlightEvent, GrainVisit, STRATA, SimdLevel, SurfaceHit, SurfaceId};
use snowgrain_math::sampler::{PathKey, numbers};
use snowgrain_math::{DVec3, Ray, frame};

/// What the walk keeps of a path beside its lane in the flight.
#[derive(Clone, Copy)]
struct Walker<Tag> {
    tag: Tag,
    key: PathKey,
    start_event: u32,
    /// What it did before it last entered the flight, where it went through the snow in another way.
    before: Before,
    throughput: [f32; 3],
    surface_bounces: u32,
    releases: u32,
    first_hit: Option<FirstHit>,
}

/// What a path did before its lane in the flight began to count.
#[derive(Clone, Copy, Default)]
struct Before {
    ice: IceLength,
    air_length: f64,
    grain_visits: u32,
    interface_events: u32,
}

impl<Tag> Walker<Tag> {
    fn state(&self) -> PathState {
        let Self { key, throughput, before, .. } = self;
        PathState { key: *key, throughput: *throughput, ice_before: before.ice }
    }
}

/// Traces every path of `source` through `world`; light is found where a path escapes.
pub fn trace<Source: PathSource>(world: &World, level: SimdLevel, source: &mut Source) {
    trace_with((world, world.eta), level, (None, None), source);
}

/// As [`trace`], among grains of the relative index `eta`; light is looked for on the way, and paths may end deep in
/// the snow, where there is what that needs. Both are given back.
pub(crate) fn trace_with<'a, Source: PathSource>(
    (world, eta): (&'a World, f64),
    level: SimdLevel,
    (seeker, deep): (Option<Seeker<'a>>, Option<Deep<'a>>),
    source: &mut Source,
) -> (Option<Seeker<'a>>, Option<Deep<'a>>) {
    let mut flight = Flight::new(&world.grid, &world.surfaces, eta, level);
    if seeker.is_some() {
        flight.note_visits();
    }
    if let Some(deep) = &deep {
        flight.watch_deep(deep.watch());
    }
    let trails = || std::array::from_fn(|_| Trail::default());
    let search = seeker.map(|seeker| Search { seeker, trails: trails() });
    let lanes = flight.lanes();
    let mut walk = Walk {
        world,
        flight,
        walkers: [None; LANES],
        search,
        deep,
        visits: Vec::new(),
        found: Vec::new(),
        in_use: lanes,
    };
    for lane in 0..lanes {
        walk.refill(lane, source);
    }
    let mut events = Vec::with_capacity(lanes);
    loop {
        walk.flight.advance(&mut events);
        if !walk.take_arrivals() && events.is_empty() {
            return (walk.search.map(|search| search.seeker), walk.deep);
        }
        for (lane, event) in events.drain(..) {
            walk.answer(lane, event, source);
        }
        walk.close_ranks();
    }
}

struct Walk<'a, Tag> {
    world: &'a World,
    flight: Flight<'a>,
    walkers: [Option<Walker<Tag>>; LANES],
    search: Option<Search<'a>>,
    deep: Option<Deep<'a>>,
    /// Arrivals at grains.
    visits: Vec<GrainVisit>,
    /// Light that a path found, where none is looked for on the way.
    found: Vec<Contribution>,
    /// All paths are in the first lanes.
    in_use: usize,
}

/// Where light is looked for.
struct Search<'a> {
    seeker: Seeker<'a>,
    /// Of each lane.
    trails: [Trail; LANES],
}

impl<Tag: Copy> Walk<'_, Tag> {
    /// Looks for light where paths have arrived since the last time, and notes what is learnt from; whether
    /// any has arrived.
    fn take_arrivals(&mut self) -> bool {
        if self.search.is_none() && self.deep.is_none() {
            return false;
        }
        self.flight.take_visits(&mut self.visits);
        let (walkers, visits) = (&self.walkers, &self.visits);
        let state = |lane: usize| {
            let walker = walkers[lane].as_ref().expect("a lane that arrives has a walker");
            walker.state()
        };
        if let Some(Deep::Learn(learner)) = &mut self.deep {
            visits.iter().for_each(|visit| learner.note(visit, &state(visit.lane)));
        }
        if let Some(Search { seeker, trails }) = &mut self.search {
            seeker.at_grains(visits, trails, state);
        }
        let any = !visits.is_empty();
        self.visits.clear();
        any
    }

    /// Starts paths in `lane` until one is under way in the grid or the source is dry.
    fn refill<Source: PathSource<Tag = Tag>>(&mut self, lane: usize, source: &mut Source) {
        while let Some(NewPath { tag, ray, key, event }) = source.next_path() {
            if let Some(search) = &mut self.search {
                search.trails[lane].begin(source.view(tag), ray.direction);
            }
            if let Some(Deep::Learn(learner)) = &mut self.deep {
                learner.begin(lane);
            }
            self.walkers[lane] = Some(Walker {
                tag,
                key,
                start_event: event,
                before: Before::default(),
                throughput: [1.0; 3],
                surface_bounces: 0,
                releases: 0,
                first_hit: None,
            });
            self.flight.launch(lane, key, event);
            match self.travel_outside(lane, ray, None, true) {
                None => return,
                Some(end) => self.finish(lane, end, source),
            }
        }
        self.flight.retire(lane);
    }

    /// When the source is dry, moves the last paths into the lanes that became free, so that the
    /// flight has fewer lanes to look at.
    fn close_ranks(&mut self) {
        for lane in 0..self.in_use {
            while self.in_use > lane && self.walkers[self.in_use - 1].is_none() {
                self.in_use -= 1;
            }
            if lane >= self.in_use {
                break;
            }
            if self.walkers[lane].is_none() {
                let last = self.in_use - 1;
                self.walkers[lane] = self.walkers[last].take();
                if let Some(search) = &mut self.search {
                    search.trails.swap(lane, last);
                }
                if let Some(Deep::Learn(learner)) = &mut self.deep {
                    learner.relocate(last, lane);
                }
                self.flight.relocate(last, lane);
            }
        }
        self.flight.use_lanes(self.in_use);
    }

    fn answer<Source: PathSource<Tag = Tag>>(
        &mut self,
        lane: usize,
        event: FlightEvent,
        source: &mut Source,
    ) {
        let end = match event {
            FlightEvent::Trapped => {
                self.release(lane);
                None
            }
            FlightEvent::Left => {
                let ray = self.flight.ray(lane);
                self.travel_outside(lane, ray, self.flight.excluded(lane), false)
            }
            FlightEvent::Deep(visit) if let Some(Deep::Proxy(proxy)) = self.deep => {
                self.go_deep(proxy, &visit);
                None
            }
            FlightEvent::Deep(visit) => {
                self.finish_deep(&visit, source);
                return self.refill(lane, source);
            }
            FlightEvent::Surface(hit) => match self.scatter(lane, &hit, self.flight.ray(lane)) {
                Err(end) => Some(end),
                Ok(ray) => {
                    let event = self.flight.travelled(lane).event;
                    self.flight.bounce(lane, ray.direction, hit.id, event);
                    None
                }
            },
        };
        if let Some(end) = end {
            self.finish(lane, end, source);
            self.refill(lane, source);
        }
    }

    /// Follows a ray outside the box of the grains: off surfaces, until it enters the box (`None`)
    /// or ends. A ray that has just left the box cannot meet it again (`may_enter` false).
    fn travel_outside(
        &mut self,
        lane: usize,
        mut ray: Ray,
        mut excluded: Option<SurfaceId>,
        mut may_enter: bool,
    ) -> Option<PathEnd> {
        // A surface at the very face of the box is met before the box is entered.
        let tolerance = self.world.grid.quantum();
        loop {
            let surface = if self.world.surfaces.is_empty() {
                None
            } else {
                self.world.surfaces.intersect(&ray, f64::INFINITY, excluded)
            };
            let grid = if may_enter { self.world.grid.enter(&ray) } else { None };
            match (surface, grid) {
                (None, None) => return Some(PathEnd::Escaped(ray)),
                (hit, Some((t, place))) if hit.is_none_or(|hit| t < hit.t - tolerance) => {
                    let surfaces = &self.world.surfaces;
                    let still_on_it =
                        |id: &SurfaceId| t == 0.0 || !surfaces.is_met_again(&ray, *id);
                    let excluded = excluded.filter(still_on_it);
                    self.flight.enter(lane, place, ray.direction, excluded);
                    return None;
                }
                (Some(hit), _) => {
                    let arrival = Ray::new(ray.at(hit.t), ray.direction);
                    match self.scatter(lane, &hit, arrival) {
                        Err(end) => return Some(end),
                        Ok(next) => ray = next,
                    }
                    excluded = Some(hit.id);
                    may_enter = true;
                }
                (None, Some(_)) => unreachable!("a ray without a surface ahead enters the grid"),
            }
        }
    }

    /// Lets a path that circles in ice out of the grain where it stands. It has lost nothing, and
    /// would have come out in some direction: any choice that is independent of where the light is
    /// keeps the balance of energy, which ending the path would not.
    fn release(&mut self, lane: usize) {
        let walker = self.walkers[lane].as_mut().expect("a lane with an event has a walker");
        walker.releases += 1;
        let event = self.flight.travelled(lane).event;
        let [_, u, v] = numbers(walker.key, event);
        let outward = self.flight.outward(lane);
        let direction = frame::cosine_hemisphere(outward, [f64::from(u), f64::from(v)]);
        self.flight.release(lane, direction, event + 1);
    }

    /// What a surface does to a path that arrives: the next ray, or how the path ends.
    fn scatter(&mut self, lane: usize, hit: &SurfaceHit, arrival: Ray) -> Result<Ray, PathEnd> {
        let position = arrival.origin;
        let visits = self.flight.travelled(lane).grain_visits;
        let walker = self.walkers[lane].as_mut().expect("a lane with an event has a walker");
        let is_first = visits + walker.before.grain_visits == 0 && walker.surface_bounces == 0;
        let object = hit.id.object as usize;
        if let Some(Some(emitter)) = self.world.emitters.get(object) {
            if is_first && !emitter.visible_to_camera {
                return Ok(arrival);
            }
            if is_first {
                walker.first_hit = Some(FirstHit {
                    position,
                    normal: hit.normal,
                    albedo: [0.0; 3],
                    is_shadow_catcher: false,
                });
            }
            return Err(if emitter.shines_towards(hit.normal) {
                PathEnd::Emitted {
                    light: emitter.light,
                    position,
                    normal: hit.normal,
                    direction: arrival.direction,
                }
            } else {
                PathEnd::Absorbed
            });
        }
        let event = self.flight.travelled(lane).event;
        let material = &self.world.materials[object];
        if is_first && material.direct_view() == DirectView::Holdout {
            return Err(PathEnd::Absorbed);
        }
        let scatterer = material.scatterer(hit, position, arrival.direction);
        if is_first {
            let albedo = scatterer.guide();
            let is_shadow_catcher = material.direct_view() == DirectView::ShadowCatcher;
            walker.first_hit =
                Some(FirstHit { position, normal: hit.normal, albedo, is_shadow_catcher });
        }
        walker.surface_bounces += 1;
        let (key, [u0, u1, u2]) = (walker.key, numbers(walker.key, event));
        self.flight.set_event(lane, event + 1);
        self.look_at_surface(lane, hit, position, (scatterer, event));
        let third = || further_number(key, event);
        let Some(scattered) = scatterer.sample([u1, u2].map(f64::from), third) else {
            return Err(PathEnd::Absorbed);
        };
        let walker = self.walkers[lane].as_mut().expect("a lane with an event has a walker");
        for (throughput, weight) in walker.throughput.iter_mut().zip(scattered.weight) {
            *throughput *= weight;
        }
        let [r, g, b] = walker.throughput;
        let largest = r.max(g).max(b);
        if largest < ROULETTE_THRESHOLD {
            let survival = largest / ROULETTE_THRESHOLD;
            if u0 >= survival {
                return Err(PathEnd::Absorbed);
            }
            walker.throughput = walker.throughput.map(|t| t / survival);
        }
        if walker.surface_bounces >= MAX_BOUNCES_WITHOUT_LOSS {
            return Err(PathEnd::Enclosed);
        }
        Ok(Ray::new(position, scattered.direction))
    }

    /// Looks for light at a surface, where light is looked for.
    fn look_at_surface(
        &mut self,
        lane: usize,
        hit: &SurfaceHit,
        position: DVec3,
        (scatterer, event): (Scatterer, u32),
    ) {
        let Some(Search { seeker, trails }) = &mut self.search else { return };
        let walker = self.walkers[lane].as_ref().expect("a lane with an event has a walker");
        let travelled = self.flight.travelled(lane);
        let in_strata = self.flight.ice_in_strata(lane);
        let ice = IceLength { all: travelled.ice_length, in_strata };
        let bounce = Bounce {
            lane,
            position,
            scatterer,
            surface: hit.id,
            in_ice: self.flight.is_in_ice(lane),
            event,
            grain_visits: travelled.grain_visits,
            ice: walker.before.ice + ice,
        };
        seeker.at_surface(&bounce, trails, &walker.state());
    }

    fn finish<Source: PathSource<Tag = Tag>>(
        &mut self,
        lane: usize,
        end: PathEnd,
        source: &mut Source,
    ) {
        let travelled = self.flight.travelled(lane);
        let (walker, result) = self.result(lane, end, travelled, self.flight.ice_in_strata(lane));
        let met = match end {
            PathEnd::Escaped(ray) => Some(Met::Infinity(ray.direction)),
            PathEnd::Emitted { light, position, normal, direction } => {
                Some(Met::Surface { light, position, normal, direction })
            }
            PathEnd::Absorbed | PathEnd::Enclosed | PathEnd::Deep(_) => None,
        };
        let found = match (&mut self.search, &self.deep) {
            (None, None) => return source.finish(walker.tag, &result),
            (Some(Search { seeker, trails }), _) => {
                let trail = &mut trails[lane];
                if let Some(met) = met {
                    seeker.at_end(trail, met, &result);
                }
                &trail.contributions
            }
            (None, Some(deep)) => {
                let Some(lights) = deep.lights() else { return source.finish(walker.tag, &result) };
                self.found.clear();
                Deep::at_end(lights, &result, &mut self.found);
                &self.found
            }
        };
        if let Some(Deep::Learn(learner)) = &mut self.deep {
            learner.learn(lane, found);
        }
        source.finish_with_light(walker.tag, &result, found);
    }

    /// What the path of a lane met first.
    fn first_hit(&self, lane: usize) -> Option<FirstHit> {
        let walker = self.walkers[lane].as_ref().expect("a lane that ends has a walker");
        walker.first_hit.or_else(|| {
            self.flight.first_grain(lane).map(|grain| FirstHit {
                position: grain.position,
                normal: grain.normal,
                albedo: [1.0; 3],
                is_shadow_catcher: false,
            })
        })
    }

    /// What became of the path of a lane, which is free then.
    fn result(
        &mut self,
        lane: usize,
        end: PathEnd,
        travelled: Travelled,
        ice_in_strata: [f64; STRATA],
    ) -> (Walker<Tag>, PathResult) {
        let first_hit = self.first_hit(lane);
        let walker = self.walkers[lane].take().expect("a lane that ends has a walker");
        let before = walker.before;
        let ice = before.ice + IceLength { all: travelled.ice_length, in_strata: ice_in_strata };
        let events = before.interface_events + (travelled.event - walker.start_event);
        let interface_events = events - walker.surface_bounces - walker.releases;
        let result = PathResult {
            end,
            throughput: walker.throughput,
            ice_length: ice.all,
            ice_in_strata: ice.in_strata,
            air_length: before.air_length + travelled.air_length,
            grain_visits: before.grain_visits + travelled.grain_visits,
            interface_events,
            surface_bounces: walker.surface_bounces,
            releases: walker.releases,
            first_hit,
        };
        (walker, result)
    }
}
