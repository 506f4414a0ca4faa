//! A pinhole camera.

use snowgrain_math::{DVec3, Ray, trig};

/// A pinhole camera whose pixel (0, 0) is at the top left.
#[derive(Clone, Copy, Debug)]
pub struct PinholeCamera {
    from: DVec3,
    forward: DVec3,
    right: DVec3,
    up: DVec3,
    size: [f64; 2],
}

impl PinholeCamera {
    /// The camera at `from` that looks at `at`; `vertical_fov` in radians, `size` in pixels.
    #[must_use]
    pub fn new(from: DVec3, at: DVec3, up: DVec3, vertical_fov: f64, size: [u32; 2]) -> Self {
        let size = size.map(f64::from);
        let height = trig::tan(0.5 * vertical_fov);
        let forward = (at - from).normalize();
        let right = forward.cross(up).normalize();
        let up = right.cross(forward) * height;
        Self { from, forward, right: right * (height * size[0] / size[1]), up, size }
    }

    /// The ray through the film at `x` pixels from the left and `y` from the top.
    #[must_use]
    pub fn ray(&self, x: f64, y: f64) -> Ray {
        let right = 2.0 * x / self.size[0] - 1.0;
        let up = 1.0 - 2.0 * y / self.size[1];
        let direction = self.forward + self.right * right + self.up * up;
        Ray::new(self.from, direction.normalize())
    }
}
