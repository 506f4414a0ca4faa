//! The film: exact sums of every pixel, and what they are sums of.

use crate::tile::add_rows;
use crate::{FilmError, FilmTile, FilmTileMut, PixelRect, PixelSums, SampleRanges};
use std::ops::Range;

/// What decides the samples of a film, together with their indices.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct FilmIdentity {
    /// Hash of the resolved scene.
    pub scene_hash: [u8; 32],
    /// Seed of the sampler.
    pub seed: u64,
}

/// Exact sums over the samples of a picture; 208 bytes per pixel of the crop.
///
/// Films of the same picture and of different samples merge in any order to the same bytes.
#[derive(Clone, Debug, PartialEq)]
pub struct Film {
    width: u32,
    height: u32,
    crop: PixelRect,
    identity: FilmIdentity,
    samples: SampleRanges,
    pixels: Vec<PixelSums>,
}

impl Film {
    /// An empty film of a picture of `width` x `height` pixels, of which only `crop` is kept.
    ///
    /// # Errors
    /// A crop that is empty or leaves the picture; more pixels than memory.
    pub fn new(
        width: u32,
        height: u32,
        crop: PixelRect,
        identity: FilmIdentity,
    ) -> Result<Self, FilmError> {
        if crop.is_empty() || !PixelRect::new(0, 0, width, height).encloses(&crop) {
            return Err(FilmError::BadCrop { crop, width, height });
        }
        let pixels = pixels_for(crop)?;
        Ok(Self { width, height, crop, identity, samples: SampleRanges::default(), pixels })
    }

    /// Pixels across of the whole picture.
    #[must_use]
    pub fn width(&self) -> u32 {
        self.width
    }

    /// Pixels down of the whole picture.
    #[must_use]
    pub fn height(&self) -> u32 {
        self.height
    }

    /// The pixels that are kept.
    #[must_use]
    pub fn crop(&self) -> PixelRect {
        self.crop
    }

    /// What decides its samples.
    #[must_use]
    pub fn identity(&self) -> FilmIdentity {
        self.identity
    }

    /// The samples that every pixel has.
    #[must_use]
    pub fn samples(&self) -> &SampleRanges {
        &self.samples
    }

    /// Sums of the pixels of the crop in row-major order.
    #[must_use]
    pub fn pixels(&self) -> &[PixelSums] {
        &self.pixels
    }

    /// The same, to be filled by a reader of film files.
    pub fn pixels_mut(&mut self) -> &mut [PixelSums] {
        &mut self.pixels
    }

    /// Adds the sums of a tile; on an error nothing is added.
    ///
    /// # Errors
    /// A tile that leaves the crop; sums that leave their range.
    pub fn merge_tile(&mut self, tile: &FilmTile) -> Result<(), FilmError> {
        let rect = tile.rect();
        if rect.is_empty() {
            return Ok(());
        }
        if !self.crop.encloses(&rect) {
            return Err(FilmError::TileOutsideFilm { tile: rect, crop: self.crop });
        }
        self.add_pixels(rect, tile.pixels())
    }

    /// Notes that every pixel now holds these samples: to be called when all tiles of a pass over
    /// the crop are merged. Samples in the pixels that are not noted make a film that cannot be
    /// continued without counting them twice.
    ///
    /// # Errors
    /// An empty range, or samples that were noted already.
    pub fn record_samples(&mut self, range: Range<u64>) -> Result<(), FilmError> {
        self.samples.insert(range)
    }

    /// Adds the samples of another film of the same picture; on an error nothing is added.
    ///
    /// # Errors
    /// Films of different size, crop, scene or seed; samples that are in both; sums that leave
    /// their range.
    pub fn merge(&mut self, other: &Self) -> Result<(), FilmError> {
        self.check_same_picture(other)?;
        let mut samples = self.samples.clone();
        samples.insert_all(&other.samples)?;
        self.add_pixels(other.crop, &other.pixels)?;
        self.samples = samples;
        Ok(())
    }

    fn check_same_picture(&self, other: &Self) -> Result<(), FilmError> {
        let differ = |what, ours: String, theirs: String| {
            if ours == theirs { Ok(()) } else { Err(FilmError::FilmsDiffer { what, ours, theirs }) }
        };
        let size = |film: &Self| format!("{}x{}", film.width, film.height);
        differ("size", size(self), size(other))?;
        differ("crop", self.crop.to_string(), other.crop.to_string())?;
        let hash = |film: &Self| hexadecimal(&film.identity.scene_hash);
        differ("scene", hash(self), hash(other))?;
        differ("seed", self.identity.seed.to_string(), other.identity.seed.to_string())
    }

    /// The pixels of the crop as tiles of at most `side` x `side`, as [`PixelRect::tiles`] orders them,
    /// to be filled by several threads in place.
    pub fn tiles_mut(&mut self, side: u32) -> Vec<FilmTileMut<'_>> {
        let side = side.max(1);
        let mut tiles: Vec<_> = self.crop.tiles(side).map(FilmTileMut::without_rows).collect();
        let width = self.crop.width() as usize;
        let across = width.div_ceil(side as usize);
        for (row, pixels) in self.pixels.chunks_mut(width).enumerate() {
            let first = row / side as usize * across;
            let pieces = pixels.chunks_mut(side as usize);
            tiles[first..].iter_mut().zip(pieces).for_each(|(tile, piece)| tile.rows.push(piece));
        }
        tiles
    }

    /// Adds row-major sums of `rect`, which lies inside the crop; on an error nothing is added.
    fn add_pixels(&mut self, rect: PixelRect, sums: &[PixelSums]) -> Result<(), FilmError> {
        let width = self.crop.width() as usize;
        let columns = (rect.x0 - self.crop.x0) as usize..(rect.x1 - self.crop.x0) as usize;
        let rows = self.pixels.chunks_mut(width).skip((rect.y0 - self.crop.y0) as usize);
        let mut rows: Vec<_> =
            rows.take(rect.height() as usize).map(|row| &mut row[columns.clone()]).collect();
        add_rows(&mut rows, sums.chunks(columns.len().max(1))).map_err(|(row, column)| {
            FilmError::Overflow { x: rect.x0 + column as u32, y: rect.y0 + row as u32 }
        })
    }
}

/// Empty sums for every pixel of `rect`.
pub(crate) fn pixels_for(rect: PixelRect) -> Result<Vec<PixelSums>, FilmError> {
    let too_large = || FilmError::TooLarge {
        pixels: rect.area(),
        bytes: u128::from(rect.area()) * size_of::<PixelSums>() as u128,
    };
    let count = usize::try_from(rect.area()).map_err(|_| too_large())?;
    let mut pixels = Vec::new();
    pixels.try_reserve_exact(count).map_err(|_| too_large())?;
    pixels.resize(count, PixelSums::default());
    Ok(pixels)
}

fn hexadecimal(bytes: &[u8]) -> String {
    bytes.iter().map(|byte| format!("{byte:02x}")).collect()
}
