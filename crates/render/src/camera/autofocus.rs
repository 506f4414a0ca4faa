//! Focusing on what the middle of the picture shows.

use super::{Camera, Rays};
use crate::World;
use crate::transport::{NewPath, PathResult, PathSource, trace};
use snowgrain_accel::SimdLevel;
use snowgrain_math::Ray;
use snowgrain_math::sampler::{PathKey, numbers};

/// Rays that look for the surface: enough that pores between grains do not decide.
const PROBES: u64 = 129;

/// Part of the height of the picture, around its middle, that they go through.
const MIDDLE: f64 = 1.0 / 16.0;

impl Camera {
    /// The same camera, a lens of which is focused on the distance of what the middle of the picture
    /// shows of `world`: the median of some rays through the middle of the lens. Left as it is where
    /// most of them meet nothing.
    #[must_use]
    pub(crate) fn focused_on_surface(mut self, world: &World, level: SimdLevel) -> Self {
        if !self.has_lens() {
            return self;
        }
        let mut probes = Probes { camera: &self, next: 0, distances: Vec::new() };
        trace(world, level, &mut probes);
        let mut distances = probes.distances;
        // As paths end in any order.
        distances.sort_unstable_by(f64::total_cmp);
        let median = distances.get(PROBES as usize / 2).copied().filter(|distance| *distance > 0.0);
        if let (Rays::Lens { focus, .. }, Some(distance)) = (&mut self.rays, median) {
            *focus = distance;
        }
        self
    }

    /// The ray of a probe: a pinhole's.
    fn probe(&self, key: PathKey) -> Ray {
        let [x, y, _] =
            numbers(key, 0).map(|number| (f64::from(number) - 0.5) * MIDDLE * self.height);
        let pinhole = Self { rays: Rays::Pinhole, ..self.clone() };
        pinhole.ray(0.5 * self.width + x, 0.5 * self.height + y, [0.5; 2])
    }
}

/// The probes of a camera and what they found.
struct Probes<'a> {
    camera: &'a Camera,
    next: u64,
    distances: Vec<f64>,
}

impl PathSource for Probes<'_> {
    type Tag = ();

    fn next_path(&mut self) -> Option<NewPath<()>> {
        if self.next == PROBES {
            return None;
        }
        let key = PathKey::new(0, self.next, 0);
        self.next += 1;
        Some(NewPath { tag: (), ray: self.camera.probe(key), key, event: 1 })
    }

    fn finish(&mut self, (): (), path: &PathResult) {
        self.distances.extend(path.first_hit.map(|hit| self.camera.depth(hit.position)));
    }
}
