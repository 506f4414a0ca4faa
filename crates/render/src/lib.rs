//! Light transport through grains: scene, camera, lights, integrator, tiles and measures.
//!
//! Opens no file and owns no thread pool: both are handed in.

pub mod description;
