//! What the oracles do alike at the events of a path: numbers, Fresnel decisions, diffuse reflection, counts.

use crate::interface::Interface;
use crate::oracle::{Oracle, OraclePath, PathEnd};
use snowgrain_math::sampler::{self, PathKey};
use snowgrain_math::{DVec3, frame};

/// A path so far, and the random numbers of its next event.
pub(crate) struct Account {
    key: PathKey,
    next_event: u32,
    turns_in_ice: u32,
    pub(crate) path: OraclePath,
}

impl Account {
    /// A path that begins at `position`, whose first event takes the numbers of event `first_event` of `key`.
    pub(crate) fn new(position: DVec3, key: PathKey, first_event: u32) -> Self {
        let path = OraclePath {
            end: PathEnd::Absorbed,
            last_position: position,
            throughput: DVec3::ONE,
            ice_length: 0.0,
            void_length: 0.0,
            interface_events: 0,
            grain_visits: 0,
            diffuse_bounces: 0,
        };
        Self { key, next_event: first_event, turns_in_ice: 0, path }
    }

    /// Takes the next event's numbers and decides whether light goes through.
    pub(crate) fn transmits(&mut self, interface: &Interface) -> bool {
        self.path.interface_events += 1;
        f64::from(self.numbers()[0]) < 1.0 - interface.reflectance
    }

    /// The direction after a diffuse surface, unless that takes the rest.
    pub(crate) fn reflect_diffusely(
        &mut self,
        albedo: DVec3,
        normal: DVec3,
    ) -> Result<DVec3, PathEnd> {
        let [u0, u1, u2] = self.numbers().map(f64::from);
        self.path.diffuse_bounces += 1;
        self.path.throughput *= albedo;
        let largest = self.path.throughput.max_element();
        if largest <= 0.0 {
            return Err(PathEnd::Absorbed);
        }
        if largest < Oracle::ROULETTE_BELOW {
            let survival = largest / Oracle::ROULETTE_BELOW;
            if u0 >= survival {
                return Err(PathEnd::Absorbed);
            }
            self.path.throughput /= survival;
        }
        Ok(frame::cosine_hemisphere(normal, [u1, u2]))
    }

    /// A stretch of ice begins.
    pub(crate) fn enter_ice(&mut self) {
        self.turns_in_ice = 0;
    }

    /// A turn within the stretch of ice.
    pub(crate) fn count_turn(&mut self) -> Result<(), PathEnd> {
        self.turns_in_ice += 1;
        if self.turns_in_ice < Oracle::TURNS_BEFORE_TRAPPED {
            Ok(())
        } else {
            Err(PathEnd::Trapped)
        }
    }

    fn numbers(&mut self) -> [f32; 3] {
        let numbers = sampler::numbers(self.key, self.next_event);
        self.next_event += 1;
        numbers
    }
}
