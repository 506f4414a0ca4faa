//! Exact light that goes on as the proxy while it is deep in the snow.
//!
//! A path that arrives at a grain deep in the snow, after some, goes on from sphere to sphere met at random until it leaves the deep
//! cells. Where it does it is in air, and flies on among the real grains. A place that lies in one of these is exchanged for one
//! nearby that does not: one grain is like another there.
//!
//! Where it has room it may jump from sphere to sphere ([`super::shells`]), as the same proxy does grain by grain.

use super::deep_light::Looking;
use super::grains::{Grains, Meeting};
use super::reach::Reach;
use super::shells::{Jump, Shells};
use super::uniform_numbers;
use super::{Calibration, Inside, Medium, MediumKind, SnowyWorld, darkness};
use crate::light::Lights;
use crate::transport::deep::Scale;
use crate::transport::ice::IceLength;
use crate::world::World;
use core::convert::Infallible;
use core::f64::consts::TAU;
use snowgrain_accel::{GrainVisit, GrainsBefore, Interior, SimdLevel};
use snowgrain_geometry::Shape;
use snowgrain_math::sampler::PathKey;
use snowgrain_math::{DVec3, Ray, trig};

/// When a path goes on as the proxy.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ProxyStart {
    /// Grains that it meets exactly before, at least.
    pub after_grains: u32,
    /// Distance from open air and surfaces at least, transport lengths.
    pub depth: f64,
    /// Whether it jumps over spheres of uniform snow.
    pub jumps: bool,
}

/// How far off, in radii, a place in air is looked for.
const NEARBY: f64 = 2.0;
/// Places that are tried before the path meets another grain instead.
const TRIES: u32 = 64;

/// Snow that is met as the proxy where it is deep.
#[derive(Clone, Debug)]
pub struct ProxyInDepth {
    pub(super) medium: Medium,
    /// Nodes around which it stays the proxy: deep cells, and holes in them, which are there by chance.
    deep: Reach,
    shells: Option<Shells>,
    pub(in super::super) interior: Interior,
    pub(in super::super) after: GrainsBefore,
    /// Steps in which is looked where a ray leaves the deep cells, metres.
    step: f64,
}

/// A path that has left the deep cells.
#[derive(Clone, Copy, Debug)]
pub(in super::super) struct Emerged {
    /// Where it is, in air, and where it goes.
    pub(in super::super) ray: Ray,
    /// Length in ice since it went in.
    pub(in super::super) ice: IceLength,
    /// Grains since, but for the first.
    pub(in super::super) grain_visits: u32,
    /// Its next random event.
    pub(in super::super) event: u32,
    /// Whether small lights were looked for where it was last turned.
    pub(in super::super) looked: bool,
}

impl ProxyInDepth {
    /// The snow of a world, as [`Medium::new`], of which `calibrate` makes one with a calibration; cells of a quarter of a
    /// transport length. `looks` for small lights, or waits for paths to meet them. `None` where no snow is deep.
    ///
    /// # Errors
    /// Those of `calibrate`.
    pub fn new<E>(
        (world, shapes, prototypes): SnowyWorld<'_>,
        (lights, looks): (&Lights, bool),
        start: &ProxyStart,
        calibrate: impl FnOnce(Medium) -> Result<Medium, E>,
    ) -> Result<Option<Self>, E> {
        let Some(Scale { transport_length, .. }) =
            Scale::of(world, prototypes, SimdLevel::detect())
        else {
            return Ok(None);
        };
        let cell = 0.25;
        let rings = (start.depth / cell).ceil() as u32;
        let interior = world.grid.interior(cell * transport_length, rings);
        if !interior.has_deep() {
            return Ok(None);
        }
        let snowy = (world, shapes, prototypes);
        let Some(medium) = Medium::new(MediumKind::Proxy, snowy, (lights, looks)) else {
            return Ok(None);
        };
        let medium = calibrate(medium)?;
        let is_deep = |place| interior.is_deep(world.grid.locate(place).cell);
        let far = start.depth * transport_length;
        let deep = medium.nodes_where(is_deep, far, &world.surfaces);
        let shells = if start.jumps { Shells::new(&medium, &deep) } else { None };
        let step = 0.25 * interior.edges().min_element();
        let after = GrainsBefore::everywhere(start.after_grains);
        Ok(Some(Self { medium, deep, shells, interior, after, step }))
    }

    /// The grains of a world without surfaces, which have these shapes, if any, to be measured: in the dark.
    #[must_use]
    pub fn in_the_dark(
        (world, prototypes): (&World, &[Shape]),
        start: &ProxyStart,
        table: &[Calibration],
    ) -> Option<Self> {
        let calibrate = |medium: Medium| Ok::<_, Infallible>(medium.calibrated(table));
        let Ok(proxy) = Self::new((world, &[], prototypes), (&darkness(), false), start, calibrate);
        proxy
    }

    /// Memory, bytes.
    #[must_use]
    pub fn memory_bytes(&self) -> u64 {
        let shells = self.shells.as_ref().map_or(0, Shells::memory_bytes);
        let deep = self.deep.memory_bytes() + self.interior.memory_bytes();
        self.medium.memory_bytes() + deep + shells
    }

    /// Follows a path from its arrival at a grain until it leaves the deep cells, and looks for small lights where those are looked
    /// for.
    pub(in super::super) fn follow(
        &self,
        world: &World,
        key: PathKey,
        visit: &GrainVisit,
        looking: Option<Looking<'_>>,
    ) -> Emerged {
        let direction = DVec3::from_array(visit.direction.map(f64::from)).normalize();
        let radius = f64::from(visit.radius) * world.grid.quantum();
        let Inside::Grains(grains) = &self.medium.inside else {
            unreachable!("the proxy meets grains")
        };
        let mut deep = DeepPath {
            proxy: self,
            grains,
            world,
            key,
            event: visit.event,
            ice: IceLength::default(),
            grain_visits: 0,
            looking,
            looked: false,
        };
        let center = world.grid.world(visit.center);
        let mut ray = deep.pass(Ray::new(center, direction), radius, true);
        loop {
            ray = deep.jump(ray);
            match deep.fly(&ray) {
                Flown::Met(met) => {
                    ray = deep.go_on(Ray::new(ray.at(met.t), ray.direction), &met);
                    continue;
                }
                Flown::Out(place) => {
                    if let Some(place) = deep.in_air_near(place, radius) {
                        let DeepPath { ice, grain_visits, event, looked, .. } = deep;
                        let (ray, grain_visits) =
                            (Ray::new(place, ray.direction), grain_visits - 1);
                        return Emerged { ray, ice, grain_visits, event, looked };
                    }
                    ray = deep.pass(Ray::new(place, ray.direction), radius, false);
                }
            }
        }
    }
}

/// How a flight between grains ends.
enum Flown {
    /// At the next.
    Met(Meeting),
    /// Here, beyond the deep cells.
    Out(DVec3),
}

/// A path between its arrival and its leaving.
pub(super) struct DeepPath<'a> {
    pub(super) proxy: &'a ProxyInDepth,
    pub(super) grains: &'a Grains,
    world: &'a World,
    pub(super) key: PathKey,
    pub(super) event: u32,
    pub(super) ice: IceLength,
    grain_visits: u32,
    /// Where it looks for small lights.
    pub(super) looking: Option<Looking<'a>>,
    /// Whether it did so where it was last turned.
    pub(super) looked: bool,
}

impl DeepPath<'_> {
    fn random(&mut self) -> [f64; 3] {
        self.event += 1;
        uniform_numbers(self.key, self.event - 1)
    }

    /// Through a grain that is met, or around whose centre the arrival is told.
    fn pass(&mut self, arrival: Ray, radius: f64, is_center: bool) -> Ray {
        let numbers = self.random();
        let met = self.grains.meeting_of(&self.proxy.medium.density, &arrival, radius, numbers);
        let entry = met.passage.entry.filter(|_| is_center).unwrap_or(DVec3::ZERO) * radius;
        self.go_on(Ray::new(arrival.origin + entry, arrival.direction), &met)
    }

    /// From a meeting to where the path leaves the grain.
    fn go_on(&mut self, arrival: Ray, met: &Meeting) -> Ray {
        self.look(arrival.origin, met);
        self.ice += self.proxy.medium.ice_of(met);
        self.grain_visits += 1;
        Ray::new(arrival.origin + met.passage.displacement * met.radius, met.passage.direction)
    }

    /// Over spheres as long as there is room.
    fn jump(&mut self, mut ray: Ray) -> Ray {
        let Self { proxy, grains, .. } = *self;
        let Some(shells) = &proxy.shells else { return ray };
        loop {
            let room = grains
                .uniform_room(&proxy.medium.density, ray.origin)
                .min(self.deep_room(ray.origin));
            let Some(shell) = shells.within(room) else { return ray };
            let [which, turn, _] = self.random();
            let Jump { displacement, direction, ice_length, grain_visits } =
                shell.jump(grains, ray.direction, [which, turn]);
            ray = Ray::new(ray.origin + displacement, direction);
            self.looked = false;
            self.ice += grains.shared(ice_length, |kind| proxy.medium.composition.stratum(kind));
            self.grain_visits += grain_visits;
        }
    }

    /// To the next grain, or to where the path leaves the deep cells.
    fn fly(&mut self, ray: &Ray) -> Flown {
        let Self { proxy, grains, .. } = *self;
        let density = &proxy.medium.density;
        let met = grains.meeting(density, ray, f64::INFINITY, || self.random());
        let end = met.map_or(f64::INFINITY, |met| met.t);
        let t = self.leaves_deep(ray, end);
        match met {
            Some(met) if t >= end => Flown::Met(met),
            _ => Flown::Out(ray.at(t)),
        }
    }

    /// How far along a ray it leaves the deep cells, in steps; `end` if that is nearer.
    pub(super) fn leaves_deep(&self, ray: &Ray, end: f64) -> f64 {
        let mut t = self.deep_room(ray.origin);
        while t < end && self.is_deep(ray.at(t)) {
            t += self.proxy.step;
        }
        t.min(end)
    }

    /// How far around a place all is deep, as far as nodes tell, metres.
    fn deep_room(&self, place: DVec3) -> f64 {
        let ProxyInDepth { medium: Medium { density, .. }, deep, .. } = self.proxy;
        deep.near(density, density.coordinates(place)).max(0.0) * density.shortest_edge()
    }

    fn is_deep(&self, place: DVec3) -> bool {
        let ProxyInDepth { medium: Medium { density, .. }, deep, .. } = self.proxy;
        deep.holds(density, density.coordinates(place))
    }

    /// The place, or one nearby that is not in ice.
    pub(super) fn in_air_near(&mut self, place: DVec3, radius: f64) -> Option<DVec3> {
        let mut tried = place;
        for _ in 0..TRIES {
            if !self.world.grid.is_inside_grain(tried) {
                return Some(tried);
            }
            let [u, v, w] = self.random();
            let height = 2.0 * u - 1.0;
            let across = (1.0 - height * height).max(0.0).sqrt();
            let (sin, cos) = trig::sin_cos(TAU * v);
            let off = DVec3::new(across * cos, height, across * sin);
            tried = place + off * (NEARBY * radius * trig::cbrt(w));
        }
        None
    }
}
