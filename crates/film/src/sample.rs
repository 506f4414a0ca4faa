//! What one path tells the film.

use thiserror::Error;

/// Largest magnitude of an albedo or of a component of a normal that a film takes.
pub const LARGEST_GUIDE: f32 = 256.0;

/// What one path tells the film about its pixel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sample {
    /// Radiance, scene-linear RGB, each finite and in (-2^48, 2^48); below 0 for colours out of the
    /// gamut of the primaries, as light through deep ice is.
    pub radiance: [f32; 3],
    /// 0 where the path saw only the backdrop, 1 otherwise.
    pub alpha: f32,
    /// Diffuse albedo of the first surface, RGB; 0 where nothing was hit.
    pub albedo: [f32; 3],
    /// Unit normal of the first surface in world space; 0 where nothing was hit.
    pub normal: [f32; 3],
    /// Distance of the first surface from the camera, metres; infinite where nothing was hit.
    pub depth: f32,
}

impl Default for Sample {
    /// A path that saw only a black backdrop.
    fn default() -> Self {
        Self {
            radiance: [0.0; 3],
            alpha: 0.0,
            albedo: [0.0; 3],
            normal: [0.0; 3],
            depth: f32::INFINITY,
        }
    }
}

/// Why a sample is refused. Such a sample is a fault of the renderer, never to be dropped quietly.
#[derive(Clone, Copy, Debug, Error, PartialEq)]
pub enum SampleFault {
    /// A radiance is infinite, not a number, or 2^48 and more in magnitude.
    #[error("a radiance of {0} (its magnitude must be below 2.8e14)")]
    Radiance(f32),
    /// An alpha outside [0, 1].
    #[error("an alpha of {0} (it must be in [0, 1])")]
    Alpha(f32),
    /// An albedo outside [0, 256].
    #[error("an albedo of {0} (it must be in [0, 256])")]
    Albedo(f32),
    /// A component of a normal outside [-256, 256].
    #[error("a normal component of {0} (it must be in [-256, 256])")]
    Normal(f32),
    /// A depth that is negative, not a number, or finite and 2^48 m and more.
    #[error("a depth of {0} m (it must be in [0, 2.8e14) or infinite)")]
    Depth(f32),
}
