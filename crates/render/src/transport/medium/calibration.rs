//! What light among real grains differs by from light that meets spheres at random.

/// What real grains of a solid fraction differ by from spheres that are met at random.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Calibration {
    /// Solid fraction.
    pub solid: f64,
    /// Part of the grains that light passes straight through: so that as much comes through a slab.
    pub straight: f64,
}

/// Packs of equal spheres of ice in air, by `cargo xtask roads --calibrate`: see docs/roads.md. Without grains there is nothing to
/// differ by.
pub const CALIBRATION: [Calibration; 5] = [
    Calibration { solid: 0.0, straight: 0.0 },
    Calibration { solid: 0.164, straight: 0.052 },
    Calibration { solid: 0.300, straight: 0.074 },
    Calibration { solid: 0.436, straight: 0.076 },
    Calibration { solid: 0.545, straight: 0.106 },
];

impl Calibration {
    /// The part that passes straight between two solid fractions of a table in rising order, evenly; beyond its ends as there.
    pub(super) fn straight(table: &[Self], solid: f64) -> f64 {
        let above = table.partition_point(|entry| entry.solid < solid);
        let high = table[above.min(table.len() - 1)];
        let low = table[above.saturating_sub(1).min(table.len() - 1)];
        if high.solid <= low.solid {
            return high.straight;
        }
        let part = (solid - low.solid) / (high.solid - low.solid);
        low.straight + part * (high.straight - low.straight)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tables_are_even_between_their_entries_and_constant_beyond() {
        let [from, to] = [CALIBRATION[1], CALIBRATION[2]];
        let middle = Calibration::straight(&CALIBRATION, 0.5 * (from.solid + to.solid));
        assert!((middle - 0.5 * (from.straight + to.straight)).abs() < 1e-12);
        assert_eq!(Calibration::straight(&CALIBRATION, 0.0), CALIBRATION[0].straight);
        assert_eq!(Calibration::straight(&CALIBRATION, 0.8), CALIBRATION[4].straight);
        assert_eq!(Calibration::straight(&CALIBRATION[..1], 0.3), CALIBRATION[0].straight);
    }
}
