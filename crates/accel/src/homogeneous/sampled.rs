//! Grains of any shape, by light that was followed through them beforehand.

use crate::flight::vector::{F, W, WIDTH};
use fearless_simd::prelude::*;
use std::sync::Arc;

/// Light that one grain turned.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ScatteringSample {
    /// Cosine of the angle by which it was turned; exactly 1 where it went straight through.
    pub cosine: f32,
    /// Its length in the grain, in radii of the sphere of equal volume.
    pub length: f32,
}

/// What a grain does to light that meets it.
#[derive(Clone, Debug, Default, PartialEq)]
pub enum GrainScattering {
    /// The closed form of a sphere.
    #[default]
    Sphere,
    /// One of these samples, each as likely as any other; at least one, at most 2^24. The grain takes all
    /// orientations alike, so the azimuth is drawn anew.
    Sampled(Arc<[ScatteringSample]>),
}

impl GrainScattering {
    /// The sample of a random word, of which the low eight bits are not used.
    #[inline(always)]
    fn sample(&self, word: u32) -> Option<ScatteringSample> {
        let Self::Sampled(samples) = self else { return None };
        Some(samples[((u64::from(word) * samples.len() as u64) >> 32) as usize])
    }
}

/// Whether any layer has other grains than spheres.
pub(super) fn any_sampled(layers: &[GrainScattering]) -> bool {
    layers.iter().any(|layer| *layer != GrainScattering::Sphere)
}

/// Puts the samples of grains that are no spheres, at their depths, in the place of what spheres would do: the
/// cosine of the turn and the length.
#[inline(always)]
pub(super) fn replace<S: Simd>(
    simd: S,
    (layers, bottoms): (&[GrainScattering], &[f32]),
    (depth, words): (F<S>, W<S>),
    [cosine, length]: [F<S>; 2],
) -> [F<S>; 2] {
    let (mut depths, mut drawn) = ([0.0; WIDTH], [0; WIDTH]);
    let (mut cosines, mut lengths) = ([0.0; WIDTH], [0.0; WIDTH]);
    depth.store_slice(&mut depths);
    words.store_slice(&mut drawn);
    cosine.store_slice(&mut cosines);
    length.store_slice(&mut lengths);
    for lane in 0..WIDTH {
        // Outside of the snow whatever comes is not used.
        let layer = bottoms.iter().position(|&bottom| depths[lane] <= bottom);
        let Some(sample) = layer.and_then(|layer| layers[layer].sample(drawn[lane])) else {
            continue;
        };
        cosines[lane] = sample.cosine;
        lengths[lane] = sample.length;
    }
    [F::<S>::from_slice(simd, &cosines), F::<S>::from_slice(simd, &lengths)]
}
