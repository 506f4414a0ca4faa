//! Glare: light that spreads in the eye or in a lens, so that a glint looks brighter than white.
//!
//! Light is only moved: what a pixel scatters is taken from it, and what would leave the picture, or fall farther
//! than its width or height, stays where it is or comes back mirrored. So the energy of the
//! picture is kept, and a constant picture stays as it is.

mod eye;
mod fft;
mod lens;
mod mirror;

use super::Curve;
use crate::{FilmError, Picture};
use fft::Complex;
use mirror::{Mirror, zeros};
use snowgrain_math::trig;

/// Where light spreads, with a factor for how much of it does (1: as the model says; at least 0).
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Glare {
    /// Nowhere.
    #[default]
    None,
    /// In the eye, as far as the screen cannot make it happen: light over what the curve shows as nearly white
    /// (250 of 255) spreads as in the eye of a 35-year-old (the CIE total glare function, by angles). What
    /// the screen does show spreads in the eye that looks at it.
    Eye {
        /// Factor.
        strength: f64,
    },
    /// In a lens: 5 % of all light, as a narrow bloom, a halo and a veil, by the height of the picture.
    Lens {
        /// Factor.
        strength: f64,
    },
}

/// What a screen shows as nearly white, of 1.
const NEARLY_WHITE: f64 = 250.0 / 255.0;

/// Offsets up to which the weights of a pixel are means of so many places a side.
const FINE: [(usize, u32); 3] = [(2, 16), (8, 4), (24, 2)];

type Planes = [Vec<f64>; 3];

impl Glare {
    /// The light of a picture after it has spread; `None` where that changes nothing.
    ///
    /// # Errors
    /// The eye, of a picture of unknown field of view; more than memory.
    pub(super) fn spread(
        self,
        picture: &Picture,
        curve: Curve,
        light: impl Fn(usize) -> [f64; 3],
    ) -> Result<Option<Planes>, FilmError> {
        let window = picture.window();
        let (width, height) = (window.width() as usize, window.height() as usize);
        let whole = f64::from(picture.height());
        match self {
            Self::None => Ok(None),
            Self::Eye { strength } => {
                let fov = picture.vertical_fov_degrees.ok_or(FilmError::NoFieldOfView)?;
                let tangent = 2.0 * trig::tan(0.5 * fov.to_radians()) / whole;
                let white = curve.light_shown_as(NEARLY_WHITE);
                let over = |pixel: usize| light(pixel).map(|x| (x - white).max(0.0));
                if (0..width * height).all(|pixel| over(pixel) == [0.0; 3]) {
                    return Ok(None);
                }
                let kernel = quadrant(width, height, strength, |x, y| eye::share(x, y, tangent))?;
                let mut planes = convolve(width, height, &kernel, over)?;
                for pixel in 0..width * height {
                    let light = light(pixel);
                    for (plane, x) in planes.iter_mut().zip(light) {
                        plane[pixel] += x.min(white);
                    }
                }
                Ok(Some(planes))
            }
            Self::Lens { strength } => {
                let kernel = quadrant(width, height, strength, |x, y| lens::share(x, y, whole))?;
                convolve(width, height, &kernel, light).map(Some)
            }
        }
    }
}

/// The weights of offsets of `0..width` columns and `0..height` rows; with those of the other quadrants they
/// add up to 1, as what does not spread stays.
fn quadrant(
    width: usize,
    height: usize,
    strength: f64,
    share: impl Fn(f64, f64) -> f64,
) -> Result<Vec<f64>, FilmError> {
    let mut weights: Vec<f64> = zeros(width * height)?;
    let mut total = 0.0;
    for (index, weight) in weights.iter_mut().enumerate().skip(1) {
        let (x, y) = (index % width, index / width);
        *weight = mean_share(x, y, &share);
        let quadrants = if x == 0 || y == 0 { 2.0 } else { 4.0 };
        total += quadrants * *weight;
    }
    let factor = if strength * total > 1.0 { 1.0 / total } else { strength };
    weights.iter_mut().for_each(|weight| *weight *= factor);
    weights[0] = (1.0 - factor * total).max(0.0);
    Ok(weights)
}

/// The mean of a share over a pixel at an offset.
fn mean_share(x: usize, y: usize, share: impl Fn(f64, f64) -> f64) -> f64 {
    let places = FINE.iter().find(|(reach, _)| x.max(y) <= *reach).map_or(1, |(_, places)| *places);
    let at = |middle: usize, place: u32| {
        middle as f64 - 0.5 + (f64::from(place) + 0.5) / f64::from(places)
    };
    let all = (0..places).flat_map(|v| (0..places).map(move |u| (u, v)));
    let sum: f64 = all.map(|(u, v)| share(at(x, u), at(y, v))).sum();
    sum / f64::from(places * places)
}

/// Three channels, convolved.
fn convolve(
    width: usize,
    height: usize,
    kernel: &[f64],
    light: impl Fn(usize) -> [f64; 3],
) -> Result<Planes, FilmError> {
    let mut mirror = Mirror::new(width, height, kernel)?;
    let count = width * height;
    let mut planes: Planes = [zeros(count)?, zeros(count)?, zeros(count)?];
    let mut pairs: Vec<Complex> = zeros(count)?;
    for (pixel, pair) in pairs.iter_mut().enumerate() {
        let [re, im, _] = light(pixel);
        *pair = Complex { re, im };
    }
    for (pixel, pair) in mirror.convolve(pairs)?.into_iter().enumerate() {
        (planes[0][pixel], planes[1][pixel]) = (pair.re, pair.im);
    }
    let mut pairs: Vec<Complex> = zeros(count)?;
    for (pixel, pair) in pairs.iter_mut().enumerate() {
        pair.re = light(pixel)[2];
    }
    for (pixel, pair) in mirror.convolve(pairs)?.into_iter().enumerate() {
        planes[2][pixel] = pair.re;
    }
    Ok(planes)
}

#[cfg(test)]
mod tests;
