//! What light among real grains differs by from light that meets spheres at random.

/// What real grains of a solid fraction differ by from spheres that are met at random.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Calibration {
    /// Solid fraction.
    pub solid: f64,
    /// Part of the grains that light passes straight through: so that as much comes through a slab. Where it is negative, so many
    /// turn light twice: grains that have grown together turn it more than lone ones.
    pub straight: f64,
    /// Length in ice over that in lone grains, which more light finds where grains have grown together.
    pub ice: f64,
}

/// Packs of equal spheres of ice in air, by `cargo xtask roads --calibrate`: see docs/roads.md. Without grains there is nothing to
/// differ by.
pub const CALIBRATION: [Calibration; 5] = [
    Calibration { solid: 0.0, straight: 0.0, ice: 1.0 },
    Calibration { solid: 0.164, straight: 0.052, ice: 1.0 },
    Calibration { solid: 0.300, straight: 0.074, ice: 1.0 },
    Calibration { solid: 0.436, straight: 0.076, ice: 1.0 },
    Calibration { solid: 0.545, straight: 0.106, ice: 1.0 },
];

/// Indices of grains, relative to what is between them, of which [`CALIBRATION`] is known: ice in air.
pub const KNOWN_INDICES: std::ops::RangeInclusive<f64> = 1.29..=1.34;

impl Calibration {
    /// Between which the part lies that may pass straight.
    pub const PARTS: [f64; 2] = [-0.9, 0.5];

    /// The table of grains of which one entry was measured: that of equal spheres of ice, with the parts that pass straight in the
    /// proportion of this one to that of such spheres of its solid fraction, and as much ice everywhere.
    #[must_use]
    pub fn table_through(measured: Self) -> Vec<Self> {
        let proportion = measured.straight / Self::of(&CALIBRATION, measured.solid).straight;
        let ice = measured.ice;
        let [least, most] = Self::PARTS;
        let straight = |of: &Self| (of.straight * proportion).clamp(least, most);
        let entry = |of: &Self| Self { straight: straight(of), ice, ..*of };
        CALIBRATION.iter().map(entry).collect()
    }

    /// As bytes that are told from those of another key: its numbers, little-endian, and BLAKE3 of the key and of these.
    #[must_use]
    pub(crate) fn to_bytes(self, key: &[u8; 32]) -> Vec<u8> {
        let mut bytes: Vec<u8> =
            [self.solid, self.straight, self.ice].into_iter().flat_map(f64::to_le_bytes).collect();
        let hash = blake3::keyed_hash(key, &bytes);
        bytes.extend_from_slice(hash.as_bytes());
        bytes
    }

    /// Of such bytes; `None` where they are damaged or of another key.
    #[must_use]
    pub(crate) fn from_bytes(key: &[u8; 32], bytes: &[u8]) -> Option<Self> {
        let (numbers, hash) = bytes.split_first_chunk::<24>()?;
        if blake3::keyed_hash(key, numbers).as_bytes() != hash {
            return None;
        }
        let (chunks, _) = numbers.as_chunks::<8>();
        let number = |index: usize| f64::from_le_bytes(chunks[index]);
        Some(Self { solid: number(0), straight: number(1), ice: number(2) })
    }

    /// What there is between two solid fractions of a table in rising order, evenly; beyond its ends as there.
    pub(super) fn of(table: &[Self], solid: f64) -> Self {
        let above = table.partition_point(|entry| entry.solid < solid);
        let high = table[above.min(table.len() - 1)];
        let low = table[above.saturating_sub(1).min(table.len() - 1)];
        if high.solid <= low.solid {
            return Self { solid, ..high };
        }
        let part = (solid - low.solid) / (high.solid - low.solid);
        let between = |low: f64, high: f64| low + part * (high - low);
        Self {
            solid,
            straight: between(low.straight, high.straight),
            ice: between(low.ice, high.ice),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bytes_are_read_back_and_told_from_those_of_another_key() {
        let calibration = Calibration { solid: 0.3, straight: 0.074, ice: 1.1 };
        let mut bytes = calibration.to_bytes(&[7; 32]);
        assert_eq!(Calibration::from_bytes(&[7; 32], &bytes), Some(calibration));
        assert_eq!(Calibration::from_bytes(&[8; 32], &bytes), None);
        assert_eq!(Calibration::from_bytes(&[7; 32], &bytes[..20]), None);
        bytes[3] ^= 1;
        assert_eq!(Calibration::from_bytes(&[7; 32], &bytes), None);
    }

    #[test]
    fn a_table_through_an_entry_has_it_and_ends_without_grains() {
        let table =
            Calibration::table_through(Calibration { solid: 0.2, straight: 0.03, ice: 1.1 });
        let found = Calibration::of(&table, 0.2);
        assert!((found.straight - 0.03).abs() < 1e-12 && found.ice == 1.1, "{found:?}");
        assert_eq!(table[0].straight, 0.0);
        assert!(Calibration::of(&table, 0.5).straight > 0.03);
        // What was measured on loose snow is never more than there may be in dense.
        let table =
            Calibration::table_through(Calibration { solid: 0.03, straight: 0.2, ice: 1.0 });
        assert_eq!(Calibration::of(&table, 0.5).straight, Calibration::PARTS[1]);
    }

    #[test]
    fn tables_are_even_between_their_entries_and_constant_beyond() {
        let [from, to] = [CALIBRATION[1], CALIBRATION[2]];
        let straight = |table: &[Calibration], solid| Calibration::of(table, solid).straight;
        let middle = straight(&CALIBRATION, 0.5 * (from.solid + to.solid));
        assert!((middle - 0.5 * (from.straight + to.straight)).abs() < 1e-12);
        assert_eq!(straight(&CALIBRATION, 0.0), CALIBRATION[0].straight);
        assert_eq!(straight(&CALIBRATION, 0.8), CALIBRATION[4].straight);
        assert_eq!(straight(&CALIBRATION[..1], 0.3), CALIBRATION[0].straight);
    }
}
