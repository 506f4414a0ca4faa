//! What light can meet.

use snowgrain_accel::{GrainGrid, Surfaces};

/// Grains, surfaces and their materials: everything between the camera and the lights.
#[derive(Debug)]
pub struct World {
    /// All grains, packed for light.
    pub grid: GrainGrid,
    /// All solid objects.
    pub surfaces: Surfaces,
    /// Diffuse albedo of each object, linear RGB.
    pub albedos: Vec<[f32; 3]>,
    /// Index of refraction of the grains relative to air, >= 1.
    pub eta: f64,
}
