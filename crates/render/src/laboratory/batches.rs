//! Means of many numbers at once, whose errors follow from the differences between batches of paths.

use super::progress::{Round, Tell};
use crate::measure::Estimate;
use rayon::prelude::*;

/// Batches whose means are held at a time.
const AT_ONCE: u64 = 256;

/// How many paths are followed at a time, and in all.
#[derive(Clone, Copy, Debug)]
pub(super) struct Batches {
    /// Paths in a batch.
    pub(super) paths: u64,
    /// Batches of the first round, at least 2.
    pub(super) first: u64,
    /// Paths at which the search ends.
    pub(super) most_paths: u64,
}

impl Batches {
    /// The means over batches, traced until `error` of them, in that to reach, is at most 1, or too many
    /// paths are. `batch` gives the means of the batch of a number, always as many.
    pub(super) fn until_exact(
        self,
        batch: impl Fn(u64) -> Vec<f64> + Sync,
        error: impl Fn(&[Estimate]) -> f64,
        tell: Tell<'_>,
    ) -> Vec<Estimate> {
        let mut sums: Vec<[f64; 2]> = Vec::new();
        let (mut done, mut next, mut short) = (0u64, self.first.max(2), f64::INFINITY);
        loop {
            let round = Round::new(tell, done, short);
            let one = |number: u64| {
                let means = batch(number);
                round.add(1);
                means
            };
            let until = done + next;
            while done < until {
                let some = done..until.min(done + AT_ONCE);
                done = some.end;
                let parts: Vec<Vec<f64>> = some.into_par_iter().map(one).collect();
                sums.resize(parts[0].len(), [0.0; 2]);
                for part in &parts {
                    for (sum, value) in sums.iter_mut().zip(part) {
                        *sum = [sum[0] + value, sum[1] + value * value];
                    }
                }
            }
            let n = done as f64;
            let estimate = |[sum, squares]: &[f64; 2]| {
                let mean = sum / n;
                let variance = (squares / n - mean * mean).max(0.0);
                Estimate { mean, standard_error: (variance / (n - 1.0)).sqrt() }
            };
            let means: Vec<Estimate> = sums.iter().map(estimate).collect();
            let error = error(&means);
            short = error * error;
            if short <= 1.0 || done * self.paths >= self.most_paths {
                return means;
            }
            // A little more than is missing, but not far beyond what is known.
            next = ((n * (1.05 * short - 1.0).clamp(0.1, 2.0)) as u64).max(1);
        }
    }
}
