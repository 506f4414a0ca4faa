//! A film of what is complete, taken while the render goes on.

use super::{Rendering, TILE, empty_film};
use crate::RenderError;
use snowgrain_film::Film;
use std::sync::atomic::Ordering;

impl Rendering<'_> {
    /// The film of all passes that are complete, as a stop at this moment would leave it; `None` before the
    /// first is. For one thread at a time.
    ///
    /// # Errors
    /// More than memory; sums that leave their range.
    pub fn snapshot(&self) -> Result<Option<Film>, RenderError> {
        self.holds_settling.store(true, Ordering::SeqCst);
        let film = self.snapshot_while_held();
        self.holds_settling.store(false, Ordering::SeqCst);
        film
    }

    fn snapshot_while_held(&self) -> Result<Option<Film>, RenderError> {
        // Who held a tile may not have seen that settling is held; who comes to one from now on does. So no
        // tile is settled beyond the passes that are complete after this.
        self.tiles.iter().for_each(|tile| drop(tile.lock()));
        let (complete, samples) = self.passes.complete_with_samples();
        if complete == 0 || samples.is_empty() {
            return Ok(None);
        }
        let mut film = empty_film(self.scene, self.settings.crop, self.counts.clone())?;
        for (shared, copy) in self.tiles.iter().zip(&mut film.tiles_mut(TILE)) {
            let mut sums = shared.lock();
            sums.settle(complete)?;
            copy.copy_from(sums.base());
        }
        film.record_samples(samples)?;
        Ok(Some(film))
    }
}
