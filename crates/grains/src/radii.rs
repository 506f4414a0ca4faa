//! Sizes of grains.

use crate::GrainsError;
use snowgrain_math::trig;
use std::sync::Arc;

/// Radii of log-normal grains lie within so many standard deviations of the median (99.7 % of them do).
const LOG_NORMAL_REACH: f64 = 3.0;
/// Steps of the curve that stands for a log-normal distribution.
const LOG_NORMAL_STEPS: u32 = 240;
/// Most classes of a measured distribution.
const MOST_CLASSES: usize = 10_000;

/// How many grains have which radius.
#[derive(Clone, Debug, PartialEq)]
pub enum Radii {
    /// Uniform between `mean - variation` and `mean + variation` (the paper, section 4.1), metres.
    Uniform {
        /// Mean radius r, metres, > 0.
        mean: f64,
        /// Half-width r_sigma, metres, between 0 and `mean`.
        variation: f64,
    },
    /// Any other distribution, by its cumulative curve.
    Curve(Arc<RadiusCurve>),
}

impl Radii {
    /// Equal grains of this radius, metres.
    #[must_use]
    pub fn equal(radius: f64) -> Self {
        Self::Uniform { mean: radius, variation: 0.0 }
    }

    /// Log-normal by number, cut off at three standard deviations: `median` in metres,
    /// `geometric_deviation` > 1 the factor of one standard deviation.
    ///
    /// # Errors
    /// A median that is not positive and finite, a deviation that is not above 1 and at most 3.
    pub fn log_normal(median: f64, geometric_deviation: f64) -> Result<Self, GrainsError> {
        Self::equal(median).check()?;
        if !(geometric_deviation > 1.0 && geometric_deviation <= 3.0) {
            let reason = format!(
                "is {geometric_deviation}, but must be above 1 and at most 3: the factor of one \
                 geometric standard deviation"
            );
            return Err(GrainsError::setting("spread", reason));
        }
        let deviation = trig::ln(geometric_deviation);
        let step = 2.0 * LOG_NORMAL_REACH / f64::from(LOG_NORMAL_STEPS);
        let at = |index: f64| -LOG_NORMAL_REACH + step * index;
        let mut cumulative = 0.0;
        let mut points = vec![(median * trig::exp(deviation * at(0.0)), 0.0)];
        for index in 0..LOG_NORMAL_STEPS {
            let middle = at(f64::from(index) + 0.5);
            cumulative += trig::exp(-0.5 * middle * middle);
            points.push((median * trig::exp(deviation * at(f64::from(index + 1))), cumulative));
        }
        Ok(Self::Curve(Arc::new(RadiusCurve::normalised(points))))
    }

    /// A measured distribution: classes of `(radius, number of grains)`, metres and any unit, in rising
    /// order of the radius. Within a class, which reaches half-way to its neighbours, radii are uniform.
    ///
    /// # Errors
    /// Fewer than two classes or too many, radii that are not positive, finite and rising, negative
    /// numbers, or none at all.
    pub fn measured(classes: &[(f64, f64)]) -> Result<Self, GrainsError> {
        let bad = |reason: String| Err(GrainsError::setting("sizes", reason));
        if !(2..=MOST_CLASSES).contains(&classes.len()) {
            return bad(format!("must hold 2 to {MOST_CLASSES} classes, not {}", classes.len()));
        }
        for (index, &(radius, number)) in classes.iter().enumerate() {
            let rises = index == 0 || classes[index - 1].0 < radius;
            if !(radius > 0.0 && radius.is_finite() && rises) {
                return bad(format!(
                    "class {} has radius {radius} m, but radii must be positive and rise",
                    index + 1
                ));
            }
            if !(number >= 0.0 && number.is_finite()) {
                return bad(format!(
                    "class {} has {number} grains, but needs 0 or more",
                    index + 1
                ));
            }
        }
        if classes.iter().all(|class| class.1 == 0.0) {
            return bad("every class is empty".into());
        }
        let half = |index: usize| 0.5 * (classes[index + 1].0 - classes[index].0);
        let last = classes.len() - 1;
        let mut cumulative = 0.0;
        let mut points = vec![((classes[0].0 - half(0)).max(0.5 * classes[0].0), 0.0)];
        for (index, class) in classes.iter().enumerate() {
            cumulative += class.1;
            points.push((class.0 + half(index.min(last - 1)), cumulative));
        }
        Ok(Self::Curve(Arc::new(RadiusCurve::normalised(points))))
    }

    /// The same distribution in another unit of length, `unit` metres long.
    #[must_use]
    pub fn in_units_of(&self, unit: f64) -> Self {
        match self {
            Self::Uniform { mean, variation } => {
                Self::Uniform { mean: mean / unit, variation: variation / unit }
            }
            Self::Curve(curve) => {
                let points = curve.points.iter().map(|&(r, c)| (r / unit, c)).collect();
                Self::Curve(Arc::new(RadiusCurve { points }))
            }
        }
    }

    /// Mean radius, metres.
    #[must_use]
    pub fn mean(&self) -> f64 {
        match self {
            Self::Uniform { mean, .. } => *mean,
            Self::Curve(curve) => curve.moment(|low, high| 0.5 * (low + high)),
        }
    }

    /// Largest radius that can be drawn, metres.
    #[must_use]
    pub fn largest(&self) -> f64 {
        match self {
            Self::Uniform { mean, variation } => mean + variation,
            Self::Curve(curve) => curve.points.last().map_or(0.0, |point| point.0),
        }
    }

    /// Mean of the cube of the radius, cubic metres.
    #[must_use]
    pub fn mean_cube(&self) -> f64 {
        match self {
            Self::Uniform { mean, variation } => mean * (mean * mean + variation * variation),
            Self::Curve(curve) => {
                curve.moment(|low, high| 0.25 * (low + high) * (low * low + high * high))
            }
        }
    }

    /// # Errors
    /// A mean that is not positive and finite, a variation that is not between 0 and the mean.
    pub fn check(&self) -> Result<(), GrainsError> {
        let Self::Uniform { mean, variation } = *self else { return Ok(()) };
        if !(mean > 0.0 && mean.is_finite()) {
            let reason = format!("is {mean} m, but must be a positive finite length");
            return Err(GrainsError::setting("radius", reason));
        }
        if !(0.0..=mean).contains(&variation) {
            let reason =
                format!("is {variation} m, but must lie between 0 and the radius, {mean} m");
            return Err(GrainsError::setting("variation", reason));
        }
        Ok(())
    }

    /// The radius, metres, that the part `unit` of all grains does not exceed.
    #[must_use]
    pub fn quantile(&self, unit: f64) -> f64 {
        match self {
            Self::Uniform { mean, variation } => mean + (2.0 * unit - 1.0) * variation,
            Self::Curve(curve) => curve.quantile(unit),
        }
    }
}

/// A cumulative distribution of radii, linear between points.
#[derive(Clone, Debug, PartialEq)]
pub struct RadiusCurve {
    /// Radius, metres, and the part of the grains that do not exceed it: from 0 to 1.
    points: Vec<(f64, f64)>,
}

impl RadiusCurve {
    fn normalised(mut points: Vec<(f64, f64)>) -> Self {
        let all = points.last().map_or(1.0, |point| point.1);
        points.iter_mut().for_each(|point| point.1 /= all);
        Self { points }
    }

    /// Mean of a function of the radius, given its means between two radii.
    fn moment(&self, between: impl Fn(f64, f64) -> f64) -> f64 {
        self.points.windows(2).map(|p| (p[1].1 - p[0].1) * between(p[0].0, p[1].0)).sum()
    }

    fn quantile(&self, unit: f64) -> f64 {
        let above = self.points.partition_point(|point| point.1 < unit);
        let above = above.clamp(1, self.points.len() - 1);
        let [(low, from), (high, to)] = [self.points[above - 1], self.points[above]];
        let part = if to > from { ((unit - from) / (to - from)).clamp(0.0, 1.0) } else { 1.0 };
        low + part * (high - low)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sampled(radii: &Radii, of: impl Fn(f64) -> f64) -> f64 {
        let all = 100_000;
        let unit = |index: u32| (f64::from(index) + 0.5) / f64::from(all);
        (0..all).map(|index| of(radii.quantile(unit(index)))).sum::<f64>() / f64::from(all)
    }

    #[test]
    fn moments_are_those_of_what_is_drawn() {
        let classes = [(0.2e-3, 1.0), (0.4e-3, 5.0), (0.5e-3, 0.0), (0.9e-3, 2.0)];
        let all = [
            Radii::Uniform { mean: 1e-3, variation: 0.4e-3 },
            Radii::log_normal(0.5e-3, 1.4).unwrap(),
            Radii::measured(&classes).unwrap(),
        ];
        for radii in all {
            let mean = sampled(&radii, |r| r);
            assert!((radii.mean() / mean - 1.0).abs() < 1e-4, "{radii:?}");
            let cube = sampled(&radii, |r| r * r * r);
            assert!((radii.mean_cube() / cube - 1.0).abs() < 1e-4);
            assert!(radii.quantile(1.0) <= radii.largest() && radii.quantile(0.0) > 0.0);
            let half = radii.in_units_of(2.0);
            assert!((half.mean_cube() / radii.mean_cube() - 0.125).abs() < 1e-9);
        }
    }

    #[test]
    fn log_normal_radii_have_the_moments_of_the_closed_form() {
        // Mean of r^3 is median^3 exp(9 sigma^2 / 2); what the cut at 3 deviations takes is below 4 %.
        let radii = Radii::log_normal(1.0, 1.2).unwrap();
        let sigma = trig::ln(1.2);
        let expected = trig::exp(4.5 * sigma * sigma);
        assert!((radii.mean_cube() / expected - 1.0).abs() < 0.01, "{}", radii.mean_cube());
        assert!((radii.quantile(0.5) - 1.0).abs() < 1e-3);
        assert!((radii.quantile(0.8413) / 1.2 - 1.0).abs() < 2e-3);
    }

    #[test]
    fn distributions_without_meaning_are_refused() {
        for (median, deviation) in [(0.0, 1.2), (1.0, 1.0), (1.0, 4.0), (1.0, f64::NAN)] {
            assert!(Radii::log_normal(median, deviation).is_err());
        }
        let refused: [&[(f64, f64)]; 5] = [
            &[(1.0, 1.0)],
            &[(1.0, 1.0), (1.0, 2.0)],
            &[(0.0, 1.0), (1.0, 2.0)],
            &[(1.0, 1.0), (2.0, -1.0)],
            &[(1.0, 0.0), (2.0, 0.0)],
        ];
        refused.iter().for_each(|classes| assert!(Radii::measured(classes).is_err()));
    }
}
