//! What surfaces that only catch shadows show, beside what they would show alone.
//!
//! A shadow catcher stands for a surface of another picture, the plate: it is not seen itself, but what
//! snow and objects do to its light is to be put onto the plate. Of each sample whose path meets one first,
//! the film keeps the light that it shows (`lit`) and the light that it would show if there were nothing
//! but shadow catchers and lights (`unoccluded`), found by a path with the same random numbers. Both are exact
//! sums, as means of them are compared only when a picture is made: a ratio of single samples would be biased.
//!
//! Seven sums of 16 bytes a pixel, 112 bytes, in quanta of 2^-64.

use crate::FilmError;
use crate::exact::power_of_two;
use crate::light_layers::{Refused, fixed};

/// Fractional bits of the sums.
const FRACTION_BITS: i32 = 64;

/// Exact sums of one pixel in quanta of 2^-64: red, green and blue of `lit`, of `unoccluded`, and the number
/// of samples that met a shadow catcher first.
pub type ShadowSums = [i128; 7];

/// Luminance of linear sRGB (Rec. 709).
const LUMINANCE: [f64; 3] = [0.2126, 0.7152, 0.0722];

/// What shadow catchers show in one pixel: means over all its samples.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct CaughtLight {
    /// Light that they show.
    pub lit: [f64; 3],
    /// Light that they would show alone.
    pub unoccluded: [f64; 3],
    /// Part of the pixel in which they are seen, 0 to 1.
    pub coverage: f64,
}

impl CaughtLight {
    /// Of sums over so many samples.
    #[must_use]
    pub fn of(sums: &ShadowSums, samples: u64) -> Self {
        let scale = power_of_two(-FRACTION_BITS) / samples.max(1) as f64;
        let mean = |index: usize| sums[index] as f64 * scale;
        Self {
            lit: [0, 1, 2].map(mean),
            unoccluded: [3, 4, 5].map(mean),
            coverage: sums[6] as f64 / samples.max(1) as f64,
        }
    }

    /// The part of the plate's light that the shadow takes, 0 to 1, where a catcher is seen.
    #[must_use]
    pub fn shade(&self) -> f64 {
        let luminance = |light: [f64; 3]| {
            light.iter().zip(LUMINANCE).map(|(x, weight)| x * weight).sum::<f64>()
        };
        let (lit, alone) = (luminance(self.lit), luminance(self.unoccluded));
        if alone > 0.0 { (1.0 - lit / alone).clamp(0.0, 1.0) } else { 0.0 }
    }

    /// What is left of a pixel's radiance and alpha when the catcher gives way to the plate: alpha is its
    /// shade, and the light is what it shows beyond the shaded light that it would show alone.
    ///
    /// Put over a plate that shows `unoccluded` (colour + (1 - alpha) plate), this gives back the radiance,
    /// whatever the noise.
    #[must_use]
    pub fn over_plate(&self, radiance: [f64; 3], alpha: f64) -> ([f64; 3], f64) {
        let shade = self.shade();
        let left = |channel: usize| radiance[channel] - (1.0 - shade) * self.unoccluded[channel];
        ([0, 1, 2].map(left), alpha + shade * self.coverage)
    }
}

/// Adds what a sample shows of a catcher; on an error nothing is added.
pub(crate) fn add(
    sums: &mut ShadowSums,
    lit: [f32; 3],
    unoccluded: [f32; 3],
) -> Result<(), Refused> {
    let mut total = *sums;
    let light = lit.into_iter().chain(unoccluded);
    for (sum, light) in total.iter_mut().zip(light) {
        *sum = sum.checked_add(fixed(light)?).ok_or(Refused::Overflow)?;
    }
    total[6] = total[6].checked_add(1).ok_or(Refused::Overflow)?;
    *sums = total;
    Ok(())
}

/// Empty sums of so many pixels.
pub(crate) fn empty_sums(pixels: usize) -> Result<Vec<ShadowSums>, FilmError> {
    let mut sums = Vec::new();
    sums.try_reserve_exact(pixels).map_err(|_| FilmError::TooLarge {
        pixels: pixels as u64,
        bytes: pixels as u128 * size_of::<ShadowSums>() as u128,
    })?;
    sums.resize(pixels, [0; 7]);
    Ok(sums)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn over_the_plate_that_it_would_show_alone_a_catcher_gives_the_render(
            lit in prop::array::uniform3(0.0..4.0f64),
            unoccluded in prop::array::uniform3(0.0..4.0f64),
            others in prop::array::uniform3(0.0..4.0f64),
            coverage in 0.05..1.0f64,
        ) {
            let caught = CaughtLight {
                lit: lit.map(|x| x * coverage),
                unoccluded: unoccluded.map(|x| x * coverage),
                coverage,
            };
            let radiance = [0, 1, 2].map(|c| caught.lit[c] + others[c]);
            let (colour, alpha) = caught.over_plate(radiance, 1.0 - coverage);
            for c in 0..3 {
                let composed = colour[c] + (1.0 - alpha) * unoccluded[c];
                prop_assert!((composed - radiance[c]).abs() < 1e-12);
            }
            prop_assert!((0.0..=1.0).contains(&alpha));
        }
    }

    #[test]
    fn sums_are_exact_and_out_of_range_nothing_is_added() {
        let mut sums = [0; 7];
        for _ in 0..3 {
            assert_eq!(add(&mut sums, [0.25, 0.5, 0.0], [1.0, 0.5, 0.0]), Ok(()));
        }
        let caught = CaughtLight::of(&sums, 4);
        assert_eq!((caught.lit[0], caught.unoccluded[0], caught.coverage), (0.1875, 0.75, 0.75));
        let before = sums;
        assert_eq!(add(&mut sums, [0.0; 3], [f32::NAN, 0.0, 0.0]), Err(Refused::Overflow));
        assert_eq!(sums, before);
    }

    #[test]
    fn where_a_catcher_would_be_dark_alone_there_is_no_shade() {
        let caught = CaughtLight { lit: [0.5; 3], unoccluded: [0.0; 3], coverage: 1.0 };
        assert_eq!(caught.over_plate([0.5; 3], 0.0), ([0.5; 3], 0.0));
    }
}
