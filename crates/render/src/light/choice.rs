//! Choices among few or many, with fixed probabilities.

/// Numbers 0, 1, ..., each with its probability.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Choice {
    /// Sums of the weights so far, the last one 1; empty where nothing can be chosen.
    cumulative: Vec<f64>,
}

impl Choice {
    /// Choices in proportion to `weights`, finite and at least 0. Where all are 0, nothing is chosen.
    pub(super) fn new(weights: impl IntoIterator<Item = f64>) -> Self {
        let mut sum = 0.0;
        let mut cumulative: Vec<f64> = weights
            .into_iter()
            .map(|weight| {
                sum += weight;
                sum
            })
            .collect();
        if sum > 0.0 {
            // Those after the last weight above 0 end at 1 as it does: none is chosen in its place.
            cumulative.iter_mut().for_each(|end| *end = if *end == sum { 1.0 } else { *end / sum });
        } else {
            cumulative.clear();
        }
        Self { cumulative }
    }

    /// The number of `u` in [0, 1), and where `u` lies within its share, in [0, 1).
    pub(super) fn pick(&self, u: f64) -> Option<(usize, f64)> {
        let index = self.cumulative.partition_point(|&end| end <= u);
        let end = *self.cumulative.get(index)?;
        let start = self.start(index);
        Some((index, (u - start) / (end - start)))
    }

    /// How likely a number is.
    pub(super) fn probability(&self, index: usize) -> f64 {
        self.cumulative.get(index).map_or(0.0, |end| end - self.start(index))
    }

    fn start(&self, index: usize) -> f64 {
        index.checked_sub(1).map_or(0.0, |before| self.cumulative[before])
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shares_follow_the_weights_and_nothing_is_never_chosen() {
        let choice = Choice::new([0.0, 1.0, 0.0, 3.0, 0.0]);
        assert_eq!(
            [0, 1, 2, 3, 4, 5].map(|i| choice.probability(i)),
            [0.0, 0.25, 0.0, 0.75, 0.0, 0.0]
        );
        assert_eq!(choice.pick(0.0), Some((1, 0.0)));
        assert_eq!(choice.pick(0.25), Some((3, 0.0)));
        assert_eq!(choice.pick(0.625), Some((3, 0.5)));
        assert_eq!(choice.pick(1.0 - f64::EPSILON / 2.0).map(|(index, _)| index), Some(3));
        for empty in [Choice::new([]), Choice::new([0.0, 0.0])] {
            assert_eq!((empty.pick(0.0), empty.probability(0)), (None, 0.0));
        }
    }
}
