//! Grains as they are handed over to be packed.

use snowgrain_geometry::QuantisedGrain;
use std::fmt;

/// Grains of a part of a list.
const GRAINS_PER_PART: usize = 1 << 14;

/// Grains in parts, which are walked several times and by several threads; packing is fastest where
/// the grains of a part lie together in space. The order of all, part by part, is the order in which
/// cells list them.
#[derive(Clone, Copy)]
pub enum GrainParts<'a> {
    /// A list.
    List(&'a [QuantisedGrain]),
    /// Grains that are held in another form.
    Parts {
        /// Number of parts.
        count: usize,
        /// Appends the grains of a part, always in the same order.
        read: &'a PartReader<'a>,
    },
}

/// Appends the grains of the part to the list.
pub type PartReader<'a> = dyn Fn(usize, &mut Vec<QuantisedGrain>) + Sync + 'a;

impl GrainParts<'_> {
    pub(super) fn count(&self) -> usize {
        match self {
            Self::List(grains) => grains.len().div_ceil(GRAINS_PER_PART),
            Self::Parts { count, .. } => *count,
        }
    }

    #[inline(always)]
    pub(super) fn for_each(&self, part: usize, mut visit: impl FnMut(QuantisedGrain)) {
        match self {
            Self::List(grains) => {
                let first = part * GRAINS_PER_PART;
                let last = grains.len().min(first + GRAINS_PER_PART);
                grains[first..last].iter().for_each(|&grain| visit(grain));
            }
            Self::Parts { read, .. } => {
                let mut grains = Vec::new();
                read(part, &mut grains);
                grains.into_iter().for_each(visit);
            }
        }
    }
}

impl fmt::Debug for GrainParts<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("GrainParts").field("count", &self.count()).finish_non_exhaustive()
    }
}

impl<'a> From<&'a [QuantisedGrain]> for GrainParts<'a> {
    fn from(grains: &'a [QuantisedGrain]) -> Self {
        Self::List(grains)
    }
}

impl<'a> From<&'a Vec<QuantisedGrain>> for GrainParts<'a> {
    fn from(grains: &'a Vec<QuantisedGrain>) -> Self {
        Self::List(grains)
    }
}

impl<'a, const N: usize> From<&'a [QuantisedGrain; N]> for GrainParts<'a> {
    fn from(grains: &'a [QuantisedGrain; N]) -> Self {
        Self::List(grains)
    }
}
