//! Pictures without noise, where `--denoise` asks for them.

use crate::arguments::{DenoiseArguments, PictureFile, PictureFormat};
use crate::failure::Failure;
use snowgrain_denoise::Denoiser;
use snowgrain_film::{GLINTS, Picture};
use std::path::PathBuf;

/// Names the library, or the folder that holds it.
const VARIABLE: &str = "SNOWGRAIN_OIDN";

/// The denoiser that was asked for, if one was, on `threads` threads (0: as many as it likes).
///
/// # Errors
/// No picture to denoise among `files`; no library.
pub(super) fn denoiser(
    arguments: &DenoiseArguments,
    files: &[PictureFile],
    threads: usize,
) -> Result<Option<Denoiser>, Failure> {
    if !arguments.denoise {
        return Ok(None);
    }
    if files.iter().all(|file| file.format == PictureFormat::Film) {
        return Err(Failure::usage("--denoise is for .png and .exr files; name one by -o"));
    }
    let variable = || std::env::var_os(VARIABLE).filter(|v| !v.is_empty()).map(PathBuf::from);
    let library = arguments.denoise_library.clone().or_else(variable);
    Ok(Some(Denoiser::open(library.as_deref(), threads)?))
}

/// The picture without noise, its glints as they are where it has a layer of them.
///
/// # Errors
/// What the library refuses.
pub(super) fn denoised(denoiser: &Denoiser, picture: &Picture) -> Result<Picture, Failure> {
    let glints = picture.light_layers.iter().find(|layer| layer.name == GLINTS);
    let apart = glints.map(|layer| layer.values.each_ref().map(Vec::as_slice));
    Ok(denoiser.denoise_picture(picture, apart)?)
}
