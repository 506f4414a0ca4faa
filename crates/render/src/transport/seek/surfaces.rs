//! Light at a surface.

use super::shadow::{Brings, Condition, Wanted};
use super::{PathState, Seeker, Trail, Vertex, product, scaled, search_key};
use crate::surface::Scatterer;
use crate::transport::Contribution;
use crate::transport::ice::IceLength;
use snowgrain_accel::{Probe, SurfaceId};
use snowgrain_math::sampler::numbers;
use snowgrain_math::{DVec3, Ray};

/// A bounce off a surface, or through it.
#[derive(Clone, Copy, Debug)]
pub(in super::super) struct Bounce {
    pub(in super::super) lane: usize,
    pub(in super::super) position: DVec3,
    pub(in super::super) scatterer: Scatterer,
    pub(in super::super) surface: SurfaceId,
    pub(in super::super) in_ice: bool,
    /// Random event of the path.
    pub(in super::super) event: u32,
    pub(in super::super) grain_visits: u32,
    pub(in super::super) ice: IceLength,
}

impl Seeker<'_> {
    /// Looks for light at a surface: `state` holds the throughput before it. From within a grain no
    /// straight line leads to a light, and a smooth surface has none to it: light is then met by chance.
    pub(in super::super) fn at_surface(
        &mut self,
        bounce: &Bounce,
        trails: &mut [Trail],
        state: &PathState,
    ) {
        let trail = &mut trails[bounce.lane];
        (trail.visits_before, trail.visits_forgotten) = (bounce.grain_visits, 0);
        trail.through_ice = false;
        (trail.last, trail.turned) = (None, None);
        (trail.first_grain, trail.second_grain) = (None, None);
        if bounce.in_ice {
            trail.vertex = Vertex::SurfaceInIce;
            return;
        }
        if bounce.scatterer.is_smooth() {
            trail.vertex = Vertex::SmoothSurface;
            return;
        }
        trail.vertex = Vertex::Surface(bounce.position, bounce.scatterer);
        if self.tally.is_some() {
            return;
        }
        let [light, u, v] = numbers(search_key(state.key), 2 * bounce.event).map(f64::from);
        let Some(sample) = self.search.late.sample(bounce.position, [light, u, v]) else { return };
        let (colour, value) = bounce.scatterer.value(sample.direction);
        if value <= 0.0 {
            return;
        }
        let ray = Ray::new(bounce.position, sample.direction);
        let surfaces = &self.world.surfaces;
        let lamp = sample.surface.map(|id| id.object);
        let hit = surfaces.intersect(&ray, sample.distance, Some(bounce.surface));
        if hit.is_some_and(|hit| lamp != Some(hit.id.object)) {
            return;
        }
        // The balance heuristic; nothing meets a point by chance.
        let rivals = if sample.is_point { 0.0 } else { bounce.scatterer.density(sample.direction) };
        let contribution = Contribution {
            slot: sample.slot,
            glint: false,
            event: bounce.event,
            weight: scaled(
                product(product(state.throughput, colour), sample.radiance),
                value / (sample.pdf + rivals),
            ),
            ice_length: bounce.ice.all,
            ice_in_strata: bounce.ice.in_strata,
        };
        let entry = self.world.grid.enter(&ray).filter(|&(t, _)| t < sample.distance);
        let Some((t, start)) = entry else {
            trails[bounce.lane].contributions.push(contribution);
            return;
        };
        let length = self.quanta(sample.distance - t);
        self.rays.push(Probe::through_air(start, sample.direction, length));
        // Surfaces have been looked at.
        let brings = Brings::Light(contribution);
        let (lane, condition) = (bounce.lane, Condition::Nothing);
        self.wanted.push(Wanted { lane, brings, ray, distance: 0.0, lamp: None, condition });
        self.follow_shadow_rays(trails);
    }
}
