//! Bins that grow with the distance.

use super::SpreadBin;
use crate::measure::Estimate;
use core::f64::consts::{LN_10, LOG10_E};
use snowgrain_math::trig;

/// Bins of equal factors from `first` on, with one below and one above.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Axis {
    pub(super) first: f64,
    pub(super) per_decade: u32,
    /// Without the lowest and the highest.
    pub(super) bins: u32,
}

impl Axis {
    /// All bins.
    pub(super) fn count(&self) -> usize {
        self.bins as usize + 2
    }

    pub(super) fn bin(&self, value: f64) -> usize {
        if value < self.first {
            return 0;
        }
        let decades = trig::ln(value / self.first) * LOG10_E;
        1 + ((decades * f64::from(self.per_decade)) as usize).min(self.bins as usize)
    }

    /// Where a bin begins and ends.
    fn edges(&self, bin: usize) -> [f64; 2] {
        let end = |bin: usize| {
            let decades = bin as f64 / f64::from(self.per_decade);
            self.first * trig::exp(LN_10 * decades)
        };
        let from = if bin == 0 { 0.0 } else { end(bin - 1) };
        [from, if bin + 1 == self.count() { f64::INFINITY } else { end(bin) }]
    }

    /// Parts in bins as densities by the size of a bin, where it has one.
    pub(super) fn densities(
        &self,
        parts: &[Estimate],
        size: impl Fn([f64; 2]) -> f64,
    ) -> Vec<SpreadBin> {
        let of = |(bin, part): (usize, &Estimate)| {
            let [from, to] = self.edges(bin);
            let size = size([from, to]);
            let value =
                Estimate { mean: part.mean / size, standard_error: part.standard_error / size };
            SpreadBin { from, to, value }
        };
        parts.iter().enumerate().map(of).collect()
    }

    /// Values at the ends of bins.
    pub(super) fn ends(&self, values: &[Estimate]) -> Vec<SpreadBin> {
        self.densities(values, |_| 1.0)
    }
}

/// Sums from the first part on.
pub(super) fn cumulated(parts: &[f64]) -> Vec<f64> {
    let mut sum = 0.0;
    let up_to = |part: &f64| {
        sum += part;
        sum
    };
    parts.iter().map(up_to).collect()
}

/// Where the fraction of all is reached, spread evenly within a bin; its error is that of the part within
/// over the density there.
pub(super) fn quantile(
    axis: &Axis,
    parts: &[Estimate],
    within: &[Estimate],
    fraction: f64,
) -> Estimate {
    let none = Estimate { mean: f64::NAN, standard_error: f64::NAN };
    let wanted = fraction * within.last().map_or(0.0, |all| all.mean);
    let Some(bin) = within.iter().position(|part| part.mean >= wanted && wanted > 0.0) else {
        return none;
    };
    let ([from, to], part) = (axis.edges(bin), parts[bin].mean);
    if to.is_infinite() || part == 0.0 {
        return none;
    }
    let before = within[bin].mean - part;
    Estimate {
        mean: from + (to - from) * (wanted - before) / part,
        standard_error: within[bin].standard_error * (to - from) / part,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bins_hold_what_lies_between_their_edges() {
        let axis = Axis { first: 0.1, per_decade: 4, bins: 8 };
        assert_eq!((axis.count(), axis.bin(0.0), axis.bin(0.11), axis.bin(1e9)), (10, 0, 1, 9));
        for value in [0.05, 0.12, 0.3, 1.2, 7.0, 9.9, 20.0] {
            let [from, to] = axis.edges(axis.bin(value));
            assert!(from <= value && value < to, "{value}: {from} {to}");
        }
        assert!(axis.edges(9)[1].is_infinite() && (axis.edges(8)[1] - 10.0).abs() < 1e-12);
    }

    #[test]
    fn half_of_what_is_even_lies_in_its_half() {
        let axis = Axis { first: 1.0, per_decade: 1, bins: 2 };
        let known = |mean: f64| Estimate { mean, standard_error: 0.01 };
        let parts = [0.0, 0.4, 0.0, 0.0].map(known);
        let within = [0.0, 0.4, 0.4, 0.4].map(known);
        let half = quantile(&axis, &parts, &within, 0.5);
        assert!((half.mean - 5.5).abs() < 1e-9, "{half:?}");
        assert!((half.standard_error - 0.01 * 9.0 / 0.4).abs() < 1e-9);
        assert!(quantile(&axis, &[known(0.0); 4], &[known(0.0); 4], 0.5).mean.is_nan());
    }
}
