//! The part of a film that one thread fills.

use crate::film::pixels_for;
use crate::{FilmError, PixelRect, PixelSums, Sample};

/// Exact sums of one rectangle of pixels, filled by one thread, then merged into a film.
#[derive(Clone, Debug, PartialEq)]
pub struct FilmTile {
    rect: PixelRect,
    pixels: Vec<PixelSums>,
}

impl FilmTile {
    /// An empty tile.
    ///
    /// # Errors
    /// [`FilmError::TooLarge`].
    pub fn new(rect: PixelRect) -> Result<Self, FilmError> {
        Ok(Self { rect, pixels: pixels_for(rect)? })
    }

    /// Its pixels.
    #[must_use]
    pub fn rect(&self) -> PixelRect {
        self.rect
    }

    /// Sums of its pixels in row-major order.
    #[must_use]
    pub fn pixels(&self) -> &[PixelSums] {
        &self.pixels
    }

    /// Adds one sample to pixel `(x, y)` of the picture; on an error nothing is added.
    ///
    /// # Errors
    /// A pixel outside the tile, a bad sample, or sums that leave their range.
    pub fn add(&mut self, x: u32, y: u32, sample: &Sample) -> Result<(), FilmError> {
        let index =
            self.rect.index(x, y).ok_or(FilmError::OutsideTile { x, y, rect: self.rect })?;
        let sums =
            PixelSums::from_sample(sample).map_err(|fault| FilmError::BadSample { x, y, fault })?;
        let pixel = &mut self.pixels[index];
        *pixel = pixel.checked_add(&sums).ok_or(FilmError::Overflow { x, y })?;
        Ok(())
    }

    /// Forgets all samples, to be used again.
    pub fn clear(&mut self) {
        self.pixels.fill(PixelSums::default());
    }
}
