//! Vectors of sixteen paths.
//!
//! Every operation acts on each path alone and rounds as IEEE 754 says (no fused multiply-add), so a
//! path's numbers do not depend on how many others travel beside it.

use fearless_simd::prelude::*;

/// One number a path.
pub(crate) type F<S> = fearless_simd::f32x16<S>;
/// One word a path.
pub(crate) type W<S> = fearless_simd::u32x16<S>;
/// One truth a path.
pub(crate) type M<S> = fearless_simd::mask32x16<S>;

/// Paths handled at once: two native vectors on most machines, whose chains of dependent steps then
/// overlap.
pub(crate) const WIDTH: usize = 16;

/// One vector in space a path.
#[derive(Clone, Copy)]
pub(crate) struct Vector<S: Simd>(pub(crate) F<S>, pub(crate) F<S>, pub(crate) F<S>);

impl<S: Simd> Vector<S> {
    #[inline(always)]
    pub(crate) fn load<const N: usize>(simd: S, axes: &[[f32; N]; 3], at: usize) -> Self {
        let part = |axis: usize| F::<S>::from_slice(simd, &axes[axis][at..at + WIDTH]);
        Self(part(0), part(1), part(2))
    }

    #[inline(always)]
    pub(crate) fn store<const N: usize>(self, axes: &mut [[f32; N]; 3], at: usize) {
        self.0.store_slice(&mut axes[0][at..at + WIDTH]);
        self.1.store_slice(&mut axes[1][at..at + WIDTH]);
        self.2.store_slice(&mut axes[2][at..at + WIDTH]);
    }

    #[inline(always)]
    pub(crate) fn dot(self, other: Self) -> F<S> {
        self.0 * other.0 + self.1 * other.1 + self.2 * other.2
    }

    #[inline(always)]
    pub(crate) fn scaled(self, factor: F<S>) -> Self {
        Self(self.0 * factor, self.1 * factor, self.2 * factor)
    }

    /// `self + other * factor`, rounded twice.
    #[inline(always)]
    pub(crate) fn plus(self, other: Self, factor: F<S>) -> Self {
        Self(self.0 + other.0 * factor, self.1 + other.1 * factor, self.2 + other.2 * factor)
    }

    #[inline(always)]
    pub(crate) fn choose(mask: M<S>, yes: Self, no: Self) -> Self {
        Self(mask.select(yes.0, no.0), mask.select(yes.1, no.1), mask.select(yes.2, no.2))
    }

    /// A vector of nearly unit length brought closer to it by one step of Newton's method for the
    /// inverse square root: a deviation of `e` becomes one of 1.5 e^2.
    #[inline(always)]
    pub(crate) fn straightened(self, simd: S) -> Self {
        let half = F::<S>::splat(simd, 0.5);
        self.scaled(F::<S>::splat(simd, 1.5) - half * self.dot(self))
    }
}
