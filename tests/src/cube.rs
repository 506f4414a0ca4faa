//! A cube of touching grains on the simple cubic lattice: the project's benchmark.
//!
//! Grains of radius 1/2 fill [0, N]^3; sky of radiance 1 above the horizon, 0 below. The camera
//! looks at the centre from centre + 2.6 N (1, .9, .8)/|(1, .9, .8)| with a vertical field of view
//! of 40 degrees. *Interior* pixels are those whose four corner rays all hit [1, N-1]^3.

use crate::camera::PinholeCamera;
use crate::oracle::Oracle;
use crate::packs;
use crate::search::Search;
use crate::statistics::{Estimate, estimate};
use snowgrain_math::sampler::{PathKey, numbers};
use snowgrain_math::{Aabb, DVec3, frame};

/// The cube and its tracer.
pub struct LatticeCube {
    side: u32,
    oracle: Oracle,
}

/// What light around a cube did, per path.
#[derive(Clone, Copy, Debug)]
pub struct CubeMeasure {
    /// Radiance found, under the sky.
    pub radiance: Estimate,
    /// Arrivals at ice from air.
    pub visits: Estimate,
    /// Fresnel decisions.
    pub interface_events: Estimate,
    /// Fraction of paths that ended without escaping.
    pub trapped: Estimate,
}

impl LatticeCube {
    /// The cube of `side`^3 grains with index of refraction `eta`.
    #[must_use]
    pub fn new(side: u32, eta: f64) -> Self {
        let grains = packs::simple_cubic([side; 3], 0.5);
        Self { side, oracle: Oracle::new(&grains, &[], eta, Search::Cells) }
    }

    /// The camera, for a picture of `pixels`^2.
    #[must_use]
    pub fn camera(&self, pixels: u32) -> PinholeCamera {
        let side = f64::from(self.side);
        let at = DVec3::splat(0.5 * side);
        let from = at + DVec3::new(1.0, 0.9, 0.8).normalize() * (2.6 * side);
        PinholeCamera::new(from, at, DVec3::Y, 40f64.to_radians(), [pixels; 2])
    }

    /// Indices (row by row from the top) of the interior pixels of a picture of `pixels`^2.
    #[must_use]
    pub fn interior_pixels(&self, pixels: u32) -> Vec<u32> {
        let camera = self.camera(pixels);
        let core = Aabb::new(DVec3::ONE, DVec3::splat(f64::from(self.side) - 1.0));
        let inside =
            |x: u32, y: u32| core.intersect(&camera.ray(f64::from(x), f64::from(y))).is_some();
        (0..pixels * pixels)
            .filter(|index| {
                let (x, y) = (index % pixels, index / pixels);
                [(0, 0), (1, 0), (0, 1), (1, 1)].iter().all(|(i, j)| inside(x + i, y + j))
            })
            .collect()
    }

    /// The mean over the interior pixels of a picture of `pixels`^2, `samples` each; samples that
    /// miss every grain count with what they see.
    #[must_use]
    pub fn seen_by_camera(&self, pixels: u32, samples: u32, seed: u64) -> CubeMeasure {
        let (camera, interior) = (self.camera(pixels), self.interior_pixels(pixels));
        let count = interior.len() as u64 * u64::from(samples);
        self.measure(count, |index| {
            let pixel = interior[(index / u64::from(samples)) as usize];
            let sample = index % u64::from(samples);
            let key = PathKey::new(seed, u64::from(pixel), sample);
            let [jitter_x, jitter_y, _] = numbers(key, 0).map(f64::from);
            let ray = camera
                .ray(f64::from(pixel % pixels) + jitter_x, f64::from(pixel / pixels) + jitter_y);
            (key, 1, ray.origin, ray.direction)
        })
    }

    /// Light from all around, cosine-distributed over the faces of the hull [0, N]^3; paths that
    /// miss every grain are counted. Event 0 is the face and the place on it, event 1 the direction.
    #[must_use]
    pub fn lit_all_around(&self, paths: u64, seed: u64) -> CubeMeasure {
        let side = f64::from(self.side);
        self.measure(paths, |index| {
            let key = PathKey::new(seed, index, 0);
            let [face, a, b] = numbers(key, 0).map(f64::from);
            let [_, u1, u2] = numbers(key, 1).map(f64::from);
            let face = (face * 6.0) as usize;
            let axis = face / 2;
            let lower = face.is_multiple_of(2);
            let mut inward = DVec3::ZERO;
            inward[axis] = if lower { 1.0 } else { -1.0 };
            let mut origin = DVec3::ZERO;
            origin[axis] = if lower { 0.0 } else { side };
            origin[(axis + 1) % 3] = a * side;
            origin[(axis + 2) % 3] = b * side;
            (key, 2, origin, frame::cosine_hemisphere(inward, [u1, u2]))
        })
    }

    fn measure(
        &self,
        paths: u64,
        start: impl Fn(u64) -> (PathKey, u32, DVec3, DVec3) + Sync,
    ) -> CubeMeasure {
        let [radiance, visits, interface_events, trapped] = estimate(paths, |index| {
            let (key, first_event, origin, direction) = start(index);
            let path = self.oracle.trace(origin, direction, key, first_event);
            let escaped = path.escaped_direction();
            [
                escaped.map_or(0.0, |d| f64::from(u8::from(d.y > 0.0))),
                f64::from(path.grain_visits),
                f64::from(path.interface_events),
                f64::from(u8::from(escaped.is_none())),
            ]
        });
        CubeMeasure { radiance, visits, interface_events, trapped }
    }
}
