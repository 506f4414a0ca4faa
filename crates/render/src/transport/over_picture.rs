//! Paths that a camera begins anywhere in a picture, for what is measured before it.

use super::{NewPath, PathResult, PathSource};
use crate::camera::Camera;
use snowgrain_math::sampler::{PathKey, numbers};
use std::ops::Range;

/// Paths of these numbers, at random places of a picture of a size in pixels and of the lens; of their results it is
/// counted how many met grains.
pub(super) struct PathsOverPicture<'a> {
    pub(super) camera: &'a Camera,
    pub(super) size: [f64; 2],
    pub(super) seed: u64,
    pub(super) range: Range<u64>,
    pub(super) met: u64,
}

impl PathSource for PathsOverPicture<'_> {
    type Tag = ();

    fn next_path(&mut self) -> Option<NewPath<()>> {
        let key = PathKey::new(self.seed, self.range.next()?, 0);
        let [x, y, _] = numbers(key, 0).map(f64::from);
        let [u, v, _] = numbers(key, 1).map(f64::from);
        let ray = self.camera.ray(x * self.size[0], y * self.size[1], [u, v]);
        Some(NewPath { tag: (), ray, key, event: 2 })
    }

    fn finish(&mut self, (): (), path: &PathResult) {
        self.met += u64::from(path.grain_visits > 0);
    }
}
