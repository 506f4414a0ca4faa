//! Files of what was learnt of light deep in the snow (`KEY.learnt` in a folder of the user's): what
//! `snowgrain_render::transport::deep::LearntStore` keeps, as it is.

use crate::{FormatsError, atomic, input};
use std::fmt::Write as _;
use std::io::Write as _;
use std::path::{Path, PathBuf};

/// What lies in a folder under a key; `None` where there is nothing that can be read. Whether it is whole is told by its
/// own checksum.
#[must_use]
pub fn read_learnt(folder: &Path, key: &[u8; 32]) -> Option<Vec<u8>> {
    input::read_whole(&file(folder, key)).ok()
}

/// Puts it there.
///
/// # Errors
/// What [`atomic::write`] refuses.
pub fn write_learnt(folder: &Path, key: &[u8; 32], bytes: &[u8]) -> Result<(), FormatsError> {
    atomic::write(&file(folder, key), |writer| writer.write_all(bytes))
}

fn file(folder: &Path, key: &[u8; 32]) -> PathBuf {
    let mut name = String::new();
    for byte in key {
        let _ = write!(name, "{byte:02x}");
    }
    folder.join(name + ".learnt")
}
