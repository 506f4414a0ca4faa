//! Exact light that goes on as the proxy while it is deep in the snow.
//!
//! A path that arrives at a grain deep in the snow, after some, goes on from sphere to sphere met at random until it leaves the deep
//! cells. Where it does it is in air, and flies on among the real grains. A place that lies in one of these is exchanged for one
//! nearby that does not: one grain is like another there.

use super::scattering::Passage;
use super::{Grains, Inside, Medium, MediumKind};
use crate::light::Lights;
use crate::transport::deep::Scale;
use crate::world::World;
use core::f64::consts::TAU;
use snowgrain_accel::{GrainVisit, Interior, SimdLevel, SurfaceShape};
use snowgrain_math::sampler::{PathKey, numbers};
use snowgrain_math::{DAffine3, DVec3, Ray, trig};

/// When a path goes on as the proxy.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ProxyStart {
    /// Grains that it meets exactly before, at least.
    pub after_grains: u32,
    /// Distance from open air and surfaces at least, transport lengths.
    pub depth: f64,
}

/// Mean depth of the place where a ray that strikes a sphere somewhere enters it, before its centre, radii.
const MEAN_ENTRY: f64 = 2.0 / 3.0;
/// How far off, in radii, a place in air is looked for.
const NEARBY: f64 = 2.0;
/// Places that are tried before the path meets another grain instead.
const TRIES: u32 = 64;

/// Snow that is met as the proxy where it is deep.
#[derive(Clone, Debug)]
pub struct ProxyInDepth {
    medium: Medium,
    pub(in super::super) interior: Interior,
    pub(in super::super) after_grains: u32,
    /// Steps in which is looked where a ray leaves the deep cells, metres.
    step: f64,
}

/// A path that has left the deep cells.
#[derive(Clone, Copy, Debug)]
pub(in super::super) struct Emerged {
    /// Where it is, in air, and where it goes.
    pub(in super::super) ray: Ray,
    /// Length in ice since it went in, metres.
    pub(in super::super) ice_length: f64,
    /// Grains since, but for the first.
    pub(in super::super) grain_visits: u32,
    /// Its next random event.
    pub(in super::super) event: u32,
}

impl ProxyInDepth {
    /// The snow of a world, as [`Medium::new`]; cells of a quarter of a transport length. `None` where no snow is deep.
    #[must_use]
    pub fn new(
        (world, shapes): (&World, &[(SurfaceShape, DAffine3)]),
        lights: &Lights,
        start: &ProxyStart,
    ) -> Option<Self> {
        let Scale { transport_length, .. } = Scale::of(world, &[], SimdLevel::detect())?;
        let cell = 0.25;
        let rings = (start.depth / cell).ceil() as u32;
        let interior = world.grid.interior(cell * transport_length, rings);
        if !interior.has_deep() {
            return None;
        }
        let medium = Medium::new(MediumKind::Proxy, (world, shapes), (lights, false))?;
        let step = 0.25 * world.grid.cell_edges().min_element();
        Some(Self { medium, interior, after_grains: start.after_grains, step })
    }

    /// Memory, bytes.
    #[must_use]
    pub fn memory_bytes(&self) -> u64 {
        self.medium.memory_bytes() + self.interior.memory_bytes()
    }

    /// Follows a path from its arrival at a grain until it leaves the deep cells.
    pub(in super::super) fn follow(
        &self,
        world: &World,
        key: PathKey,
        visit: &GrainVisit,
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
            ice_length: 0.0,
            grain_visits: 0,
        };
        let entry = world.grid.world(visit.center) - direction * (MEAN_ENTRY * radius);
        let mut ray = deep.scatter(Ray::new(entry, direction), radius, 1.0);
        loop {
            let (place, met) = deep.fly(&ray);
            if let Some(grains) = met {
                let radius = self.medium.matter(place).radius();
                ray = deep.scatter(Ray::new(place, ray.direction), radius, grains);
                continue;
            }
            let radius = self.medium.matter(place).radius();
            if let Some(place) = deep.in_air_near(place, radius) {
                let DeepPath { ice_length, grain_visits, event, .. } = deep;
                let ray = Ray::new(place, ray.direction);
                return Emerged { ray, ice_length, grain_visits: grain_visits - 1, event };
            }
            ray = deep.scatter(Ray::new(place, ray.direction), radius, 1.0);
        }
    }
}

/// A path between its arrival and its leaving.
struct DeepPath<'a> {
    proxy: &'a ProxyInDepth,
    grains: &'a Grains,
    world: &'a World,
    key: PathKey,
    event: u32,
    ice_length: f64,
    grain_visits: u32,
}

impl DeepPath<'_> {
    fn random(&mut self) -> [f64; 3] {
        self.event += 1;
        numbers(self.key, self.event - 1).map(f64::from)
    }

    /// From a meeting to where the path leaves the grain.
    fn scatter(&mut self, arrival: Ray, radius: f64, grains: f64) -> Ray {
        let [a, b, c] = self.random();
        let [turn, count, _] = self.random();
        let scattering = &self.grains.scattering;
        let Passage { direction, displacement, length, .. } =
            scattering.sample(arrival.direction, [a, b, c, turn]);
        self.ice_length += length * radius * grains;
        self.grain_visits += (grains + count).floor() as u32;
        Ray::new(arrival.origin + displacement * radius, direction)
    }

    /// Where a path meets its next grain, with how many that stands for, or leaves the deep cells.
    fn fly(&mut self, ray: &Ray) -> (DVec3, Option<f64>) {
        let proxy = self.proxy;
        let grains = self.grains;
        let met = proxy.medium.free_flight(grains, ray, f64::INFINITY, || self.random());
        let end = met.map_or(f64::INFINITY, |(t, _)| t);
        let mut t = 0.0;
        while t < end {
            if !self.is_deep(ray.at(t)) {
                return (ray.at(t), None);
            }
            t += proxy.step;
        }
        (ray.at(end), met.map(|(_, grains)| grains))
    }

    fn is_deep(&self, place: DVec3) -> bool {
        self.proxy.interior.is_deep(self.world.grid.locate(place).cell)
    }

    /// The place, or one nearby that is not in ice.
    fn in_air_near(&mut self, place: DVec3, radius: f64) -> Option<DVec3> {
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
