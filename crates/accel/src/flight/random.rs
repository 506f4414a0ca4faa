//! The random numbers of `snowgrain_math::sampler`, many paths at a time.

use super::vector::{F, W};
use fearless_simd::prelude::*;

const MULTIPLIER: u32 = 1_664_525;
const INCREMENT: u32 = 1_013_904_223;

/// One word of the hash's input after its first step. The kernels keep keys and events in this form.
pub(crate) fn prepared(word: u32) -> u32 {
    word.wrapping_mul(MULTIPLIER).wrapping_add(INCREMENT)
}

/// The word that [`prepared`] made `prepared` of.
pub(crate) fn unprepared(prepared: u32) -> u32 {
    // The inverse of the multiplier modulo 2^32.
    prepared.wrapping_sub(INCREMENT).wrapping_mul(4_276_115_653)
}

/// What takes a prepared event to the next one.
pub(crate) const NEXT_EVENT: u32 = MULTIPLIER;

/// First number of event `event` of each path, `snowgrain_math::sampler::numbers(key, event)[0]`,
/// times 2^24; all words are [`prepared`].
#[inline(always)]
pub(crate) fn uniform_24_bits<S: Simd>(key: [W<S>; 2], event: W<S>) -> F<S> {
    // What makes the other two words is not computed.
    let [x, _, _] = hashed::<S>(key, event);
    let top: fearless_simd::i32x16<S> = (x >> 8).bitcast();
    top.to_float()
}

/// The three words of event `event` of each path, `snowgrain_math::sampler::pcg3d` of key and event;
/// all words given are [`prepared`].
#[inline(always)]
pub(crate) fn hashed<S: Simd>(key: [W<S>; 2], event: W<S>) -> [W<S>; 3] {
    let ([mut x, mut y], mut z) = (key, event);
    x += y * z;
    y += z * x;
    z += x * y;
    x ^= x >> 16;
    y ^= y >> 16;
    z ^= z >> 16;
    x += y * z;
    y += z * x;
    z += x * y;
    [x, y, z]
}

/// The top 24 bits of each word as a number in `[0, 1)`.
#[inline(always)]
pub(crate) fn unit_interval<S: Simd>(simd: S, words: W<S>) -> F<S> {
    let top: fearless_simd::i32x16<S> = (words >> 8).bitcast();
    simd.cvt_f32_i32x16(top) * F::<S>::splat(simd, 1.0 / 16_777_216.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn preparing_can_be_undone() {
        for word in [0, 1, 2, 77, 1 << 31, u32::MAX] {
            assert_eq!(unprepared(prepared(word)), word);
            assert_eq!(prepared(word).wrapping_add(NEXT_EVENT), prepared(word.wrapping_add(1)));
        }
    }
}
