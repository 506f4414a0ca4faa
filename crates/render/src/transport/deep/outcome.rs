//! What a path brings on average from a place on.

use crate::transport::Contribution;
use snowgrain_accel::STRATA;

/// The light of one slot that a path brings from somewhere on, and its length in ice until then.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Outcome {
    /// Linear sRGB before the ice.
    pub(super) weight: [f32; 3],
    /// Means of the first three powers of the length, times the sum of the channels; lengths in units of
    /// the field.
    pub(super) lengths: [f32; 3],
    /// Of the mean length, that in grains of each stratum from 1 on.
    pub(super) in_strata: [f32; STRATA],
    /// Standard error of the mean of the channels.
    pub(super) standard_error: f32,
}

/// Numbers of an outcome: three of light, three powers of the length, lengths in strata.
pub(super) const PARTS: usize = 6 + STRATA;

impl Outcome {
    /// Of its parts in a row.
    pub(super) fn of_parts(parts: [f32; PARTS], standard_error: f32) -> Self {
        Self {
            weight: std::array::from_fn(|c| parts[c]),
            lengths: std::array::from_fn(|power| parts[3 + power]),
            in_strata: std::array::from_fn(|stratum| parts[6 + stratum]),
            standard_error,
        }
    }

    /// Adds another one, times a number.
    pub(super) fn add(&mut self, other: &Self, times: f32) {
        let add = |mine: &mut [f32], theirs: &[f32]| {
            mine.iter_mut().zip(theirs).for_each(|(mine, theirs)| *mine += theirs * times);
        };
        add(&mut self.weight, &other.weight);
        add(&mut self.lengths, &other.lengths);
        add(&mut self.in_strata, &other.in_strata);
        self.standard_error += other.standard_error * times;
    }

    /// Its parts in a row.
    pub(super) fn parts(&self) -> [f32; PARTS] {
        let mut parts = self.weight.iter().chain(&self.lengths).chain(&self.in_strata);
        std::array::from_fn(|_| parts.next().copied().unwrap_or_default())
    }

    /// The mean of the channels.
    pub(super) fn light(&self) -> f64 {
        f64::from(self.weight.iter().sum::<f32>()) / 3.0
    }

    /// Two lengths with their shares of the light, which together have its mean length, variance and
    /// skewness (the Gauss quadrature of two nodes).
    pub(super) fn nodes(&self) -> [(f64, f64); 2] {
        let total = f64::from(self.weight[0] + self.weight[1] + self.weight[2]);
        if total <= 0.0 {
            return [(0.0, 0.0); 2];
        }
        let [first, second, third] = self.lengths.map(|sum| f64::from(sum) / total);
        let variance = second - first * first;
        if variance <= 1e-6 * second {
            return [(first, 1.0), (first, 0.0)];
        }
        let deviation = variance.sqrt();
        let central = third - 3.0 * first * second + 2.0 * first * first * first;
        let half_skewness = 0.5 * central / (variance * deviation);
        let root = (1.0 + half_skewness * half_skewness).sqrt();
        let node = |sign: f64| {
            let length = (first + deviation * (half_skewness + sign * root)).max(0.0);
            (length, 0.5 * (1.0 - sign * half_skewness / root))
        };
        [node(-1.0), node(1.0)]
    }

    /// What a path of this throughput, length and length in each stratum (metres) brings that ends here.
    pub(super) fn contributions(
        &self,
        (slot, event, unit): (usize, u32, f64),
        throughput: [f32; 3],
        (length, in_strata): (f64, [f64; STRATA]),
    ) -> impl Iterator<Item = Contribution> {
        let mean = f64::from(self.lengths[0]).max(f64::MIN_POSITIVE);
        let total = f64::from(self.weight[0] + self.weight[1] + self.weight[2]);
        let parts = self.in_strata.map(|part| f64::from(part) / mean);
        let light = std::array::from_fn::<f64, 3, _>(|c| f64::from(throughput[c] * self.weight[c]));
        let nodes = self.nodes().into_iter().filter(move |&(_, share)| total > 0.0 && share > 0.0);
        nodes.map(move |(more, share)| Contribution {
            slot,
            glint: false,
            event,
            weight: light.map(|channel| (channel * share) as f32),
            ice_length: length + more * unit,
            ice_in_strata: std::array::from_fn(|s| in_strata[s] + more * unit * parts[s]),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Two lengths are told exactly by their moments.
    #[test]
    fn two_lengths_are_found_again() {
        let (a, b, part) = (0.7_f64, 5.0_f64, 0.2_f64);
        let moment = |k: u32| {
            (0..k).fold(1.0, |p, _| p * a) * (1.0 - part) + (0..k).fold(1.0, |p, _| p * b) * part
        };
        let total = 3.0;
        let lengths = [1, 2, 3].map(|k| (total * moment(k)) as f32);
        let outcome = Outcome { weight: [1.0; 3], lengths, ..Outcome::default() };
        let [(low, of_low), (high, of_high)] = outcome.nodes();
        for (found, wanted) in [(low, a), (of_low, 1.0 - part), (high, b), (of_high, part)] {
            assert!((found - wanted).abs() < 1e-5, "{found} {wanted}");
        }
    }

    #[test]
    fn a_single_length_is_one_node() {
        let outcome =
            Outcome { weight: [1.0; 3], lengths: [6.0, 12.0, 24.0], ..Outcome::default() };
        assert_eq!(outcome.nodes(), [(2.0, 1.0), (2.0, 0.0)]);
    }
}
