//! The pinhole camera.

use crate::description::{CameraDescription, FilmDescription};
use snowgrain_math::{DVec3, Ray, trig};

/// A pinhole that looks along `forward`; image y runs down.
#[derive(Clone, Debug)]
pub struct Camera {
    origin: DVec3,
    forward: DVec3,
    right: DVec3,
    down: DVec3,
    width: f64,
    height: f64,
    vertical_fov_degrees: f64,
}

impl Camera {
    /// The camera of a description that has been checked (`from != at`, `up` not along the view).
    #[must_use]
    pub fn new(camera: &CameraDescription, film: &FilmDescription) -> Self {
        let forward = (camera.at - camera.from).normalize();
        let up = camera.up / camera.up.abs().max_element();
        let right = forward.cross(up).normalize();
        let down = forward.cross(right);
        let (width, height) = (f64::from(film.width), f64::from(film.height));
        let half_height = trig::tan(camera.vertical_fov_degrees.to_radians() * 0.5);
        let half_width = half_height * width / height;
        Self {
            origin: camera.from,
            forward,
            right: right * half_width,
            down: down * half_height,
            width,
            height,
            vertical_fov_degrees: camera.vertical_fov_degrees,
        }
    }

    /// Vertical field of view, degrees.
    #[must_use]
    pub fn vertical_fov_degrees(&self) -> f64 {
        self.vertical_fov_degrees
    }

    /// The ray through a point of the image in pixels: (0, 0) is the upper left corner,
    /// (width, height) the lower right one.
    #[inline]
    #[must_use]
    pub fn ray(&self, x: f64, y: f64) -> Ray {
        let (u, v) = (2.0 * x / self.width - 1.0, 2.0 * y / self.height - 1.0);
        let direction = self.forward + self.right * u + self.down * v;
        Ray::new(self.origin, direction.normalize())
    }

    /// Distance of a point from the camera along the view direction, metres.
    #[must_use]
    pub fn depth(&self, point: DVec3) -> f64 {
        (point - self.origin).dot(self.forward)
    }
}
