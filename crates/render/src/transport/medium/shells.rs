//! Jumps through uniform snow: over the largest sphere around a place in which there is nothing else.
//!
//! Where light that starts at the centre of a sphere leaves it, in which direction and after how much ice, depends on nothing but
//! the direction in which it starts. So for spheres of a few radii many such ways are followed once, grain by grain, and a path
//! that has room for a sphere takes one of them, turned at random about its direction (Moon, Walter and Marschner 2007,
//! "Rendering Discrete Random Media Using Precomputed Scattering Solutions", EGSR, do so with functions fitted to grains). Nothing is
//! fitted: a way has its own length in ice.

use super::grains::{Grains, UniformGrains};
use super::reach::Reach;
use super::{Inside, Medium, uniform_numbers};
use rayon::prelude::*;
use snowgrain_math::sampler::PathKey;
use snowgrain_math::{DVec3, frame};

/// Radii of the spheres in mean free paths: powers of two from here on.
const LEAST: f64 = 4.0;
/// Spheres at most.
const SHELLS: u32 = 6;
/// Mean free paths beyond a sphere that must be room, too, where small lights are looked for: nothing looks within it, so that light which
/// came from its last grains to one unhindered would be met by chance, seldom and bright.
const BEYOND: f64 = 8.0;
/// Ways through each. Their mean length in ice is off by a part in 200 for the least sphere, less for larger ones.
const WAYS: u32 = 1 << 15;
/// Of their random numbers.
const SEED: u64 = 0x5e11_5eed;

/// Ways out of spheres of uniform snow, from the least on.
#[derive(Clone, Debug)]
pub(super) struct Shells {
    shells: Vec<Shell>,
    /// Room beyond a sphere, metres.
    beyond: f64,
}

/// Ways out of a sphere.
#[derive(Clone, Debug)]
pub(super) struct Shell {
    /// Metres.
    radius: f64,
    ways: Vec<WayOut>,
}

/// How light leaves a sphere, told along the direction in which it started at the centre, aside, and across both.
#[derive(Clone, Copy, Debug, PartialEq)]
struct WayOut {
    /// Place, metres: nothing of it is across.
    place: [f32; 2],
    /// Unit direction.
    direction: [f32; 3],
    /// Length in ice, metres.
    ice_length: f32,
    grain_visits: u32,
}

/// What a jump does to a path.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Jump {
    /// From where it was to where it is, metres.
    pub(super) displacement: DVec3,
    /// Unit direction.
    pub(super) direction: DVec3,
    /// Length in ice, metres: of grains of all kinds.
    pub(super) ice_length: f64,
    pub(super) grain_visits: u32,
}

impl Shells {
    /// Spheres that have room in a part of the uniform snow of a medium; `None` where it has no such snow, or its grains lie so that
    /// light of one direction fares otherwise than that of another.
    pub(super) fn new(medium: &Medium, part: &Reach) -> Option<Self> {
        let Inside::Grains(grains) = &medium.inside else { return None };
        if grains.scattering.lies() {
            return None;
        }
        let uniform = grains.uniform.as_ref()?;
        let beyond = if medium.small.is_some() { BEYOND * uniform.free_path } else { 0.0 };
        let room = (part.most() - 2.0) * medium.density.shortest_edge() - beyond;
        let radius = |shell: u32| LEAST * f64::from(1 << shell) * uniform.free_path;
        let shells = (0..SHELLS).filter(|&shell| radius(shell) <= room).map(|shell| {
            let (radius, of) = (radius(shell), u64::from(shell));
            let way = |index: u32| {
                let key = PathKey::new(SEED, u64::from(index), of);
                WayOut::follow((grains, uniform), radius, key)
            };
            Shell { radius, ways: (0..WAYS).into_par_iter().map(way).collect() }
        });
        Some(Self { shells: shells.collect(), beyond })
    }

    /// Memory, bytes.
    pub(super) fn memory_bytes(&self) -> u64 {
        self.shells.iter().map(|shell| size_of_val(shell.ways.as_slice()) as u64).sum()
    }

    /// The largest sphere that has room, metres.
    #[inline]
    pub(super) fn within(&self, room: f64) -> Option<&Shell> {
        self.shells.iter().rev().find(|shell| shell.radius + self.beyond <= room)
    }
}

impl Shell {
    /// A way out, by two uniform numbers.
    #[inline]
    pub(super) fn jump(&self, grains: &Grains, direction: DVec3, [which, turn]: [f64; 2]) -> Jump {
        let way = &self.ways[(which * f64::from(WAYS)) as usize];
        let aside = grains.across(direction, turn);
        let across = direction.cross(aside);
        let [x, y, z] = way.direction.map(f64::from);
        let [along, beside] = way.place.map(f64::from);
        Jump {
            displacement: direction * along + aside * beside,
            direction: (direction * x + aside * y + across * z).normalize(),
            ice_length: f64::from(way.ice_length),
            grain_visits: way.grain_visits,
        }
    }
}

impl WayOut {
    fn follow((grains, uniform): (&Grains, &UniformGrains), radius: f64, key: PathKey) -> Self {
        let start = DVec3::Y;
        let (mut place, mut direction) = (DVec3::ZERO, start);
        let (mut ice_length, mut grain_visits) = (0.0, 0);
        for event in 0.. {
            let met = grains.meeting_in_uniform(uniform, direction, uniform_numbers(key, event));
            let along = place.dot(direction);
            let inside = (radius * radius - place.length_squared()).max(0.0);
            let out = (along * along + inside).sqrt() - along;
            if met.t >= out {
                place += direction * out;
                break;
            }
            place += direction * met.t + met.passage.displacement * met.radius;
            direction = met.passage.direction;
            ice_length += met.passage.length * met.radius;
            grain_visits += 1;
            if place.length_squared() >= radius * radius {
                break;
            }
        }
        let beside = place - start * place.dot(start);
        let aside = beside.try_normalize().unwrap_or_else(|| frame::tangents(start).0);
        let across = start.cross(aside);
        Self {
            place: [place.dot(start) as f32, place.dot(aside) as f32],
            direction: [start, aside, across].map(|axis| direction.dot(axis) as f32),
            ice_length: ice_length as f32,
            grain_visits,
        }
    }
}
