//! Opening files to read.

use crate::error::{Fault, FormatsError, room};
use std::fs::File;
use std::io::{BufReader, Read};
use std::path::Path;

/// A file opened to read, and its length in bytes.
pub(crate) fn open(path: &Path) -> Result<(BufReader<File>, u64), FormatsError> {
    // Asked before it is opened: opening a pipe would wait for whoever writes into it.
    let metadata = path.metadata().map_err(|source| FormatsError::opening(path, source))?;
    if !metadata.is_file() {
        return Err(Fault::whole("this is not a regular file", "name a file").of(path));
    }
    let file = File::open(path).map_err(|source| FormatsError::opening(path, source))?;
    Ok((BufReader::with_capacity(1 << 20, file), metadata.len()))
}

/// The whole content of a file.
pub(crate) fn read_whole(path: &Path) -> Result<Vec<u8>, FormatsError> {
    let (mut reader, length) = open(path)?;
    let too_large = || Fault::TooLarge(format!("a file of {length} bytes")).of(path);
    let capacity = usize::try_from(length).map_err(|_| too_large())?;
    let mut bytes = room(capacity, "bytes").map_err(|fault| fault.of(path))?;
    reader
        .read_to_end(&mut bytes)
        .map_err(|source| FormatsError::Read { path: path.to_path_buf(), source })?;
    Ok(bytes)
}
