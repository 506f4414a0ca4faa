//! What light among real grains differs by from light that meets spheres at random.

/// What real grains of a solid fraction differ by from spheres that are met at random.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Calibration {
    /// Solid fraction.
    pub solid: f64,
    /// Way from grain to grain over the mean chord of the void, 4 r (1 - phi) / (3 phi): so that as much light comes through a slab.
    pub chord: f64,
    /// Grains that each meeting stands for: so that light visits as many, and travels as far in ice.
    pub grains: f64,
}

/// Packs of equal spheres of ice in air, by `cargo xtask roads --calibrate`: see docs/roads.md. Without grains there is nothing to
/// differ by.
pub const CALIBRATION: [Calibration; 5] = [
    Calibration { solid: 0.0, chord: 1.0, grains: 1.0 },
    Calibration { solid: 0.164, chord: 1.063, grains: 1.049 },
    Calibration { solid: 0.300, chord: 1.143, grains: 1.108 },
    Calibration { solid: 0.436, chord: 1.242, grains: 1.173 },
    Calibration { solid: 0.545, chord: 1.372, grains: 1.218 },
];

impl Calibration {
    /// Between two solid fractions of a table in rising order, evenly; beyond its ends as there.
    pub(super) fn at(table: &[Self], solid: f64) -> Self {
        let above = table.partition_point(|entry| entry.solid < solid);
        let high = table[above.min(table.len() - 1)];
        let low = table[above.saturating_sub(1).min(table.len() - 1)];
        if high.solid <= low.solid {
            return high;
        }
        let part = (solid - low.solid) / (high.solid - low.solid);
        let between = |from: f64, to: f64| from + part * (to - from);
        Self {
            solid,
            chord: between(low.chord, high.chord),
            grains: between(low.grains, high.grains),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tables_are_even_between_their_entries_and_constant_beyond() {
        let [from, to] = [CALIBRATION[1], CALIBRATION[2]];
        let middle = Calibration::at(&CALIBRATION, 0.5 * (from.solid + to.solid));
        assert!((middle.chord - 0.5 * (from.chord + to.chord)).abs() < 1e-12);
        assert!((middle.grains - 0.5 * (from.grains + to.grains)).abs() < 1e-12);
        assert_eq!(Calibration::at(&CALIBRATION, 0.0), CALIBRATION[0]);
        assert_eq!(Calibration::at(&CALIBRATION, 0.8), CALIBRATION[4]);
        assert_eq!(Calibration::at(&CALIBRATION[..1], 0.3), CALIBRATION[0]);
    }
}
