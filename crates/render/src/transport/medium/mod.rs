//! Snow as a medium: light that meets grains at random in a smoothed density, instead of the grains themselves.
//!
//! Three ways through it ([`MediumKind`]) are here to be compared with light that meets every grain, and to stand for it where that
//! is exact enough:
//!
//! - *Volume*: what volume path tracing does with snow. Grains are points that are met after exponential lengths, sigma = 3 phi / (4 r),
//!   and refract light by the phase function of Bohren and Barkstrom ([`snowgrain_optics::BohrenBarkstrom`]); any number of
//!   times.
//! - *Proxy*: between grains a path is free for the mean chord of the void, 4 r (1 - phi) / (3 phi) of spheres, then strikes a grain at a
//!   random place of its shadow and goes on from where it leaves it, by the closed form of spheres or by samples of a shape
//!   (`shape_passages`), so that grains take room (`grains`). Real grains let more light through: so it passes some of them straight, a part
//!   that is measured for each solid fraction: beforehand for equal spheres of ice ([`CALIBRATION`]), else before the picture
//!   ([`crate::measure::calibrate_proxy`]).
//!
//! - *Dipole*: what fast renderers do. The snow has the surface of the smoothed density, from where light that falls on it
//!   diffuses (`dipole`).
//!
//! Surfaces are met as ever. Lights are found where a path escapes; small ones are looked for at every grain and rough surface.

mod calibration;
mod composition;
mod deep_light;
mod density;
mod depth;
mod dipole;
mod grains;
mod irradiance;
mod light;
mod reach;
mod scattering;
mod shape_passages;
mod shells;
mod skin;
mod uniform;
mod walk;

pub use calibration::{CALIBRATION, Calibration, KNOWN_INDICES};
pub(super) use deep_light::{DeepLight, Looking};
pub use depth::{ProxyInDepth, ProxyStart};
pub(crate) use walk::trace_in_medium;

use super::ice::IceLength;
use crate::light::{Lights, LitSurfaces};
use crate::surface::Place;
use crate::world::World;
use composition::Composition;
use density::Density;
use dipole::Dipole;
use grains::{Grains, Meeting};
use light::SmallLights;
use reach::Reach;
use scattering::Scattering;
use skin::SURFACE_LEVEL;
use snowgrain_accel::{SurfaceShape, Surfaces};
use snowgrain_geometry::Shape;
use snowgrain_grains::{DepositSettings, GrainsError, Radii, ShapeMix};
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

/// Snow as light deep in it meets it, by which the same can be made again.
#[derive(Clone, Debug)]
pub struct InnerSnow {
    /// How it fell; `None` where it is as packs of its solid fraction are.
    pub fell: Option<DepositSettings>,
    /// Volume of its grains by volume.
    pub solid: f64,
    /// Their sizes.
    pub radii: Radii,
    /// Their shapes; `None` where all are spheres.
    pub mix: Option<ShapeMix>,
    /// Their relative index.
    pub eta: f64,
}

impl InnerSnow {
    /// Whether [`CALIBRATION`] is that of its grains: equal spheres of ice in air, as in packs.
    #[must_use]
    pub fn is_known(&self) -> bool {
        let is_equal = matches!(self.radii, Radii::Uniform { variation: 0.0, .. });
        self.fell.is_none() && self.mix.is_none() && is_equal && KNOWN_INDICES.contains(&self.eta)
    }
}

/// A world, the shapes of its objects in their order, lamps last, and those of its grains, if they have any.
pub type SnowyWorld<'a> = (&'a World, &'a [(SurfaceShape, DAffine3)], &'a [Shape]);

/// The snow of a world as a medium, and how lights are found in it.
#[derive(Clone, Debug)]
pub struct Medium {
    density: Density,
    composition: Composition,
    eta: f64,
    inside: Inside,
    lights: Lights,
    small: Option<SmallLights>,
}

impl Medium {
    /// The snow of a world. `looks` for small lights, or waits for paths to meet them. `None` where there are no grains.
    ///
    /// The proxy has the calibration of equal spheres of ice, whatever its grains are: see [`Self::inner_snow`].
    #[must_use]
    pub fn new(
        kind: MediumKind,
        (world, shapes, prototypes): SnowyWorld<'_>,
        (lights, looks): (&Lights, bool),
    ) -> Option<Self> {
        let places: Vec<Place> = shapes.iter().map(Place::new).collect();
        let composition = Composition::new(&world.grid, prototypes);
        let mut density = Density::new(&world.grid, &composition, (&world.surfaces, &places))?;
        let inside = match Scattering::new(kind, &composition, world.eta) {
            Some(scattering) => Inside::Grains(Grains::new(&mut density, scattering)),
            None => Inside::Skin(SURFACE_LEVEL * world.grid.extinction(), None),
        };
        Some(Self {
            density,
            composition,
            eta: world.eta,
            inside,
            lights: lights.clone(),
            small: looks.then(|| SmallLights::of(lights)).flatten(),
        })
    }

    /// The grains of a world without surfaces, which have these shapes, if any, to be measured: in the dark.
    #[must_use]
    pub fn in_the_dark(kind: MediumKind, (world, prototypes): (&World, &[Shape])) -> Option<Self> {
        Self::new(kind, (world, &[], prototypes), (&darkness(), false))
    }

    /// The snow where it is most the same; `fell`, how most of it fell by a rule. `None` where grains are not met as the proxy's.
    ///
    /// # Errors
    /// Sizes without meaning.
    pub fn inner_snow(
        &self,
        fell: Option<DepositSettings>,
    ) -> Result<Option<InnerSnow>, GrainsError> {
        let Inside::Grains(grains) = &self.inside else { return Ok(None) };
        if matches!(grains.scattering, Scattering::Refracted(_)) {
            return Ok(None);
        }
        let uniform = grains.uniform.as_ref().map(|grains| grains.uniform.matter);
        Ok(Some(InnerSnow {
            fell,
            solid: uniform.unwrap_or_else(|| self.density.mean()).solid,
            radii: self.composition.sizes()?,
            mix: self.composition.mix()?,
            eta: self.eta,
        }))
    }

    /// Part of the surface of its grains that is not within others.
    #[must_use]
    pub fn bare_surface(&self) -> f64 {
        self.composition.overlap().surface
    }

    /// The same, with what real grains differ by from grains met at random: by solid fraction, in rising order.
    #[must_use]
    pub fn calibrated(mut self, table: &[Calibration]) -> Self {
        if let Inside::Grains(grains) = &mut self.inside {
            grains.calibrate(table);
        }
        self
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

    /// The ice of a meeting.
    #[inline]
    fn ice_of(&self, met: &Meeting) -> IceLength {
        let stratum = self.composition.stratum(met.passage.kind);
        IceLength::of(met.passage.length * met.radius, stratum)
    }

    /// Length in ice on the way of a ray as far as this, if the snow lets it pass; `random` gives uniform numbers.
    fn way_through(
        &self,
        ray: &Ray,
        far: f64,
        mut random: impl FnMut() -> [f64; 3],
    ) -> Option<IceLength> {
        let grains = match &self.inside {
            Inside::Grains(grains) => grains,
            Inside::Skin(level, _) => {
                return self
                    .density
                    .surface_on(ray, far, *level)
                    .is_none()
                    .then(IceLength::default);
            }
        };
        let (mut from, mut ice) = (0.0, IceLength::default());
        loop {
            let rest = Ray::new(ray.at(from), ray.direction);
            let Some(met) = grains.meeting(&self.density, &rest, far - from, &mut random) else {
                return Some(ice);
            };
            if !met.is_straight {
                return None;
            }
            from += met.t + met.passage.displacement.dot(ray.direction) * met.radius;
            ice += self.ice_of(&met);
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
