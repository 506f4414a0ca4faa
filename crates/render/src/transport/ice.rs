//! Length of a path in ice.

use core::ops::{Add, AddAssign};
use snowgrain_accel::STRATA;

/// Length in ice, and that in grains of each stratum that has one, metres.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct IceLength {
    pub(super) all: f64,
    pub(super) in_strata: [f64; STRATA],
}

impl IceLength {
    /// In a grain of a stratum; 0 is none.
    #[inline]
    pub(super) fn of(length: f64, stratum: u8) -> Self {
        let mut ice = Self { all: length, ..Self::default() };
        if let Some(stratum) = usize::from(stratum).checked_sub(1) {
            ice.in_strata[stratum] = length;
        }
        ice
    }
}

impl Add for IceLength {
    type Output = Self;

    fn add(mut self, more: Self) -> Self {
        self += more;
        self
    }
}

impl AddAssign for IceLength {
    #[inline]
    fn add_assign(&mut self, more: Self) {
        self.all += more.all;
        self.in_strata.iter_mut().zip(more.in_strata).for_each(|(sum, length)| *sum += length);
    }
}
