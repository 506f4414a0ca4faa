//! Samples of one tile that wait to be added to it.

use super::caught::Caught;
use crate::Scene;
use crate::statistics::Statistics;
use crate::transport::{Contribution, Learnt, PathEnd, PathResult};
use snowgrain_accel::STRATA;
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
    /// Of each of them the light of each slot, before the ice.
    weights: Vec<[f32; 3]>,
    /// Those that met a shadow catcher first.
    pub(super) caught: Vec<Caught>,
    /// Of those that ended with what was learnt: pixel, that light, its standard error.
    pub(super) learnt: Vec<((u32, u32), f32, f32)>,
    /// Of the path at hand the light of each slot.
    lights: Vec<[f32; 3]>,
    /// Of the path at hand the light that was found, by layer where layers are kept.
    sums: Vec<[f64; 3]>,
}

impl Batch {
    /// The radiance that a path brings to a pixel; it is of a band of wavelengths where light is parted. Where ice paths or layers of light are kept it is added
    /// to them.
    pub(super) fn add_light(
        &mut self,
        (scene, band): (&Scene, usize),
        pixel: (u32, u32),
        path: &PathResult,
        found: &[Contribution],
    ) -> [f32; 3] {
        let layers = scene.light_layers.as_ref();
        let first_layer = self.layers.len();
        self.layers.resize(first_layer + layers.map_or(0, LightLayerNames::count), [0.0; 3]);
        if scene.finds_on_the_way() && path.first_hit.is_some() {
            return self.add_found((scene, band), pixel, first_layer, (found, path.end));
        }
        self.lights.clear();
        self.lights.resize(scene.lights.slots().len(), [0.0; 3]);
        let length = match (path.end, path.first_hit) {
            (PathEnd::Escaped(ray), None) => {
                scene.lights.add_seen_by_camera(ray.direction, &mut self.lights);
                0.0
            }
            (PathEnd::Escaped(ray), Some(_)) => {
                scene.lights.add_radiances(ray.direction, &mut self.lights);
                path.ice_length
            }
            (PathEnd::Emitted { light, .. }, _) => {
                scene.lights.add_emission(light, &mut self.lights);
                path.ice_length
            }
            (PathEnd::Absorbed | PathEnd::Enclosed | PathEnd::Deep(_), _) => return [0.0; 3],
        };
        let mut radiance = [0.0; 3];
        for (slot, light) in self.lights.iter().enumerate() {
            if *light == [0.0; 3] && !scene.film.keep_ice_paths {
                continue;
            }
            let weight = std::array::from_fn(|c| light[c] * path.throughput[c]);
            let seen = colour_of((scene, band), slot, weight, length, &path.ice_in_strata);
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

    /// The radiance of all light that was found along a path.
    fn add_found(
        &mut self,
        (scene, band): (&Scene, usize),
        pixel: (u32, u32),
        first_layer: usize,
        (found, end): (&[Contribution], PathEnd),
    ) -> [f32; 3] {
        // In double precision, so that the layers add up to the whole in single.
        self.sums.clear();
        self.sums.resize((self.layers.len() - first_layer).max(1), [0.0; 3]);
        let (first_learnt, relative_error) = match end {
            PathEnd::Deep(Learnt { first, relative_error }) => (first, relative_error),
            _ => (usize::MAX, 0.0),
        };
        let mut learnt = 0.0;
        for (index, contribution) in found.iter().enumerate() {
            let &Contribution { slot, glint, weight, ice_length, ref ice_in_strata, .. } =
                contribution;
            let seen = colour_of((scene, band), slot, weight, ice_length, ice_in_strata);
            let layer = scene.light_layers.as_ref().map_or(0, |layers| {
                let own = layers.layer_of_slot()[slot] as usize;
                scene.glint_layer.filter(|_| glint).unwrap_or(own)
            });
            self.sums[layer].iter_mut().zip(seen).for_each(|(sum, seen)| *sum += f64::from(seen));
            if index >= first_learnt {
                learnt += f64::from(seen.iter().sum::<f32>()) / 3.0;
            }
            if scene.film.keep_ice_paths {
                let slots = scene.lights.slots().len();
                let weights = (0..slots).map(|other| if other == slot { weight } else { [0.0; 3] });
                self.weights.extend(weights);
                self.lengths.push((pixel, ice_length));
            }
        }
        if first_learnt < usize::MAX {
            self.learnt.push((pixel, learnt as f32, (learnt * relative_error) as f32));
        }
        for (layer, sum) in self.layers[first_layer..].iter_mut().zip(&self.sums) {
            *layer = sum.map(|channel| channel as f32);
        }
        [0, 1, 2].map(|channel: usize| self.sums.iter().map(|sum| sum[channel]).sum::<f64>() as f32)
    }

    /// The samples: pixel, what it is told, and, where layers of light are kept, the radiance in each.
    pub(super) fn samples(&self) -> impl Iterator<Item = ((u32, u32), &Sample, &[[f32; 3]])> {
        let count = self.layers.len() / self.samples.len().max(1);
        let layers_of = move |index: usize| &self.layers[index * count..(index + 1) * count];
        let samples = self.samples.iter().enumerate();
        samples.map(move |(index, (pixel, sample))| (*pixel, sample, layers_of(index)))
    }

    /// The ice paths that are kept: pixel, length in ice (metres), light of each slot before the ice.
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
        self.caught.clear();
        self.learnt.clear();
        self.statistics = Statistics::default();
    }
}

/// The colour of light of a slot, of a band of wavelengths where light is parted, after its length in ice.
fn colour_of(
    (scene, band): (&Scene, usize),
    slot: usize,
    weight: [f32; 3],
    length: f64,
    in_strata: &[f64; STRATA],
) -> [f32; 3] {
    let (colours, strata_colours) = scene.colours_of(band);
    match strata_colours.get(slot) {
        Some(strata) if in_strata.iter().any(|&length| length > 0.0) => {
            strata.apply(weight, length, in_strata)
        }
        _ => colours[slot].apply(weight, length),
    }
}

/// Adds a radiance to a sum of some.
fn add(sum: &mut [f32; 3], radiance: [f32; 3]) {
    sum.iter_mut().zip(radiance).for_each(|(sum, radiance)| *sum += radiance);
}
