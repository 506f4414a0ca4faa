//! What of a picture is light that was learnt, and what that is off by.
//!
//! Where light ends deep in the snow with the mean of what other light brought, each sample tells how much
//! of its radiance that is, and the standard error of the mean. The samples of a pixel end in the same few cells, so their
//! errors do not average out: the mean of the errors is that of the pixel.
//!
//! Two sums of 16 bytes a pixel, 32 bytes, in quanta of 2^-64.

use crate::FilmError;
use crate::exact::power_of_two;
use crate::light_layers::{Refused, fixed};

/// Fractional bits of the sums.
const FRACTION_BITS: i32 = 64;

/// Exact sums of one pixel in quanta of 2^-64: of learnt light, and of its standard error; means of the channels.
pub type LearntSums = [i128; 2];

/// Means over all samples of one pixel.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct LearntLight {
    /// Radiance that was learnt, the mean of the channels.
    pub light: f64,
    /// Standard error of it.
    pub error: f64,
}

impl LearntLight {
    /// Of sums over so many samples.
    #[must_use]
    pub fn of(sums: &LearntSums, samples: u64) -> Self {
        let scale = power_of_two(-FRACTION_BITS) / samples.max(1) as f64;
        let [light, error] = sums.map(|sum| sum as f64 * scale);
        Self { light, error }
    }
}

/// Adds what a sample learnt; on an error nothing is added.
pub(crate) fn add(sums: &mut LearntSums, light: f32, error: f32) -> Result<(), Refused> {
    let mut total = *sums;
    for (sum, value) in total.iter_mut().zip([light, error]) {
        *sum = sum.checked_add(fixed(value)?).ok_or(Refused::Overflow)?;
    }
    *sums = total;
    Ok(())
}

/// Sums of so many pixels, empty.
///
/// # Errors
/// More than memory.
pub(crate) fn empty_sums(pixels: usize) -> Result<Vec<LearntSums>, FilmError> {
    let mut sums = Vec::new();
    sums.try_reserve_exact(pixels).map_err(|_| FilmError::TooLarge {
        pixels: pixels as u64,
        bytes: pixels as u128 * size_of::<LearntSums>() as u128,
    })?;
    sums.resize(pixels, [0; 2]);
    Ok(sums)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn means_are_those_of_what_was_added() {
        let mut sums = LearntSums::default();
        add(&mut sums, 0.75, 0.0625).unwrap();
        add(&mut sums, 0.25, 0.0).unwrap();
        assert!(add(&mut sums, f32::NAN, 1.0).is_err());
        assert_eq!(LearntLight::of(&sums, 4), LearntLight { light: 0.25, error: 0.015_625 });
        assert_eq!(LearntLight::of(&LearntSums::default(), 0), LearntLight::default());
    }
}
