//! How lights are found in a medium: small ones are looked for, the others are met where a path escapes.

use super::Inside;
use super::scattering::{Passage, Scattering};
use super::uniform_numbers;
use super::walk::MediumPath;
use crate::light::{LightSample, Lights};
use crate::surface::Scatterer;
use crate::transport::ice::IceLength;
use crate::transport::{Contribution, PathEnd};
use core::f64::consts::PI;
use snowgrain_accel::SurfaceId;
use snowgrain_math::sampler::{PathKey, split_mix};
use snowgrain_math::{DVec3, Ray};

/// What tells the random numbers of a search from those of its path.
const SEARCH: u64 = 0x3ed1_u64 << 32;

/// The lights that are looked for.
#[derive(Clone, Debug)]
pub(super) struct SmallLights {
    /// They alone, and the others alone; the indices are those of all lights.
    pub(super) sought: Lights,
    others: Lights,
    is_sought: Vec<bool>,
}

impl SmallLights {
    /// Of lights that paths hardly meet by chance; `None` where there are none.
    pub(super) fn of(lights: &Lights) -> Option<Self> {
        let is_sought: Vec<bool> = (0..lights.count())
            .map(|light| lights.is_point(light) || lights.is_small(light))
            .collect();
        is_sought.contains(&true).then(|| Self {
            sought: lights.select(|light| is_sought[light]),
            others: lights.select(|light| !is_sought[light]),
            is_sought,
        })
    }
}

/// Random numbers of what is looked for at one event of a path.
pub(super) struct SearchNumbers {
    key: PathKey,
    event: u32,
}

impl SearchNumbers {
    pub(super) fn new(key: PathKey, event: u32) -> Self {
        let word = u64::from(key.hi) << 32 | u64::from(key.lo);
        let mixed = split_mix(word ^ SEARCH ^ split_mix(u64::from(event)));
        Self { key: PathKey { lo: mixed as u32, hi: (mixed >> 32) as u32 }, event: 0 }
    }

    pub(super) fn next(&mut self) -> [f64; 3] {
        self.event += 1;
        uniform_numbers(self.key, self.event - 1)
    }
}

impl MediumPath<'_> {
    /// Looks for light at a grain that is met at `position`, by the direction from which a passage turns the path and the kind of what
    /// turns it.
    pub(super) fn look_at_grain(
        &mut self,
        position: DVec3,
        &Passage { turned_from: direction, kind, .. }: &Passage,
        (scattering, radius): (&Scattering, f64),
    ) {
        let Some(small) = &self.medium.small else { return };
        self.looked = true;
        let mut random = SearchNumbers::new(self.key, self.event);
        let Some(sample) = small.sought.sample(position, random.next()) else { return };
        let [which, place, _] = random.next();
        let towards = scattering.towards(direction, sample.direction, (kind, [which, place]));
        let Some((density, passage)) = towards else { return };
        let through = passage.displacement * radius;
        if self.hides(position, through) {
            return;
        }
        let weight = density / sample.pdf;
        let stratum = self.medium.composition.stratum(kind);
        let ice = IceLength::of(passage.length * radius, stratum);
        self.book((position + through, None), &sample, ([1.0; 3], weight), ice, random);
    }

    /// Looks for light that falls on a point of the snow's surface; what is booked is the irradiance over pi.
    pub(super) fn look_from_skin(&mut self, position: DVec3, normal: DVec3) {
        let Some(small) = &self.medium.small else { return };
        self.looked = true;
        let mut random = SearchNumbers::new(self.key, self.event);
        let Some(sample) = small.sought.sample(position, random.next()) else { return };
        let cosine = normal.dot(sample.direction);
        if cosine > 0.0 {
            let weight = ([1.0; 3], cosine / (PI * sample.pdf));
            self.book((position, None), &sample, weight, IceLength::default(), random);
        }
    }

    /// Looks for light at a surface; a smooth one has no way to it, and light is then met by chance.
    pub(super) fn look_at_surface(
        &mut self,
        position: DVec3,
        surface: SurfaceId,
        scatterer: &Scatterer,
    ) {
        let Some(small) = &self.medium.small else { return };
        self.looked = !scatterer.is_smooth();
        if !self.looked {
            return;
        }
        let mut random = SearchNumbers::new(self.key, self.event);
        let Some(sample) = small.sought.sample(position, random.next()) else { return };
        let (colour, value) = scatterer.value(sample.direction);
        if value > 0.0 {
            let weight = (colour, value / sample.pdf);
            self.book((position, Some(surface)), &sample, weight, IceLength::default(), random);
        }
    }

    /// Books light that was drawn where neither a surface nor a grain is in its way.
    fn book(
        &mut self,
        (from, excluded): (DVec3, Option<SurfaceId>),
        sample: &LightSample,
        (colour, weight): ([f32; 3], f64),
        more_ice: IceLength,
        mut random: SearchNumbers,
    ) {
        let ray = Ray::new(from, sample.direction);
        let surfaces = &self.world.surfaces;
        if !surfaces.is_empty() {
            let lamp = sample.surface.map(|id| id.object);
            let hit = surfaces.intersect(&ray, sample.distance, excluded);
            if hit.is_some_and(|hit| lamp != Some(hit.id.object)) {
                return;
            }
        }
        let Some(ice) = self.medium.way_through(&ray, sample.distance, || random.next()) else {
            return;
        };
        let ice = self.ice + more_ice + ice;
        let factor: [f64; 3] = std::array::from_fn(|c| {
            f64::from(self.throughput[c]) * f64::from(colour[c]) * f64::from(sample.radiance[c])
        });
        self.found.push(Contribution {
            slot: sample.slot,
            glint: false,
            event: self.event,
            weight: factor.map(|channel| (channel * weight) as f32),
            ice_length: ice.all,
            ice_in_strata: ice.in_strata,
        });
    }

    /// The light of a path that has ended, but for what was looked for.
    pub(super) fn light_at_end(&mut self, end: &PathEnd) {
        let medium = self.medium;
        let (met, small) = match (&medium.small, self.looked) {
            (Some(small), true) => (&small.others, Some(small)),
            (Some(_), false) | (None, _) => (&medium.lights, None),
        };
        let mut radiances = vec![[0.0; 3]; met.slots().len()];
        if let (Some(place), Inside::Skin(_, Some(glow))) = (self.on_skin, &medium.inside) {
            glow.add_radiances(place, &mut radiances);
        }
        match *end {
            PathEnd::Escaped(_) if self.first_hit.is_none() => {}
            PathEnd::Escaped(ray) => met.add_radiances(ray.direction, &mut radiances),
            PathEnd::Emitted { light, .. } if small.is_some_and(|small| small.is_sought[light]) => {
            }
            PathEnd::Emitted { light, .. } => met.add_emission(light, &mut radiances),
            PathEnd::Absorbed | PathEnd::Enclosed | PathEnd::Deep(_) => {}
        }
        let lit = radiances.into_iter().enumerate().filter(|(_, light)| *light != [0.0; 3]);
        let (throughput, ice) = (self.throughput, self.ice);
        self.found.extend(lit.map(|(slot, light)| Contribution {
            slot,
            glint: false,
            event: u32::MAX,
            weight: std::array::from_fn(|c| light[c] * throughput[c]),
            ice_length: ice.all,
            ice_in_strata: ice.in_strata,
        }));
    }
}
