//! Data on standard output, words on standard error, figures in files.

use crate::arguments::{PictureFile, PictureFormat};
use crate::failure::{Failure, exit};
use snowgrain_formats::{Claim, atomic};
use std::io::{self, Write};
use std::path::Path;

/// Writes `text` to standard output. A reader that has seen enough (`| head`) is no failure.
pub(crate) fn print(text: &str) -> Result<(), Failure> {
    let mut stdout = io::stdout().lock();
    match stdout.write_all(text.as_bytes()).and_then(|()| stdout.flush()) {
        Err(error) if error.kind() != io::ErrorKind::BrokenPipe => {
            Err(Failure::new(exit::INPUT_OUTPUT, format!("standard output: {error}")))
        }
        _ => Ok(()),
    }
}

/// Writes a line to standard error. Whoever does not want to read it misses nothing: the exit code
/// and the files tell too.
pub(crate) fn tell(line: &str) {
    let _ = writeln!(io::stderr(), "{line}");
}

/// The value as JSON over several lines.
pub(crate) fn json(value: &impl serde::Serialize) -> Result<String, Failure> {
    serde_json::to_string_pretty(value)
        .map(|text| text + "\n")
        .map_err(|error| Failure::new(exit::BUG, format!("the figures cannot be written: {error}")))
}

/// Writes a text file, whole or not at all.
pub(crate) fn write_text(path: &Path, text: &str) -> Result<(), Failure> {
    Ok(atomic::write(path, |writer| writer.write_all(text.as_bytes()))?)
}

/// Keeps other runs from the films among `files` until the claims are dropped.
///
/// # Errors
/// A film that another run is at work on.
pub(crate) fn claim_films(files: &[PictureFile]) -> Result<Vec<Claim>, Failure> {
    let films = files.iter().filter(|file| file.format == PictureFormat::Film);
    films.map(|file| Ok(Claim::take(&file.path)?)).collect()
}
