//! Whether the disk has room for what will be written, said before anything is made.

use crate::arguments::{PictureFile, PictureFormat};
use crate::budget::readable_bytes;
use crate::failure::Failure;
use crate::process;
use snowgrain_film::PixelRect;
use snowgrain_render::CostEstimate;
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

/// Bytes a pixel of an EXR file without compression beside what it shows of the film, and of a PNG file.
const EXR_BYTES_PER_PIXEL: u64 = 60;
const PNG_BYTES_PER_PIXEL: u64 = 6;

/// Refuses files for which there is no room beside the ones that they will replace.
///
/// # Errors
/// Too little room in a folder.
pub(crate) fn check(
    files: &[PictureFile],
    cost: &CostEstimate,
    crop: PixelRect,
) -> Result<(), Failure> {
    let mut folders: BTreeMap<PathBuf, u64> = BTreeMap::new();
    for file in files {
        let bytes = match file.format {
            PictureFormat::Film => cost.sums_bytes,
            PictureFormat::Exr => crop.area().saturating_mul(EXR_BYTES_PER_PIXEL),
            PictureFormat::Png => crop.area().saturating_mul(PNG_BYTES_PER_PIXEL),
        };
        let folder = match file.path.parent() {
            Some(parent) if !parent.as_os_str().is_empty() => parent.to_path_buf(),
            _ => PathBuf::from("."),
        };
        let needed = folders.entry(folder).or_default();
        *needed = needed.saturating_add(bytes);
    }
    folders.iter().try_for_each(|(folder, &needed)| check_folder(folder, needed))
}

fn check_folder(folder: &Path, needed: u64) -> Result<(), Failure> {
    let Some(free) = process::free_disk(folder).filter(|&free| free < needed) else {
        return Ok(());
    };
    Err(Failure::refused(format!(
        "{}: the files take up to {}, but only {} are free on that disk; make room, or write elsewhere",
        folder.display(),
        readable_bytes(needed),
        readable_bytes(free)
    )))
}
