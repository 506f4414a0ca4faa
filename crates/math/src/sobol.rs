//! Numbers that fill four dimensions more evenly than chance: an Owen-scrambled Sobol sequence.
//!
//! Of any 2^k samples whose indices are an aligned block (0 to 2^k - 1, 2^k to 2^(k+1) - 1, ...), each
//! interval of length 2^-k holds exactly one in every dimension, and the first two dimensions together
//! are a (0, 2)-sequence: each box of area 2^-k whose sides are powers of two holds exactly one. Each
//! number alone is uniform whatever its index, so means stay unbiased; but numbers of different samples
//! of one pixel are not independent, so a variance estimated from them is too large (never too small,
//! in the mean), by what the even filling gains.
//!
//! Points: I. M. Sobol' 1967 with the direction numbers of S. Joe and F. Y. Kuo 2008, "Constructing
//! Sobol sequences with better two-dimensional projections", SIAM J. Sci. Comput. 30, 2635 (their table
//! of dimensions up to 21201). Scrambling: B. Burley 2020, "Practical Hash-based Owen Scrambling", JCGT
//! 9(4), section 3: bits reversed, the hash of Laine and Karras with his constants, bits reversed.

use crate::sampler::{split_mix, unit_interval};

/// Dimensions of the sequence.
pub const DIMENSIONS: usize = 4;

/// Degree, inner coefficients and first direction numbers of the primitive polynomials of dimensions 1
/// to 3 (dimension 0 reverses the bits of the index).
const POLYNOMIALS: [(usize, u32, [u32; 3]); DIMENSIONS - 1] =
    [(1, 0, [1, 0, 0]), (2, 1, [1, 3, 0]), (3, 1, [1, 3, 1])];

/// Direction numbers of each bit of the index.
const DIRECTIONS: [[u32; DIMENSIONS]; 32] = directions();

const fn directions() -> [[u32; DIMENSIONS]; 32] {
    let mut table = [[0; DIMENSIONS]; 32];
    let mut bit = 0;
    while bit < 32 {
        table[bit][0] = 1 << (31 - bit);
        let mut dimension = 1;
        while dimension < DIMENSIONS {
            let (degree, inner, first) = POLYNOMIALS[dimension - 1];
            table[bit][dimension] = if bit < degree {
                first[bit] << (31 - bit)
            } else {
                let oldest = table[bit - degree][dimension];
                let mut direction = oldest ^ (oldest >> degree);
                let mut back = 1;
                while back < degree {
                    if inner >> (degree - 1 - back) & 1 == 1 {
                        direction ^= table[bit - back][dimension];
                    }
                    back += 1;
                }
                direction
            };
            dimension += 1;
        }
        bit += 1;
    }
    table
}

/// The four uniform numbers in `[0, 1)` of sample number `sample` of stream `stream` (the pixel's
/// index): multiples of 2^-24, as those of [`crate::sampler::numbers`].
///
/// Streams, seeds, and blocks of 2^32 samples (the sequence has 32 bits; the upper half of the index
/// goes into the scrambling) are scrambled independently.
#[inline]
#[must_use]
pub fn sobol_numbers(seed: u64, stream: u64, sample: u64) -> [f32; DIMENSIONS] {
    let scramble = split_mix(split_mix(split_mix(seed) ^ (sample >> 32)).wrapping_add(stream));
    let (mut words, mut rest) = ([0; DIMENSIONS], sample as u32);
    while rest != 0 {
        let bit = rest.trailing_zeros() as usize;
        words.iter_mut().zip(DIRECTIONS[bit]).for_each(|(word, direction)| *word ^= direction);
        rest &= rest - 1;
    }
    let mut dimension = 0;
    words.map(|word| {
        dimension += 1;
        let seed = split_mix(scramble.wrapping_add(dimension)) as u32;
        unit_interval(owen_scrambled(word, seed))
    })
}

/// Flips each bit or not, by a hash of the seed and all bits above it.
#[inline]
fn owen_scrambled(word: u32, seed: u32) -> u32 {
    let mut x = word.reverse_bits().wrapping_add(seed);
    for factor in [0x6c50_b47c, 0xb82f_1e52, 0xc7af_e638, 0x8d22_f6e6] {
        x ^= x.wrapping_mul(factor);
    }
    x.reverse_bits()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_aligned_block_has_one_sample_in_each_interval_and_box() {
        for (block, k) in [(0u64, 8u32), (3, 8), (1 << 30, 6), (5 << 40, 4), (7, 1)] {
            let count = 1u64 << k;
            let samples: Vec<_> =
                (0..count).map(|i| sobol_numbers(9, 1234, block * count + i)).collect();
            for dimension in 0..DIMENSIONS {
                let mut seen = vec![false; count as usize];
                for numbers in &samples {
                    let interval = (numbers[dimension] * count as f32) as usize;
                    assert!(!std::mem::replace(&mut seen[interval], true), "{block} {dimension}");
                }
            }
            for columns in (0..=k).map(|power| 1u64 << power) {
                let mut seen = vec![false; count as usize];
                for [x, y, ..] in &samples {
                    let column = (x * columns as f32) as u64;
                    let row = (y * (count / columns) as f32) as u64;
                    let at = (column + columns * row) as usize;
                    assert!(!std::mem::replace(&mut seen[at], true), "{block}, {columns} columns");
                }
            }
        }
    }

    /// Over pixels a sample's numbers are uniform, and those of two samples or dimensions independent
    /// where they are not meant to differ. 64 cells, 2^18 pixels: chi-square with 63 degrees of freedom
    /// exceeds 120 by chance once in 10^5; 14 tables are tested, so a false alarm has probability
    /// 1.4 10^-4.
    #[test]
    fn numbers_are_uniform_over_pixels_by_chi_square() {
        let n = 1u64 << 18;
        let test = |cell: &dyn Fn(u64) -> usize, what: &str| {
            let mut bins = [0u32; 64];
            (0..n).for_each(|stream| bins[cell(stream)] += 1);
            let expected = n as f64 / 64.0;
            let chi2: f64 =
                bins.iter().map(|&b| f64::from(b) - expected).map(|d| d * d / expected).sum();
            assert!(chi2 < 120.0, "{what}: {chi2}");
        };
        for sample in [0, 1, 1 << 33] {
            for dimension in 0..DIMENSIONS {
                let cell = |stream| (sobol_numbers(3, stream, sample)[dimension] * 64.0) as usize;
                test(&cell, &format!("sample {sample}, dimension {dimension}"));
            }
        }
        let eighth = |x: f32| (x * 8.0) as usize;
        let two = |stream| {
            let [x, _, u, _] = sobol_numbers(3, stream, 5);
            eighth(x) + 8 * eighth(u)
        };
        test(&two, "two dimensions");
        let neighbours = |stream| {
            let x = |stream| sobol_numbers(3, stream, 5)[0];
            eighth(x(stream)) + 8 * eighth(x(stream + 1))
        };
        test(&neighbours, "two pixels");
    }
}
