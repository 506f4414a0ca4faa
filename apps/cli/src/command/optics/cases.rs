//! Many cases at once.

use crate::failure::Failure;
use crate::progress::Progress;
use rayon::ThreadPool;
use rayon::prelude::*;
use snowgrain_render::laboratory::Tell;

/// Whether a case leaves the others room beside it.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Share {
    /// It is found at the same time as others.
    Together,
    /// It needs much memory: one such case at a time.
    Alone,
}

/// What `find` finds of each case, in their order. A case does not depend on the others, so that the
/// threads cannot show; the first failure counts.
pub(super) fn find_all<Case: Sync, Found: Send>(
    (progress, pool, work): (&Progress, &ThreadPool, &str),
    cases: &[Case],
    share: impl Fn(&Case) -> Share,
    find: impl Fn(&Case, Tell<'_>) -> Result<Found, Failure> + Sync,
) -> Result<Vec<Found>, Failure> {
    let (together, alone): (Vec<usize>, Vec<usize>) =
        (0..cases.len()).partition(|&index| share(&cases[index]) == Share::Together);
    progress.cases(work, cases.len(), |parts| {
        let one = |&index: &usize| {
            let found = find(&cases[index], &|done| parts.tell(index, done));
            parts.tell(index, 1.0);
            (index, found)
        };
        let mut all: Vec<_> = pool.install(|| together.par_iter().map(one).collect());
        all.extend(alone.iter().map(|index| pool.install(|| one(index))));
        all.sort_by_key(|(index, _)| *index);
        all.into_iter().map(|(_, found)| found).collect()
    })
}
