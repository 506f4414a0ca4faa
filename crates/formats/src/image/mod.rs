//! Pictures: PNG for display, OpenEXR for scene-linear layers.

pub(crate) mod exr;
mod png;

pub use self::exr::write_exr;
pub use self::png::{write_png_8, write_png_16};

use crate::error::{Fault, FormatsError};
use crate::{film_file, input, read_film};
use snowgrain_film::{FilmError, Picture};
use std::path::Path;

/// Most pixels across or down of a picture that is read.
const LARGEST_SIDE: u32 = 65_536;

/// Most bytes that one byte of a compressed picture may become: a bound on what a small file can
/// make a reader allocate. Deflate reaches 1032, run lengths 64.
const LARGEST_EXPANSION: u64 = 2048;

/// Reads a PNG (sRGB, to linear), an EXR or a film, told apart by their first bytes.
///
/// # Errors
/// A missing or unreadable file, another format, damaged content, or claimed sizes that the file
/// cannot hold.
pub fn read_picture(path: &Path) -> Result<Picture, FormatsError> {
    let bytes = input::read_whole(path)?;
    if film_file::is_film(&bytes) {
        drop(bytes);
        let film = read_film(path)?;
        return Picture::from_film(&film).map_err(|error| picture_fault(&error).of(path));
    }
    decode(&bytes).map_err(|fault| fault.of(path))
}

fn decode(bytes: &[u8]) -> Result<Picture, Fault> {
    if bytes.starts_with(png::SIGNATURE) {
        png::decode(bytes)
    } else if bytes.starts_with(exr::MAGIC) {
        exr::decode(bytes)
    } else {
        let what = "this is not a picture that Snowgrain reads";
        Err(Fault::whole(what, "give a PNG, an EXR or a .film file"))
    }
}

/// Refuses sizes that the file cannot hold, before memory is taken; `pixel_bytes` as decoded.
fn check_size(width: u64, height: u64, pixel_bytes: u64, file_bytes: usize) -> Result<(), Fault> {
    let needed = u128::from(width) * u128::from(height) * u128::from(pixel_bytes);
    let largest = u128::from(LARGEST_EXPANSION) * file_bytes as u128;
    let side = u64::from(LARGEST_SIDE);
    if width == 0 || height == 0 || width > side || height > side || needed > largest {
        let what = format!(
            "the picture claims {width}x{height} pixels of {pixel_bytes} bytes, which a file of \
             {file_bytes} bytes does not hold"
        );
        return Err(Fault::whole(what, "the file is damaged: make it again"));
    }
    Ok(())
}

fn picture_fault(error: &FilmError) -> Fault {
    match error {
        FilmError::TooLarge { .. } => Fault::TooLarge("the picture".into()),
        error => Fault::whole(error.to_string(), "the file is damaged: make it again"),
    }
}
