//! Light that the eye scatters.

use core::f64::consts::PI;
use snowgrain_math::trig;

/// Age of the eye, years, as the fourth power of its part of 70.
const AGE: f64 = 0.5 * 0.5 * 0.5 * 0.5;
/// Pigment of the eye: 0 for very dark, .5 for brown, 1 for blue-green eyes.
const PIGMENT: f64 = 0.5;

/// The point spread function of the eye of a 35-year-old with brown eyes, at `degrees` from the source, 1/sr: the
/// CIE total glare function (J. J. Vos and T. J. T. P. van den Berg, "Report on disability glare", CIE Collection 135/1,
/// 1999; CIE 146:2002), 0 to 90 degrees. It adds up to 1.03.
#[must_use]
pub(super) fn point_spread(degrees: f64) -> f64 {
    let over = |scale: f64| {
        let ratio = degrees / scale;
        1.0 + ratio * ratio
    };
    let root_cubed = |x: f64| x * x.sqrt();
    let focus = 9.2e6 / root_cubed(over(0.0046)) + 1.5e5 / root_cubed(over(0.045));
    let wide = over(0.1);
    let lens = 400.0 / wide + 3e-8 * degrees * degrees;
    let fundus = 1300.0 / root_cubed(wide) + 0.8 / wide.sqrt();
    (1.0 - 0.08 * AGE) * focus + (1.0 + 1.6 * AGE) * (lens + PIGMENT * fundus) + 2.5e-3 * PIGMENT
}

/// The part of a light's energy that reaches a spot of a picture whose middle is `x`, `y` pixels away, a pixel
/// square, where a pixel has `tangent` as the tangent of its angle.
pub(super) fn share(x: f64, y: f64, tangent: f64) -> f64 {
    let distance = tangent * (x * x + y * y).sqrt();
    let degrees = trig::atan2(distance, 1.0) * 180.0 / PI;
    let cosine_squared = 1.0 / (1.0 + distance * distance);
    let solid_angle = tangent * tangent * cosine_squared * cosine_squared.sqrt();
    point_spread(degrees) * solid_angle
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_spread_adds_up_to_one_as_published() {
        let (mut sum, steps) = (0.0, 40_000);
        let (first, last) = (trig::ln(1e-5), trig::ln(90.0));
        let width = (last - first) / f64::from(steps);
        for step in 0..steps {
            let degrees = trig::exp(first + (f64::from(step) + 0.5) * width);
            let (sin, _) = trig::sin_cos(degrees.to_radians());
            sum += point_spread(degrees) * 2.0 * PI * sin * degrees.to_radians() * width;
        }
        assert!((sum - 1.0).abs() < 0.04, "{sum}");
    }

    #[test]
    fn far_out_it_is_the_formula_for_disability_glare() {
        // CIE 146:2002, general equation, of the same age and pigment, within its spread.
        let age = (35.0f64 / 62.5) * (35.0 / 62.5);
        for degrees in [3.0, 10.0, 30.0] {
            let general = 10.0 / (degrees * degrees * degrees)
                + (5.0 / (degrees * degrees) + 0.1 * PIGMENT / degrees) * (1.0 + age * age)
                + 0.0025 * PIGMENT;
            let ratio = point_spread(degrees) / general;
            assert!((0.75..1.35).contains(&ratio), "{degrees}: {ratio}");
        }
    }
}
