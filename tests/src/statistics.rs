//! Means of many paths with their standard errors.

use rayon::prelude::*;

/// A mean and the standard error of it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Estimate {
    /// The mean.
    pub mean: f64,
    /// Its standard error.
    pub standard_error: f64,
}

impl Estimate {
    /// Whether `expected` (known to within `tolerance`) lies within `sigmas` standard errors.
    #[must_use]
    pub fn agrees_with(&self, expected: f64, tolerance: f64, sigmas: f64) -> bool {
        (self.mean - expected).abs() <= tolerance + sigmas * self.standard_error
    }

    /// The estimate of a ratio of means, to first order in their errors; `sum` estimates the sum of
    /// both, from the same paths, and so knows how they vary together.
    #[must_use]
    pub fn ratio(numerator: Self, denominator: Self, sum: Self) -> Self {
        let square = |e: Self| e.standard_error * e.standard_error;
        let mean = numerator.mean / denominator.mean;
        let covariance = 0.5 * (square(sum) - square(numerator) - square(denominator));
        let residual =
            square(numerator) - 2.0 * mean * covariance + mean * mean * square(denominator);
        Self { mean, standard_error: residual.max(0.0).sqrt() / denominator.mean }
    }

    /// The estimate of a sum of `count` values with the sum of their squares.
    fn from_sums(count: f64, sum: f64, squares: f64) -> Self {
        let mean = sum / count;
        let variance = (squares / count - mean * mean).max(0.0);
        Self { mean, standard_error: (variance / (count - 1.0).max(1.0)).sqrt() }
    }
}

/// Estimates of the `K` numbers that `sample` gives for each of `count` indices, in parallel. The
/// order of summation is fixed, so the result does not depend on the number of threads.
pub fn estimate<const K: usize>(
    count: u64,
    sample: impl Fn(u64) -> [f64; K] + Sync,
) -> [Estimate; K] {
    const CHUNK: u64 = 256;
    let sums: Vec<[[f64; 2]; K]> = (0..count.div_ceil(CHUNK))
        .into_par_iter()
        .map(|chunk| {
            let mut sums = [[0.0; 2]; K];
            for index in chunk * CHUNK..count.min((chunk + 1) * CHUNK) {
                for (sum, value) in sums.iter_mut().zip(sample(index)) {
                    sum[0] += value;
                    sum[1] += value * value;
                }
            }
            sums
        })
        .collect();
    core::array::from_fn(|k| {
        let total = |part: usize| sums.iter().map(|chunk| chunk[k][part]).sum::<f64>();
        Estimate::from_sums(count as f64, total(0), total(1))
    })
}
