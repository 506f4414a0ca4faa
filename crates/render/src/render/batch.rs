//! Samples of one tile that wait to be added to it.

use crate::Scene;
use crate::statistics::Statistics;
use crate::transport::{PathEnd, PathResult};
use snowgrain_film::{LightLayerNames, Sample};

/// Samples of one tile that wait to be added to it.
#[derive(Default)]
pub(super) struct Batch {
    /// By pixel.
    pub(super) samples: Vec<((u32, u32), Sample)>,
    /// Where layers of light are kept, of each sample the radiance in each layer.
    layers: Vec<[f32; 3]>,
    /// Counts of their paths.
    pub(super) statistics: Statistics,
    /// Where ice paths are kept, those that brought light: pixel and length in ice, metres.
    lengths: Vec<((u32, u32), f64)>,
    /// Of each of them the light of each spectrum, before the ice.
    weights: Vec<[f32; 3]>,
}

impl Batch {
    /// The radiance that a path brings to a pixel. Where ice paths or layers of light are kept it is added
    /// to them.
    pub(super) fn add_light(
        &mut self,
        scene: &Scene,
        pixel: (u32, u32),
        path: &PathResult,
    ) -> [f32; 3] {
        let layers = scene.light_layers.as_ref();
        let first_layer = self.layers.len();
        self.layers.resize(first_layer + layers.map_or(0, LightLayerNames::count), [0.0; 3]);
        let PathEnd::Escaped(ray) = path.end else { return [0.0; 3] };
        let (lights, length) = match path.first_hit {
            None => (scene.environment.seen_by_camera(ray.direction), 0.0),
            Some(_) => (scene.environment.radiances(ray.direction), path.ice_length),
        };
        let mut radiance = [0.0; 3];
        let in_strata = path.ice_in_strata.iter().any(|&length| length > 0.0);
        for (slot, (light, colour)) in lights.iter().zip(&scene.colours).enumerate() {
            let weight = std::array::from_fn(|c| light[c] * path.throughput[c]);
            let seen = match scene.strata_colours.get(slot) {
                Some(strata) if in_strata => strata.apply(weight, length, &path.ice_in_strata),
                _ => colour.apply(weight, length),
            };
            add(&mut radiance, seen);
            if let Some(layers) = layers {
                add(&mut self.layers[first_layer + layers.layer_of_slot()[slot] as usize], seen);
            }
            if scene.film.keep_ice_paths {
                self.weights.push(weight);
            }
        }
        if scene.film.keep_ice_paths {
            self.lengths.push((pixel, length));
        }
        radiance
    }

    /// The samples: pixel, what it is told, and, where layers of light are kept, the radiance in each.
    pub(super) fn samples(&self) -> impl Iterator<Item = ((u32, u32), &Sample, &[[f32; 3]])> {
        let count = self.layers.len() / self.samples.len().max(1);
        let layers_of = move |index: usize| &self.layers[index * count..(index + 1) * count];
        let samples = self.samples.iter().enumerate();
        samples.map(move |(index, (pixel, sample))| (*pixel, sample, layers_of(index)))
    }

    /// The ice paths that are kept: pixel, length in ice (metres), light of each spectrum before the ice.
    pub(super) fn ice_paths(&self) -> impl Iterator<Item = ((u32, u32), f64, &[[f32; 3]])> {
        let spectra = self.weights.len() / self.lengths.len().max(1);
        let weights = self.weights.chunks_exact(spectra.max(1));
        self.lengths.iter().zip(weights).map(|(&(pixel, length), weights)| (pixel, length, weights))
    }

    /// Forgets all, but not the memory.
    pub(super) fn clear(&mut self) {
        self.samples.clear();
        self.layers.clear();
        self.lengths.clear();
        self.weights.clear();
        self.statistics = Statistics::default();
    }
}

/// Adds a radiance to a sum of some.
fn add(sum: &mut [f32; 3], radiance: [f32; 3]) {
    sum.iter_mut().zip(radiance).for_each(|(sum, radiance)| *sum += radiance);
}
