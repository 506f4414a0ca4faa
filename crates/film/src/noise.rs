//! How noisy a film is, block by block, and how many samples each block is to have.
//!
//! Blocks are squares of [`BlockCounts::SIDE`] pixels, aligned with the picture, so that a crop has the
//! blocks of the whole picture (cut at its edges).
//!
//! The relative error of a block is the root mean square of the standard errors of its pixels, over all
//! its pixels and the three colours, divided by the mean of all these values and [`FLOOR`]. Standard
//! errors are the roots of [`crate::PixelSums::variance_of_mean`].

use crate::{Film, FilmError, PixelRect};

/// What is added to the mean of a block, so that the dark does not ask for endless samples: a hundredth
/// of the white of a picture that is shown without exposure.
pub const FLOOR: f64 = 0.01;

/// How noisy a block is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BlockNoise {
    /// Its pixels, of those that the film holds.
    pub rect: PixelRect,
    /// Variance of the means of its pixels, averaged over pixels and colours; infinite where a pixel
    /// has fewer than two samples.
    pub variance: f64,
    /// Radiance, averaged over pixels and colours.
    pub mean: f64,
}

impl BlockNoise {
    /// The relative error of the block.
    #[must_use]
    pub fn relative_error(&self) -> f64 {
        self.variance.sqrt() / (self.mean.max(0.0) + FLOOR)
    }
}

impl Film {
    /// How noisy each block is, in the order of [`PixelRect::tiles`].
    pub fn block_noise(&self) -> impl Iterator<Item = BlockNoise> + '_ {
        self.crop().tiles(BlockCounts::SIDE).map(|rect| {
            let (mut variance, mut mean) = (0.0, 0.0);
            for index in 0..rect.area() as usize {
                let (x, y) = rect.pixel(index);
                let Some(at) = self.crop().index(x, y) else { continue };
                let sums = &self.pixels()[at];
                variance += sums.variance_of_mean().iter().sum::<f64>();
                mean += sums.mean_radiance().iter().sum::<f64>();
            }
            let values = 3.0 * rect.area() as f64;
            BlockNoise { rect, variance: variance / values, mean: mean / values }
        })
    }
}

/// How many samples the pixels of each block are to have at most: a pixel of a film with counts holds
/// of the film's samples those whose index is below the count of its block.
#[derive(Clone, Debug, PartialEq)]
pub struct BlockCounts {
    crop: PixelRect,
    relative_error: f64,
    counts: Vec<u32>,
}

impl BlockCounts {
    /// Pixels along an edge of a block.
    pub const SIDE: u32 = 16;

    /// Counts of the blocks of `crop` in the order of [`PixelRect::tiles`], chosen for this relative
    /// error.
    ///
    /// # Errors
    /// Not one count per block, a count of 0, or an error that is not above 0 and finite.
    pub fn new(crop: PixelRect, relative_error: f64, counts: Vec<u32>) -> Result<Self, FilmError> {
        let blocks = Self::blocks(crop);
        let chosen = relative_error > 0.0 && relative_error.is_finite();
        if counts.len() as u64 != blocks || counts.contains(&0) || !chosen {
            return Err(FilmError::BadBlockCounts { counts: counts.len(), blocks, relative_error });
        }
        Ok(Self { crop, relative_error, counts })
    }

    /// Number of blocks of a crop.
    #[must_use]
    pub fn blocks(crop: PixelRect) -> u64 {
        let along = |start: u32, end: u32| {
            u64::from(end.max(start).div_ceil(Self::SIDE)) - u64::from(start / Self::SIDE)
        };
        if crop.is_empty() { 0 } else { along(crop.x0, crop.x1) * along(crop.y0, crop.y1) }
    }

    /// The pixels whose blocks have counts.
    #[must_use]
    pub fn crop(&self) -> PixelRect {
        self.crop
    }

    /// The relative error that the counts were chosen for.
    #[must_use]
    pub fn relative_error(&self) -> f64 {
        self.relative_error
    }

    /// The counts in the order of [`PixelRect::tiles`].
    #[must_use]
    pub fn counts(&self) -> &[u32] {
        &self.counts
    }

    /// The greatest count.
    #[must_use]
    pub fn greatest(&self) -> u32 {
        self.counts.iter().copied().max().unwrap_or(0)
    }

    /// Samples of all pixels together.
    #[must_use]
    pub fn total(&self) -> u64 {
        let areas = self.crop.tiles(Self::SIDE).map(|rect| rect.area());
        areas.zip(&self.counts).map(|(area, &count)| area.saturating_mul(count.into())).sum()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{FilmIdentity, FilmTile, Sample};

    #[test]
    fn the_relative_error_is_that_of_the_definition() {
        let crop = PixelRect::new(15, 0, 17, 1);
        let identity = FilmIdentity { scene_hash: [0; 32], seed: 0 };
        let mut film = Film::new(32, 16, crop, identity).unwrap();
        let mut tile = FilmTile::new(crop).unwrap();
        for radiance in [[0.0, 1.0, 2.0], [2.0, 1.0, 0.0]] {
            tile.add(15, 0, &Sample { radiance, ..Sample::default() }).unwrap();
        }
        film.merge_tile(&tile).unwrap();
        let blocks: Vec<_> = film.block_noise().collect();
        assert_eq!(blocks.len(), 2);
        assert_eq!(blocks[0].rect, PixelRect::new(15, 0, 16, 1));
        // Variances of the means are 1, 0 and 1.
        assert_eq!((blocks[0].variance, blocks[0].mean), (2.0 / 3.0, 1.0));
        assert_eq!(blocks[0].relative_error(), (2.0f64 / 3.0).sqrt() / 1.01);
        assert_eq!(blocks[1].relative_error(), f64::INFINITY, "nothing is known there");
    }

    #[test]
    fn counts_belong_to_the_blocks_of_the_picture() {
        let crop = PixelRect::new(15, 3, 33, 17);
        assert_eq!(BlockCounts::blocks(crop), 6);
        assert_eq!(crop.tiles(BlockCounts::SIDE).count(), 6);
        let counts = BlockCounts::new(crop, 0.1, vec![1, 2, 3, 4, 5, 6]).unwrap();
        assert_eq!(counts.greatest(), 6);
        assert_eq!(counts.total(), 13 + 2 * 13 * 16 + 3 * 13 + 4 + 5 * 16 + 6);
        for (error, bad) in [(0.1, vec![1; 5]), (0.1, vec![1, 1, 0, 1, 1, 1]), (0.0, vec![1; 6])] {
            assert!(BlockCounts::new(crop, error, bad).is_err());
        }
    }
}
