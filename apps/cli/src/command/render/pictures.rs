//! The files that a picture goes to.

use crate::arguments::{PictureFile, PictureFormat};
use crate::failure::Failure;
use crate::progress::Progress;
use snowgrain_film::{Film, Picture, develop};
use snowgrain_formats::{atomic, image, write_film};
use std::time::{Duration, Instant};

/// Least time between two refreshments.
const REFRESH: Duration = Duration::from_secs(2);

/// The files that a picture goes to.
pub(super) struct Pictures<'a> {
    files: &'a [PictureFile],
    /// Stops.
    exposure: f64,
}

impl<'a> Pictures<'a> {
    /// # Errors
    /// A file that cannot be created.
    pub(super) fn new(files: &'a [PictureFile], exposure: f64) -> Result<Self, Failure> {
        for file in files {
            atomic::check_writable_target(&file.path)?;
        }
        Ok(Self { files, exposure })
    }

    /// Writes every file; the first failure is told after all were tried.
    pub(super) fn write(&self, film: &Film, picture: &Picture) -> Result<(), Failure> {
        let mut written = Ok(());
        for file in self.files {
            written = written.and(self.write_one(file, film, picture));
        }
        written
    }

    fn write_one(&self, file: &PictureFile, film: &Film, picture: &Picture) -> Result<(), Failure> {
        match file.format {
            PictureFormat::Png => {
                image::write_png_8(&file.path, &develop::to_8_bit(picture, self.exposure)?)?;
            }
            PictureFormat::Exr => image::write_exr(&file.path, picture)?,
            PictureFormat::Film => write_film(&file.path, film)?,
        }
        Ok(())
    }

    pub(super) fn refresh(&self) -> Refresh<'_> {
        Refresh { pictures: self, last: None, failed: false }
    }
}

/// Refreshes the PNG files while a picture is rendered.
pub(super) struct Refresh<'a> {
    pictures: &'a Pictures<'a>,
    last: Option<Instant>,
    failed: bool,
}

impl Refresh<'_> {
    /// Writes the film so far, unless that was done just now. A file that cannot be written now is
    /// told and left until the end.
    pub(super) fn with(&mut self, film: &Film, progress: &Progress) {
        if self.failed || self.last.is_some_and(|last| last.elapsed() < REFRESH) {
            return;
        }
        let shown = self.pictures.files.iter().filter(|file| file.format == PictureFormat::Png);
        for file in shown {
            let written = Picture::from_film(film)
                .map_err(Failure::from)
                .and_then(|picture| self.pictures.write_one(file, film, &picture));
            if let Err(failure) = written {
                self.failed = true;
                progress.note(&format!("cannot refresh the picture: {}", failure.message));
            }
        }
        self.last = Some(Instant::now());
    }
}
