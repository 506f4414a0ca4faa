//! Snow as a medium: light that meets grains at random in a smoothed density, instead of the grains themselves.
//!
//! Three ways through it ([`MediumKind`]) are here to be compared with light that meets every grain, and to stand for it where that
//! is exact enough:
//!
//! - *Volume*: what volume path tracing does with snow. Grains are points that are met after exponential lengths, sigma = 3 phi / (4 r),
//!   and refract light by the phase function of Bohren and Barkstrom ([`snowgrain_optics::BohrenBarkstrom`]); any number of
//!   times.
//! - *Proxy*: between grains a path is free for the mean chord of the void, 4 r (1 - phi) / (3 phi), then strikes a sphere at a random
//!   place of its disc and goes on from where the closed form lets it out, so that grains take room (`grains`). Real grains let more light through:
//!   so it passes some of them straight, a part that is measured for each solid fraction ([`CALIBRATION`]).
//!
//! - *Dipole*: what fast renderers do. The snow has the surface of the smoothed density, from where light that falls on it
//!   diffuses (`dipole`).
//!
//! Surfaces are met as ever. Lights are found where a path escapes; small ones are looked for at every grain and rough surface.

mod calibration;
mod density;
mod depth;
mod dipole;
mod grains;
mod irradiance;
mod light;
mod reach;
mod scattering;
mod shells;
mod skin;
mod uniform;
mod walk;

pub use calibration::{CALIBRATION, Calibration};
pub use depth::{ProxyInDepth, ProxyStart};
pub(crate) use walk::trace_in_medium;

use crate::light::{Lights, LitSurfaces};
use crate::surface::Place;
use crate::world::World;
use density::Density;
use dipole::Dipole;
use grains::Grains;
use light::SmallLights;
use reach::Reach;
use scattering::Scattering;
use skin::SURFACE_LEVEL;
use snowgrain_accel::{SurfaceShape, Surfaces};
use snowgrain_math::sampler::{PathKey, numbers};
use snowgrain_math::{Aabb, DAffine3, DVec3, Ray};

/// How a path goes through the medium.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum MediumKind {
    /// From point to point, refracted.
    Volume,
    /// From sphere to sphere.
    Proxy,
    /// From the surface to the surface.
    Dipole,
}

/// What a path meets of the snow.
#[derive(Clone, Debug)]
enum Inside {
    Grains(Grains),
    /// Its surface, where the area of discs by volume is so large, and what leaves it.
    Skin(f64, Option<Dipole>),
}

/// The snow of a world as a medium, and how lights are found in it.
#[derive(Clone, Debug)]
pub struct Medium {
    density: Density,
    inside: Inside,
    lights: Lights,
    small: Option<SmallLights>,
}

impl Medium {
    /// The snow of a world whose objects have these shapes in their order, lamps last. `looks` for small lights, or waits for paths
    /// to meet them. `None` where there are no grains.
    #[must_use]
    pub fn new(
        kind: MediumKind,
        (world, shapes): (&World, &[(SurfaceShape, DAffine3)]),
        (lights, looks): (&Lights, bool),
    ) -> Option<Self> {
        Self::calibrated(kind, (world, shapes), (lights, looks), &CALIBRATION)
    }

    /// As [`Self::new`], with what real grains differ by from spheres met at random: by solid fraction, in rising order.
    #[must_use]
    pub fn calibrated(
        kind: MediumKind,
        (world, shapes): (&World, &[(SurfaceShape, DAffine3)]),
        (lights, looks): (&Lights, bool),
        calibration: &[Calibration],
    ) -> Option<Self> {
        let places: Vec<Place> = shapes.iter().map(Place::new).collect();
        let mut density = Density::new(&world.grid, &world.surfaces, &places)?;
        let inside = match Scattering::new(kind, world.eta) {
            Some(scattering) => Inside::Grains(Grains::new(&mut density, scattering, calibration)),
            None => Inside::Skin(SURFACE_LEVEL * world.grid.extinction(), None),
        };
        Some(Self {
            density,
            inside,
            lights: lights.clone(),
            small: looks.then(|| SmallLights::of(lights)).flatten(),
        })
    }

    /// The spheres of a world without surfaces, to be measured: in the dark.
    #[must_use]
    pub fn in_the_dark(
        kind: MediumKind,
        world: &World,
        calibration: &[Calibration],
    ) -> Option<Self> {
        Self::calibrated(kind, (world, &[]), (&darkness(), false), calibration)
    }

    /// The nodes where this holds, and those of the uniform snow that are so far, metres, from surfaces and from what else there is.
    fn nodes_where(&self, holds: impl Fn(DVec3) -> bool, far: f64, surfaces: &Surfaces) -> Reach {
        let Self { density, inside, .. } = self;
        let uniform = match inside {
            Inside::Grains(grains) => grains.uniform.as_ref(),
            Inside::Skin(..) => None,
        };
        let is_open = |place: DVec3| {
            let ball = Aabb::new(place - density.edges, place + density.edges);
            surfaces.is_empty() || !surfaces.may_cross(&ball)
        };
        let mut marks: Vec<bool> = density.places().map(&holds).collect();
        if let Some(grains) = uniform {
            let open = grains.uniform.reach.marks().zip(density.places());
            let open = Reach::new(density, open.map(|(same, place)| same && is_open(place)));
            let is_far = open.farther_than(far / density.shortest_edge() + 1.0);
            marks.iter_mut().zip(is_far).for_each(|(mark, is_far)| *mark |= is_far);
        }
        Reach::new(density, marks.into_iter())
    }

    /// Between which heights it lies, metres.
    pub(crate) fn heights(&self) -> [f64; 2] {
        let Aabb { min, max } = self.density.bounds;
        [min.y, max.y]
    }

    /// Memory, bytes.
    #[must_use]
    pub fn memory_bytes(&self) -> u64 {
        self.density.memory_bytes()
            + match &self.inside {
                Inside::Grains(grains) => grains.memory_bytes(),
                Inside::Skin(_, glow) => glow.as_ref().map_or(0, Dipole::memory_bytes),
            }
    }

    /// Length in ice on the way of a ray as far as this, metres, if the snow lets it pass; `random` gives uniform numbers.
    fn way_through(
        &self,
        ray: &Ray,
        far: f64,
        mut random: impl FnMut() -> [f64; 3],
    ) -> Option<f64> {
        let grains = match &self.inside {
            Inside::Grains(grains) => grains,
            Inside::Skin(level, _) => {
                return self.density.surface_on(ray, far, *level).is_none().then_some(0.0);
            }
        };
        let (mut from, mut ice) = (0.0, 0.0);
        loop {
            let rest = Ray::new(ray.at(from), ray.direction);
            let Some(met) = grains.meeting(&self.density, &rest, far - from, &mut random) else {
                return Some(ice);
            };
            if !met.is_straight {
                return None;
            }
            from += met.t + met.passage.displacement.dot(ray.direction) * met.radius;
            ice += met.passage.length * met.radius;
        }
    }
}

/// No lights.
fn darkness() -> Lights {
    let nothing = LitSurfaces::new(Vec::new(), &[]);
    Lights::new(&[], &nothing, [0.0; 3], &Aabb::EMPTY)
}

/// The uniform numbers of an event of a path.
#[inline]
fn uniform_numbers(key: PathKey, event: u32) -> [f64; 3] {
    let [x, y, z] = numbers(key, event);
    [f64::from(x), f64::from(y), f64::from(z)]
}

#[cfg(test)]
mod tests;
