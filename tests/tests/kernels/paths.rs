//! Paths that start where a case says, and what becomes of each.

use snowgrain_accel::SimdLevel;
use snowgrain_math::sampler::PathKey;
use snowgrain_math::{DVec3, Ray, frame};
use snowgrain_render::World;
use snowgrain_render::transport::{self, NewPath, PathResult, PathSource};

/// The random numbers of a path; its start takes events 0 and 1.
pub(super) fn key(tag: u64) -> PathKey {
    PathKey::new(9, tag, 0)
}

/// A point on the unit sphere.
pub(super) fn on_sphere([u, v, w]: [f32; 3]) -> DVec3 {
    let pole = if w < 0.5 { DVec3::Y } else { -DVec3::Y };
    frame::cosine_hemisphere(pole, [f64::from(u), f64::from(v)])
}

/// Follows so many paths.
pub(super) fn trace(
    world: &World,
    level: SimdLevel,
    paths: u64,
    start: impl Fn(PathKey) -> Ray,
) -> Vec<PathResult> {
    let results = vec![None; paths as usize];
    let mut recorder = Recorder { start, next: 0, results };
    transport::trace(world, level, &mut recorder);
    recorder.results.into_iter().map(Option::unwrap).collect()
}

struct Recorder<F> {
    start: F,
    next: u64,
    results: Vec<Option<PathResult>>,
}

impl<F: Fn(PathKey) -> Ray> PathSource for Recorder<F> {
    type Tag = u64;

    fn next_path(&mut self) -> Option<NewPath<u64>> {
        if self.next == self.results.len() as u64 {
            return None;
        }
        let tag = self.next;
        self.next += 1;
        let key = key(tag);
        Some(NewPath { tag, ray: (self.start)(key), key, event: 2 })
    }

    fn finish(&mut self, tag: u64, result: &PathResult) {
        self.results[tag as usize] = Some(*result);
    }
}
