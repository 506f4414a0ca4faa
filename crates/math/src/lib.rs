//! Vectors, rays, frames, deterministic trigonometry and counter-based sampling.
//!
//! Everything here is a pure function of its arguments: no I/O, no threads, no state. Results are
//! the same bits on every machine (contract 2 of `ARCHITECTURE.md`): [`trig`] never calls the
//! platform's maths library, nothing fuses a multiply with an add.
//!
//! ```
//! use snowgrain_math::sampler::{PathKey, numbers};
//! let key = PathKey::new(7, 12, 0);
//! assert_eq!(numbers(key, 3), numbers(key, 3)); // stateless: the same question, the same answer
//! ```

pub mod aabb;
mod exponential;
pub mod frame;
pub mod ray;
pub mod sampler;
pub mod sobol;
pub mod trig;

pub use aabb::Aabb;
pub use exponential::Exponential;
pub use glam::{DAffine3, DMat3, DVec2, DVec3, IVec3, UVec2, UVec3, Vec3};
pub use ray::Ray;
