//! Why noise cannot be removed.

use snowgrain_film::FilmError;
use std::path::PathBuf;
use thiserror::Error;

/// Why noise cannot be removed.
#[derive(Debug, Error)]
pub enum DenoiseError {
    /// The library is nowhere.
    #[error(
        "Intel Open Image Denoise is not found ({tried}); install version 2 of it, or name its library \
         or the folder that holds it by --denoise-library or in SNOWGRAIN_OIDN"
    )]
    NotFound {
        /// What was tried, and what the system said to it.
        tried: String,
    },
    /// A library is there, but not the right one.
    #[error("{}: this is not version 2 of Intel Open Image Denoise ({what}); name that one", path.display())]
    Unsuitable {
        /// The library.
        path: PathBuf,
        /// What it lacks.
        what: String,
    },
    /// The library cannot do it.
    #[error("Intel Open Image Denoise failed ({0}); leave out --denoise")]
    Failed(String),
    /// Colours and guides are not of as many pixels as the picture.
    #[error("{values} values were given for a layer of {pixels} pixels")]
    Size {
        /// Values given.
        values: usize,
        /// Pixels of the picture.
        pixels: usize,
    },
    /// The picture lacks a layer.
    #[error(
        "the picture has no layer {0}, by which the denoiser is guided; render it again, or leave out \
         --denoise"
    )]
    NoGuide(&'static str),
    /// The picture is refused.
    #[error("{0}")]
    Film(#[from] FilmError),
}
