//! Snow as a medium: light that meets grains at random in a smoothed density, instead of the grains themselves.
//!
//! Two ways through it ([`MediumKind`]) are here to be compared with light that meets every grain, and to stand for it where that
//! is exact enough:
//!
//! - *Volume*: what volume path tracing does with snow. Grains are points that are met after exponential lengths, sigma = 3 phi / (4 r),
//!   and refract light by the phase function of Bohren and Barkstrom ([`snowgrain_optics::BohrenBarkstrom`]); any number of
//!   times.
//! - *Proxy*: between grains a path is free for the mean chord of the void, 4 r (1 - phi) / (3 phi), then strikes a sphere at a random
//!   place of its disc and goes on from where the closed form lets it out, so that grains take room. One number for each solid
//!   fraction is measured ([`CALIBRATION`]).
//!
//! Surfaces are met as ever. Lights are found where a path escapes; small ones are looked for at every grain and rough surface.

mod density;
mod light;
mod scattering;
mod walk;

pub(crate) use walk::trace_in_medium;

use crate::light::Lights;
use crate::surface::Place;
use crate::world::World;
use density::{Density, Matter};
use light::SmallLights;
use scattering::Scattering;
use snowgrain_accel::SurfaceShape;
use snowgrain_math::{DAffine3, DVec3, Ray, trig};

/// How a path goes through the medium.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum MediumKind {
    /// From point to point, refracted.
    Volume,
    /// From sphere to sphere.
    Proxy,
}

/// By how much more often than chords of the void tell a path of the proxy meets a grain, less one, over the solid fraction: so that
/// it visits as many grains as light does. Measured by `cargo xtask roads`: see docs/roads.md.
pub const CALIBRATION: f64 = 0.11;

/// Greatest solid fraction: where grains overlap, their volumes may add to more than there is room.
const MOST_SOLID: f64 = 0.9;

/// The snow of a world as a medium, and how lights are found in it.
#[derive(Clone, Debug)]
pub struct Medium {
    density: Density,
    /// Grains met by length, 1/m: at each node of the density, and the most of them.
    extinction: Vec<f32>,
    most: f64,
    scattering: Scattering,
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
        let places: Vec<Place> = shapes.iter().map(Place::new).collect();
        let density = Density::new(&world.grid, &world.surfaces, &places)?;
        let extinction: Vec<f32> =
            density.nodes().map(|matter| extinction(kind, matter) as f32).collect();
        let most = extinction.iter().copied().fold(0.0, f32::max);
        Some(Self {
            density,
            extinction,
            most: f64::from(most),
            scattering: Scattering::new(kind, world.eta),
            lights: lights.clone(),
            small: looks.then(|| SmallLights::of(lights)).flatten(),
        })
    }

    /// Memory, bytes.
    #[must_use]
    pub fn memory_bytes(&self) -> u64 {
        self.density.memory_bytes() + size_of_val(self.extinction.as_slice()) as u64
    }

    /// Where a ray meets a grain before `far`, metres; `random` gives uniform numbers (tracking by the greatest
    /// extinction: Woodcock et al. 1965).
    fn free_flight(
        &self,
        ray: &Ray,
        far: f64,
        mut random: impl FnMut() -> [f64; 2],
    ) -> Option<f64> {
        let (mut t, end) = self.density.bounds.intersect(ray)?;
        let end = end.min(far);
        loop {
            let [length, chance] = random();
            t -= trig::ln(1.0 - length) / self.most;
            if t >= end {
                return None;
            }
            if chance * self.most < self.density.mean_of(&self.extinction, ray.at(t)) {
                return Some(t);
            }
        }
    }

    /// The matter at a point within the bounds.
    fn matter(&self, point: DVec3) -> Matter {
        self.density.at(point)
    }
}

/// Grains met by length, 1/m.
fn extinction(kind: MediumKind, matter: Matter) -> f64 {
    match kind {
        MediumKind::Volume => matter.area,
        MediumKind::Proxy => {
            let solid = matter.solid.min(MOST_SOLID);
            matter.area * (1.0 + CALIBRATION * solid) / (1.0 - solid)
        }
    }
}

#[cfg(test)]
mod tests;
