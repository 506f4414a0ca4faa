//! Light transport through grains: scene, camera, lights, integrator, tiles and measures.
//!
//! Opens no file and owns no thread pool: both are handed in.

pub mod camera;
pub mod description;
pub mod transport;
pub mod world;

pub use world::World;
