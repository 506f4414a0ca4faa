//! The files that a picture goes to, and the viewer that is shown it.

use crate::arguments::{Bits, DisplayArguments, PictureFile, PictureFormat};
use crate::failure::Failure;
use crate::progress::Progress;
use crate::signals::Interrupts;
use crate::viewer::Viewer;
use snowgrain_film::develop::{self, Development, Exposure};
use snowgrain_film::{Film, Picture};
use snowgrain_formats::{atomic, image, write_film};
use snowgrain_render::Rendering;
use std::path::Path;
use std::sync::mpsc::{Receiver, RecvTimeoutError, channel};
use std::time::{Duration, Instant};

/// Least time between two refreshments.
const REFRESH: Duration = Duration::from_secs(2);
/// At most one part in so many of the time of one thread goes into them.
const SHARE: u32 = 20;
/// When a coarse picture is shown where pixels still have no sample.
const EARLY: Duration = Duration::from_millis(500);
/// Between two looks at whether there is something to show.
const LOOK: Duration = Duration::from_millis(20);

/// The files that a picture goes to, and the viewer that is shown it.
pub(super) struct Pictures<'a> {
    files: &'a [PictureFile],
    viewer: Option<Viewer>,
    development: Development,
    bits: Bits,
}

impl<'a> Pictures<'a> {
    /// # Errors
    /// A file that cannot be created or is named twice, or options of the display that do not go together.
    pub(super) fn new(
        files: &'a [PictureFile],
        display: &DisplayArguments,
    ) -> Result<Self, Failure> {
        let development = display.development()?;
        for (index, file) in files.iter().enumerate() {
            if files[..index].iter().any(|other| is_same(&other.path, &file.path)) {
                let what = "two of the files that are to be written have this name; name two";
                return Err(Failure::usage(what).of(&file.path.display().to_string()));
            }
            atomic::check_writable_target(&file.path)?;
        }
        Ok(Self { files, viewer: None, development, bits: display.bits })
    }

    /// From now on previews go to this viewer, too.
    pub(super) fn show_in(&mut self, viewer: Viewer) {
        self.viewer = Some(viewer);
    }

    /// Shows the last picture in the viewer, if there is one.
    pub(super) fn show_last(&self, picture: &Picture, progress: &Progress) {
        let Some(viewer) = &self.viewer else { return };
        if viewer.is_there() {
            viewer.show(picture.clone());
        }
        viewer.finish();
        self.tell_of_loss(progress);
    }

    fn tell_of_loss(&self, progress: &Progress) {
        if let Some(fault) = self.viewer.as_ref().and_then(Viewer::fault) {
            progress.note(&fault);
        }
    }

    /// The exposure that is found for a picture, stops, where it is automatic and shows.
    pub(super) fn automatic_stops(&self, picture: &Picture) -> Result<Option<f64>, Failure> {
        match self.development.exposure {
            Exposure::Auto if self.shown().next().is_some() => {
                Ok(Some(self.development.stops(picture)?))
            }
            Exposure::Auto | Exposure::Stops(_) => Ok(None),
        }
    }

    /// Writes every file; the first failure is told after all were tried.
    pub(super) fn write(&self, film: &Film, picture: &Picture) -> Result<(), Failure> {
        let mut written = Ok(());
        for file in self.files {
            written = written.and(match file.format {
                PictureFormat::Png => self.write_png(file, picture),
                PictureFormat::Exr => image::write_exr(&file.path, picture).map_err(Failure::from),
                PictureFormat::Film => write_film(&file.path, film).map_err(Failure::from),
            });
        }
        written
    }

    /// Writes the PNG files alone, for a picture that holds colours alone.
    pub(super) fn write_preview(&self, picture: &Picture) -> Result<(), Failure> {
        let mut written = Ok(());
        for file in self.shown() {
            written = written.and(self.write_png(file, picture));
        }
        written
    }

    fn shown(&self) -> impl Iterator<Item = &PictureFile> {
        self.files.iter().filter(|file| file.format == PictureFormat::Png)
    }

    fn write_png(&self, file: &PictureFile, picture: &Picture) -> Result<(), Failure> {
        let how = &self.development;
        match self.bits {
            Bits::Eight => image::write_png_8(&file.path, &develop::to_8_bit(picture, how)?)?,
            Bits::Sixteen => image::write_png_16(&file.path, &develop::to_16_bit(picture, how)?)?,
        }
        Ok(())
    }

    /// Does `work` and meanwhile refreshes the PNG files and what the viewer shows, together with the film of an
    /// earlier run, on a thread of its own.
    pub(super) fn refreshed<T>(
        &self,
        (rendering, earlier): (&Rendering, Option<&Film>),
        interrupts: &Interrupts,
        progress: &Progress,
        work: impl FnOnce() -> T,
    ) -> T {
        std::thread::scope(|scope| {
            let (working, ended) = channel::<()>();
            if self.shown().next().is_some() || self.viewer.is_some() {
                scope.spawn(move || {
                    self.refresh((rendering, earlier), interrupts, progress, &ended);
                });
            }
            let result = work();
            drop(working);
            result
        })
    }

    /// Writes the picture so far: as soon as every pixel has a sample or [`EARLY`] is over, and then
    /// every now and then. A file that cannot be written now is told and left until the end.
    fn refresh(
        &self,
        (rendering, earlier): (&Rendering, Option<&Film>),
        interrupts: &Interrupts,
        progress: &Progress,
        ended: &Receiver<()>,
    ) {
        let start = Instant::now();
        let mut due = start + EARLY;
        let mut first = true;
        while ended.recv_timeout(LOOK) == Err(RecvTimeoutError::Timeout) {
            if interrupts.exit_code().is_some() {
                return;
            }
            let early = first && rendering.samples() > 0;
            if !early && Instant::now() < due {
                continue;
            }
            let began = Instant::now();
            let written = match rendering.preview(earlier) {
                Ok(None) => continue,
                Ok(Some(picture)) => {
                    let written = interrupts.while_writing(|| self.write_preview(&picture));
                    if let Some(viewer) = self.viewer.as_ref().filter(|viewer| viewer.is_there()) {
                        viewer.show(picture);
                    }
                    self.tell_of_loss(progress);
                    written
                }
                Err(error) => Err(Failure::from(error)),
            };
            if let Err(failure) = written {
                progress.note(&format!("cannot refresh the picture: {}", failure.message));
                return;
            }
            if first {
                progress.detail(&format!(
                    "first picture {:.2} s after the start of rendering, written in {:.2} s",
                    start.elapsed().as_secs_f64(),
                    began.elapsed().as_secs_f64(),
                ));
            }
            first = false;
            due = Instant::now() + REFRESH.max(began.elapsed() * SHARE);
        }
    }
}

/// Whether two paths name the same file, however they are written.
fn is_same(a: &Path, b: &Path) -> bool {
    std::path::absolute(a).is_ok_and(|a| std::path::absolute(b).is_ok_and(|b| a == b))
}
