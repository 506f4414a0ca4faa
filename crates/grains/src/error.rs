//! Why snow cannot be made.

use snowgrain_geometry::GeometryError;
use thiserror::Error;

/// Why snow cannot be made.
#[derive(Debug, Error, Clone, PartialEq)]
pub enum GrainsError {
    /// A shape or position is out of range.
    #[error(transparent)]
    Geometry(#[from] GeometryError),
    /// A setting has a value that means nothing; `key` is its name in the scene file.
    #[error("{key}: {reason}")]
    Setting {
        /// Name of the setting, as in the scene file.
        key: &'static str,
        /// What is wrong and how to mend it.
        reason: String,
    },
}
