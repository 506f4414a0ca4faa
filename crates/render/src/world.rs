//! What light can meet.

use crate::light::Emitter;
use crate::surface::Material;
use snowgrain_accel::{GrainGrid, Surfaces};

/// Grains, surfaces and their materials: everything between the camera and the lights.
#[derive(Debug)]
pub struct World {
    /// All grains, packed for light.
    pub grid: GrainGrid,
    /// All solid objects, and lamps after them.
    pub surfaces: Surfaces,
    /// What each object does to light.
    pub materials: Vec<Material>,
    /// Of each object whether it shines; empty where none does.
    pub emitters: Vec<Option<Emitter>>,
    /// Index of refraction of the grains relative to air, >= 1.
    pub eta: f64,
}
