//! Light that a lens scatters.

use core::f64::consts::PI;
use snowgrain_math::trig;

/// Energy of a Gaussian, and its standard deviation over the height of the picture: bloom around highlights.
const BLOOM: [f64; 2] = [0.03, 0.003];
/// Energy of a tail `(1 + (r / s)^2)^(-3/2)`, and s over the height of the picture: halation.
const HALO: [f64; 2] = [0.012, 0.012];
/// The same of the veil over the whole picture.
const VEIL: [f64; 2] = [0.008, 0.3];

/// The part of a light's energy that reaches a spot of a picture whose middle is `x`, `y` pixels away, a pixel
/// square, in a picture of `height` pixels.
///
/// The figures are those of no one lens: they are chosen so that the veil and the halo are those of a good
/// one (a veiling glare index of about 2 %, as ISO 9358 measures it) and a bright glint blooms visibly.
pub(super) fn share(x: f64, y: f64, height: f64) -> f64 {
    let square = x * x + y * y;
    let [energy, deviation] = BLOOM;
    let variance = deviation * deviation * height * height;
    let bloom = energy / (2.0 * PI * variance) * trig::exp(-0.5 * square / variance);
    let tail = |[energy, scale]: [f64; 2]| {
        let scale = scale * scale * height * height;
        let over = 1.0 + square / scale;
        energy / (2.0 * PI * scale) / (over * over.sqrt())
    };
    bloom + tail(HALO) + tail(VEIL)
}
