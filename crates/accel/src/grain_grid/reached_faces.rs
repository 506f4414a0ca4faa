//! Which faces of a grain other ice may reach: a chord that ends on another face ends at an interface, and no cell need be
//! asked.

use super::slabs::ROUND;

/// The faces of a grain between parallel faces that other ice may reach: a bit each, at the number of the face, as
/// [`Slabs`](super::Slabs) has it, and 5; [`Self::BITS`] of them.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct ReachedFaces(u16);

impl ReachedFaces {
    pub(crate) const BITS: u32 = 12;
    /// Of a grain that overlaps no other.
    pub(crate) const NONE: Self = Self(0);
    /// Of a grain of which no more is known than that it overlaps others.
    pub(crate) const ALL: Self = Self((1 << Self::BITS) - 1);
    /// What is not flat, and what is no face: reached wherever any of the grain is.
    pub(crate) const NOT_FLAT: Self = Self(1 << (ROUND as u32 + 5) | 1 << 5);

    /// The face of this number alone.
    pub(crate) fn only(number: f64) -> Self {
        Self(1 << place(number))
    }

    pub(crate) fn from_bits(bits: u16) -> Self {
        Self(bits)
    }

    #[inline(always)]
    pub(crate) fn to_bits(self) -> u16 {
        self.0
    }

    /// These and those of another set.
    pub(crate) fn with(self, other: Self) -> Self {
        Self(self.0 | other.0)
    }

    /// Whether the face of this number is one of them.
    #[inline(always)]
    pub(crate) fn has(self, number: f64) -> bool {
        self.0 >> place(number) & 1 != 0
    }
}

#[inline(always)]
fn place(number: f64) -> u32 {
    (number as i32 + 5).cast_unsigned() & 15
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_face_has_a_bit_of_its_own() {
        let all: Vec<f64> = (-5..=6).map(f64::from).collect();
        for &one in &all {
            for &other in &all {
                assert_eq!(ReachedFaces::only(one).has(other), one == other);
            }
            assert!(ReachedFaces::ALL.has(one) && !ReachedFaces::NONE.has(one));
            assert_eq!(ReachedFaces::NOT_FLAT.has(one), one == 0.0 || one == ROUND);
        }
    }
}
