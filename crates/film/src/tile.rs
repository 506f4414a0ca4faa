//! The part of a film that one thread fills.

use crate::film::pixels_for;
use crate::pixel::add_all;
use crate::{FilmError, PixelRect, PixelSums, Refusal, Sample};

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
    #[inline]
    pub fn add(&mut self, x: u32, y: u32, sample: &Sample) -> Result<(), FilmError> {
        let index =
            self.rect.index(x, y).ok_or(FilmError::OutsideTile { x, y, rect: self.rect })?;
        self.pixels[index].add_sample(sample).map_err(|refusal| match refusal {
            Refusal::Sample(fault) => FilmError::BadSample { x, y, fault },
            Refusal::Overflow => FilmError::Overflow { x, y },
        })
    }

    /// Adds the sums of another tile of the same pixels; on an error nothing is added.
    ///
    /// # Errors
    /// Sums that leave their range.
    ///
    /// # Panics
    /// If the other tile is of other pixels.
    pub fn merge(&mut self, other: &Self) -> Result<(), FilmError> {
        assert_eq!(self.rect, other.rect, "only tiles of the same pixels are merged");
        add_all(&mut self.pixels, &other.pixels).map_err(|index| {
            let (x, y) = self.rect.pixel(index);
            FilmError::Overflow { x, y }
        })
    }

    /// Forgets all samples, to be used again.
    pub fn clear(&mut self) {
        self.pixels.fill(PixelSums::default());
    }
}
