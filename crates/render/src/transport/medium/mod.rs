//! Snow as a medium: light that meets grains at random in a smoothed density, instead of the grains themselves.
//!
//! Three ways through it ([`MediumKind`]) are here to be compared with light that meets every grain, and to stand for it where that
//! is exact enough:
//!
//! - *Volume*: what volume path tracing does with snow. Grains are points that are met after exponential lengths, sigma = 3 phi / (4 r),
//!   and refract light by the phase function of Bohren and Barkstrom ([`snowgrain_optics::BohrenBarkstrom`]); any number of
//!   times.
//! - *Proxy*: between grains a path is free for the mean chord of the void, 4 r (1 - phi) / (3 phi), then strikes a sphere at a random
//!   place of its disc and goes on from where the closed form lets it out, so that grains take room. What real grains differ by, in
//!   chords and in grains met, is measured for each solid fraction ([`CALIBRATION`]).
//!
//! - *Dipole*: what fast renderers do. The snow has the surface of the smoothed density, from where light that falls on it
//!   diffuses (`dipole`).
//!
//! Surfaces are met as ever. Lights are found where a path escapes; small ones are looked for at every grain and rough surface.

mod calibration;
mod density;
mod depth;
mod dipole;
mod irradiance;
mod light;
mod scattering;
mod skin;
mod walk;

pub use calibration::{CALIBRATION, Calibration};
pub use depth::{ProxyInDepth, ProxyStart};
pub(crate) use walk::trace_in_medium;

use crate::light::{Lights, LitSurfaces};
use crate::surface::Place;
use crate::world::World;
use density::{Density, Matter};
use dipole::Dipole;
use light::SmallLights;
use scattering::Scattering;
use skin::SURFACE_LEVEL;
use snowgrain_accel::SurfaceShape;
use snowgrain_math::{Aabb, DAffine3, DVec3, Ray, trig};

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

/// Greatest solid fraction: where grains overlap, their volumes may add to more than there is room.
const MOST_SOLID: f64 = 0.9;

/// What a path meets of the snow.
#[derive(Clone, Debug)]
enum Inside {
    Grains(Grains),
    /// Its surface, where the area of discs by volume is so large, and what leaves it.
    Skin(f64, Option<Dipole>),
}

/// Grains that are met at random.
#[derive(Clone, Debug)]
struct Grains {
    /// Meetings by length, 1/m, and grains that each stands for: at each node of the density; and the most meetings.
    meetings: Vec<[f32; 2]>,
    most: f64,
    scattering: Scattering,
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
        let density = Density::new(&world.grid, &world.surfaces, &places)?;
        let inside = match Scattering::new(kind, world.eta) {
            Some(scattering) => Inside::Grains(Grains::new(&density, scattering, calibration)),
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
        let nothing = LitSurfaces::new(Vec::new(), &[]);
        let dark = Lights::new(&[], &nothing, [0.0; 3], &Aabb::EMPTY);
        Self::calibrated(kind, (world, &[]), (&dark, false), calibration)
    }

    /// Memory, bytes.
    #[must_use]
    pub fn memory_bytes(&self) -> u64 {
        self.density.memory_bytes()
            + match &self.inside {
                Inside::Grains(grains) => size_of_val(grains.meetings.as_slice()) as u64,
                Inside::Skin(_, glow) => glow.as_ref().map_or(0, Dipole::memory_bytes),
            }
    }

    /// Whether the snow lets a ray pass as far as this, metres; `random` gives uniform numbers.
    fn is_open(&self, ray: &Ray, far: f64, random: impl FnMut() -> [f64; 3]) -> bool {
        match &self.inside {
            Inside::Grains(grains) => self.free_flight(grains, ray, far, random).is_none(),
            Inside::Skin(level, _) => self.density.surface_on(ray, far, *level).is_none(),
        }
    }

    /// Where a ray meets a grain before `far`, metres, and how many grains it stands for; `random` gives uniform numbers.
    ///
    /// Tracking by the greatest extinction (Woodcock et al. 1965), at one node drawn by its weight instead of the mean of
    /// eight: it accepts as often.
    fn free_flight(
        &self,
        grains: &Grains,
        ray: &Ray,
        far: f64,
        mut random: impl FnMut() -> [f64; 3],
    ) -> Option<(f64, f64)> {
        let (mut t, end) = self.density.bounds.intersect(ray)?;
        let end = end.min(far);
        loop {
            let [length, chance, node] = random();
            t -= trig::ln(1.0 - length) / grains.most;
            if t >= end {
                return None;
            }
            let [meetings, each] = grains.meetings[self.density.node_near(ray.at(t), node)];
            if chance * grains.most < f64::from(meetings) {
                return Some((t, f64::from(each)));
            }
        }
    }

    /// The matter at a point within the bounds.
    fn matter(&self, point: DVec3) -> Matter {
        self.density.at(point)
    }
}

impl Grains {
    fn new(density: &Density, scattering: Scattering, calibration: &[Calibration]) -> Self {
        let at_node = |matter| meetings(&scattering, matter, calibration).map(|value| value as f32);
        let meetings: Vec<[f32; 2]> = density.nodes().map(at_node).collect();
        let most = meetings.iter().map(|meetings| meetings[0]).fold(0.0, f32::max);
        Self { meetings, most: f64::from(most), scattering }
    }
}

/// Meetings by length, 1/m, and grains that each stands for.
fn meetings(scattering: &Scattering, matter: Matter, calibration: &[Calibration]) -> [f64; 2] {
    match scattering {
        Scattering::Refracted(_) => [matter.area, 1.0],
        Scattering::Sphere(_) => {
            let solid = matter.solid.min(MOST_SOLID);
            let Calibration { chord, grains, .. } = Calibration::at(calibration, solid);
            [matter.area / ((1.0 - solid) * chord), grains]
        }
    }
}

#[cfg(test)]
mod tests;
