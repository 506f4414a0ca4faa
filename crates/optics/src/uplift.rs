//! From colours to spectra: a smooth reflectance for every linear sRGB colour.
//!
//! Red, green and blue each have a spectrum; the three add to 1 at every wavelength, none is below 0,
//! and light of D65 that one of them reflects has exactly its colour. So `r red + g green + b blue` is
//! a reflectance in [0, 1] of the colour `(r, g, b)` for all of them in [0, 1], and greys are flat. This
//! is what Mallett and Yuksel ask for ("Spectral Primary Decomposition for Rendering with sRGB
//! Reflectance", EGSR 2019); in place of their table the spectra here are the shares of three
//! exponentials of quadratic polynomials, whose six free coefficients the six conditions on the colours
//! fix.

use snowgrain_math::trig;

/// Coefficients of `exp(a t^2 + b t + c)` for green and blue, red being 1 everywhere; `t = (lambda -
/// 570 nm) / 100 nm`. Found by least squares to a residual of 2.5e-12; a test solves the conditions
/// again.
const GREEN: [f64; 3] = [-12.846_384_087_434_672, -11.397_768_153_385_117, 3.105_163_404_253_633_4];
const BLUE: [f64; 3] = [-3.921_651_270_406_300_7, -8.755_288_459_287_32, -0.790_802_937_754_869_7];

/// Reflectances of red, green and blue at a wavelength, each in [0, 1]; they add to 1.
#[must_use]
pub fn reflectances(wavelength_nm: f64) -> [f64; 3] {
    let t = (wavelength_nm - 570.0) / 100.0;
    let exponents = [[0.0; 3], GREEN, BLUE].map(|[a, b, c]| (a * t + b) * t + c);
    let greatest = exponents.iter().copied().fold(0.0, f64::max);
    let powers = exponents.map(|exponent| trig::exp(exponent - greatest));
    let sum = powers[0] + powers[1] + powers[2];
    powers.map(|power| power / sum)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::colour::{Illuminant, Primaries, tristimulus};
    use snowgrain_math::DVec3;

    #[test]
    fn each_primary_reflects_daylight_of_its_own_colour() {
        for primary in 0..3 {
            let xyz = tristimulus(Illuminant::D65, |nm| reflectances(nm)[primary]);
            let rgb = Primaries::Srgb.under_d65() * xyz;
            let expected = DVec3::AXES[primary];
            assert!((rgb - expected).abs().max_element() < 1e-10, "{primary}: {rgb}");
        }
    }

    #[test]
    fn greys_are_flat_and_nothing_leaves_the_range() {
        for nm in 300..2500 {
            let spectra = reflectances(f64::from(nm));
            assert!(spectra.iter().all(|share| (0.0..=1.0).contains(share)), "{nm}");
            assert!((spectra.iter().sum::<f64>() - 1.0).abs() < 1e-15, "{nm}");
        }
    }

    #[test]
    fn spectra_are_smooth() {
        let steepest = (380..780)
            .flat_map(|nm| {
                let [here, next] = [nm, nm + 1].map(|nm| reflectances(f64::from(nm)));
                [0, 1, 2].map(|i: usize| (here[i] - next[i]).abs())
            })
            .fold(0.0, f64::max);
        assert!(steepest < 0.05, "{steepest} a nanometre");
    }
}
