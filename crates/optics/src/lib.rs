//! Light and ice without scenes: Fresnel's equations, the ice that a path has crossed, and the
//! closed form of a grain that touches nothing.
//!
//! Geometric optics throughout: no diffraction, unpolarised light, `f64`. Nothing here knows where
//! a grain lies or what surrounds it.
//!
//! ```
//! use snowgrain_optics::{Dielectric, sphere};
//! let ice = Dielectric { eta: 1.31 };
//! assert!((ice.reflectance_from_outside(1.0) - (0.31f64 / 2.31) * (0.31 / 2.31)).abs() < 1e-15);
//! assert!((sphere::asymmetry(ice) - 0.78166).abs() < 1e-5);
//! ```

pub mod dielectric;
pub mod fresnel;
pub mod ice_path;
mod quadrature;
pub mod sphere;

pub use dielectric::Dielectric;
pub use ice_path::IcePath;
