//! Whole numbers of blocks as the kernels' floats.

use fearless_simd::prelude::*;
use fearless_simd::{f32x16, i32x16, u16x16};

/// Sixteen 16-bit words as floats.
#[inline(always)]
pub(crate) fn floats<S: Simd>(simd: S, words: u16x16<S>) -> f32x16<S> {
    let (low, high) = simd.widen_u16x16(words);
    let words: i32x16<S> = simd.combine_u32x8(low, high).bitcast();
    simd.cvt_f32_i32x16(words)
}
