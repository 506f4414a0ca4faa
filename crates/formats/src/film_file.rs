//! The film container (`.film`): the exact sums of a render, to continue or merge it.
//!
//! Little-endian, version 3:
//!
//! | bytes | content |
//! |---|---|
//! | 8 | `SNOWFILM` |
//! | 4 | version |
//! | 4 each | width, height, then x0, y0, x1, y1 of the crop |
//! | 32 | scene hash |
//! | 8 | seed |
//! | 4 | number of sample ranges |
//! | 4 | spectra of lights of which ice paths are kept; 0: they are not kept |
//! | 4 | scale exponent of the ice paths, signed |
//! | 4 | bytes of the grade |
//! | 4 | counts of samples by block ([`BlockCounts`]); 0: blocks do not differ |
//! | so many | the grade, as TOML ([`grade`]) |
//! | 16 each | first sample, sample after the last |
//! | 8 | where there are counts: the relative error that they were chosen for, a double |
//! | 4 each | the counts, in the order of [`PixelRect::tiles`] |
//! | 208 each | sums of the pixels of the crop, row-major ([`PixelSums::to_le_bytes`]) |
//! | 768 each, for each spectrum | ice paths of the pixels ([`IcePaths::sums`]), signed, 8 bytes each |
//! | 32 | BLAKE3 of all bytes before |

mod grade;

use crate::error::{Fault, FormatsError, room};
use crate::{atomic, input};
use snowgrain_film::{
    BlockCounts, Film, FilmError, FilmIdentity, IcePathLayout, IcePaths, PixelRect, PixelSums,
};
use std::io::{self, Read, Write};
use std::path::Path;

const MAGIC: &[u8; 8] = b"SNOWFILM";
const VERSION: u32 = 3;
/// Bytes before the grade.
const HEADER_BYTES: u64 = 8 + 4 + 6 * 4 + 32 + 8 + 4 + 4 + 4 + 4 + 4;
/// Spectra of lights are few.
const MOST_LIGHTS: u32 = 64;
const RANGE_BYTES: u64 = 16;
const HASH_BYTES: u64 = 32;
/// Sums of ice paths that are read or written at once.
const SUMS_AT_ONCE: usize = 1 << 15;

const MEND: &str = "copy or render it again";

/// Writes a film.
///
/// # Errors
/// What [`atomic::write`] refuses.
pub fn write_film(path: &Path, film: &Film) -> Result<(), FormatsError> {
    atomic::write(path, |writer| write(writer, film))
}

/// Reads a film.
///
/// # Errors
/// A missing or unreadable file; another magic number or version; a length or checksum that does
/// not agree with the content; a film that does not fit into memory.
pub fn read_film(path: &Path) -> Result<Film, FormatsError> {
    let (reader, length) = input::open(path)?;
    read(reader, length).map_err(|fault| fault.of(path))
}

/// Whether bytes begin like those of a film.
pub(crate) fn is_film(start: &[u8]) -> bool {
    start.starts_with(MAGIC)
}

fn write(writer: &mut impl Write, film: &Film) -> io::Result<()> {
    let mut writer = Hashing { stream: writer, hasher: blake3::Hasher::new() };
    writer.write_all(MAGIC)?;
    let crop = film.crop();
    let numbers = [VERSION, film.width(), film.height(), crop.x0, crop.y0, crop.x1, crop.y1];
    numbers.iter().try_for_each(|number| writer.write_all(&number.to_le_bytes()))?;
    writer.write_all(&film.identity().scene_hash)?;
    writer.write_all(&film.identity().seed.to_le_bytes())?;
    let ranges = film.samples().as_slice();
    let count = u32::try_from(ranges.len()).map_err(io::Error::other)?;
    writer.write_all(&count.to_le_bytes())?;
    let layout = film.ice_paths().map(IcePaths::layout);
    let (lights, scale) = layout.map_or((0, 0), |layout| (layout.lights, layout.scale_exponent));
    writer.write_all(&lights.to_le_bytes())?;
    writer.write_all(&scale.to_le_bytes())?;
    let grade = grade::to_toml(&film.grade);
    writer.write_all(&(grade.len() as u32).to_le_bytes())?;
    let counts = film.block_counts().map_or(&[][..], BlockCounts::counts);
    writer.write_all(&(counts.len() as u32).to_le_bytes())?;
    writer.write_all(grade.as_bytes())?;
    for range in ranges {
        writer.write_all(&range.start.to_le_bytes())?;
        writer.write_all(&range.end.to_le_bytes())?;
    }
    if let Some(counts) = film.block_counts() {
        writer.write_all(&counts.relative_error().to_le_bytes())?;
        counts.counts().iter().try_for_each(|count| writer.write_all(&count.to_le_bytes()))?;
    }
    film.pixels().iter().try_for_each(|sums| writer.write_all(&sums.to_le_bytes()))?;
    let ice = film.ice_paths().map_or(&[][..], IcePaths::sums);
    let mut bytes = Vec::with_capacity(8 * SUMS_AT_ONCE);
    for sums in ice.chunks(SUMS_AT_ONCE) {
        bytes.clear();
        sums.iter().for_each(|sum| bytes.extend_from_slice(&sum.to_le_bytes()));
        writer.write_all(&bytes)?;
    }
    let hash = writer.hasher.finalize();
    writer.stream.write_all(hash.as_bytes())
}

fn read(reader: impl Read, length: u64) -> Result<Film, Fault> {
    let mut reader = Hashing { stream: reader, hasher: blake3::Hasher::new() };
    if !is_film(&array::<8>(&mut reader)?) {
        return Err(Fault::whole("this is not a film of Snowgrain", "name a .film file"));
    }
    let version = u32::from_le_bytes(array(&mut reader)?);
    if version != VERSION {
        let what = format!("version {version} of film files is not known (this reads {VERSION})");
        return Err(Fault::whole(what, "use the Snowgrain that wrote it"));
    }
    let mut number = || array(&mut reader).map(u32::from_le_bytes);
    let (width, height) = (number()?, number()?);
    let crop = PixelRect::new(number()?, number()?, number()?, number()?);
    let scene_hash = array(&mut reader)?;
    let seed = u64::from_le_bytes(array(&mut reader)?);
    let ranges = u32::from_le_bytes(array(&mut reader)?);
    let lights = u32::from_le_bytes(array(&mut reader)?);
    let layout = (lights > 0).then_some(IcePathLayout {
        lights: lights.min(MOST_LIGHTS),
        scale_exponent: i32::from_le_bytes(array(&mut reader)?),
    });
    let grade_bytes = u32::from_le_bytes(array(&mut reader)?);
    let counts = u32::from_le_bytes(array(&mut reader)?);
    check_length(crop, ranges, layout, grade_bytes, counts, length)?;
    let mut grade = vec![0; grade_bytes as usize];
    reader.read_exact(&mut grade)?;
    let grade = grade::from_toml(&grade).map_err(|what| Fault::whole(what, MEND))?;
    if let Some(layout) = layout
        && layout.lights as usize != grade.lights.len()
    {
        return Err(Fault::whole("its ice paths are not those of its lights", MEND));
    }
    let identity = FilmIdentity { scene_hash, seed };
    let film_fault = |error: FilmError| match error {
        FilmError::TooLarge { .. } => Fault::TooLarge("the film".into()),
        error => Fault::whole(error.to_string(), MEND),
    };
    let mut film = Film::new(width, height, crop, identity).map_err(film_fault)?;
    film.grade = grade;
    if let Some(layout) = layout {
        film = film.keeping_ice_paths(layout).map_err(film_fault)?;
    }
    for _ in 0..ranges {
        let start = u64::from_le_bytes(array(&mut reader)?);
        let end = u64::from_le_bytes(array(&mut reader)?);
        let recorded = film.record_samples(start..end);
        recorded.map_err(|error| Fault::whole(error.to_string(), MEND))?;
    }
    if counts > 0 {
        let relative_error = f64::from_le_bytes(array(&mut reader)?);
        let mut list = room(counts as usize, "counts of samples")?;
        for _ in 0..counts {
            list.push(u32::from_le_bytes(array(&mut reader)?));
        }
        let counts = BlockCounts::new(crop, relative_error, list).map_err(film_fault)?;
        film = film.with_block_counts(counts).map_err(film_fault)?;
    }
    for sums in film.pixels_mut() {
        *sums = PixelSums::from_le_bytes(&array(&mut reader)?);
    }
    let ice = film.ice_paths_mut().map_or(&mut [][..], IcePaths::sums_mut);
    let mut bytes = vec![0; 8 * SUMS_AT_ONCE];
    for sums in ice.chunks_mut(SUMS_AT_ONCE) {
        let bytes = &mut bytes[..8 * sums.len()];
        reader.read_exact(bytes)?;
        for (sum, bytes) in sums.iter_mut().zip(bytes.as_chunks().0) {
            *sum = i64::from_le_bytes(*bytes);
        }
    }
    let hash = reader.hasher.finalize();
    let mut written = [0; 32];
    reader.stream.read_exact(&mut written)?;
    if hash != written {
        return Err(Fault::whole("the checksum is wrong: the film is damaged", MEND));
    }
    Ok(film)
}

/// Compares the length of the file with what its header claims, before memory is taken.
fn check_length(
    crop: PixelRect,
    ranges: u32,
    layout: Option<IcePathLayout>,
    grade_bytes: u32,
    counts: u32,
    length: u64,
) -> Result<(), Fault> {
    let counts_bytes = if counts > 0 { 8 + 4 * u64::from(counts) } else { 0 };
    let fixed = HEADER_BYTES
        + u64::from(grade_bytes)
        + u64::from(ranges) * RANGE_BYTES
        + counts_bytes
        + HASH_BYTES;
    let pixel_bytes = PixelSums::BYTES as u64 + layout.map_or(0, IcePathLayout::bytes);
    let expected = u128::from(fixed) + u128::from(crop.area()) * u128::from(pixel_bytes);
    if expected == u128::from(length) {
        return Ok(());
    }
    let what = format!("a film of {} pixels has {expected} bytes, not {length}", crop.area());
    Err(Fault::whole(what, MEND))
}

fn array<const N: usize>(reader: &mut impl Read) -> Result<[u8; N], Fault> {
    let mut bytes = [0; N];
    reader.read_exact(&mut bytes)?;
    Ok(bytes)
}

/// A stream that hashes what passes through it.
struct Hashing<S> {
    stream: S,
    hasher: blake3::Hasher,
}

impl<W: Write> Write for Hashing<W> {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        let written = self.stream.write(bytes)?;
        self.hasher.update(&bytes[..written]);
        Ok(written)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.stream.flush()
    }
}

impl<R: Read> Read for Hashing<R> {
    fn read(&mut self, bytes: &mut [u8]) -> io::Result<usize> {
        let read = self.stream.read(bytes)?;
        self.hasher.update(&bytes[..read]);
        Ok(read)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use snowgrain_film::{FilmTile, Sample};
    use snowgrain_optics::{
        Absorption, Grade, Illuminant, Impurity, ImpurityKind, Load, Primaries,
    };

    fn film(values: &[f32]) -> Film {
        let crop = PixelRect::new(1, 0, 1 + values.len() as u32, 1);
        let identity = FilmIdentity { scene_hash: [9; 32], seed: 0xdead_beef_0123 };
        let mut film = Film::new(20, 3, crop, identity).unwrap();
        let mut tile = FilmTile::new(crop).unwrap();
        for (x, &value) in (1..).zip(values) {
            let sample = Sample {
                radiance: [value, 1.0, 0.3],
                normal: [-0.5, 0.1, 0.0],
                depth: 2.5,
                ..Sample::default()
            };
            tile.add(x, 0, &sample).unwrap();
        }
        film.merge_tile(&tile).unwrap();
        film.record_samples(5..6).unwrap();
        film.record_samples(9..10).unwrap();
        film
    }

    /// With ice paths of two lights.
    fn graded(length: f64) -> Film {
        let crop = PixelRect::new(0, 0, 2, 2);
        let identity = FilmIdentity { scene_hash: [3; 32], seed: 1 };
        let layout = IcePathLayout::for_radiance(2, 40.0);
        let mut film = Film::new(2, 2, crop, identity).unwrap().keeping_ice_paths(layout).unwrap();
        film.grade = Grade {
            primaries: Primaries::AcesCg,
            lights: vec![Illuminant::A, Illuminant::D65],
            absorption: Absorption::Grey(0.1 + length),
            impurities: vec![
                Impurity { kind: ImpurityKind::BlackCarbon, load: Load::MassFraction(3e-7) },
                Impurity { kind: ImpurityKind::SnowAlgae, load: Load::CellsPerKilogram(1e7) },
            ],
            enhancement: 1.253_5,
        };
        let mut tile = FilmTile::keeping_ice_paths(crop, layout).unwrap();
        tile.add_ice_path(1, 0, length, &[[0.5, 0.25, -0.1], [40.0, 0.0, 3.0]]).unwrap();
        film.merge_tile(&tile).unwrap();
        film
    }

    #[test]
    fn a_film_of_other_lights_than_its_ice_paths_is_refused() {
        let mut film = graded(1.0);
        film.grade.lights.pop();
        let error = read_bytes(&written(&film)).unwrap_err().to_string();
        assert!(error.contains("ice paths"), "{error}");
    }

    fn written(film: &Film) -> Vec<u8> {
        let mut bytes = Vec::new();
        write(&mut bytes, film).unwrap();
        bytes
    }

    fn read_bytes(bytes: &[u8]) -> Result<Film, FormatsError> {
        read(bytes, bytes.len() as u64).map_err(|fault| fault.of(Path::new("a.film")))
    }

    proptest! {
        #[test]
        fn films_come_back_as_they_were(values in prop::collection::vec(0.0..1e9f32, 1..15)) {
            let film = film(&values);
            prop_assert_eq!(read_bytes(&written(&film)).unwrap(), film);
        }

        #[test]
        fn ice_paths_and_grades_come_back_as_they_were(length in 0.0..2000.0f64) {
            let film = graded(length);
            prop_assert_eq!(read_bytes(&written(&film)).unwrap(), film);
        }

        #[test]
        fn counts_of_blocks_come_back_as_they_were(
            relative_error in 1e-6..10.0f64,
            count in 1..u32::MAX,
        ) {
            let crop = PixelRect::new(14, 1, 18, 2);
            let film = Film::new(20, 3, crop, film(&[1.0]).identity()).unwrap();
            let counts = BlockCounts::new(crop, relative_error, vec![count, 1]).unwrap();
            let film = film.with_block_counts(counts).unwrap();
            let mut bytes = written(&film);
            prop_assert_eq!(read_bytes(&bytes).unwrap(), film);
            let at = bytes.len() - 32 - 4 * PixelSums::BYTES - 4;
            bytes[at] = 0; // the second count
            let error = read_bytes(&bytes).unwrap_err().to_string();
            prop_assert!(error.contains("count"), "{}", error);
        }

        #[test]
        fn any_change_is_noticed(at in any::<prop::sample::Index>(), flip in 1..=255u8) {
            let mut bytes = written(&film(&[0.5, 0.25]));
            let at = at.index(bytes.len());
            bytes[at] ^= flip;
            prop_assert_eq!(read_bytes(&bytes).unwrap_err().exit_code(), 65);
            prop_assert_eq!(read_bytes(&bytes[..at]).unwrap_err().exit_code(), 65);
        }

        #[test]
        fn any_bytes_are_refused(bytes in prop::collection::vec(any::<u8>(), 0..300)) {
            prop_assert!(read_bytes(&bytes).is_err());
            prop_assert!(read_bytes(&[&MAGIC[..], &[3, 0, 0, 0], &bytes].concat()).is_err());
        }
    }

    #[test]
    fn a_film_of_many_pixels_in_a_short_file_is_refused_by_arithmetic() {
        let mut bytes = written(&film(&[1.0]));
        bytes[12..36].fill(0xff);
        bytes[20..28].fill(0); // crop 0,0,2^32-1,2^32-1
        let error = read_bytes(&bytes).unwrap_err().to_string();
        assert!(error.starts_with("a.film: a film of 18446744065119617025 pixels"), "{error}");
    }

    #[test]
    fn other_versions_and_files_are_refused() {
        let mut bytes = written(&film(&[1.0]));
        bytes[8] = 1;
        let error = read_bytes(&bytes).unwrap_err().to_string();
        assert!(error.contains("version 1"), "{error}");
        bytes[0] = b'X';
        let error = read_bytes(&bytes).unwrap_err().to_string();
        assert!(error.contains("not a film"), "{error}");
    }
}
