//! One path after another through a medium and off surfaces.

use super::grains::{Grains, Meeting};
use super::scattering::Passage;
use super::uniform_numbers;
use super::{Inside, Medium};
use crate::World;
use crate::description::DirectView;
use crate::transport::ice::IceLength;
use crate::transport::{
    Contribution, FirstHit, MAX_BOUNCES_WITHOUT_LOSS, NewPath, PathEnd, PathResult, PathSource,
    ROULETTE_THRESHOLD, further_number,
};
use snowgrain_accel::{SurfaceHit, SurfaceId};
use snowgrain_math::sampler::PathKey;
use snowgrain_math::{DVec3, Ray};

/// Traces every path of `source` through `world`, the snow of which is `medium`.
pub(crate) fn trace_in_medium<Source: PathSource>(
    world: &World,
    medium: &Medium,
    source: &mut Source,
) {
    let mut found = Vec::new();
    while let Some(NewPath { tag, ray, key, event }) = source.next_path() {
        found.clear();
        let mut path = MediumPath::new((world, medium), key, event, &mut found);
        let end = path.follow(ray);
        path.light_at_end(&end);
        let result = path.result(end);
        source.finish_with_light(tag, &result, &found);
    }
}

/// A path on its way.
pub(super) struct MediumPath<'a> {
    pub(super) world: &'a World,
    pub(super) medium: &'a Medium,
    pub(super) key: PathKey,
    /// Its next random event.
    pub(super) event: u32,
    pub(super) throughput: [f32; 3],
    pub(super) ice: IceLength,
    air_length: f64,
    grain_visits: u32,
    surface_bounces: u32,
    pub(super) first_hit: Option<FirstHit>,
    /// Whether small lights were looked for where it last was turned.
    pub(super) looked: bool,
    /// Where it ended on the surface of the snow, if that shines.
    pub(super) on_skin: Option<DVec3>,
    pub(super) found: &'a mut Vec<Contribution>,
}

/// What a path meets of the snow.
enum Met<'a> {
    /// One of the grains.
    Grain(Meeting, &'a Grains),
    /// The surface of it all, so many metres off.
    Skin(f64),
}

impl<'a> MediumPath<'a> {
    /// A path that begins.
    pub(super) fn new(
        (world, medium): (&'a World, &'a Medium),
        key: PathKey,
        event: u32,
        found: &'a mut Vec<Contribution>,
    ) -> Self {
        Self {
            world,
            medium,
            key,
            event,
            throughput: [1.0; 3],
            ice: IceLength::default(),
            air_length: 0.0,
            grain_visits: 0,
            surface_bounces: 0,
            first_hit: None,
            looked: false,
            on_skin: None,
            found,
        }
    }
}

impl MediumPath<'_> {
    pub(super) fn random(&mut self) -> [f64; 3] {
        self.event += 1;
        uniform_numbers(self.key, self.event - 1)
    }

    /// Follows it to its end.
    pub(super) fn follow(&mut self, mut ray: Ray) -> PathEnd {
        let (medium, surfaces) = (self.medium, &self.world.surfaces);
        let mut excluded = None;
        loop {
            let met = match &medium.inside {
                Inside::Grains(grains) => grains
                    .meeting(&medium.density, &ray, f64::INFINITY, || self.random())
                    .map(|met| Met::Grain(met, grains)),
                Inside::Skin(level, _) => {
                    medium.density.surface_on(&ray, f64::INFINITY, *level).map(Met::Skin)
                }
            };
            let far = match &met {
                Some(Met::Grain(met, _)) => met.t,
                Some(Met::Skin(t)) => *t,
                None => f64::INFINITY,
            };
            let hit = match surfaces.is_empty() {
                true => None,
                false => surfaces.intersect(&ray, far, excluded),
            };
            let next = match (hit, met) {
                (Some(hit), _) => {
                    self.air_length += hit.t;
                    self.meet_surface(&hit, Ray::new(ray.at(hit.t), ray.direction))
                }
                (None, Some(Met::Grain(met, grains))) => {
                    self.air_length += met.t;
                    self.meet_grain(grains, Ray::new(ray.at(met.t), ray.direction), &met)
                }
                (None, Some(Met::Skin(t))) => {
                    self.meet_skin(ray.at(t), ray.direction);
                    return PathEnd::Absorbed;
                }
                (None, None) => return PathEnd::Escaped(ray),
            };
            match next {
                Ok(next) => (ray, excluded) = next,
                Err(end) => return end,
            }
        }
    }

    /// A grain lets the path out elsewhere; where a surface lies between, it is met there.
    fn meet_grain(
        &mut self,
        grains: &Grains,
        arrival: Ray,
        met: &Meeting,
    ) -> Result<(Ray, Option<SurfaceId>), PathEnd> {
        let Ray { origin: position, direction } = arrival;
        let Meeting { radius, passage, is_straight, .. } = *met;
        if !is_straight {
            self.look_at_grain(position, &passage, (&grains.scattering, radius));
        }
        self.note_first_grain(position, direction, &passage);
        self.grain_visits += 1;
        let stratum = self.medium.composition.stratum(passage.kind);
        let ice = passage.length * radius;
        let through = passage.displacement * radius;
        let length = through.length();
        if let Some(hit) = self.surface_within(position, through) {
            self.ice += IceLength::of(ice * hit.t / length, stratum);
            let along = through / length;
            return self.meet_surface(&hit, Ray::new(position + along * hit.t, along));
        }
        self.ice += IceLength::of(ice, stratum);
        Ok((Ray::new(position + through, passage.direction), None))
    }

    /// The surface of the snow ends a path with what comes out there.
    fn meet_skin(&mut self, position: DVec3, direction: DVec3) {
        let normal = self.medium.density.outwards(position).try_normalize();
        if self.first_hit.is_none() && self.surface_bounces == 0 {
            let normal = normal.unwrap_or(-direction);
            let (albedo, is_shadow_catcher) = ([1.0; 3], false);
            self.first_hit = Some(FirstHit { position, normal, albedo, is_shadow_catcher });
        }
        self.on_skin = Some(position);
    }

    fn note_first_grain(&mut self, position: DVec3, direction: DVec3, passage: &Passage) {
        if self.first_hit.is_some() || self.surface_bounces > 0 {
            return;
        }
        let outwards = || self.medium.density.outwards(position).try_normalize();
        let normal =
            passage.entry.and_then(DVec3::try_normalize).or_else(outwards).unwrap_or(-direction);
        let is_shadow_catcher = false;
        self.first_hit = Some(FirstHit { position, normal, albedo: [1.0; 3], is_shadow_catcher });
    }

    /// The surface that is met first on the way from a point by a vector.
    fn surface_within(&self, from: DVec3, by: DVec3) -> Option<SurfaceHit> {
        let surfaces = &self.world.surfaces;
        let length = by.length();
        if surfaces.is_empty() || length == 0.0 {
            return None;
        }
        surfaces.intersect(&Ray::new(from, by / length), length, None)
    }

    /// Whether a surface lies on the way from a point by a vector.
    pub(super) fn hides(&self, from: DVec3, by: DVec3) -> bool {
        self.surface_within(from, by).is_some()
    }

    /// What a surface does to a path that arrives: where it goes on, or how it ends.
    fn meet_surface(
        &mut self,
        hit: &SurfaceHit,
        arrival: Ray,
    ) -> Result<(Ray, Option<SurfaceId>), PathEnd> {
        let Ray { origin: position, direction } = arrival;
        let is_first = self.first_hit.is_none() && self.surface_bounces == 0;
        let object = hit.id.object as usize;
        if let Some(Some(emitter)) = self.world.emitters.get(object) {
            if is_first && !emitter.visible_to_camera {
                return Ok((arrival, Some(hit.id)));
            }
            if is_first {
                self.see_first(hit, position, ([0.0; 3], false));
            }
            return Err(match emitter.shines_towards(hit.normal) {
                true => PathEnd::Emitted {
                    light: emitter.light,
                    position,
                    normal: hit.normal,
                    direction,
                },
                false => PathEnd::Absorbed,
            });
        }
        let material = &self.world.materials[object];
        if is_first && material.direct_view() == DirectView::Holdout {
            return Err(PathEnd::Absorbed);
        }
        let scatterer = material.scatterer(hit, position, direction);
        if is_first {
            let is_shadow_catcher = material.direct_view() == DirectView::ShadowCatcher;
            self.see_first(hit, position, (scatterer.guide(), is_shadow_catcher));
        }
        self.surface_bounces += 1;
        self.look_at_surface(position, hit.id, &scatterer);
        let event = self.event;
        let [survives, u, v] = self.random();
        let third = || further_number(self.key, event);
        let scattered = scatterer.sample([u, v], third).ok_or(PathEnd::Absorbed)?;
        for (throughput, weight) in self.throughput.iter_mut().zip(scattered.weight) {
            *throughput *= weight;
        }
        if !self.survives(survives as f32) {
            return Err(PathEnd::Absorbed);
        }
        if self.surface_bounces >= MAX_BOUNCES_WITHOUT_LOSS {
            return Err(PathEnd::Enclosed);
        }
        Ok((Ray::new(position, scattered.direction), Some(hit.id)))
    }

    fn see_first(
        &mut self,
        hit: &SurfaceHit,
        position: DVec3,
        (albedo, is_shadow_catcher): ([f32; 3], bool),
    ) {
        self.first_hit = Some(FirstHit { position, normal: hit.normal, albedo, is_shadow_catcher });
    }

    /// Unbiased roulette over what surfaces have left.
    fn survives(&mut self, random: f32) -> bool {
        let largest = self.throughput.into_iter().fold(0.0, f32::max);
        if largest >= ROULETTE_THRESHOLD {
            return true;
        }
        let survival = largest / ROULETTE_THRESHOLD;
        if random >= survival {
            return false;
        }
        self.throughput = self.throughput.map(|throughput| throughput / survival);
        true
    }

    fn result(&self, end: PathEnd) -> PathResult {
        PathResult {
            end,
            throughput: self.throughput,
            ice_length: self.ice.all,
            ice_in_strata: self.ice.in_strata,
            air_length: self.air_length,
            grain_visits: self.grain_visits,
            interface_events: 2 * self.grain_visits,
            surface_bounces: self.surface_bounces,
            releases: 0,
            first_hit: self.first_hit,
        }
    }
}
