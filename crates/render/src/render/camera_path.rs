//! Where the path of a sample begins.

use crate::Scene;
use crate::description::Sampler;
use snowgrain_math::Ray;
use snowgrain_math::sampler::{PathKey, numbers};
use snowgrain_math::sobol::sobol_numbers;

/// The beginning of the path of a sample: a function of the scene, the pixel and the number of the sample.
pub(super) struct CameraPath {
    pub(super) ray: Ray,
    pub(super) key: PathKey,
    /// Next event of its random numbers.
    pub(super) event: u32,
    /// Place in the image, pixels.
    pub(super) image: [f64; 2],
    /// Place on the lens; the middle of one without size.
    pub(super) lens: [f64; 2],
}

impl CameraPath {
    /// Of a sample of pixel `(x, y)`. Of independent numbers, only a lens that has a size takes an event.
    pub(super) fn of(scene: &Scene, (x, y): (u32, u32), sample: u64) -> Self {
        let stream = u64::from(y) * u64::from(scene.film.width) + u64::from(x);
        let key = PathKey::new(scene.film.seed, stream, sample);
        let has_lens = scene.camera.has_lens();
        let (jitter, lens, event) = match scene.film.sampler {
            Sampler::Independent => {
                let [x, y, _] = numbers(key, 0);
                let [u, v, _] = if has_lens { numbers(key, 1) } else { [0.5; 3] };
                ([x, y], [u, v], if has_lens { 2 } else { 1 })
            }
            Sampler::Sobol => {
                let [x, y, u, v] = sobol_numbers(scene.film.seed, stream, sample);
                ([x, y], if has_lens { [u, v] } else { [0.5; 2] }, 1)
            }
        };
        let image = [f64::from(x) + f64::from(jitter[0]), f64::from(y) + f64::from(jitter[1])];
        let lens = lens.map(f64::from);
        let ray = scene.camera.ray(image[0], image[1], lens);
        Self { ray, key, event, image, lens }
    }
}
