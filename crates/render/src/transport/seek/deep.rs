//! Light that would come to grains that were met at random deep in the snow.

use super::shadow::{Brings, Condition, Wanted};
use super::{Seeker, Trail};
use crate::transport::medium::DeepLight;
use snowgrain_accel::Probe;

impl Seeker<'_> {
    /// Sends shadow rays from where light would come into the deep cells, by real grains and surfaces.
    pub(in super::super) fn above_deep(
        &mut self,
        lane: usize,
        lights: Vec<DeepLight>,
        trails: &mut [Trail],
    ) {
        for DeepLight { contribution, ray, distance, lamp } in lights {
            let start = self.world.grid.locate(ray.origin);
            self.rays.push(Probe::through_air(start, ray.direction, self.quanta(distance)));
            let (brings, condition) = (Brings::Light(contribution), Condition::Nothing);
            self.wanted.push(Wanted { lane, brings, ray, distance, lamp, condition });
        }
        if !self.rays.is_empty() {
            self.follow_shadow_rays(trails);
        }
    }
}
