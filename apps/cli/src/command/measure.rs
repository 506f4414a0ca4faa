//! `snowgrain measure`.

mod cube;
mod glints;
mod search;
mod slab;
mod snow;

use crate::arguments::{MeasureArguments, MeasureKind};
use crate::failure::Failure;
use serde::Serialize;
use snowgrain_render::measure::Estimate;

pub(super) fn run(arguments: &MeasureArguments) -> Result<u8, Failure> {
    match &arguments.kind {
        MeasureKind::Slab(arguments) => slab::run(arguments),
        MeasureKind::Cube(arguments) => cube::run(arguments),
        MeasureKind::Search(arguments) => search::run(arguments),
        MeasureKind::Glints(arguments) => glints::run(arguments),
    }
}

/// A mean, its standard error, and what it should be.
#[derive(Clone, Copy, Debug, Serialize)]
struct Figure {
    mean: f64,
    standard_error: f64,
    #[serde(skip_serializing_if = "Option::is_none")]
    expected: Option<f64>,
}

impl Figure {
    fn of(estimate: Estimate) -> Self {
        let Estimate { mean, standard_error } = estimate;
        Self { mean, standard_error, expected: None }
    }

    fn expecting(self, expected: f64) -> Self {
        Self { expected: Some(expected), ..self }
    }

    /// `.1234 +- .0012`, and how it compares.
    fn text(&self, formula: &str) -> String {
        let Self { mean, standard_error, expected } = self;
        let digits = digits(*mean);
        let measured = format!("{mean:.digits$} +- {standard_error:.digits$}");
        match expected {
            Some(expected) => format!(
                "{measured}   {formula} = {expected:.digits$}, {:+.3} %",
                100.0 * (mean / expected - 1.0)
            ),
            None => measured,
        }
    }
}

/// Decimals that show six digits or so of a number.
fn digits(number: f64) -> usize {
    (0..12).find(|&n| number.abs() * power_of_ten(n) >= 1e4).unwrap_or(12)
}

/// 10 to the power of `n`.
fn power_of_ten(n: usize) -> f64 {
    (0..n).fold(1.0, |power, _| power * 10.0)
}
