//! The display transform: exposure, primaries of sRGB, its transfer function, then 8 or 16 bits.

use crate::{FilmError, Picture, PixelRect};
use snowgrain_math::{DVec3, trig};
use snowgrain_optics::Primaries;

/// Display values of a picture: R, G, B interleaved, row-major, sRGB-encoded.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Developed<T> {
    /// The pixels they belong to.
    pub window: PixelRect,
    /// Three values per pixel of the window.
    pub values: Vec<T>,
}

/// The sRGB transfer function (IEC 61966-2-1): linear [0, 1] to display [0, 1]; clamps, and turns
/// what is not a number into 0.
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

/// 8 bits per channel; `exposure` in stops: the picture is multiplied by 2^exposure, beside its own
/// exposure.
///
/// # Errors
/// A picture without colour.
pub fn to_8_bit(picture: &Picture, exposure: f64) -> Result<Developed<u8>, FilmError> {
    develop(picture, exposure, |x| (255.0 * x).round() as u8)
}

/// 16 bits per channel; `exposure` in stops: the picture is multiplied by 2^exposure, beside its own
/// exposure.
///
/// # Errors
/// A picture without colour.
pub fn to_16_bit(picture: &Picture, exposure: f64) -> Result<Developed<u16>, FilmError> {
    develop(picture, exposure, |x| (65535.0 * x).round() as u16)
}

fn develop<T: Copy>(
    picture: &Picture,
    exposure: f64,
    quantise: impl Fn(f64) -> T,
) -> Result<Developed<T>, FilmError> {
    let [red, green, blue] = picture.colour()?;
    let gain = trig::pow(2.0, picture.exposure_stops + exposure);
    let mut values = Vec::with_capacity(3 * red.len());
    let to_srgb = match picture.primaries {
        Primaries::Srgb => None,
        other => Some(Primaries::Srgb.under_d65() * other.under_d65().inverse()),
    };
    let shown = |x: f32| quantise(srgb_from_linear(gain * f64::from(x)));
    // Neighbouring values are often equal (grey, or a backdrop), and powers are slow.
    let mut last = (0.0, shown(0.0));
    for ((&r, &g), &b) in red.iter().zip(green).zip(blue) {
        let colour = match to_srgb {
            None => [r, g, b],
            Some(matrix) => {
                (matrix * DVec3::from([r, g, b].map(f64::from))).to_array().map(|x| x as f32)
            }
        };
        values.extend(colour.map(|x| {
            if x != last.0 {
                last = (x, shown(x));
            }
            last.1
        }));
    }
    Ok(Developed { window: picture.window(), values })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Layer;

    fn strip(values: &[f32]) -> Picture {
        let width = values.len() as u32;
        let mut picture = Picture::new(width, 1, PixelRect::new(0, 0, width, 1)).unwrap();
        for layer in Layer::COLOUR {
            picture.set_layer(layer, values.to_vec()).unwrap();
        }
        picture
    }

    #[test]
    fn known_values_clamp_and_encode() {
        let picture = strip(&[0.0, 1.0, 2.0, -1.0, f32::NAN, 0.214_041_14, f32::INFINITY]);
        let developed = to_8_bit(&picture, 0.0).unwrap().values;
        let first: Vec<u8> = developed.chunks_exact(3).map(|rgb| rgb[0]).collect();
        assert_eq!(first, [0, 255, 255, 0, 0, 128, 255]); // sRGB .5 is linear .21404
        assert_eq!(to_16_bit(&picture, 0.0).unwrap().values[15], 32768);
    }

    #[test]
    fn a_stop_doubles() {
        let stop = to_16_bit(&strip(&[0.1, 0.4]), 1.0).unwrap();
        assert_eq!(stop.values, to_16_bit(&strip(&[0.2, 0.8]), 0.0).unwrap().values);
        let mut own = strip(&[0.1, 0.4]);
        own.exposure_stops = 3.0;
        assert_eq!(to_16_bit(&own, -2.0).unwrap(), stop, "its own exposure, and more");
    }

    #[test]
    fn other_primaries_show_the_same_colours() {
        let mut picture = strip(&[0.4]);
        picture.primaries = Primaries::AcesCg;
        assert_eq!(to_8_bit(&picture, 0.0).unwrap(), to_8_bit(&strip(&[0.4]), 0.0).unwrap());
        // Red of sRGB in ACEScg.
        for (layer, value) in Layer::COLOUR.into_iter().zip([0.6131, 0.0702, 0.0206]) {
            picture.set_layer(layer, vec![value]).unwrap();
        }
        let [red, green, blue] = to_8_bit(&picture, 0.0).unwrap().values[..] else { panic!() };
        assert!(red >= 254 && green <= 5 && blue <= 5, "{red} {green} {blue}");
    }

    #[test]
    fn every_8_bit_value_survives_the_round_trip() {
        for value in 0..=255u8 {
            let linear = linear_from_srgb(f64::from(value) / 255.0);
            assert_eq!((255.0 * srgb_from_linear(linear)).round() as u8, value);
        }
    }
}
