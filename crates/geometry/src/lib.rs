//! What shapes are: grains, meshes and simple solids as plain data, in metres, y up.
//!
//! Nothing here searches: structures that answer "what is hit next" live in `snowgrain-accel`.
//!
//! ```
//! use snowgrain_geometry::{Quantisation, QuantisedGrain};
//! use snowgrain_math::DVec3;
//! let lattice = Quantisation::for_grains(DVec3::ZERO, 0.5e-3);
//! let grain = lattice.round(DVec3::new(0.01, 0.02, 0.03), 0.5e-3).unwrap();
//! let back = lattice.grain(grain);
//! assert!((back.center - DVec3::new(0.01, 0.02, 0.03)).length() < lattice.quantum());
//! ```

mod error;
pub mod grain;
pub mod mesh;
pub mod shape;
pub mod teapot;

pub use error::GeometryError;
pub use grain::{Grain, Quantisation, QuantisedGrain};
pub use mesh::TriangleMesh;
pub use shape::{GrainShape, Shape, ShapeKind};
pub use teapot::teapot;
