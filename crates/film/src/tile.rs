//! Parts of a film, each filled by one thread at a time.

use crate::film::pixels_for;
use crate::pixel::add_all;
use crate::{FilmError, IcePathLayout, IcePaths, PixelRect, PixelSums, Sample, ice_paths};

/// Exact sums of one rectangle of pixels, filled by one thread, then merged into a film.
#[derive(Clone, Debug, PartialEq)]
pub struct FilmTile {
    rect: PixelRect,
    pixels: Vec<PixelSums>,
    ice_paths: Option<IcePaths>,
}

impl FilmTile {
    /// An empty tile.
    ///
    /// # Errors
    /// [`FilmError::TooLarge`].
    pub fn new(rect: PixelRect) -> Result<Self, FilmError> {
        Ok(Self { rect, pixels: pixels_for(rect)?, ice_paths: None })
    }

    /// An empty tile that keeps ice paths.
    ///
    /// # Errors
    /// [`FilmError::TooLarge`].
    pub fn keeping_ice_paths(rect: PixelRect, layout: IcePathLayout) -> Result<Self, FilmError> {
        let pixels = pixels_for(rect)?;
        let ice_paths = Some(IcePaths::new(layout, pixels.len())?);
        Ok(Self { rect, pixels, ice_paths })
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

    /// Adds a sample's light to the ice paths of a pixel, where they are kept: as
    /// [`FilmTileMut::add_ice_path`].
    ///
    /// # Errors
    /// As there.
    pub fn add_ice_path(
        &mut self,
        x: u32,
        y: u32,
        length: f64,
        weights: &[[f32; 3]],
    ) -> Result<(), FilmError> {
        let rect = self.rect;
        let Some(ice) = &mut self.ice_paths else { return Ok(()) };
        let index = rect.index(x, y).ok_or(FilmError::OutsideTile { x, y, rect })?;
        let layout = ice.layout();
        let sums = &mut ice.sums_mut()[index * layout.sums()..][..layout.sums()];
        if layout.add(sums, length, weights) { Ok(()) } else { Err(FilmError::Overflow { x, y }) }
    }

    /// Forgets all samples, to be used again.
    pub fn clear(&mut self) {
        self.pixels.fill(PixelSums::default());
        if let Some(ice) = &mut self.ice_paths {
            ice.sums_mut().fill(0);
        }
    }
}

/// A rectangle of a film's own pixels: see [`crate::Film::tiles_mut`].
#[derive(Debug)]
pub struct FilmTileMut<'a> {
    rect: PixelRect,
    layout: Option<IcePathLayout>,
    /// Row by row; together all pixels of the rectangle.
    pub(crate) rows: Vec<&'a mut [PixelSums]>,
    /// Their ice paths, where those are kept.
    pub(crate) ice_rows: Vec<&'a mut [i64]>,
}

impl FilmTileMut<'_> {
    /// To be given its rows.
    pub(crate) fn without_rows(rect: PixelRect, layout: Option<IcePathLayout>) -> Self {
        let height = rect.height() as usize;
        let ice_rows = Vec::with_capacity(if layout.is_some() { height } else { 0 });
        Self { rect, layout, rows: Vec::with_capacity(height), ice_rows }
    }

    /// Its pixels.
    #[must_use]
    pub fn rect(&self) -> PixelRect {
        self.rect
    }

    /// An empty tile of the same pixels that keeps the same.
    ///
    /// # Errors
    /// [`FilmError::TooLarge`].
    pub fn empty_copy(&self) -> Result<FilmTile, FilmError> {
        match self.layout {
            None => FilmTile::new(self.rect),
            Some(layout) => FilmTile::keeping_ice_paths(self.rect, layout),
        }
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

    /// Adds a sample's light to the ice paths of pixel `(x, y)`, where they are kept: `weights`, for
    /// each spectrum of lights the light's radiance times the albedos met, has passed through `length`
    /// metres of ice.
    ///
    /// # Errors
    /// A pixel outside the tile; weights that are no numbers or leave the range of the sums.
    pub fn add_ice_path(
        &mut self,
        x: u32,
        y: u32,
        length: f64,
        weights: &[[f32; 3]],
    ) -> Result<(), FilmError> {
        let Some(layout) = self.layout else { return Ok(()) };
        if !self.rect.contains(x, y) {
            return Err(FilmError::OutsideTile { x, y, rect: self.rect });
        }
        let row = &mut self.ice_rows[(y - self.rect.y0) as usize];
        let sums = &mut row[(x - self.rect.x0) as usize * layout.sums()..][..layout.sums()];
        if layout.add(sums, length, weights) { Ok(()) } else { Err(FilmError::Overflow { x, y }) }
    }

    /// Adds the sums of a tile of the same pixels that keeps the same; on an error nothing is added.
    ///
    /// # Errors
    /// Sums that leave their range.
    ///
    /// # Panics
    /// If the other tile is of other pixels, or only one keeps ice paths.
    pub fn merge(&mut self, other: &FilmTile) -> Result<(), FilmError> {
        assert_eq!(self.rect, other.rect, "only tiles of the same pixels are merged");
        let ice = other.ice_paths.as_ref();
        assert_eq!(
            self.layout,
            ice.map(IcePaths::layout),
            "only tiles that keep the same are merged"
        );
        self.add_sums(&other.pixels, ice.map_or(&[][..], IcePaths::sums))
    }

    /// Adds row-major sums of its pixels; on an error nothing is added.
    pub(crate) fn add_sums(&mut self, pixels: &[PixelSums], ice: &[i64]) -> Result<(), FilmError> {
        let rect = self.rect;
        let overflow = |(row, column): (usize, usize)| FilmError::Overflow {
            x: rect.x0 + column as u32,
            y: rect.y0 + row as u32,
        };
        let width = rect.width().max(1) as usize;
        let stride = self.layout.map_or(0, IcePathLayout::sums);
        let added = ice.chunks((width * stride).max(1));
        let fits = |(row, added): (&&mut [i64], &[i64])| ice_paths::overflow(row, added);
        let failed = self.ice_rows.iter().zip(added.clone()).map(fits).enumerate();
        let failed = failed.filter_map(|(row, index)| Some((row, index? / stride))).next();
        failed.map_or(Ok(()), |place| Err(overflow(place)))?;
        add_rows(&mut self.rows, pixels.chunks(width)).map_err(overflow)?;
        for (row, added) in self.ice_rows.iter_mut().zip(added) {
            row.iter_mut().zip(added).for_each(|(sum, added)| *sum += added);
        }
        Ok(())
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
