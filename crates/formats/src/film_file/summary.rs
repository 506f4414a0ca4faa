//! What a film file says of itself, without its sums.

use super::header::Header;
use super::{MEND, array, skip};
use crate::error::{Fault, FormatsError};
use crate::input;
use snowgrain_film::{FilmIdentity, PixelRect, SampleRanges};
use std::io::Read;
use std::path::Path;

/// What a film file says of itself.
#[derive(Clone, Debug, PartialEq)]
pub struct FilmSummary {
    /// What decides its samples.
    pub identity: FilmIdentity,
    /// Digest of what was asked for, if known.
    pub recipe: Option<[u8; 32]>,
    /// The pixels that it keeps.
    pub crop: PixelRect,
    /// The samples that every pixel has.
    pub samples: SampleRanges,
}

/// Reads what a film file says of itself; its length is checked, its checksum is not.
///
/// # Errors
/// A missing or unreadable file, another magic number or version, a length that does not agree with the
/// content.
pub fn film_summary(path: &Path) -> Result<FilmSummary, FormatsError> {
    let (mut reader, length) = input::open(path)?;
    read(&mut reader, length).map_err(|fault| fault.of(path))
}

fn read(reader: &mut impl Read, length: u64) -> Result<FilmSummary, Fault> {
    let header = Header::read(reader, length)?;
    skip(reader, u64::from(header.grade_bytes) + u64::from(header.layers_bytes))?;
    let samples = read_ranges(reader, header.ranges)?;
    let Header { identity, recipe, crop, .. } = header;
    Ok(FilmSummary { identity, recipe, crop, samples })
}

/// Reads so many ranges of samples.
pub(super) fn read_ranges(reader: &mut impl Read, count: u32) -> Result<SampleRanges, Fault> {
    let mut samples = SampleRanges::default();
    for _ in 0..count {
        let start = u64::from_le_bytes(array(reader)?);
        let end = u64::from_le_bytes(array(reader)?);
        let recorded = samples.insert(start..end);
        recorded.map_err(|error| Fault::whole(error.to_string(), MEND))?;
    }
    Ok(samples)
}
