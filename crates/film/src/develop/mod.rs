//! The display transform: from scene-linear light to 8 or 16 bits of a screen.
//!
//! In this order: primaries to sRGB, white balance, exposure, glare, tone curve, gamut mapping, the sRGB
//! transfer function, rounding. Each step but the first and the last two does nothing unless
//! [`Development`] asks for it.

mod body;
mod curve;
mod gamut;
mod glare;
mod oklab;
mod transfer;

use crate::{FilmError, Layer, Picture, PixelRect};
use body::Body;
use snowgrain_math::{DMat3, DVec3, trig};
use snowgrain_optics::{Primaries, colour_temperature};

pub use curve::Curve;
pub use gamut::Gamut;
pub use glare::Glare;
pub use transfer::{linear_from_srgb, srgb_from_linear};

/// How bright a picture is shown.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Exposure {
    /// The light is multiplied by 2 to this power, beside the exposure that the picture carries.
    Stops(f64),
    /// Such that the median of the sunlit body (`develop::body`) is shown as 212 of 255.
    Auto,
}

/// What is shown as white.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum WhiteBalance {
    /// Light of D65.
    #[default]
    None,
    /// Light of this temperature, K, in [`colour_temperature::KELVIN`]; adapted by Bradford's cones.
    Kelvin(f64),
    /// The mean colour of the sunlit body (`develop::body`); adapted by Bradford's cones.
    Sunlit,
}

/// How a picture is shown; the default shows it as it is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Development {
    /// Brightness.
    pub exposure: Exposure,
    /// White.
    pub white_balance: WhiteBalance,
    /// Light that spreads in the eye or in a lens.
    pub glare: Glare,
    /// Tone curve.
    pub curve: Curve,
    /// What becomes of colours out of the gamut of the screen.
    pub gamut: Gamut,
}

impl Default for Development {
    fn default() -> Self {
        Self::plain(0.0)
    }
}

/// Code of the median of the sunlit body under [`Exposure::Auto`], of 1.
const BODY_CODE: f64 = 212.0 / 255.0;

impl Development {
    /// The picture as it is, times 2 to the power of `stops`, cut off at white.
    #[must_use]
    pub fn plain(stops: f64) -> Self {
        Self {
            exposure: Exposure::Stops(stops),
            white_balance: WhiteBalance::None,
            glare: Glare::None,
            curve: Curve::Plain,
            gamut: Gamut::Clip,
        }
    }

    /// The exposure of a picture in stops, its own included; 0 where it is automatic and nothing has light.
    ///
    /// # Errors
    /// A picture without colour.
    pub fn stops(&self, picture: &Picture) -> Result<f64, FilmError> {
        let mut scene = Scene::new(picture)?;
        scene.balance(self.white_balance);
        Ok(self.stops_of(&scene))
    }

    fn stops_of(&self, scene: &Scene<'_>) -> f64 {
        match self.exposure {
            Exposure::Stops(stops) => scene.exposure_stops + stops,
            Exposure::Auto => Body::of(scene).map_or(0.0, |body| {
                let gain = self.curve.light_shown_as(BODY_CODE) / body.luminance;
                trig::ln(gain) * core::f64::consts::LOG2_E
            }),
        }
    }

    /// Linear light of the screen, of which 1 is white, of a pixel's exposed light.
    fn show(&self, exposed: [f64; 3]) -> [f64; 3] {
        self.gamut.apply(self.curve.apply(exposed))
    }
}

/// Display values of a picture: R, G, B interleaved, row-major, sRGB-encoded.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Developed<T> {
    /// The pixels they belong to.
    pub window: PixelRect,
    /// Three values per pixel of the window.
    pub values: Vec<T>,
}

/// 8 bits per channel.
///
/// # Errors
/// A picture without colour; glare of the eye where the field of view is not known, or beyond memory.
pub fn to_8_bit(picture: &Picture, how: &Development) -> Result<Developed<u8>, FilmError> {
    develop(picture, how, |x| (255.0 * x).round() as u8)
}

/// 16 bits per channel.
///
/// # Errors
/// As [`to_8_bit`].
pub fn to_16_bit(picture: &Picture, how: &Development) -> Result<Developed<u16>, FilmError> {
    develop(picture, how, |x| (65535.0 * x).round() as u16)
}

fn develop<T: Copy>(
    picture: &Picture,
    how: &Development,
    quantise: impl Fn(f64) -> T,
) -> Result<Developed<T>, FilmError> {
    let mut scene = Scene::new(picture)?;
    scene.balance(how.white_balance);
    let gain = trig::pow(2.0, how.stops_of(&scene));
    let exposed = |pixel: usize| scene.colour(pixel).map(|x| gain * x);
    let spread = how.glare.spread(picture, how.curve, exposed)?;
    let mut values = Vec::with_capacity(3 * scene.pixels());
    let encode = |x: f64| quantise(srgb_from_linear(x));
    // Neighbouring values are often equal (grey, or a backdrop), and powers are slow.
    let mut last = (0.0, encode(0.0));
    for pixel in 0..scene.pixels() {
        let light = match &spread {
            None => exposed(pixel),
            Some(planes) => planes.each_ref().map(|plane| plane[pixel]),
        };
        values.extend(how.show(light).map(|x| {
            if x != last.0 {
                last = (x, encode(x));
            }
            last.1
        }));
    }
    Ok(Developed { window: picture.window(), values })
}

/// The light of a picture in linear sRGB.
struct Scene<'a> {
    channels: [&'a [f32]; 3],
    alpha: Option<&'a [f32]>,
    /// What the picture carries.
    exposure_stops: f64,
    /// From the primaries of the picture, where those are others.
    to_srgb: Option<DMat3>,
    /// Adaptation to white.
    white: Option<DMat3>,
}

impl<'a> Scene<'a> {
    fn new(picture: &'a Picture) -> Result<Self, FilmError> {
        let to_srgb = match picture.primaries {
            Primaries::Srgb => None,
            other => Some(Primaries::Srgb.under_d65() * other.under_d65().inverse()),
        };
        let (channels, alpha) = (picture.colour()?, picture.layer(Layer::A));
        let exposure_stops = picture.exposure_stops;
        Ok(Self { channels, alpha, exposure_stops, to_srgb, white: None })
    }

    /// Chooses what is white.
    fn balance(&mut self, white: WhiteBalance) {
        let white = match white {
            WhiteBalance::None => None,
            WhiteBalance::Kelvin(kelvin) => Some(colour_temperature::chromaticity_of(kelvin)),
            WhiteBalance::Sunlit => Body::of(self).map(|body| {
                let xyz = Primaries::Srgb.under_d65().inverse() * DVec3::from(body.colour);
                snowgrain_optics::colour::chromaticity(xyz)
            }),
        };
        self.white = white.map(colour_temperature::adaptation_from);
    }

    fn pixels(&self) -> usize {
        self.channels[0].len()
    }

    fn colour(&self, pixel: usize) -> [f64; 3] {
        let mut colour = self.channels.map(|channel| f64::from(channel[pixel]));
        if let Some(matrix) = &self.to_srgb {
            let srgb = *matrix * DVec3::from(colour);
            colour = srgb.to_array().map(|x| f64::from(x as f32));
        }
        match &self.white {
            None => colour,
            Some(white) => (*white * DVec3::from(colour)).to_array(),
        }
    }
}

#[cfg(test)]
mod tests;
