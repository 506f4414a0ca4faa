//! Logarithm and cosine of many numbers at once: the same bits at every SIMD level.

use crate::flight::vector::{F, W};
use fearless_simd::i32x16;
use fearless_simd::prelude::*;

/// The natural logarithm of numbers in [2^-126, 2^127], to 2e-7 of it or of 1.
///
/// `ln x = e ln 2 + 2 atanh(t)` with x = 2^e m, m in [2/3, 4/3], t = (m - 1) / (m + 1).
#[inline(always)]
pub(super) fn ln<S: Simd>(simd: S, x: F<S>) -> F<S> {
    let splat = |v: f32| F::<S>::splat(simd, v);
    let bits: W<S> = x.bitcast();
    // So that the mantissa that is left lies in [2/3, 4/3).
    let offset = W::<S>::splat(simd, 0x3F2A_AAAB);
    let shifted = bits - offset;
    let exponent: i32x16<S> = (shifted & W::<S>::splat(simd, 0xFF80_0000)).bitcast();
    let mantissa: W<S> = bits - exponent.bitcast::<W<S>>();
    let m: F<S> = mantissa.bitcast();
    let e: F<S> = simd.cvt_f32_i32x16(exponent >> 23);
    let t = (m - splat(1.0)) / (m + splat(1.0));
    let t2 = t * t;
    let series = splat(2.0)
        + t2 * (splat(2.0 / 3.0)
            + t2 * (splat(2.0 / 5.0) + t2 * (splat(2.0 / 7.0) + t2 * splat(2.0 / 9.0))));
    e * splat(core::f32::consts::LN_2) + t * series
}

/// Cosine and sine of a full turn times a fraction in [0, 1), to 3e-7.
#[inline(always)]
pub(super) fn cos_sin_of_turn<S: Simd>(simd: S, turn: F<S>) -> [F<S>; 2] {
    let splat = |v: f32| F::<S>::splat(simd, v);
    // The sine is the cosine of a quarter turn less.
    let back = turn - splat(0.25);
    let back = back.simd_lt(splat(0.0)).select(back + splat(1.0), back);
    [cos_of_turn(simd, turn), cos_of_turn(simd, back)]
}

/// The cosine of a full turn times a fraction in [0, 1), to 3e-7.
#[inline(always)]
pub(super) fn cos_of_turn<S: Simd>(simd: S, turn: F<S>) -> F<S> {
    let splat = |v: f32| F::<S>::splat(simd, v);
    // cos(2 pi x) = sin(2 pi (|x - 1/2| - 1/4)).
    let x = (turn - splat(0.5)).abs() - splat(0.25);
    let y = x * splat(core::f32::consts::TAU);
    let y2 = y * y;
    // Taylor's series: the first term left out is 6e-8 at the ends.
    let series = splat(1.0)
        - y2 * (splat(1.0 / 6.0)
            - y2 * (splat(1.0 / 120.0)
                - y2 * (splat(1.0 / 5040.0)
                    - y2 * (splat(1.0 / 362_880.0) - y2 * splat(1.0 / 39_916_800.0)))));
    y * series
}
