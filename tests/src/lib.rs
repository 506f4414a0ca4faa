//! An independent oracle of light in grains, for tests of the fast kernels.
//!
//! The [`Oracle`] follows light one interface at a time in `f64` through the union of all balls of
//! ice, without closed forms, epsilons or SIMD. It shares nothing with the kernels but the random
//! numbers of a path ([`snowgrain_math::sampler`]) and the map of two of them to a diffuse
//! direction ([`snowgrain_math::frame::cosine_hemisphere`]), so that the two can be compared event
//! by event:
//!
//! - event 0 is the camera's sample: two numbers are its place in the pixel;
//! - every arrival at an interface between air and ice, totally reflected or not, takes the next
//!   event; light is transmitted where `u0 < 1 - R`;
//! - every hit of a diffuse surface takes the next event: `u1, u2` choose the direction, `u0`
//!   decides roulette.
//!
//! Lengths are in the unit of the scene given.

mod account;
mod ball;
pub mod camera;
pub mod cube;
pub mod interface;
pub mod oracle;
pub mod packs;
pub mod picture;
pub mod reference;
mod search;
pub mod shape_oracle;
pub mod slab;
pub mod statistics;
pub mod surfaces;

pub use camera::PinholeCamera;
pub use oracle::{Event, EventKind, Oracle, OraclePath, PathEnd};
pub use search::Search;
pub use shape_oracle::{ShapeOracle, ShapedGrain};
pub use statistics::Estimate;
pub use surfaces::{OracleShape, OracleSurface};
