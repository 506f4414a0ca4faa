//! Numbers and vectors that carry their derivatives by `N` others: what is computed with them is differentiated
//! on the way, exactly (forward accumulation; Wengert 1964, "A Simple Automatic Derivative Evaluation Program").
//! Those by none are plain numbers.

#![expect(
    clippy::suspicious_arithmetic_impl,
    reason = "derivatives of products and quotients are sums of products"
)]

use core::array::from_fn;
use core::ops::{Add, Div, Mul, Neg, Sub};
use snowgrain_math::DVec3;

/// A number and its derivatives.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Dual<const N: usize> {
    pub(super) value: f64,
    pub(super) by: [f64; N],
}

/// A vector and its derivatives.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct DualVector<const N: usize> {
    pub(super) value: DVec3,
    pub(super) by: [DVec3; N],
}

impl<const N: usize> Dual<N> {
    #[inline]
    pub(super) fn constant(value: f64) -> Self {
        Self { value, by: [0.0; N] }
    }

    /// Of a number above 0.
    #[inline]
    pub(super) fn sqrt(self) -> Self {
        let root = self.value.sqrt();
        Self { value: root, by: self.by.map(|by| by / (2.0 * root)) }
    }
}

impl<const N: usize> DualVector<N> {
    #[inline]
    pub(super) fn dot(self, other: Self) -> Dual<N> {
        Dual {
            value: self.value.dot(other.value),
            by: from_fn(|i| self.by[i].dot(other.value) + self.value.dot(other.by[i])),
        }
    }

    /// The dot product with a constant vector.
    #[inline]
    pub(super) fn along(self, axis: DVec3) -> Dual<N> {
        Dual { value: self.value.dot(axis), by: self.by.map(|by| by.dot(axis)) }
    }

    #[inline]
    pub(super) fn normalized(self) -> Self {
        self / self.dot(self).sqrt()
    }
}

impl<const N: usize> Neg for Dual<N> {
    type Output = Self;
    #[inline]
    fn neg(self) -> Self {
        Self { value: -self.value, by: self.by.map(|by| -by) }
    }
}

impl<const N: usize> Add for Dual<N> {
    type Output = Self;
    #[inline]
    fn add(self, other: Self) -> Self {
        Self { value: self.value + other.value, by: from_fn(|i| self.by[i] + other.by[i]) }
    }
}

impl<const N: usize> Sub for Dual<N> {
    type Output = Self;
    #[inline]
    fn sub(self, other: Self) -> Self {
        self + -other
    }
}

impl<const N: usize> Mul for Dual<N> {
    type Output = Self;
    #[inline]
    fn mul(self, other: Self) -> Self {
        Self {
            value: self.value * other.value,
            by: from_fn(|i| self.by[i] * other.value + self.value * other.by[i]),
        }
    }
}

impl<const N: usize> Mul<f64> for Dual<N> {
    type Output = Self;
    #[inline]
    fn mul(self, factor: f64) -> Self {
        Self { value: self.value * factor, by: self.by.map(|by| by * factor) }
    }
}

impl<const N: usize> Div for Dual<N> {
    type Output = Self;
    #[inline]
    fn div(self, divisor: Self) -> Self {
        let value = self.value / divisor.value;
        Self { value, by: from_fn(|i| (self.by[i] - value * divisor.by[i]) / divisor.value) }
    }
}

impl<const N: usize> Add for DualVector<N> {
    type Output = Self;
    #[inline]
    fn add(self, other: Self) -> Self {
        Self { value: self.value + other.value, by: from_fn(|i| self.by[i] + other.by[i]) }
    }
}

impl<const N: usize> Add<DVec3> for DualVector<N> {
    type Output = Self;
    #[inline]
    fn add(self, constant: DVec3) -> Self {
        Self { value: self.value + constant, by: self.by }
    }
}

impl<const N: usize> Sub for DualVector<N> {
    type Output = Self;
    #[inline]
    fn sub(self, other: Self) -> Self {
        Self { value: self.value - other.value, by: from_fn(|i| self.by[i] - other.by[i]) }
    }
}

impl<const N: usize> Mul<Dual<N>> for DualVector<N> {
    type Output = Self;
    #[inline]
    fn mul(self, factor: Dual<N>) -> Self {
        Self {
            value: self.value * factor.value,
            by: from_fn(|i| self.by[i] * factor.value + self.value * factor.by[i]),
        }
    }
}

impl<const N: usize> Mul<f64> for DualVector<N> {
    type Output = Self;
    #[inline]
    fn mul(self, factor: f64) -> Self {
        Self { value: self.value * factor, by: self.by.map(|by| by * factor) }
    }
}

impl<const N: usize> Div<Dual<N>> for DualVector<N> {
    type Output = Self;
    #[inline]
    fn div(self, divisor: Dual<N>) -> Self {
        self * (Dual::constant(1.0) / divisor)
    }
}
