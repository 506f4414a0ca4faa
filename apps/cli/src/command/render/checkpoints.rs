//! The film so far, saved every now and then while it is rendered.

use super::earlier::film_path;
use crate::arguments::RenderArguments;
use crate::failure::Failure;
use crate::progress::Progress;
use crate::signals::Interrupts;
use snowgrain_film::Film;
use snowgrain_formats::write_film;
use snowgrain_render::Rendering;
use std::path::Path;
use std::sync::mpsc::{Receiver, RecvTimeoutError, channel};
use std::time::{Duration, Instant};

/// Time between two checkpoints where nothing is said.
const EVERY: Duration = Duration::from_secs(600);

/// Where and how often the film so far is saved.
pub(super) struct Checkpoints<'a> {
    file: Option<&'a Path>,
    every: Duration,
}

impl<'a> Checkpoints<'a> {
    /// # Errors
    /// A time between checkpoints without a film to save.
    pub(super) fn new(arguments: &'a RenderArguments) -> Result<Self, Failure> {
        let file = film_path(arguments);
        if file.is_none() && arguments.checkpoint_every.is_some() {
            let mend = "--checkpoint-every saves a film; name one by -o FILE.film";
            return Err(Failure::usage(mend));
        }
        Ok(Self { file, every: arguments.checkpoint_every.unwrap_or(EVERY) })
    }

    /// Does `work` and meanwhile saves what is complete of `rendering`, together with the film of an earlier
    /// run, on a thread of its own.
    pub(super) fn during<T>(
        &self,
        (rendering, earlier): (&Rendering, Option<&Film>),
        interrupts: &Interrupts,
        progress: &Progress,
        work: impl FnOnce() -> T,
    ) -> T {
        let Some(file) = self.file else { return work() };
        std::thread::scope(|scope| {
            let (working, ended) = channel::<()>();
            scope.spawn(move || {
                let save = || save(file, rendering, earlier);
                self.keep_saving(&ended, interrupts, progress, save);
            });
            let result = work();
            drop(working);
            result
        })
    }

    /// Saves until the work has ended or a signal came, after which the film is written anyway.
    fn keep_saving(
        &self,
        ended: &Receiver<()>,
        interrupts: &Interrupts,
        progress: &Progress,
        save: impl Fn() -> Result<bool, Failure>,
    ) {
        let mut wait = self.every;
        while ended.recv_timeout(wait) == Err(RecvTimeoutError::Timeout) {
            if interrupts.exit_code().is_some() {
                return;
            }
            let began = Instant::now();
            match interrupts.while_writing(&save) {
                Ok(true) => progress
                    .detail(&format!("checkpoint saved in {:.2} s", began.elapsed().as_secs_f64())),
                Ok(false) => {}
                // There may be room again next time.
                Err(failure) => progress.note(&format!("no checkpoint: {}", failure.message)),
            }
            wait = self.every.saturating_sub(began.elapsed()).max(Duration::from_millis(1));
        }
    }
}

/// Saves the film so far; false where there is nothing new yet.
fn save(file: &Path, rendering: &Rendering, earlier: Option<&Film>) -> Result<bool, Failure> {
    let Some(mut film) = rendering.snapshot()? else { return Ok(false) };
    if let Some(earlier) = earlier {
        film.merge(earlier)?;
    }
    write_film(file, &film)?;
    Ok(true)
}
