//! How much of a pixel's light has passed through how much ice, kept so that ice and impurities can be
//! chosen after the render.
//!
//! Light of a length L is shared out among [`NODES`] lengths: 0, and from 1/1024 m on three for every
//! two octaves up to 1024 m. The shares are the weights of cubic interpolation in the
//! logarithm of the length through the four nodes around L, so that for a function that is smooth in it,
//! such as what ice leaves of light, the sum over the nodes is that over the light. For `exp(-gamma L)`
//! the error is at most .002 of one light, where about a tenth of it is left, of either sign elsewhere; it
//! cancels to less among many lengths.
//!
//! Each node has three sums (the light's linear sRGB times the albedos met) of 8 bytes for each spectrum
//! of lights: 768 bytes a pixel for one. Sums are integers and so associative, like all of a film.

use crate::FilmError;
use snowgrain_math::trig;

/// Lengths at which light is kept.
pub const NODES: usize = 32;
/// Nodes per octave, from [`SHORTEST`] on.
const NODES_PER_OCTAVE: f64 = 1.5;
/// Length of node 1, metres.
const SHORTEST: f64 = 1.0 / 1024.0;

/// Fractional bits of the sums, in units of the scale.
const FRACTION_BITS: i32 = 30;
/// Weights beyond this many times the scale are refused: sums keep 2^17 samples of them.
const LARGEST: f64 = 65_536.0;

/// What a film's ice paths are sums of.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct IcePathLayout {
    /// Spectra of lights, at least 1.
    pub lights: u32,
    /// The sums have quanta of `2^(scale_exponent - 30)`; at least as large as the brightest light
    /// is `2^scale_exponent`.
    pub scale_exponent: i32,
}

impl IcePathLayout {
    /// For light of at most this radiance, one of the lights' spectra.
    #[must_use]
    pub fn for_radiance(lights: u32, greatest: f32) -> Self {
        // The exponent of the power of two above it.
        let exponent = (greatest.max(f32::MIN_POSITIVE).to_bits() >> 23).cast_signed() - 126;
        Self { lights: lights.max(1), scale_exponent: exponent }
    }

    /// Sums of one pixel.
    #[must_use]
    pub fn sums(self) -> usize {
        NODES * 3 * self.lights as usize
    }

    /// Bytes of one pixel.
    #[must_use]
    pub fn bytes(self) -> u64 {
        self.sums() as u64 * 8
    }

    /// A quantum of the sums.
    fn quantum(self) -> f64 {
        crate::exact::power_of_two(self.scale_exponent - FRACTION_BITS)
    }

    /// Adds light of `weights`, one for each spectrum, that has passed through `length` metres of ice to
    /// the sums of a pixel; `false` where one does not fit.
    #[must_use]
    pub(crate) fn add(self, sums: &mut [i64], length: f64, weights: &[[f32; 3]]) -> bool {
        let (first, shares) = shares(length);
        let per_quantum = 1.0 / self.quantum();
        let mut fits = true;
        for (sums, weight) in sums.chunks_exact_mut(NODES * 3).zip(weights) {
            let quanta = weight.map(|weight| f64::from(weight) * per_quantum);
            let most = LARGEST / crate::exact::power_of_two(-FRACTION_BITS);
            fits &= quanta.iter().all(|quanta| quanta.abs() <= most);
            let nodes = sums[3 * first..].chunks_exact_mut(3);
            for (node, share) in nodes.zip(shares) {
                for (sum, quanta) in node.iter_mut().zip(quanta) {
                    let added = (quanta * share + 0.5).floor() as i64;
                    let (total, overflow) = sum.overflowing_add(added);
                    *sum = total;
                    fits &= !overflow;
                }
            }
        }
        fits
    }
}

/// Length of a node, metres.
#[must_use]
pub fn length_of_node(node: usize) -> f64 {
    match node {
        0 => 0.0,
        node => SHORTEST * trig::pow(2.0, (node - 1) as f64 / NODES_PER_OCTAVE),
    }
}

/// The first of the nodes that light of this length goes to, and its shares.
fn shares(length: f64) -> (usize, [f64; 4]) {
    if length < SHORTEST {
        // Absorption over so little is a straight line.
        let part = (length / SHORTEST).max(0.0);
        return (0, [1.0 - part, part, 0.0, 0.0]);
    }
    // Place among the nodes from node 1 on.
    let place = trig::ln(length / SHORTEST) * core::f64::consts::LOG2_E * NODES_PER_OCTAVE;
    let last = (NODES - 2) as f64;
    if place >= last {
        return (NODES - 4, [0.0, 0.0, 0.0, 1.0]);
    }
    let first = (place.floor() - 1.0).clamp(0.0, last - 3.0);
    let t = place - first;
    let (a, b, c, d) = (t, t - 1.0, t - 2.0, t - 3.0);
    (first as usize + 1, [-b * c * d / 6.0, a * c * d / 2.0, -a * b * d / 2.0, a * b * c / 6.0])
}

/// The light of every pixel of a film by its length in ice.
#[derive(Clone, Debug, PartialEq)]
pub struct IcePaths {
    layout: IcePathLayout,
    sums: Vec<i64>,
}

impl IcePaths {
    /// Of so many pixels, empty.
    ///
    /// # Errors
    /// More than memory.
    pub(crate) fn new(layout: IcePathLayout, pixels: usize) -> Result<Self, FilmError> {
        let mut sums = Vec::new();
        let count = pixels.saturating_mul(layout.sums());
        sums.try_reserve_exact(count).map_err(|_| FilmError::TooLarge {
            pixels: pixels as u64,
            bytes: pixels as u128 * u128::from(layout.bytes()),
        })?;
        sums.resize(count, 0);
        Ok(Self { layout, sums })
    }

    /// What it is made of.
    #[must_use]
    pub fn layout(&self) -> IcePathLayout {
        self.layout
    }

    /// The sums of all pixels: of each pixel, those of each spectrum; of each, those of each node; of
    /// each, red, green and blue.
    #[must_use]
    pub fn sums(&self) -> &[i64] {
        &self.sums
    }

    /// The same, to be filled.
    pub fn sums_mut(&mut self) -> &mut [i64] {
        &mut self.sums
    }

    /// Light of each spectrum at each of the [`NODES`], linear sRGB, as the mean over the `samples` of a
    /// pixel: all nodes of a spectrum, then those of the next.
    pub fn light(&self, pixel: usize, samples: u64) -> impl Iterator<Item = [f64; 3]> + '_ {
        let scale = self.layout.quantum() / samples.max(1) as f64;
        let sums = &self.sums[pixel * self.layout.sums()..][..self.layout.sums()];
        sums.chunks_exact(3).map(move |sums| [0, 1, 2].map(|c: usize| sums[c] as f64 * scale))
    }
}

/// The first index at which the total of the sums would leave its range.
pub(crate) fn overflow(sums: &[i64], added: &[i64]) -> Option<usize> {
    sums.iter().zip(added).position(|(sum, added)| sum.checked_add(*added).is_none())
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    const LAYOUT: IcePathLayout = IcePathLayout { lights: 1, scale_exponent: 0 };

    /// What is left of light of these lengths at an absorption, from the sums.
    fn left(lengths: &[f64], gamma: f64) -> f64 {
        let mut paths = IcePaths::new(LAYOUT, 1).unwrap();
        for &length in lengths {
            assert!(LAYOUT.add(&mut paths.sums, length, &[[1.0; 3]]));
        }
        let light = paths.light(0, lengths.len() as u64);
        light.enumerate().map(|(k, w)| w[0] * trig::exp(-gamma * length_of_node(k))).sum()
    }

    #[test]
    fn nodes_reach_from_a_millimetre_to_a_kilometre() {
        assert_eq!(length_of_node(1), SHORTEST);
        assert!((length_of_node(NODES - 1) - 1024.0).abs() < 1e-9);
    }

    #[test]
    fn light_of_one_length_is_absorbed_as_it_would_be() {
        let mut worst = 0.0f64;
        for step in 0..400 {
            let length = 1e-6 * trig::pow(1.052, f64::from(step));
            for gamma in [0.003, 0.1, 2.0, 30.0] {
                let error = left(&[length], gamma) - trig::exp(-gamma * length);
                if length < 1000.0 {
                    worst = worst.max(error.abs());
                }
            }
        }
        assert!(worst < 2e-3, "{worst}");
    }

    #[test]
    fn light_of_many_lengths_is_absorbed_within_less() {
        // As from deep snow: the chance of more than L falls as 1 / (1 + (L / 1 cm)^(1/2)).
        let lengths: Vec<f64> = (0..20_000)
            .map(|i| {
                let ratio = 20_000.0 / (f64::from(i) + 0.5) - 1.0;
                0.01 * ratio * ratio
            })
            .collect();
        for gamma in [0.003, 0.02, 0.1, 0.5, 2.0, 10.0] {
            let exact: f64 = lengths.iter().map(|l| trig::exp(-gamma * l)).sum::<f64>() / 20_000.0;
            let found = left(&lengths, gamma);
            assert!((found - exact).abs() < 3e-4, "{gamma}: {found} {exact}");
        }
    }

    #[test]
    fn light_beyond_the_range_is_refused() {
        let mut sums = vec![0; LAYOUT.sums()];
        assert!(!LAYOUT.add(&mut sums, 1.0, &[[1e6; 3]]));
        assert!(!LAYOUT.add(&mut sums, 1.0, &[[f32::NAN; 3]]));
        let mut sums = vec![i64::MAX - 10; LAYOUT.sums()];
        assert!(!LAYOUT.add(&mut sums, 1.0, &[[1.0; 3]]));
        assert_eq!(IcePathLayout::for_radiance(1, 1.0).scale_exponent, 1);
        assert_eq!(IcePathLayout::for_radiance(1, 0.7).scale_exponent, 0);
        assert_eq!(IcePathLayout::for_radiance(1, 5.0).scale_exponent, 3);
    }

    proptest! {
        #[test]
        fn no_light_is_lost(length in 0.0..3000.0f64, weight in -1.0..1.0f32) {
            let mut paths = IcePaths::new(LAYOUT, 1).unwrap();
            prop_assert!(LAYOUT.add(&mut paths.sums, length, &[[weight; 3]]));
            let total: f64 = paths.light(0, 1).map(|w| w[1]).sum();
            prop_assert!((total - f64::from(weight)).abs() < 3e-9);
        }
    }
}
