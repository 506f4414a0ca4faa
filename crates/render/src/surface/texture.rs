//! Pictures on objects.

use crate::RenderError;
use snowgrain_film::develop::linear_from_srgb;
use std::sync::{Arc, LazyLock};

/// Most pixels across or down.
pub const LARGEST_TEXTURE: usize = 16_384;

/// Linear values of those of 8 bits.
static LINEAR: LazyLock<[f32; 256]> =
    LazyLock::new(|| std::array::from_fn(|value| linear_from_srgb(value as f64 / 255.0) as f32));

/// A picture of parts of light, linear sRGB in [0, 1], row by row from the top. Between the middles of
/// pixels it is interpolated, beyond its edges it goes on with itself.
#[derive(Clone, Debug, PartialEq)]
pub struct Texture {
    width: usize,
    height: usize,
    pixels: Pixels,
}

#[derive(Clone, Debug, PartialEq)]
enum Pixels {
    /// sRGB of 8 bits.
    Bytes(Vec<[u8; 3]>),
    /// Linear.
    Floats(Vec<[f32; 3]>),
}

impl Texture {
    /// A picture of sRGB of 8 bits a channel.
    ///
    /// # Errors
    /// An empty picture, one larger than [`LARGEST_TEXTURE`], or another number of pixels.
    pub fn of_bytes(size: [usize; 2], pixels: Vec<[u8; 3]>) -> Result<Self, RenderError> {
        check_texture_size(size[0], size[1])?;
        Self::checked(size, pixels.len(), Pixels::Bytes(pixels))
    }

    /// A picture of linear values, which are clamped to [0, 1].
    ///
    /// # Errors
    /// As [`Self::of_bytes`]; a value that is not a number.
    pub fn of_floats(size: [usize; 2], mut pixels: Vec<[f32; 3]>) -> Result<Self, RenderError> {
        check_texture_size(size[0], size[1])?;
        if let Some(at) = pixels.iter().position(|pixel| pixel.iter().any(|value| value.is_nan())) {
            return Err(RenderError::TextureValue { x: at % size[0], y: at / size[0] });
        }
        for pixel in &mut pixels {
            *pixel = pixel.map(|value| value.clamp(0.0, 1.0));
        }
        Self::checked(size, pixels.len(), Pixels::Floats(pixels))
    }

    fn checked(
        [width, height]: [usize; 2],
        count: usize,
        pixels: Pixels,
    ) -> Result<Self, RenderError> {
        if count != width * height {
            return Err(RenderError::MapPixels { width, height, pixels: count });
        }
        Ok(Self { width, height, pixels })
    }

    /// The colour at a place: `u` to the right and `v` upwards, from 0 to 1 across the picture.
    #[must_use]
    pub fn at(&self, [u, v]: [f64; 2]) -> [f32; 3] {
        let (x, right) = split(u, self.width);
        let (y, down) = split(1.0 - v, self.height);
        let (next_x, next_y) = ((x + 1) % self.width, (y + 1) % self.height);
        let corners = [(x, y), (next_x, y), (x, next_y), (next_x, next_y)];
        let [a, b, c, d] = corners.map(|(x, y)| self.pixel(y * self.width + x));
        std::array::from_fn(|i| {
            let above = a[i] * (1.0 - right) + b[i] * right;
            let below = c[i] * (1.0 - right) + d[i] * right;
            (above * (1.0 - down) + below * down).clamp(0.0, 1.0)
        })
    }

    /// The mean colour.
    #[must_use]
    pub fn mean(&self) -> [f32; 3] {
        let count = self.width * self.height;
        let mut sums = [0.0; 3];
        for index in 0..count {
            let pixel = self.pixel(index);
            sums.iter_mut().zip(pixel).for_each(|(sum, value)| *sum += f64::from(value));
        }
        sums.map(|sum| (sum / count as f64) as f32)
    }

    /// Pixels across and down.
    #[must_use]
    pub fn size(&self) -> [usize; 2] {
        [self.width, self.height]
    }

    /// Memory held, bytes.
    #[must_use]
    pub fn memory_bytes(&self) -> u64 {
        match &self.pixels {
            Pixels::Bytes(pixels) => size_of_val(pixels.as_slice()) as u64,
            Pixels::Floats(pixels) => size_of_val(pixels.as_slice()) as u64,
        }
    }

    /// All that decides its colours, as bytes.
    pub(crate) fn digest(&self) -> [u8; 32] {
        let mut hasher = blake3::Hasher::new();
        hasher.update(&(self.width as u64).to_le_bytes());
        match &self.pixels {
            Pixels::Bytes(pixels) => {
                hasher.update(b"bytes");
                hasher.update(pixels.as_flattened());
            }
            Pixels::Floats(pixels) => {
                hasher.update(b"floats");
                for value in pixels.as_flattened() {
                    hasher.update(&value.to_le_bytes());
                }
            }
        }
        *hasher.finalize().as_bytes()
    }

    fn pixel(&self, index: usize) -> [f32; 3] {
        match &self.pixels {
            Pixels::Bytes(pixels) => pixels[index].map(|value| LINEAR[usize::from(value)]),
            Pixels::Floats(pixels) => pixels[index],
        }
    }
}

/// The pixel whose middle is at or before a place of a repeating picture, and how far on it is.
fn split(place: f64, count: usize) -> (usize, f32) {
    let place = place.rem_euclid(1.0) * count as f64 - 0.5;
    let before = place.floor();
    let index = if before < 0.0 { count - 1 } else { (before as usize).min(count - 1) };
    (index, (place - before) as f32)
}

/// Refuses sizes that no texture has.
///
/// # Errors
/// No pixels, or more than [`LARGEST_TEXTURE`] across or down.
pub fn check_texture_size(width: usize, height: usize) -> Result<(), RenderError> {
    let range = 1..=LARGEST_TEXTURE;
    if range.contains(&width) && range.contains(&height) {
        return Ok(());
    }
    Err(RenderError::TextureSize { width, height })
}

/// A picture as it lies on an object.
#[derive(Clone, Debug, PartialEq)]
pub struct TextureMap {
    /// The picture.
    pub texture: Arc<Texture>,
    /// What its colours are multiplied by, linear RGB, each in [0, 1].
    pub factor: [f32; 3],
    /// Width and height of the picture on a plane, metres, above 0; other shapes have coordinates of
    /// their own.
    pub metres: f64,
}

/// A part of light, by colour: of one value or by a picture.
#[derive(Clone, Debug, PartialEq)]
pub enum Reflectance {
    /// The same everywhere, linear RGB, each in [0, 1].
    Colour([f32; 3]),
    /// By place.
    Texture(TextureMap),
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pixels_are_met_at_their_middles_and_mixed_between() {
        let pixels = vec![[0, 255, 0], [255, 0, 0], [0, 0, 255], [188, 188, 188]];
        let picture = Texture::of_bytes([2, 2], pixels).unwrap();
        assert_eq!(picture.at([0.25, 0.75]), [0.0, 1.0, 0.0], "upper left");
        assert_eq!(picture.at([0.75, 0.75]), [1.0, 0.0, 0.0]);
        assert_eq!(picture.at([0.25, 0.25]), [0.0, 0.0, 1.0]);
        assert!((picture.at([0.75, 0.25])[0] - 0.5028).abs() < 1e-3, "sRGB is decoded");
        assert_eq!(picture.at([0.5, 0.75]), [0.5, 0.5, 0.0]);
        assert_eq!(picture.at([1.0, 0.75]), picture.at([0.0, 0.75]), "it repeats");
        assert_eq!(picture.at([-3.25, 7.25]), picture.at([0.75, 0.25]));
        assert_eq!(picture.at([-f64::MIN_POSITIVE, 0.75]), [0.5, 0.5, 0.0]);
        let mean = (1.0 + picture.at([0.75, 0.25])[0]) / 4.0;
        assert!(picture.mean().iter().all(|c| (c - mean).abs() < 1e-6));
    }

    #[test]
    fn pictures_that_are_none_are_refused_and_values_clamped() {
        assert!(Texture::of_bytes([0, 4], Vec::new()).is_err());
        assert!(Texture::of_bytes([16_385, 1], vec![[0; 3]; 16_385]).is_err());
        assert!(Texture::of_bytes([2, 2], vec![[0; 3]; 3]).is_err());
        let error = Texture::of_floats([2, 1], vec![[0.0; 3], [0.0, f32::NAN, 0.0]]).unwrap_err();
        assert!(error.to_string().contains("(1, 0)"), "{error}");
        let picture = Texture::of_floats([1, 1], vec![[-1.0, 0.25, f32::INFINITY]]).unwrap();
        assert_eq!(picture.at([0.3, 0.9]), [0.0, 0.25, 1.0]);
        assert_eq!((picture.size(), picture.memory_bytes()), ([1, 1], 12));
    }
}
