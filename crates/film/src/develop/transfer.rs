//! The sRGB transfer function (IEC 61966-2-1).

use snowgrain_math::trig;

/// Linear [0, 1] to display [0, 1]; clamps, and turns what is not a number into 0.
#[must_use]
pub fn srgb_from_linear(x: f64) -> f64 {
    if x >= 1.0 {
        1.0
    } else if x > 0.003_130_8 {
        1.055 * trig::pow(x, 1.0 / 2.4) - 0.055
    } else if x > 0.0 {
        12.92 * x
    } else {
        0.0
    }
}

/// The inverse of [`srgb_from_linear`]: display [0, 1] to linear [0, 1].
#[must_use]
pub fn linear_from_srgb(x: f64) -> f64 {
    if x <= 0.040_45 { x / 12.92 } else { trig::pow((x + 0.055) / 1.055, 2.4) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_8_bit_value_survives_the_round_trip() {
        for value in 0..=255u8 {
            let linear = linear_from_srgb(f64::from(value) / 255.0);
            assert_eq!((255.0 * srgb_from_linear(linear)).round() as u8, value);
        }
    }
}
