//! Which snow a grain belongs to, where that matters for what its ice absorbs.

use crate::grain_grid::GRAINS_PER_BLOCK;

/// Strata that are told apart: grains of stratum 0 are like most, those of 1 to so many have
/// impurities of their own.
pub const STRATA: usize = 7;

/// The strata of the grains of a block, slot by slot.
pub(crate) type BlockStrata = [u8; GRAINS_PER_BLOCK];
