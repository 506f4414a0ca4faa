//! Exponential lengths from uniform numbers, faster than by a logarithm of any number.

use crate::trig;

/// Parts of the interval from 1 to 2.
const PARTS: usize = 256;
/// Bits of a uniform number.
const BITS: u32 = 24;

/// A table for -ln(1 - u) of the multiples u of 2^-24 in [0, 1), to 1e-9.
#[derive(Clone, Debug)]
pub struct Exponential {
    /// Of each part of [1, 2) where it begins: one over that, and its logarithm.
    parts: Vec<[f64; 2]>,
}

impl Default for Exponential {
    fn default() -> Self {
        Self::new()
    }
}

impl Exponential {
    /// The table.
    #[must_use]
    pub fn new() -> Self {
        let part = |index: usize| {
            let start = 1.0 + index as f64 / PARTS as f64;
            [1.0 / start, trig::ln(start)]
        };
        Self { parts: (0..PARTS).map(part).collect() }
    }

    /// -ln(1 - u): of mean 1, at most 24 ln 2.
    #[inline]
    #[must_use]
    pub fn of(&self, uniform: f64) -> f64 {
        let left = (1u32 << BITS) - (uniform * f64::from(1u32 << BITS)) as u32;
        let halvings = left.leading_zeros() - (31 - BITS);
        // From 2^31 on: the next eight bits tell the part.
        let word = left << left.leading_zeros();
        let [inverse, logarithm] = self.parts[(word >> 23) as usize & (PARTS - 1)];
        let beyond = f64::from(word & 0x7f_ffff) * (1.0 / f64::from(1u32 << 31)) * inverse;
        let series = beyond * (1.0 - beyond * (0.5 - beyond * (1.0 / 3.0)));
        f64::from(halvings) * core::f64::consts::LN_2 - logarithm - series
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn it_is_the_logarithm() {
        let table = Exponential::new();
        let unit = f64::from(1u32 << BITS);
        for step in 0..100_000u32 {
            let uniform = f64::from(step * 167 + step % 7) / unit;
            let expected = -trig::ln(1.0 - uniform);
            assert!((table.of(uniform) - expected).abs() < 1e-9, "{uniform}");
        }
        let least = table.of(1.0 - 1.0 / unit);
        assert!((least - 24.0 * core::f64::consts::LN_2).abs() < 1e-9);
        assert_eq!(table.of(0.0), 0.0);
    }
}
