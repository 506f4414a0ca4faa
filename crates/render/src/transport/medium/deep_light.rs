//! Small lights that are looked for where grains are met at random deep in the snow.
//!
//! As far as the deep cells reach the medium hides a light; from there on it is hidden by real grains and surfaces, to which
//! the search for light sends a shadow ray.

use super::depth::DeepPath;
use super::grains::Meeting;
use super::light::SearchNumbers;
use super::scattering::Passage;
use crate::transport::Contribution;
use crate::transport::ice::IceLength;
use snowgrain_math::{DVec3, Ray};

/// What a path brings along that looks for small lights deep in the snow, and where what it finds is put.
pub(in super::super) struct Looking<'a> {
    pub(in super::super) throughput: [f32; 3],
    /// Length in ice before its arrival.
    pub(in super::super) ice_before: IceLength,
    pub(in super::super) found: &'a mut Vec<DeepLight>,
}

/// Light that comes to a grain deep in the snow if nothing is in its way up to there.
pub(in super::super) struct DeepLight {
    pub(in super::super) contribution: Contribution,
    /// From where it leaves the deep cells, in air, towards the light.
    pub(in super::super) ray: Ray,
    /// How far from there the light is, metres, and the object that shines.
    pub(in super::super) distance: f64,
    pub(in super::super) lamp: Option<u32>,
}

impl DeepPath<'_> {
    /// Looks for a small light at a grain that is met, if it turns the path.
    pub(super) fn look(&mut self, position: DVec3, met: &Meeting) {
        let proxy = self.proxy;
        let (Some(small), Some(looking), false) =
            (&proxy.medium.small, &self.looking, met.is_straight)
        else {
            return;
        };
        let (throughput, ice_before) = (looking.throughput, looking.ice_before);
        self.looked = true;
        let mut random = SearchNumbers::new(self.key, self.event);
        let Some(sample) = small.sought.sample(position, random.next()) else { return };
        let [which, place, _] = random.next();
        let Passage { turned_from, kind, .. } = met.passage;
        let scattering = &self.grains.scattering;
        let towards = scattering.towards(turned_from, sample.direction, (kind, [which, place]));
        let Some((density, passage)) = towards else { return };
        let ray = Ray::new(position + passage.displacement * met.radius, sample.direction);
        let leaves = self.leaves_deep(&ray, sample.distance);
        let ice = proxy.medium.way_through(&ray, leaves, || random.next());
        let Some(ice) = ice else { return };
        let Some(place) = self.in_air_near(ray.at(leaves), met.radius) else { return };
        let weight = density / sample.pdf;
        let turning = Meeting { passage: Passage { kind, ..passage }, ..*met };
        let ice = ice_before + self.ice + proxy.medium.ice_of(&turning) + ice;
        let contribution = Contribution {
            slot: sample.slot,
            glint: false,
            event: self.event,
            weight: std::array::from_fn(|c| {
                (f64::from(throughput[c]) * f64::from(sample.radiance[c]) * weight) as f32
            }),
            ice_length: ice.all,
            ice_in_strata: ice.in_strata,
        };
        if let Some(looking) = &mut self.looking {
            looking.found.push(DeepLight {
                contribution,
                ray: Ray::new(place, sample.direction),
                distance: sample.distance - leaves,
                lamp: sample.surface.map(|id| id.object),
            });
        }
    }
}
