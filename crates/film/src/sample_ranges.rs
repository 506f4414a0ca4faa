//! Which samples a film holds.

use crate::FilmError;
use std::fmt;
use std::ops::Range;

/// Sample indices as sorted, disjoint, non-touching ranges, so that equal sets compare equal.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct SampleRanges(Vec<Range<u64>>);

impl SampleRanges {
    /// The ranges in ascending order.
    #[must_use]
    pub fn as_slice(&self) -> &[Range<u64>] {
        &self.0
    }

    /// Number of samples.
    #[must_use]
    pub fn total(&self) -> u64 {
        self.0.iter().map(|range| range.end - range.start).sum()
    }

    /// The parts of a range that are not held, ascending.
    #[must_use]
    pub fn missing_from(&self, range: Range<u64>) -> Vec<Range<u64>> {
        let mut missing = Vec::new();
        let mut at = range.start;
        for held in &self.0 {
            if held.start.min(range.end) > at {
                missing.push(at..held.start.min(range.end));
            }
            at = at.max(held.end);
        }
        if at < range.end {
            missing.push(at..range.end);
        }
        missing
    }

    /// Adds a range.
    ///
    /// # Errors
    /// An empty range, or one of which some sample is there already.
    pub fn insert(&mut self, range: Range<u64>) -> Result<(), FilmError> {
        if range.is_empty() {
            return Err(FilmError::EmptySampleRange { start: range.start, end: range.end });
        }
        let at = self.0.partition_point(|held| held.end < range.start);
        let overlap = self.0[at..].iter().find(|r| r.start < range.end && range.start < r.end);
        if let Some(held) = overlap {
            return Err(FilmError::SamplesTwice {
                start: held.start.max(range.start),
                end: held.end.min(range.end),
            });
        }
        let touching = self.0[at..].iter().take_while(|held| held.start <= range.end).count();
        let joined = self.0[at..at + touching]
            .iter()
            .fold(range, |joined, held| joined.start.min(held.start)..joined.end.max(held.end));
        self.0.splice(at..at + touching, [joined]);
        Ok(())
    }

    /// Adds every range of `other`; on an error nothing is added.
    ///
    /// # Errors
    /// As [`SampleRanges::insert`].
    pub fn insert_all(&mut self, other: &Self) -> Result<(), FilmError> {
        let mut joined = self.clone();
        other.0.iter().try_for_each(|range| joined.insert(range.clone()))?;
        *self = joined;
        Ok(())
    }
}

impl fmt::Display for SampleRanges {
    /// As `0..16, 32..48`.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if self.0.is_empty() {
            return f.write_str("none");
        }
        for (index, range) in self.0.iter().enumerate() {
            let comma = if index > 0 { ", " } else { "" };
            write!(f, "{comma}{}..{}", range.start, range.end)?;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use std::collections::BTreeSet;

    proptest! {
        #[test]
        fn ranges_behave_as_a_set(inserts in prop::collection::vec((0u64..40, 0u64..8), 0..20)) {
            let mut ranges = SampleRanges::default();
            let mut set = BTreeSet::new();
            for (start, length) in inserts {
                let range = start..start + length;
                let fits = length > 0 && range.clone().all(|i| !set.contains(&i));
                prop_assert_eq!(ranges.insert(range.clone()).is_ok(), fits);
                if fits {
                    set.extend(range);
                }
                let held: Vec<u64> = ranges.as_slice().iter().cloned().flatten().collect();
                prop_assert_eq!(&held, &set.iter().copied().collect::<Vec<_>>());
                prop_assert!(ranges.as_slice().windows(2).all(|w| w[0].end < w[1].start));
                prop_assert_eq!(ranges.total(), set.len() as u64);
            }
            let missing: Vec<u64> = ranges.missing_from(5..33).into_iter().flatten().collect();
            prop_assert_eq!(missing, (5..33).filter(|i| !set.contains(i)).collect::<Vec<_>>());
        }
    }
}
