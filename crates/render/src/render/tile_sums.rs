//! The sums of one tile while it is rendered.
//!
//! A stopped render keeps the passes that are complete over the whole picture, so what belongs to
//! later ones stays apart until they are. Sums are moved together when the tile is next touched.

use super::batch::Batch;
use super::caught::Caught;
use crate::statistics::Statistics;
use snowgrain_film::{FilmError, FilmTile, FilmTileMut, PixelRect, PixelSums};

/// Pixels of the first pass that come first have columns and rows, from the tile's corner, that are
/// multiples of this.
pub(super) const COARSE: u32 = 4;

/// The sums of one tile.
pub(super) struct TileSums<'a> {
    /// Of the first pass and of all that were complete when the tile was last touched: in the film.
    base: FilmTileMut<'a>,
    statistics: Statistics,
    /// Of later passes.
    ahead: Vec<Ahead>,
    /// Memory for the next of them.
    spare: Option<FilmTile>,
}

/// Sums of a pass that was not complete.
struct Ahead {
    pass: u64,
    film: FilmTile,
    statistics: Statistics,
}

impl<'a> TileSums<'a> {
    pub(super) fn new(base: FilmTileMut<'a>) -> Self {
        Self { base, statistics: Statistics::default(), ahead: Vec::new(), spare: None }
    }

    pub(super) fn rect(&self) -> PixelRect {
        self.base.rect()
    }

    /// Adds samples of pass number `pass`; `complete` passes are complete.
    ///
    /// # Errors
    /// A sample that the film cannot hold; no memory.
    pub(super) fn add(&mut self, pass: u64, batch: &Batch, complete: u64) -> Result<(), FilmError> {
        self.settle(complete)?;
        let mut ice_paths = batch.ice_paths();
        let mut caught = batch.caught.iter();
        let mut learnt = batch.learnt.iter();
        if pass == 0 {
            self.statistics.add(&batch.statistics);
            let film = &mut self.base;
            batch.samples().try_for_each(|((x, y), sample, layers)| {
                film.add(x, y, sample)?;
                film.add_light_layers(x, y, sample.radiance, layers)
            })?;
            caught.try_for_each(|&Caught { pixel: (x, y), lit, unoccluded, .. }| {
                film.add_caught_light(x, y, lit, unoccluded)
            })?;
            learnt.try_for_each(|&((x, y), light, error)| {
                film.add_learnt_light(x, y, light, error)
            })?;
            return ice_paths.try_for_each(|((x, y), length, weights)| {
                film.add_ice_path(x, y, length, weights)
            });
        }
        let ahead = self.ahead_of(pass)?;
        ahead.statistics.add(&batch.statistics);
        let film = &mut ahead.film;
        batch.samples().try_for_each(|((x, y), sample, layers)| {
            film.add(x, y, sample)?;
            film.add_light_layers(x, y, sample.radiance, layers)
        })?;
        caught.try_for_each(|&Caught { pixel: (x, y), lit, unoccluded, .. }| {
            film.add_caught_light(x, y, lit, unoccluded)
        })?;
        learnt.try_for_each(|&((x, y), light, error)| film.add_learnt_light(x, y, light, error))?;
        ice_paths.try_for_each(|((x, y), length, weights)| film.add_ice_path(x, y, length, weights))
    }

    fn ahead_of(&mut self, pass: u64) -> Result<&mut Ahead, FilmError> {
        let at = match self.ahead.iter().position(|ahead| ahead.pass == pass) {
            Some(at) => at,
            None => {
                let film = self.spare.take().map_or_else(|| self.base.empty_copy(), Ok)?;
                self.ahead.push(Ahead { pass, film, statistics: Statistics::default() });
                self.ahead.len() - 1
            }
        };
        Ok(&mut self.ahead[at])
    }

    /// Moves what belongs to the first `complete` passes to the film.
    ///
    /// # Errors
    /// Sums that leave their range.
    pub(super) fn settle(&mut self, complete: u64) -> Result<(), FilmError> {
        while let Some(at) = self.ahead.iter().position(|ahead| ahead.pass < complete) {
            let mut settled = self.ahead.swap_remove(at);
            self.base.merge(&settled.film)?;
            self.statistics.add(&settled.statistics);
            settled.film.clear();
            self.spare = Some(settled.film);
        }
        Ok(())
    }

    /// The sums of the passes that are settled.
    pub(super) fn base(&self) -> &FilmTileMut<'a> {
        &self.base
    }

    /// Counts of the paths that are in the film.
    pub(super) fn statistics(&self) -> &Statistics {
        &self.statistics
    }

    /// Mean radiance of all samples of a pixel and those `before`, else of its neighbour that is rendered first;
    /// `None` where that has no sample either.
    pub(super) fn colour(&self, x: u32, y: u32, before: Option<&PixelSums>) -> Option<[f32; 3]> {
        let corner = self.rect();
        let first = |at: u32, corner: u32| at - (at - corner) % COARSE;
        let neighbour = || self.pixel(first(x, corner.x0), first(y, corner.y0));
        let sums = match before.filter(|before| before.samples() > 0) {
            Some(before) => {
                let mut sums = *before;
                if let Some(new) = self.pixel(x, y) {
                    // What leaves the range is told when it is merged.
                    sums.add_sums(&new);
                }
                sums
            }
            None => self.pixel(x, y).or_else(neighbour)?,
        };
        Some(sums.mean_radiance().map(|mean| mean as f32))
    }

    /// The sums of all samples of a pixel that has some.
    fn pixel(&self, x: u32, y: u32) -> Option<PixelSums> {
        let mut sums = *self.base.pixel(x, y)?;
        let index = self.rect().index(x, y)?;
        for ahead in &self.ahead {
            // What leaves the range is told when it is settled.
            sums.add_sums(&ahead.film.pixels()[index]);
        }
        (sums.samples() > 0).then_some(sums)
    }
}
