//! Why snow cannot be made.

use snowgrain_accel::GrainStacksError;
use snowgrain_geometry::GeometryError;
use thiserror::Error;

/// Why snow cannot be made.
#[derive(Debug, Error, Clone, PartialEq)]
pub enum GrainsError {
    /// A shape or position is out of range.
    #[error(transparent)]
    Geometry(#[from] GeometryError),
    /// Grains cannot be stored.
    #[error(transparent)]
    Stacks(#[from] GrainStacksError),
    /// A setting has a value that means nothing; `key` is its name in the scene file.
    #[error("{key}: {reason}")]
    Setting {
        /// Name of the setting, as in the scene file.
        key: &'static str,
        /// What is wrong and how to mend it.
        reason: String,
    },
    /// Grains fall, but none comes to rest any more.
    #[error(
        "the last {drops} falling grains all missed everything or were discarded as too steep \
         ({discarded} discarded, {missed} missed so far; {accepted} lie); let `area` cover \
         something to fall on, or raise `max_slope`"
    )]
    NothingComesToRest {
        /// Drops in a row without success.
        drops: u64,
        /// Grains that lie.
        accepted: u64,
        /// Grains discarded in all.
        discarded: u64,
        /// Grains that fell past everything.
        missed: u64,
    },
}

impl GrainsError {
    /// The name and the fault of a setting or of a number of a shape.
    #[must_use]
    pub fn setting_and_reason(&self) -> Option<(&'static str, &str)> {
        match self {
            Self::Setting { key, reason }
            | Self::Geometry(GeometryError::BadShape { key, reason }) => Some((key, reason)),
            _ => None,
        }
    }

    pub(crate) fn setting(key: &'static str, reason: impl Into<String>) -> Self {
        Self::Setting { key, reason: reason.into() }
    }
}
