//! Fixed-point numbers wide enough that sums of samples never round.
//!
//! Integer addition is associative, floating-point addition is not; this is what lets films merge
//! in any order to the same bytes.

/// `2^exponent`; `exponent` in [-1022, 1023].
pub(crate) fn power_of_two(exponent: i32) -> f64 {
    debug_assert!((-1022..=1023).contains(&exponent));
    f64::from_bits(((1023 + exponent) as u64) << 52)
}

/// A finite `x >= 0` as `mantissa * 2^shift` quanta of `2^-fraction_bits`, rounded to the nearest
/// quantum (halves up).
fn quanta(x: f64, fraction_bits: i32) -> (u64, u32) {
    let bits = x.to_bits();
    let biased = ((bits >> 52) & 0x7ff) as i32;
    let fraction = bits & ((1 << 52) - 1);
    let mantissa = if biased == 0 { fraction } else { fraction | (1 << 52) };
    let shift = biased.max(1) - 1075 + fraction_bits;
    match u32::try_from(shift) {
        Ok(left) => (mantissa, left),
        Err(_) if shift <= -64 => (0, 0),
        Err(_) => ((mantissa + (1 << (-shift - 1))) >> -shift, 0),
    }
}

/// A finite `x >= 0` in quanta of `2^-fraction_bits`; `None` from `2^127` quanta on.
pub(crate) fn to_fixed(x: f64, fraction_bits: i32) -> Option<u128> {
    let (mantissa, shift) = quanta(x, fraction_bits);
    match mantissa {
        0 => Some(0),
        _ if shift > mantissa.leading_zeros() + 63 => None,
        _ => Some(u128::from(mantissa) << shift),
    }
}

/// An unsigned integer of 192 bits, least significant limb first.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Wide(pub(crate) [u64; 3]);

impl Wide {
    /// A finite `x >= 0` in quanta of `2^-fraction_bits`; `None` where it does not fit.
    pub(crate) fn from_f64(x: f64, fraction_bits: i32) -> Option<Self> {
        let (mantissa, shift) = quanta(x, fraction_bits);
        if mantissa == 0 {
            return Some(Self::default());
        }
        (shift <= 128 + mantissa.leading_zeros()).then(|| Self::shifted(mantissa, shift))
    }

    /// `mantissa * 2^shift`, which must fit.
    #[inline]
    pub(crate) fn shifted(mantissa: u64, shift: u32) -> Self {
        debug_assert!(shift <= 128 + mantissa.leading_zeros());
        let spread = u128::from(mantissa) << (shift % 64);
        let (low, high) = (spread as u64, (spread >> 64) as u64);
        match shift / 64 {
            0 => Self([low, high, 0]),
            1 => Self([0, low, high]),
            _ => Self([0, 0, low]),
        }
    }

    /// The sum modulo 2^192, and whether it overflows.
    #[inline]
    pub(crate) fn overflowing_add(self, other: Self) -> (Self, bool) {
        let ([a, b, c], [x, y, z]) = (self.0, other.0);
        let (low, carry) = wide_pair(a, b).overflowing_add(wide_pair(x, y));
        let (top, first) = c.overflowing_add(z);
        let (top, second) = top.overflowing_add(u64::from(carry));
        (Self([low as u64, (low >> 64) as u64, top]), first | second)
    }

    /// The difference modulo 2^192.
    pub(crate) fn wrapping_sub(self, other: Self) -> Self {
        let ([a, b, c], [x, y, z]) = (self.0, other.0);
        let (low, borrow) = wide_pair(a, b).overflowing_sub(wide_pair(x, y));
        let top = c.wrapping_sub(z).wrapping_sub(u64::from(borrow));
        Self([low as u64, (low >> 64) as u64, top])
    }
}

fn wide_pair(low: u64, high: u64) -> u128 {
    u128::from(low) | u128::from(high) << 64
}

/// `max(count * squares - sum^2, 0)`, where `squares` is in quanta of `2^-(2 * sum_bits - 32)` and
/// `sum` in quanta of `2^-sum_bits`; the result is in quanta of `2^-(2 * sum_bits)`.
///
/// Exact up to the conversion of the result to `f64`, so equal samples have a spread of exactly 0.
pub(crate) fn spread(count: u64, squares: Wide, sum: u128) -> f64 {
    let aligned_count = u128::from(count) << 32;
    let sum = [sum as u64, (sum >> 64) as u64];
    let minuend = product(&squares.0, &[aligned_count as u64, (aligned_count >> 64) as u64]);
    difference(&minuend, &product(&sum, &sum))
        .map_or(0.0, |limbs| limbs.iter().rev().fold(0.0, |x, &l| x * power_of_two(64) + l as f64))
}

/// The product of two unsigned integers of at most five limbs together.
fn product(a: &[u64], b: &[u64]) -> [u64; 5] {
    let mut limbs = [0u64; 5];
    for (i, &x) in a.iter().enumerate() {
        let mut carry = 0u128;
        for (j, &y) in b.iter().enumerate() {
            carry += u128::from(x) * u128::from(y) + u128::from(limbs[i + j]);
            limbs[i + j] = carry as u64;
            carry >>= 64;
        }
        limbs[i + b.len()] = carry as u64;
    }
    limbs
}

/// `a - b`; `None` where that is negative.
fn difference(a: &[u64; 5], b: &[u64; 5]) -> Option<[u64; 5]> {
    let mut limbs = [0; 5];
    let mut borrow = false;
    for (i, limb) in limbs.iter_mut().enumerate() {
        let (first, under) = a[i].overflowing_sub(b[i]);
        let (second, under_again) = first.overflowing_sub(u64::from(borrow));
        *limb = second;
        borrow = under || under_again;
    }
    (!borrow).then_some(limbs)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    #[test]
    fn fixed_point_rounds_to_the_nearest_quantum_and_refuses_what_does_not_fit() {
        assert_eq!(to_fixed(1.0, 64), Some(1 << 64));
        assert_eq!(to_fixed(0.0, 64), Some(0));
        assert_eq!(to_fixed(power_of_two(-64), 64), Some(1));
        assert_eq!(to_fixed(power_of_two(-65), 64), Some(1));
        assert_eq!(to_fixed(power_of_two(-66), 64), Some(0));
        assert_eq!(to_fixed(f64::from_bits(1), 64), Some(0));
        assert_eq!(to_fixed(power_of_two(62), 64), Some(1 << 126));
        assert_eq!(to_fixed(power_of_two(63), 64), None);
        assert_eq!(to_fixed(f64::MAX, 64), None);
        assert_eq!(Wide::from_f64(power_of_two(95), 96), Some(Wide([0, 0, 1 << 63])));
        assert_eq!(Wide::from_f64(power_of_two(96), 96), None);
        assert_eq!(Wide::from_f64(f64::MAX, 96), None);
    }

    #[test]
    fn wide_sums_carry_and_report_overflow() {
        let ones = Wide([u64::MAX, u64::MAX, 0]);
        assert_eq!(ones.overflowing_add(Wide([1, 0, 0])), (Wide([0, 0, 1]), false));
        assert_eq!(Wide([u64::MAX; 3]).overflowing_add(Wide([1, 0, 0])), (Wide([0; 3]), true));
    }

    proptest! {
        #[test]
        fn wide_agrees_with_u128_where_both_fit(x in 0.0..1e18f64) {
            let wide = Wide::from_f64(x, 64).unwrap().0;
            let narrow = to_fixed(x, 64).unwrap();
            prop_assert_eq!(wide, [narrow as u64, (narrow >> 64) as u64, 0]);
        }

        #[test]
        fn products_and_differences_agree_with_u128(a: u64, b: u64, c: u64, d: u64) {
            let (p, q) = (u128::from(a) * u128::from(b), u128::from(c) * u128::from(d));
            let limbs = difference(&product(&[a], &[b]), &product(&[c], &[d]));
            prop_assert_eq!(
                limbs.map(|l| u128::from(l[0]) | u128::from(l[1]) << 64),
                p.checked_sub(q)
            );
        }

        #[test]
        fn equal_samples_have_no_spread(x in 1e-6..1e9f32, count in 1u64..1000) {
            let (mut sum, mut squares) = (0, Wide::default());
            let square = Wide::from_f64(f64::from(x) * f64::from(x), 96).unwrap();
            for _ in 0..count {
                sum += to_fixed(f64::from(x), 64).unwrap();
                squares = squares.overflowing_add(square).0;
            }
            prop_assert_eq!(spread(count, squares, sum), 0.0);
        }
    }
}
