//! Parts of a film, each filled by one thread at a time.

use crate::film::pixels_for;
use crate::pixel::add_all;
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
    #[inline]
    pub fn add(&mut self, x: u32, y: u32, sample: &Sample) -> Result<(), FilmError> {
        let index =
            self.rect.index(x, y).ok_or(FilmError::OutsideTile { x, y, rect: self.rect })?;
        self.pixels[index].add_sample(sample).map_err(|refusal| refusal.of(x, y))
    }

    /// Forgets all samples, to be used again.
    pub fn clear(&mut self) {
        self.pixels.fill(PixelSums::default());
    }
}

/// A rectangle of a film's own pixels: see [`crate::Film::tiles_mut`].
#[derive(Debug)]
pub struct FilmTileMut<'a> {
    rect: PixelRect,
    /// Row by row; together all pixels of the rectangle.
    pub(crate) rows: Vec<&'a mut [PixelSums]>,
}

impl FilmTileMut<'_> {
    /// To be given its rows.
    pub(crate) fn without_rows(rect: PixelRect) -> Self {
        Self { rect, rows: Vec::with_capacity(rect.height() as usize) }
    }

    /// Its pixels.
    #[must_use]
    pub fn rect(&self) -> PixelRect {
        self.rect
    }

    /// The sums of pixel `(x, y)` of the picture; `None` outside the tile.
    #[must_use]
    pub fn pixel(&self, x: u32, y: u32) -> Option<&PixelSums> {
        self.rect
            .contains(x, y)
            .then(|| &self.rows[(y - self.rect.y0) as usize][(x - self.rect.x0) as usize])
    }

    /// Adds one sample to pixel `(x, y)` of the picture; on an error nothing is added.
    ///
    /// # Errors
    /// A pixel outside the tile, a bad sample, or sums that leave their range.
    #[inline]
    pub fn add(&mut self, x: u32, y: u32, sample: &Sample) -> Result<(), FilmError> {
        if !self.rect.contains(x, y) {
            return Err(FilmError::OutsideTile { x, y, rect: self.rect });
        }
        let pixel = &mut self.rows[(y - self.rect.y0) as usize][(x - self.rect.x0) as usize];
        pixel.add_sample(sample).map_err(|refusal| refusal.of(x, y))
    }

    /// Adds the sums of a tile of the same pixels; on an error nothing is added.
    ///
    /// # Errors
    /// Sums that leave their range.
    ///
    /// # Panics
    /// If the other tile is of other pixels.
    pub fn merge(&mut self, other: &FilmTile) -> Result<(), FilmError> {
        assert_eq!(self.rect, other.rect, "only tiles of the same pixels are merged");
        let width = self.rect.width().max(1) as usize;
        add_rows(&mut self.rows, other.pixels.chunks(width)).map_err(|(row, column)| {
            FilmError::Overflow { x: self.rect.x0 + column as u32, y: self.rect.y0 + row as u32 }
        })
    }
}

/// Adds rows of sums to others, or nothing where one does not fit; then says at which row and column.
pub(crate) fn add_rows<'a>(
    rows: &mut [impl AsMut<[PixelSums]>],
    added: impl Iterator<Item = &'a [PixelSums]> + Clone,
) -> Result<(), (usize, usize)> {
    let failed = rows
        .iter_mut()
        .zip(added.clone())
        .map(|(row, added)| add_all(row.as_mut(), added))
        .enumerate()
        .find_map(|(row, result)| result.err().map(|column| (row, column)));
    let Some((row, column)) = failed else { return Ok(()) };
    for (row, added) in rows.iter_mut().zip(added).take(row) {
        row.as_mut().iter_mut().zip(added).for_each(|(sum, added)| sum.withdraw(added));
    }
    Err((row, column))
}
