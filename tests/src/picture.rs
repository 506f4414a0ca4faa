//! Pixels as the oracle sees them, sample for sample with the renderer's random numbers.

use crate::camera::PinholeCamera;
use crate::oracle::Oracle;
use crate::statistics::{Estimate, estimate};
use rayon::prelude::*;
use snowgrain_math::sampler::{PathKey, numbers};
use snowgrain_math::{DVec3, trig};

/// A scene in front of a camera.
pub struct Picture<'a> {
    /// Grains and surfaces.
    pub oracle: &'a Oracle,
    /// The camera.
    pub camera: PinholeCamera,
    /// Pixels across; a pixel's stream of random numbers is its index, row by row from the top.
    pub width: u32,
    /// Seed of the sampler.
    pub seed: u64,
    /// Absorption coefficient of ice, inverse to the unit of length of the scene.
    pub absorption: f64,
    /// Radiance that comes from a unit direction at infinity to a path that met something.
    pub light: fn(DVec3) -> DVec3,
    /// Radiance that a camera ray sees there if it meets nothing.
    pub backdrop: fn(DVec3) -> DVec3,
}

impl Picture<'_> {
    /// The radiance of one sample of a pixel (its index, row by row from the top).
    #[must_use]
    pub fn sample(&self, pixel: u32, sample: u64) -> DVec3 {
        let key = PathKey::new(self.seed, u64::from(pixel), sample);
        let [x, y, _] = numbers(key, 0).map(f64::from);
        let (column, row) = (f64::from(pixel % self.width), f64::from(pixel / self.width));
        let ray = self.camera.ray(column + x, row + y);
        let path = self.oracle.trace(ray.origin, ray.direction, key, 1);
        let Some(direction) = path.escaped_direction() else { return DVec3::ZERO };
        if path.interface_events + path.diffuse_bounces == 0 {
            return (self.backdrop)(direction);
        }
        path.throughput * (self.light)(direction) * trig::exp(-self.absorption * path.ice_length)
    }

    /// The radiance of the same sample of these pixels.
    #[must_use]
    pub fn samples(&self, pixels: &[u32], sample: u64) -> Vec<DVec3> {
        pixels.par_iter().map(|&pixel| self.sample(pixel, sample)).collect()
    }

    /// Mean radiance (red, green, blue) of these pixels, `samples` each.
    #[must_use]
    pub fn mean(&self, pixels: &[u32], samples: u64) -> [Estimate; 3] {
        estimate(pixels.len() as u64 * samples, |index| {
            self.sample(pixels[(index / samples) as usize], index % samples).to_array()
        })
    }
}
