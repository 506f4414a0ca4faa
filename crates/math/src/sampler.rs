//! Stateless random numbers: `(pixel, sample, dimension) -> number`.
//!
//! A path owns a [`PathKey`]; its *n*-th event asks for [`numbers`]`(key, n)` and gets three
//! numbers that depend on nothing else, so no thread, tile or order can change them. The hash is
//! `pcg3d` of Jarzynski & Olano 2020, "Hash Functions for GPU Rendering", JCGT 9(3), listing in
//! section 4; it needs only 32-bit integer arithmetic, so the SIMD kernels run the same one.

/// Names one path: a pixel and the index of one of its samples, mixed with the seed of the render.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PathKey {
    /// First word of the hash's input.
    pub lo: u32,
    /// Second word of the hash's input.
    pub hi: u32,
}

impl PathKey {
    /// The key of sample number `sample` of stream `stream` (the pixel's index, a grain's, ...).
    ///
    /// Mixed by two rounds of SplitMix64 (Steele et al. 2014), a bijection of `stream` for a fixed
    /// seed and sample, so that two pixels never share a key within one sample.
    #[inline]
    #[must_use]
    pub fn new(seed: u64, stream: u64, sample: u64) -> Self {
        let mixed = split_mix(split_mix(seed ^ split_mix(sample)).wrapping_add(stream));
        Self { lo: mixed as u32, hi: (mixed >> 32) as u32 }
    }
}

/// The finaliser of SplitMix64: a bijection of 64-bit words.
#[inline]
#[must_use]
pub fn split_mix(word: u64) -> u64 {
    let z = word.wrapping_add(0x9E37_79B9_7F4A_7C15);
    let z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
    let z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
    z ^ (z >> 31)
}

/// `pcg3d`: three words in, three well-mixed words out.
#[inline]
#[must_use]
pub fn pcg3d(mut x: u32, mut y: u32, mut z: u32) -> [u32; 3] {
    const MULTIPLIER: u32 = 1_664_525;
    const INCREMENT: u32 = 1_013_904_223;
    x = x.wrapping_mul(MULTIPLIER).wrapping_add(INCREMENT);
    y = y.wrapping_mul(MULTIPLIER).wrapping_add(INCREMENT);
    z = z.wrapping_mul(MULTIPLIER).wrapping_add(INCREMENT);
    for round in 0..2 {
        x = x.wrapping_add(y.wrapping_mul(z));
        y = y.wrapping_add(z.wrapping_mul(x));
        z = z.wrapping_add(x.wrapping_mul(y));
        if round == 0 {
            x ^= x >> 16;
            y ^= y >> 16;
            z ^= z >> 16;
        }
    }
    [x, y, z]
}

/// The three uniform numbers in `[0, 1)` of event `event` of the path: multiples of 2^-24, so they
/// are exact in `f32` and in `f64`.
#[inline]
#[must_use]
pub fn numbers(key: PathKey, event: u32) -> [f32; 3] {
    let [x, y, z] = pcg3d(key.lo, key.hi, event);
    [unit_interval(x), unit_interval(y), unit_interval(z)]
}

/// The top 24 bits of a word as a number in `[0, 1)`.
#[inline]
#[must_use]
pub fn unit_interval(word: u32) -> f32 {
    (word >> 8) as f32 * (1.0 / 16_777_216.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pcg3d_gives_what_another_implementation_gave() {
        // Computed with arbitrary-precision integers from the published listing.
        assert_eq!(pcg3d(0, 0, 0), [2_611_992_518, 2_833_812_075, 1_058_359_340]);
        assert_eq!(pcg3d(1, 2, 3), [4_204_755_366, 1_223_881_804, 1_500_469_937]);
    }

    #[test]
    fn numbers_are_uniform_by_chi_square() {
        // 64 bins, 2^18 numbers: chi-square with 63 degrees of freedom exceeds 120 by chance once
        // in 10^5; nine sequences are tested, so a false alarm has probability 10^-4.
        for stream in 0..3u64 {
            for component in 0..3 {
                let mut bins = [0u32; 64];
                let n = 1u32 << 18;
                for event in 0..n {
                    let key = PathKey::new(1, stream * 1000 + u64::from(event >> 6), 0);
                    bins[(numbers(key, event & 63)[component] * 64.0) as usize] += 1;
                }
                let expected = f64::from(n) / 64.0;
                let chi2: f64 =
                    bins.iter().map(|&b| f64::from(b) - expected).map(|d| d * d / expected).sum();
                assert!(chi2 < 120.0, "stream {stream}, component {component}: {chi2}");
            }
        }
    }

    #[test]
    fn keys_of_neighbouring_pixels_and_samples_differ() {
        let mut keys: Vec<_> = (0..100u64)
            .flat_map(|p| (0..100u64).map(move |s| PathKey::new(0, p, s)))
            .map(|k| (k.hi, k.lo))
            .collect();
        keys.sort_unstable();
        keys.dedup();
        assert_eq!(keys.len(), 10_000);
    }
}
