//! The film that an earlier run of the same render left.

use crate::arguments::{PictureFormat, RenderArguments};
use crate::failure::Failure;
use crate::progress::Progress;
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

    /// The film that is already there of the same request, to be finished (or finished already). A film that will be
    /// replaced is told of.
    ///
    /// # Errors
    /// A film of this render that is not finished, unless it is to be resumed, or that holds other samples, too; with
    /// `--resume` a film of another render, and one that cannot be read.
    pub(super) fn earlier_film(
        &self,
        arguments: &RenderArguments,
        progress: &Progress,
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
        let name = path.display().to_string();
        let film = match read_film(path) {
            Ok(film) => film,
            Err(error) if arguments.resume => return Err(error.into()),
            Err(_) => {
                progress.note(&format!(
                    "{name}: this is not a film that can be read; it will be replaced"
                ));
                return Ok(None);
            }
        };
        if let Some(difference) = self.difference(&film) {
            if arguments.resume {
                return Err(Failure::bad_input(format!(
                    "this cannot be resumed: {difference}; render to another file, or remove this one"
                ))
                .of(&name));
            }
            let held = film.samples();
            progress.note(&format!(
                "{name}: the film that is there (samples {held}) will be replaced: {difference}"
            ));
            return Ok(None);
        }
        self.check_samples(&film, arguments.resume).map_err(|failure| failure.of(&name))?;
        Ok(Some(film))
    }

    /// Refuses a film of this render whose samples would be lost, or that is to be resumed although nobody said so.
    fn check_samples(&self, film: &Film, resume: bool) -> Result<(), Failure> {
        if self.is_finished(film) {
            return Ok(());
        }
        let (held, Range { start, end }) = (film.samples(), self.samples.clone());
        if let Some(outside) = self.outside(film) {
            return Err(if resume {
                let Range { start: first, end: last } = outside;
                Failure::bad_input(format!(
                    "this cannot be resumed: it holds samples {first}..{last}, outside {start}..{end}; render to \
                     another file, or remove this one"
                ))
            } else {
                Failure::usage(format!(
                    "there is a film of this render with samples {held}, of which {start}..{end} would not keep all; \
                     render to another file (merge adds films), or remove this one"
                ))
            });
        }
        if resume || is_all_that_blocks_want(film) {
            return Ok(());
        }
        Err(Failure::usage(format!(
            "there is an unfinished film of this render (samples {held} of {start}..{end}); --resume goes on with it, \
             or remove it"
        )))
    }

    /// Refuses a film whose blocks were to have other counts of samples than those that were found.
    ///
    /// # Errors
    /// Other counts.
    pub(super) fn check_counts(film: &Film, counts: Option<&BlockCounts>) -> Result<(), Failure> {
        if film.block_counts() == counts {
            return Ok(());
        }
        let what = "the film that is there cannot be resumed: its blocks were to have other numbers of samples \
                    (another --spp); render to another file, or remove it";
        Err(Failure::bad_input(what))
    }

    /// Whether nothing is missing, as far as that is known before blocks are counted.
    pub(super) fn is_finished(&self, film: &Film) -> bool {
        self.noise_target.is_none() && film.samples().missing_from(self.samples.clone()).is_empty()
    }

    /// What is said of a finished film.
    pub(super) fn told_of_finished(&self, film: &Film, arguments: &RenderArguments) -> String {
        let name = film_path(arguments).unwrap_or(Path::new("")).display();
        match self.outside(film) {
            Some(_) => format!(
                "{name}: the film holds all samples that are asked for, and more ({}), which pictures show, too; \
                 nothing is traced",
                film.samples()
            ),
            None => format!("{name}: the film is finished already; nothing is traced"),
        }
    }

    /// In what a film is not of this render.
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
        None
    }

    /// The first samples of a film that are not asked for.
    fn outside(&self, film: &Film) -> Option<Range<u64>> {
        let Range { start, end } = self.samples;
        let mut held = film.samples().as_slice().iter();
        held.find(|held| held.start < start || held.end > end).cloned()
    }
}

/// Whether each block of a film with a noise target has its samples. Whether those are all that are wanted a pilot tells.
fn is_all_that_blocks_want(film: &Film) -> bool {
    film.block_counts().is_some_and(|counts| {
        film.samples().missing_from(0..u64::from(counts.greatest())).is_empty()
    })
}
