//! Snow as matter: size distributions, lattices, deposition and measures of what came out.

mod error;
pub mod field;
pub mod settings;

pub use error::GrainsError;
pub use field::GrainField;
pub use settings::{Amount, DepositRule, DepositSettings, LatticeKind, LatticeSettings, Radii};
