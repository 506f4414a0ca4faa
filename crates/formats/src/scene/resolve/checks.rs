//! Checks that all parts of a scene share, and the errors they give.

use super::super::document::SceneDocument;
use super::super::quantity::{Length, Triple};
use super::super::{LoadError, SceneError, SceneFile};
use crate::folder::{self, Stray};
use snowgrain_math::DVec3;
use std::path::{Path, PathBuf};

/// Farthest coordinate, largest size and largest scale, in metres: far beyond any scene, and small
/// enough that no product of them overflows.
pub(super) const LARGEST: f64 = 1e12;

/// Smallest size and scale, in metres.
pub(super) const SMALLEST: f64 = 1e-12;

/// A scene file under examination.
pub(super) struct Checks<'a> {
    file: &'a SceneFile,
}

impl<'a> Checks<'a> {
    pub(super) fn new(file: &'a SceneFile) -> Self {
        Self { file }
    }

    pub(super) fn document(&self) -> &'a SceneDocument {
        &self.file.document
    }

    /// The keys written in the table at `path`.
    pub(super) fn written_keys<'b>(&'b self, path: &'b str) -> impl Iterator<Item = &'b str> {
        self.file.source.written_keys(path)
    }

    pub(super) fn bad(&self, key: &str, mend: impl Into<String>) -> SceneError {
        SceneError::BadValue {
            place: self.file.source.place(key),
            key: key.to_owned(),
            value: self.value(key),
            mend: mend.into(),
        }
    }

    pub(super) fn misplaced(&self, key: &str, mend: impl Into<String>) -> SceneError {
        SceneError::MisplacedKey {
            place: self.file.source.place(key),
            key: key.to_owned(),
            value: self.value(key),
            mend: mend.into(),
        }
    }

    pub(super) fn missing(&self, key: &str, mend: impl Into<String>) -> SceneError {
        SceneError::MissingKey {
            place: self.file.source.place(key),
            key: key.to_owned(),
            mend: mend.into(),
        }
    }

    pub(super) fn unusable(&self, key: &str, cause: LoadError) -> SceneError {
        SceneError::Reference {
            place: self.file.source.place(key),
            key: key.to_owned(),
            value: self.value(key),
            cause,
        }
    }

    fn value(&self, key: &str) -> String {
        self.file.source.written(key).unwrap_or_else(|| "(default)".to_owned())
    }

    /// The path of a file that the scene refers to. One that the scene file names must lie in its folder; one
    /// that `--set` names may lie anywhere.
    pub(super) fn reference(&self, key: &str, file: &str) -> Result<PathBuf, SceneError> {
        if file.is_empty() || file.contains('\0') {
            return Err(self.bad(key, "must name a file"));
        }
        let folder = self.file.origin().parent().unwrap_or(Path::new(""));
        if !self.file.source.is_override(key)
            && let Err(stray) = folder::inside(folder, file)
            && stray != Stray::Missing
        {
            let mend = "a scene may only name files of its own folder: put the file there, or name it by \
                        --set, which may lead anywhere";
            return Err(self.bad(key, format!("names a file {}; {mend}", stray.clause())));
        }
        Ok(folder.join(file))
    }

    pub(super) fn finite<const N: usize>(
        &self,
        key: &str,
        values: [f64; N],
    ) -> Result<[f64; N], SceneError> {
        if values.iter().all(|v| v.is_finite()) {
            return Ok(values);
        }
        Err(self.bad(key, "must be finite numbers"))
    }

    pub(super) fn coordinates<const N: usize>(
        &self,
        key: &str,
        lengths: [Length; N],
    ) -> Result<[f64; N], SceneError> {
        let metres = lengths.map(|length| length.metres);
        if metres.iter().all(|m| m.abs() <= LARGEST) {
            return Ok(metres);
        }
        Err(self.bad(key, format!("must be finite lengths within {LARGEST:e} m of the origin")))
    }

    pub(super) fn position(&self, key: &str, point: [Length; 3]) -> Result<DVec3, SceneError> {
        self.coordinates(key, point).map(DVec3::from)
    }

    /// A length above 0.
    pub(super) fn size(&self, key: &str, length: Length) -> Result<f64, SceneError> {
        if (SMALLEST..=LARGEST).contains(&length.metres) {
            return Ok(length.metres);
        }
        Err(self.bad(key, "must be a finite length above 0, as \"0.5 mm\""))
    }

    pub(super) fn radiance(&self, key: &str, value: Triple) -> Result<[f32; 3], SceneError> {
        let channels = value.0.map(|v| v as f32);
        if channels.iter().all(|&v| v >= 0.0 && v.is_finite()) {
            return Ok(channels);
        }
        Err(self.bad(key, "must be finite and not negative"))
    }
}
