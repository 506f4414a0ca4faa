//! The film that an earlier run of the same render left.

use crate::arguments::{PictureFormat, RenderArguments};
use crate::failure::Failure;
use snowgrain_film::{BlockCounts, Film, PixelRect};
use snowgrain_formats::read_film;
use snowgrain_render::description::SceneDescription;
use snowgrain_render::recipe;
use std::ops::Range;
use std::path::Path;

/// The file that holds the exact sums: the first that was named, which is also the checkpoint.
pub(super) fn film_path(arguments: &RenderArguments) -> Option<&Path> {
    let mut films = arguments.output.iter().filter(|file| file.format == PictureFormat::Film);
    films.next().map(|file| file.path.as_path())
}

/// What is asked for, as far as it is known before anything is made.
pub(super) struct Request {
    recipe: [u8; 32],
    size: [u32; 2],
    crop: PixelRect,
    /// Where each block has as many samples as it needs, for which relative error.
    noise_target: Option<f64>,
    samples: Range<u64>,
}

impl Request {
    pub(super) fn new(
        arguments: &RenderArguments,
        scene: &SceneDescription,
        crop: PixelRect,
        samples: Range<u64>,
    ) -> Self {
        Self {
            recipe: recipe(scene),
            size: [scene.film.width, scene.film.height],
            crop,
            noise_target: arguments.noise_target,
            samples,
        }
    }

    /// The film that is already there of the same request, to be finished (or finished already).
    ///
    /// # Errors
    /// An unfinished film of this request, unless it is to be resumed; with `--resume` a film of another one,
    /// and one that cannot be read.
    pub(super) fn earlier_film(
        &self,
        arguments: &RenderArguments,
    ) -> Result<Option<Film>, Failure> {
        let Some(path) = film_path(arguments) else {
            return if arguments.resume {
                Err(Failure::usage("--resume goes on with a film; name one by -o FILE.film"))
            } else {
                Ok(None)
            };
        };
        if !path.exists() {
            return Ok(None);
        }
        let film = match read_film(path) {
            Ok(film) => film,
            Err(error) if arguments.resume => return Err(error.into()),
            // It is replaced, whatever it is.
            Err(_) => return Ok(None),
        };
        let name = path.display().to_string();
        match self.difference(&film) {
            Some(difference) if arguments.resume => Err(Failure::bad_input(format!(
                "this cannot be resumed: {difference}; render to another file, or remove this one"
            ))
            .of(&name)),
            Some(_) => Ok(None),
            None if !arguments.resume && is_all_that_blocks_want(&film) => Ok(None),
            None if arguments.resume || self.is_finished(&film) => Ok(Some(film)),
            None => Err(Failure::usage(format!(
                "there is an unfinished film of this render (samples {} of {}..{}); --resume goes on with \
                 it, or remove it",
                film.samples(),
                self.samples.start,
                self.samples.end
            ))
            .of(&name)),
        }
    }

    /// Refuses a film whose blocks were to have other counts of samples than those that were found.
    ///
    /// # Errors
    /// Other counts.
    pub(super) fn check_counts(film: &Film, counts: Option<&BlockCounts>) -> Result<(), Failure> {
        if film.block_counts() == counts {
            return Ok(());
        }
        let what = "this cannot be resumed: its blocks were to have other numbers of samples (another --spp)";
        Err(Failure::bad_input(what))
    }

    /// Whether nothing is missing, as far as that is known before blocks are counted.
    pub(super) fn is_finished(&self, film: &Film) -> bool {
        self.noise_target.is_none() && film.samples().missing_from(self.samples.clone()).is_empty()
    }

    /// In what a film is not of this request.
    fn difference(&self, film: &Film) -> Option<String> {
        let size = [film.width(), film.height()];
        if size != self.size {
            let [[w, h], [x, y]] = [size, self.size];
            return Some(format!("its picture has {w}x{h} pixels, not {x}x{y}"));
        }
        if film.crop() != self.crop {
            return Some(format!("its crop is {}, not {}", film.crop(), self.crop));
        }
        if film.recipe != Some(self.recipe) {
            return Some(
                "it is of another scene or seed, or of another version of Snowgrain".into(),
            );
        }
        let target = film.block_counts().map(BlockCounts::relative_error);
        if target != self.noise_target {
            let said = |target: Option<f64>| target.map_or("none".into(), |x| x.to_string());
            let (theirs, ours) = (said(target), said(self.noise_target));
            return Some(format!("its noise target is {theirs}, not {ours}"));
        }
        let held = film.samples().as_slice();
        let outside =
            held.iter().find(|held| held.start < self.samples.start || held.end > self.samples.end);
        outside.map(|held| {
            let Range { start, end } = self.samples;
            format!("it holds samples {}..{}, outside {start}..{end}", held.start, held.end)
        })
    }
}

/// Whether each block of a film with a noise target has its samples: such a film is rendered again, as only a pilot
/// tells how many are wanted.
fn is_all_that_blocks_want(film: &Film) -> bool {
    film.block_counts().is_some_and(|counts| {
        film.samples().missing_from(0..u64::from(counts.greatest())).is_empty()
    })
}
