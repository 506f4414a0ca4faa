//! The camera: a pinhole, a thin lens, or parallel rays.
//!
//! A sample of a picture is a place of the image and, where rays start side by side, a place of the
//! lens. For one place of the lens all rays of the picture are one [`Bundle`]: through one point, or
//! along one direction.

mod aperture;
mod autofocus;

pub use aperture::Aperture;

use crate::description::{CameraDescription, FilmDescription, Focus, Projection};
use snowgrain_math::{Aabb, DVec3, Ray, trig};
use snowgrain_optics::Pencil;

/// A camera that looks along `forward`; image y runs down.
#[derive(Clone, Debug)]
pub struct Camera {
    origin: DVec3,
    forward: DVec3,
    /// From the middle of the picture to its right edge and to its lower edge: in a plane at distance
    /// 1 from a perspective camera, and in metres for an orthographic one.
    right: DVec3,
    down: DVec3,
    width: f64,
    height: f64,
    rays: Rays,
}

/// Where rays start.
#[derive(Clone, Debug)]
enum Rays {
    /// In one point.
    Pinhole,
    /// On a lens, so that those of one image place meet in the plane at distance `focus`.
    Lens {
        /// Its shape.
        aperture: Aperture,
        /// Its radius to the right and upwards, metres.
        right: DVec3,
        up: DVec3,
        /// Distance of the plane in focus along the view, metres.
        focus: f64,
    },
    /// Side by side.
    Parallel,
}

/// All rays of a picture for one place of the lens.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Bundle {
    /// They all start in this point, metres.
    Through(DVec3),
    /// They all run along this unit vector.
    Along(DVec3),
}

impl Camera {
    /// The camera of a description that has been checked (`from != at`, `up` not along the view,
    /// lengths above 0). A lens that finds its focus is focused on `at`: only a built scene knows what
    /// it sees.
    #[must_use]
    pub fn new(camera: &CameraDescription, film: &FilmDescription) -> Self {
        let forward = (camera.at - camera.from).normalize();
        let up = camera.up / camera.up.abs().max_element();
        let right = forward.cross(up).normalize();
        let down = forward.cross(right);
        let (width, height) = (f64::from(film.width), f64::from(film.height));
        let (half_height, rays) = match &camera.projection {
            Projection::Perspective { vertical_fov_degrees, lens } => {
                let half_height = trig::tan(vertical_fov_degrees.to_radians() * 0.5);
                let rays = lens.as_ref().map_or(Rays::Pinhole, |lens| Rays::Lens {
                    aperture: Aperture::new(lens.blades, lens.blade_rotation_degrees),
                    right: right * (lens.diameter * 0.5),
                    up: -down * (lens.diameter * 0.5),
                    focus: match lens.focus {
                        Focus::Distance(distance) => distance,
                        Focus::Surface => (camera.at - camera.from).length(),
                    },
                });
                (half_height, rays)
            }
            Projection::Orthographic { height } => (height * 0.5, Rays::Parallel),
        };
        let half_width = half_height * width / height;
        Self {
            origin: camera.from,
            forward,
            right: right * half_width,
            down: down * half_height,
            width,
            height,
            rays,
        }
    }

    /// Whether rays of one image place start in different points, so that [`Self::ray`] and others
    /// depend on `lens`: two numbers in [0, 1), uniform where the lens is sampled.
    #[must_use]
    pub fn has_lens(&self) -> bool {
        matches!(self.rays, Rays::Lens { .. })
    }

    /// A box around the points where rays start, metres.
    #[must_use]
    pub fn starts(&self) -> Aabb {
        let (a, b) = match &self.rays {
            Rays::Pinhole => (DVec3::ZERO, DVec3::ZERO),
            Rays::Lens { right, up, .. } => (*right, *up),
            Rays::Parallel => (self.right, self.down),
        };
        let reach = a.abs() + b.abs();
        Aabb::new(self.origin - reach, self.origin + reach)
    }

    /// The ray through a point of the image in pixels, from a place of the lens: (0, 0) is the upper
    /// left corner, (width, height) the lower right one.
    ///
    /// The lens is thin and free of aberrations: whatever place of the lens it leaves, the ray meets
    /// the plane in focus where the ray from the middle of the lens does (Kolb, Mitchell and Hanrahan
    /// 1995, "A Realistic Camera Model for Computer Graphics", section 2).
    #[inline]
    #[must_use]
    pub fn ray(&self, x: f64, y: f64, lens: [f64; 2]) -> Ray {
        let (u, v) = (2.0 * x / self.width - 1.0, 2.0 * y / self.height - 1.0);
        match &self.rays {
            Rays::Pinhole => {
                let direction = self.forward + self.right * u + self.down * v;
                Ray::new(self.origin, direction.normalize())
            }
            Rays::Lens { focus, .. } => {
                let offset = self.lens_offset(lens);
                let direction = self.forward + self.right * u + self.down * v;
                Ray::new(self.origin + offset, (direction * *focus - offset).normalize())
            }
            Rays::Parallel => Ray::new(self.origin + self.right * u + self.down * v, self.forward),
        }
    }

    /// Vertical field of view, degrees; `None` where rays are parallel.
    #[must_use]
    pub fn vertical_fov_degrees(&self) -> Option<f64> {
        match self.rays {
            Rays::Pinhole | Rays::Lens { .. } => {
                let half = trig::atan2(self.down.length(), 1.0);
                Some(2.0 * half.to_degrees())
            }
            Rays::Parallel => None,
        }
    }

    /// What the rays from one place of the lens have in common.
    #[must_use]
    pub fn bundle(&self, lens: [f64; 2]) -> Bundle {
        match self.rays {
            Rays::Pinhole | Rays::Lens { .. } => {
                Bundle::Through(self.origin + self.lens_offset(lens))
            }
            Rays::Parallel => Bundle::Along(self.forward),
        }
    }

    /// The rays of [`Self::ray`] from this place of the lens, told apart by their place in the image (pixels).
    #[must_use]
    pub fn pencil(&self, lens: [f64; 2]) -> Pencil {
        let still = [DVec3::ZERO; 2];
        let by = [self.right * (2.0 / self.width), self.down * (2.0 / self.height)];
        let corner = -self.right - self.down;
        let (origin, direction, origin_by, direction_by) = match &self.rays {
            Rays::Pinhole => (self.origin, self.forward + corner, still, by),
            Rays::Lens { focus, .. } => {
                let offset = self.lens_offset(lens);
                let direction = (self.forward + corner) * *focus - offset;
                (self.origin + offset, direction, still, by.map(|by| by * *focus))
            }
            Rays::Parallel => (self.origin + corner, self.forward, by, still),
        };
        Pencil { origin, direction, origin_by, direction_by }
    }

    /// The image place in pixels whose ray from this place of the lens meets `point`, which may lie
    /// outside the picture; `None` for a point that is not in front of the camera.
    #[must_use]
    pub fn project(&self, point: DVec3, lens: [f64; 2]) -> Option<(f64, f64)> {
        let offset = self.lens_offset(lens);
        let from_lens = point - self.origin - offset;
        let depth = from_lens.dot(self.forward);
        if depth <= 0.0 || depth.is_nan() {
            return None;
        }
        let in_image = match &self.rays {
            Rays::Pinhole => from_lens / depth,
            // Where the ray meets the plane in focus, as seen from the middle of the lens.
            Rays::Lens { focus, .. } => from_lens / depth + offset / *focus,
            Rays::Parallel => from_lens,
        };
        let along = |edge: DVec3| in_image.dot(edge) / edge.length_squared();
        Some((
            (along(self.right) + 1.0) * 0.5 * self.width,
            (along(self.down) + 1.0) * 0.5 * self.height,
        ))
    }

    /// Whether a place in the image, pixels, lies in the picture.
    #[must_use]
    pub fn shows(&self, x: f64, y: f64) -> bool {
        (0.0..self.width).contains(&x) && (0.0..self.height).contains(&y)
    }

    /// How densely the rays of one place of the lens cover the picture: square pixels a steradian
    /// around the unit vector `direction` where they run through a point, whatever point of the lens
    /// that is, and square pixels a square metre across where they are parallel. `direction` must
    /// point forwards.
    #[must_use]
    pub fn pixel_density(&self, direction: DVec3) -> f64 {
        let pixels = self.width * self.height;
        let across = 4.0 * (self.right.length_squared() * self.down.length_squared()).sqrt();
        match self.rays {
            Rays::Pinhole | Rays::Lens { .. } => {
                let cosine = direction.dot(self.forward);
                pixels / (across * cosine * cosine * cosine)
            }
            Rays::Parallel => pixels / across,
        }
    }

    /// Edge of a pixel, metres, in the plane at `distance` metres along the view.
    #[must_use]
    pub fn pixel_footprint(&self, distance: f64) -> f64 {
        let edge = 2.0 * self.down.length() / self.height;
        match self.rays {
            Rays::Pinhole | Rays::Lens { .. } => edge * distance,
            Rays::Parallel => edge,
        }
    }

    /// Distance of a point from the camera along the view direction, metres.
    #[must_use]
    pub fn depth(&self, point: DVec3) -> f64 {
        (point - self.origin).dot(self.forward)
    }

    /// From the middle of the lens to a place of it, metres.
    fn lens_offset(&self, place: [f64; 2]) -> DVec3 {
        match &self.rays {
            Rays::Lens { aperture, right, up, .. } => {
                let place = aperture.sample(place);
                *right * place.x + *up * place.y
            }
            Rays::Pinhole | Rays::Parallel => DVec3::ZERO,
        }
    }
}

#[cfg(test)]
mod tests;
