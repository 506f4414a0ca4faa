//! Light that is looked for: directions drawn towards lights.

use super::{Lights, Source};
use snowgrain_math::DVec3;

/// A direction in which a light may be seen.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LightSample {
    /// Which light.
    pub light: usize,
    /// Its slot.
    pub slot: usize,
    /// Unit vector towards it.
    pub direction: DVec3,
    /// How far it is, metres; infinite for a light at infinity.
    pub distance: f64,
    /// Its radiance, linear sRGB, where nothing is in between.
    pub radiance: [f32; 3],
    /// Density of the direction, 1/sr, times the probability of the light.
    pub pdf: f64,
}

impl Lights {
    /// A light by its power, and a direction towards it from the point `from` (metres), by three independent
    /// uniform numbers in [0, 1). For any function f of direction, f times radiance over pdf has the mean
    /// over all lights of the integral of f times their radiance, where they are not hidden. `None` where
    /// no light shines.
    ///
    /// The probability of a light is its luminous flux onto a sphere around the scene over that of all.
    #[must_use]
    pub fn sample(&self, from: DVec3, u: [f64; 3]) -> Option<LightSample> {
        let _ = from;
        let (light, _) = self.choice.pick(u[0])?;
        let source = &self.sources[light];
        let direction = source.distant.sample([u[1], u[2]])?;
        let radiance = source.radiance(direction);
        let pdf = self.pdf_at_infinity(light, direction);
        let distance = f64::INFINITY;
        Some(LightSample { light, slot: source.slot, direction, distance, radiance, pdf })
    }

    /// A direction towards this light from the point `from`, as [`Self::sample`] draws it once the light
    /// is chosen: the density is that of the direction alone.
    #[must_use]
    pub fn sample_light(&self, light: usize, from: DVec3, u: [f64; 2]) -> Option<LightSample> {
        let _ = from;
        let source = &self.sources[light];
        let direction = source.distant.sample(u)?;
        let pdf = source.distant.density(direction);
        let (radiance, distance) = (source.radiance(direction), f64::INFINITY);
        Some(LightSample { light, slot: source.slot, direction, distance, radiance, pdf })
    }

    /// Density with which [`Self::sample`] gives this light at infinity in this direction, 1/sr.
    #[must_use]
    pub fn pdf_at_infinity(&self, light: usize, direction: DVec3) -> f64 {
        self.choice.probability(light) * self.sources[light].distant.density(direction)
    }

    /// Radiance of a light at infinity in a direction, linear sRGB.
    #[must_use]
    pub fn radiance_at_infinity(&self, light: usize, direction: DVec3) -> [f32; 3] {
        Source::radiance(&self.sources[light], direction)
    }
}
