//! The colour of light of a correlated colour temperature.

use crate::colour::{VISIBLE_NM, chromaticity, observer};
use crate::{Illuminant, Primaries, colour};
use snowgrain_math::{DMat3, DVec3, trig};

/// Temperatures that have a colour here, K.
pub const KELVIN: [f64; 2] = [1000.0, 25_000.0];

/// Second radiation constant, nm K (CODATA 2018).
const SECOND_RADIATION: f64 = 1.438_776_877e7;

/// Below this, thermal radiation; from [`DAYLIGHT`] on, daylight; both mixed in between, K.
const THERMAL: f64 = 4000.0;
const DAYLIGHT: f64 = 5000.0;

/// CIE 1931 x, y of light of a temperature in [`KELVIN`]: thermal radiation (Planck) up to 4000 K,
/// daylight from 5000 K on (CIE 15:2018, eqs. 4.7 to 4.9), and straight between them.
#[must_use]
pub fn chromaticity_of(kelvin: f64) -> [f64; 2] {
    let part = ((kelvin - THERMAL) / (DAYLIGHT - THERMAL)).clamp(0.0, 1.0);
    let (thermal, daylight) = (thermal(kelvin), daylight(kelvin.max(THERMAL)));
    [0, 1].map(|i: usize| (1.0 - part) * thermal[i] + part * daylight[i])
}

/// The colour of light of a temperature in [`KELVIN`], linear sRGB with luminance 1, in which light of
/// D65 is white. Blue that would be below 0 (under about 1900 K) is 0.
#[must_use]
pub fn srgb_of(kelvin: f64) -> [f64; 3] {
    let [x, y] = chromaticity_of(kelvin);
    let xyz = DVec3::new(x / y, 1.0, (1.0 - x - y) / y);
    (Primaries::Srgb.under_d65() * xyz).max(DVec3::ZERO).to_array()
}

/// The matrix that makes light of the chromaticity `white` white: from linear sRGB, in which D65 is
/// white, to the same, adapted by Bradford's cones.
#[must_use]
pub fn adaptation_from(white: [f64; 2]) -> DMat3 {
    let [x, y] = white;
    let white = DVec3::new(x / y, 1.0, (1.0 - x - y) / y);
    let daylight = colour::tristimulus(Illuminant::D65, |_| 1.0);
    let to_srgb = Primaries::Srgb.under_d65();
    to_srgb * colour::bradford(white, daylight) * to_srgb.inverse()
}

/// Thermal radiation.
fn thermal(kelvin: f64) -> [f64; 2] {
    let [first, last] = VISIBLE_NM;
    let sum = (0..=(last - first) as u32).fold(DVec3::ZERO, |sum, step| {
        let nm = first + f64::from(step);
        let micrometres = nm * 1e-3;
        let fifth = micrometres * micrometres * micrometres * micrometres * micrometres;
        sum + observer(nm) / (fifth * trig::exp_m1(SECOND_RADIATION / (nm * kelvin)))
    });
    chromaticity(sum)
}

/// Daylight, from 4000 K on.
fn daylight(kelvin: f64) -> [f64; 2] {
    let t = 1000.0 / kelvin;
    let x = if kelvin <= 7000.0 {
        ((-4.6070 * t + 2.9678) * t + 0.09911) * t + 0.244_063
    } else {
        ((-2.0064 * t + 1.9018) * t + 0.24748) * t + 0.237_040
    };
    [x, (-3.0 * x + 2.870) * x - 0.275]
}

#[cfg(test)]
mod tests {
    use super::*;

    fn near(kelvin: f64, x: f64, y: f64) {
        let [found_x, found_y] = chromaticity_of(kelvin);
        assert!((found_x - x).abs() < 3e-4 && (found_y - y).abs() < 3e-4, "{kelvin} {found_x}");
    }

    #[test]
    fn standard_illuminants_have_their_temperatures() {
        near(2856.0, 0.4476, 0.4074); // CIE A
        near(5503.0, 0.3324, 0.3474); // D55
        near(6504.0, 0.3127, 0.3290); // D65
        near(7504.0, 0.2990, 0.3149); // D75
    }

    #[test]
    fn the_colour_of_daylight_is_white_and_that_of_a_candle_has_no_negative_part() {
        for (c, value) in srgb_of(6504.0).into_iter().enumerate() {
            assert!((value - 1.0).abs() < 2e-3, "{c}: {value}");
        }
        let [red, green, blue] = srgb_of(1500.0);
        assert!(red > 2.0 && green > 0.3 && blue == 0.0, "{red} {green} {blue}");
    }

    #[test]
    fn temperatures_change_colour_without_steps() {
        let mut last = chromaticity_of(KELVIN[0]);
        for step in 1..=240 {
            let next = chromaticity_of(1000.0 + 100.0 * f64::from(step));
            assert!(next[0] < last[0] && (last[0] - next[0]) < 0.02, "{step}");
            last = next;
        }
    }

    #[test]
    fn adaptation_makes_the_light_white() {
        let white = adaptation_from(chromaticity_of(3200.0)) * DVec3::from(srgb_of(3200.0));
        let grey = white.element_sum() / 3.0;
        assert!((white / grey - DVec3::ONE).abs().max_element() < 1e-9, "{white}");
    }
}
