//! Measures of snow as a material: slabs that repeat for ever, and bodies lit from all around; and the glints of a
//! scene.
//!
//! Every measure traces the exact walk of [`crate::transport`] and reports plain means with their
//! standard errors, so that it can be compared with the identities and tables of snow optics.

mod body;
mod glints;
mod packed_slab;
mod proxy;
mod slab;

pub use body::{BodyMeasure, measure_body};
pub use glints::{GlintCount, GlintKind, GlintMeasure, GlintSun, measure_glints};
pub use packed_slab::PackedSlab;
pub use proxy::{CALIBRATION_PATHS, calibrate_proxy, calibration_by};
pub use slab::{
    Incidence, SlabMeasure, SlabSettings, measure_slab, measure_slab_in_depth,
    measure_slab_in_medium,
};

use rayon::prelude::*;

/// Paths in one task; also the unit in which random streams are numbered.
const PATHS_PER_TASK: u64 = 1 << 14;

/// A mean and its standard error.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Estimate {
    /// The mean.
    pub mean: f64,
    /// Its standard error, estimated from the samples.
    pub standard_error: f64,
}

/// Sums of a quantity and of its square.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Moments {
    sum: f64,
    sum_of_squares: f64,
}

impl Moments {
    pub(crate) fn add(&mut self, value: f64) {
        self.sum += value;
        self.sum_of_squares += value * value;
    }

    pub(crate) fn merge(&mut self, other: &Self) {
        self.sum += other.sum;
        self.sum_of_squares += other.sum_of_squares;
    }

    pub(crate) fn estimate(&self, count: u64) -> Estimate {
        let n = count as f64;
        let mean = self.sum / n;
        let variance = (self.sum_of_squares / n - mean * mean).max(0.0);
        Estimate { mean, standard_error: (variance / (n - 1.0).max(1.0)).sqrt() }
    }
}

/// Runs `task(first path, paths)` over all paths in parallel; the results come back in order, so
/// that sums of floating-point numbers do not depend on the threads.
pub(crate) fn in_tasks<Part: Send>(
    paths: u64,
    task: impl Fn(u64, u64) -> Part + Sync,
) -> Vec<Part> {
    (0..paths.div_ceil(PATHS_PER_TASK))
        .into_par_iter()
        .map(|index| {
            let first = index * PATHS_PER_TASK;
            task(first, PATHS_PER_TASK.min(paths - first))
        })
        .collect()
}
