//! Axes: what part of the sheet a value has, and where its ticks are.

use core::f64::consts::{LN_10, LOG10_E};
use snowgrain_math::trig;

/// How values are spread over an axis.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(in crate::command) enum Scale {
    Linear,
    Logarithmic,
}

/// From where to where an axis goes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Axis {
    scale: Scale,
    from: f64,
    to: f64,
}

impl Axis {
    /// An axis that holds the values, of those that it can hold, with whole steps at its ends.
    pub(super) fn holding(scale: Scale, values: impl Iterator<Item = f64>) -> Self {
        let fits = |value: &f64| value.is_finite() && (scale == Scale::Linear || *value > 0.0);
        let [low, high] = values
            .filter(fits)
            .fold([f64::INFINITY, f64::NEG_INFINITY], |[a, b], v| [a.min(v), b.max(v)]);
        match (low <= high, scale) {
            (false, Scale::Linear) => Self { scale, from: 0.0, to: 1.0 },
            (false, Scale::Logarithmic) => Self { scale, from: 0.1, to: 1.0 },
            (true, Scale::Linear) => {
                let step = step(high - low, 5.0);
                let (from, to) = ((low / step).floor() * step, (high / step).ceil() * step);
                Self { scale, from, to: if to > from { to } else { from + step } }
            }
            (true, Scale::Logarithmic) => {
                let room = trig::exp(0.03 * trig::ln((high / low).max(1.5)));
                Self { scale, from: low / room, to: high * room }
            }
        }
    }

    /// An axis that ends with the values.
    pub(super) fn between(scale: Scale, values: impl Iterator<Item = f64> + Clone) -> Self {
        let [low, high] = values
            .clone()
            .filter(|value| value.is_finite())
            .fold([f64::INFINITY, f64::NEG_INFINITY], |[a, b], v| [a.min(v), b.max(v)]);
        match scale {
            Scale::Linear if low < high => Self { scale, from: low, to: high },
            _ => Self::holding(scale, values),
        }
    }

    /// An axis that goes from here to there.
    pub(super) fn of(from: f64, to: f64) -> Self {
        Self { scale: Scale::Linear, from, to }
    }

    /// The part of the axis below a value, 0 to 1 within it; `None` where there is none.
    pub(super) fn place(&self, value: f64) -> Option<f64> {
        let place = match self.scale {
            Scale::Linear => (value - self.from) / (self.to - self.from),
            Scale::Logarithmic => trig::ln(value / self.from) / trig::ln(self.to / self.from),
        };
        place.is_finite().then_some(place)
    }

    /// Values that are marked, and what is written beside them.
    pub(super) fn ticks(&self) -> Vec<(f64, String)> {
        match self.scale {
            Scale::Linear => {
                let step = step(self.to - self.from, 9.0);
                let first = (self.from / step - 1e-6).ceil() as i64;
                let last = (self.to / step + 1e-6).floor() as i64;
                (first..=last).map(|i| (i as f64 * step, decimal(i as f64 * step, step))).collect()
            }
            Scale::Logarithmic => self.decades(),
        }
    }

    /// Powers of ten; where there are few of them, twice and five times as much, too.
    fn decades(&self) -> Vec<(f64, String)> {
        let log10 = |value: f64| trig::ln(value) * LOG10_E;
        let (first, last) = (log10(self.from).floor() as i32, log10(self.to).ceil() as i32);
        let few = log10(self.to / self.from) < 2.0;
        let every = ((last - first) / 8).max(1);
        let mut ticks = Vec::new();
        for power in (first..=last).filter(|power| power % every == 0) {
            for multiple in if few { &[1.0, 2.0, 5.0][..] } else { &[1.0] } {
                let value = multiple * trig::exp(f64::from(power) * LN_10);
                if (self.from..=self.to).contains(&(value * (1.0 + 1e-12))) {
                    let words = if few { plain(value) } else { power_of_ten(power) };
                    ticks.push((value, words));
                }
            }
        }
        ticks
    }
}

/// The step of 1, 2 or 5 times a power of ten that makes about so many of the width.
fn step(width: f64, about: f64) -> f64 {
    let wanted = if width > 0.0 { width / about } else { 1.0 };
    let power = trig::exp((trig::ln(wanted) * LOG10_E).floor() * LN_10);
    let steps = [1.0, 2.0, 5.0, 10.0].map(|multiple| multiple * power);
    steps.into_iter().find(|step| *step >= wanted * 0.999).unwrap_or(steps[3])
}

/// A multiple of the step with as many decimals as that needs.
fn decimal(value: f64, step: f64) -> String {
    let decimals = (-(trig::ln(step) * LOG10_E + 1e-9).floor()).max(0.0) as usize;
    // No minus before nothing.
    let value = if value.abs() < 0.5 * step { 0.0 } else { value };
    format!("{value:.decimals$}")
}

fn plain(value: f64) -> String {
    let rounded: f64 = format!("{value:.1e}").parse().unwrap_or(value);
    rounded.to_string()
}

/// 10 with its power set high.
fn power_of_ten(power: i32) -> String {
    const HIGH: [char; 10] = ['⁰', '¹', '²', '³', '⁴', '⁵', '⁶', '⁷', '⁸', '⁹'];
    let digit = |c: char| c.to_digit(10).map_or('⁻', |digit| HIGH[digit as usize]);
    format!("10{}", power.to_string().chars().map(digit).collect::<String>())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ticks_are_round_numbers_within_the_axis() {
        let words = |axis: Axis| axis.ticks().into_iter().map(|tick| tick.1).collect::<Vec<_>>();
        let axis = Axis::holding(Scale::Linear, [0.13, 0.97].into_iter());
        assert_eq!(words(axis), ["0.0", "0.2", "0.4", "0.6", "0.8", "1.0"]);
        let axis = Axis::between(Scale::Linear, [350.0, 740.0].into_iter());
        assert_eq!((words(axis).len(), axis.place(350.0)), (8, Some(0.0)));
        assert_eq!(words(Axis::of(-50.0, 50.0)), ["-40", "-20", "0", "20", "40"]);
        let axis = Axis::holding(Scale::Logarithmic, [0.002, 70.0, 0.0].into_iter());
        assert_eq!(words(axis), ["10⁻²", "10⁻¹", "10⁰", "10¹"]);
        let axis = Axis::holding(Scale::Logarithmic, [3.0, 30.0].into_iter());
        assert_eq!(words(axis), ["5", "10", "20"]);
        assert!(axis.place(3.0).unwrap() > 0.0 && axis.place(0.0).is_none());
        let nothing = Axis::holding(Scale::Linear, core::iter::empty());
        assert_eq!(nothing.place(0.5), Some(0.5));
        assert!(Axis::holding(Scale::Linear, [2.0].into_iter()).place(2.0).is_some());
    }
}
