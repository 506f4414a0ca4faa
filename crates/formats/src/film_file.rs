//! The film container (`.film`): the exact sums of a render, to continue or merge it.
//!
//! Little-endian, version 4:
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
//! | 8 | vertical field of view, degrees; 0: not known |
//! | 4 | layers of light; 0: they are not kept |
//! | 4, 4 | bytes of the grade and of the names of the layers |
//! | 4 | counts of samples by block ([`BlockCounts`]); 0: blocks do not differ |
//! | 4 | what else is kept, the sum of 1: what shadow catchers show, and 2: what is known of learnt light |
//! | 32 | digest of what was asked for ([`Film::recipe`]); 0: not known |
//! | so many | the grade, as TOML ([`grade`]) |
//! | so many | the names of the layers, as TOML ([`layers`]) |
//! | 16 each | first sample, sample after the last |
//! | 8 | where there are counts: the relative error that they were chosen for, a double |
//! | 4 each | the counts, in the order of [`snowgrain_film::PixelRect::tiles`] |
//! | 208 each | sums of the pixels of the crop, row-major ([`PixelSums::to_le_bytes`]) |
//! | 768 each, for each spectrum | ice paths of the pixels ([`IcePaths::sums`]), signed, 8 bytes each |
//! | 48 each, for each layer | layers of light of the pixels ([`LightLayers::sums`]), signed, 16 bytes each |
//! | 112 each | what shadow catchers show in the pixels ([`Film::shadow_sums`]), signed, 16 bytes each |
//! | 32 each | what is known of learnt light in the pixels ([`Film::learnt_sums`]), signed, 16 bytes each |
//! | 32 | BLAKE3 of all bytes before |

mod grade;
mod header;
mod layers;
mod summary;

use crate::error::{Fault, FormatsError, room};
use crate::{atomic, input};
use header::Header;
use snowgrain_film::{BlockCounts, Film, FilmError, IcePaths, LightLayers, PixelSums};
use std::io::{self, Read, Write};
use std::path::Path;

pub use summary::{FilmSummary, film_summary};

const MAGIC: &[u8; 8] = b"SNOWFILM";
/// Sums that are read or written at once.
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
    let grade = grade::to_toml(&film.grade);
    let layers = layers::to_toml(film.light_layers().map(LightLayers::layers));
    Header::of(film, &grade, &layers)?.write(&mut writer)?;
    writer.write_all(grade.as_bytes())?;
    writer.write_all(layers.as_bytes())?;
    for range in film.samples().as_slice() {
        writer.write_all(&range.start.to_le_bytes())?;
        writer.write_all(&range.end.to_le_bytes())?;
    }
    if let Some(counts) = film.block_counts() {
        writer.write_all(&counts.relative_error().to_le_bytes())?;
        counts.counts().iter().try_for_each(|count| writer.write_all(&count.to_le_bytes()))?;
    }
    film.pixels().iter().try_for_each(|sums| writer.write_all(&sums.to_le_bytes()))?;
    let ice = film.ice_paths().map_or(&[][..], IcePaths::sums);
    write_sums(&mut writer, ice, i64::to_le_bytes)?;
    let light = film.light_layers().map_or(&[][..], LightLayers::sums).as_flattened();
    write_sums(&mut writer, light, i128::to_le_bytes)?;
    let shadows = film.shadow_sums().unwrap_or_default().as_flattened();
    write_sums(&mut writer, shadows, i128::to_le_bytes)?;
    let learnt = film.learnt_sums().unwrap_or_default().as_flattened();
    write_sums(&mut writer, learnt, i128::to_le_bytes)?;
    let hash = writer.hasher.finalize();
    writer.stream.write_all(hash.as_bytes())
}

/// Writes sums of `N` bytes each.
fn write_sums<T: Copy, const N: usize>(
    writer: &mut impl Write,
    sums: &[T],
    to_bytes: fn(T) -> [u8; N],
) -> io::Result<()> {
    let mut bytes = Vec::with_capacity(N * SUMS_AT_ONCE.min(sums.len()));
    for sums in sums.chunks(SUMS_AT_ONCE) {
        bytes.clear();
        sums.iter().for_each(|&sum| bytes.extend_from_slice(&to_bytes(sum)));
        writer.write_all(&bytes)?;
    }
    Ok(())
}

/// Fills sums of `N` bytes each.
fn read_sums<T, const N: usize>(
    reader: &mut impl Read,
    sums: &mut [T],
    of_bytes: fn([u8; N]) -> T,
) -> io::Result<()> {
    let mut bytes = vec![0; N * SUMS_AT_ONCE.min(sums.len())];
    for sums in sums.chunks_mut(SUMS_AT_ONCE) {
        let bytes = &mut bytes[..N * sums.len()];
        reader.read_exact(bytes)?;
        for (sum, bytes) in sums.iter_mut().zip(bytes.as_chunks().0) {
            *sum = of_bytes(*bytes);
        }
    }
    Ok(())
}

fn read(reader: impl Read, length: u64) -> Result<Film, Fault> {
    let mut reader = Hashing { stream: reader, hasher: blake3::Hasher::new() };
    let header = Header::read(&mut reader, length)?;
    let mut film = empty_film(&mut reader, &header)?;
    for range in summary::read_ranges(&mut reader, header.ranges)?.as_slice() {
        film.record_samples(range.clone()).map_err(film_fault)?;
    }
    if header.block_counts > 0 {
        let counts = read_counts(&mut reader, &header)?;
        film = film.with_block_counts(counts).map_err(film_fault)?;
    }
    for sums in film.pixels_mut() {
        *sums = PixelSums::from_le_bytes(&array(&mut reader)?);
    }
    let ice = film.ice_paths_mut().map_or(&mut [][..], IcePaths::sums_mut);
    read_sums(&mut reader, ice, i64::from_le_bytes)?;
    let light = film.light_layers_mut().map_or(&mut [][..], LightLayers::sums_mut);
    read_sums(&mut reader, light.as_flattened_mut(), i128::from_le_bytes)?;
    let shadows = film.shadow_sums_mut().unwrap_or_default();
    read_sums(&mut reader, shadows.as_flattened_mut(), i128::from_le_bytes)?;
    let learnt = film.learnt_sums_mut().unwrap_or_default();
    read_sums(&mut reader, learnt.as_flattened_mut(), i128::from_le_bytes)?;
    let hash = reader.hasher.finalize();
    let mut written = [0; 32];
    reader.stream.read_exact(&mut written)?;
    if hash != written {
        return Err(Fault::whole("the checksum is wrong: the film is damaged", MEND));
    }
    Ok(film)
}

/// The film that a header and the texts after it describe, without samples.
fn empty_film(reader: &mut impl Read, header: &Header) -> Result<Film, Fault> {
    let mut text = |bytes: u32| {
        let mut text = vec![0; bytes as usize];
        reader.read_exact(&mut text).map(|()| text)
    };
    let grade = text(header.grade_bytes)?;
    let grade = grade::from_toml(&grade).map_err(|what| Fault::whole(what, MEND))?;
    let names = text(header.layers_bytes)?;
    if header.ice_paths.is_some_and(|layout| layout.lights as usize != grade.lights.len()) {
        return Err(Fault::whole("its ice paths are not those of its lights", MEND));
    }
    let Header { width, height, crop, identity, .. } = *header;
    let mut film = Film::new(width, height, crop, identity).map_err(film_fault)?;
    if let Some(layout) = header.ice_paths {
        film = film.keeping_ice_paths(layout).map_err(film_fault)?;
    }
    if header.light_layers > 0 {
        let layers = layers::from_toml(&names).map_err(|what| Fault::whole(what, MEND))?;
        let slots = layers.layer_of_slot().len();
        if layers.count() != header.light_layers as usize || slots != grade.lights.len() {
            return Err(Fault::whole("its layers of light are not those of its lights", MEND));
        }
        film = film.keeping_light_layers(layers).map_err(film_fault)?;
    }
    if header.shadow_catcher {
        film = film.keeping_shadow_catcher().map_err(film_fault)?;
    }
    if header.learnt_light {
        film = film.keeping_learnt_light().map_err(film_fault)?;
    }
    film.grade = grade;
    film.recipe = header.recipe;
    film.vertical_fov_degrees = header.vertical_fov_degrees;
    Ok(film)
}

/// The counts of samples by block.
fn read_counts(reader: &mut impl Read, header: &Header) -> Result<BlockCounts, Fault> {
    let relative_error = f64::from_le_bytes(array(reader)?);
    let mut counts = room(header.block_counts as usize, "counts of samples")?;
    for _ in 0..header.block_counts {
        counts.push(u32::from_le_bytes(array(reader)?));
    }
    BlockCounts::new(header.crop, relative_error, counts).map_err(film_fault)
}

fn film_fault(error: FilmError) -> Fault {
    match error {
        FilmError::TooLarge { .. } => Fault::TooLarge("the film".into()),
        error => Fault::whole(error.to_string(), MEND),
    }
}

fn array<const N: usize>(reader: &mut impl Read) -> Result<[u8; N], Fault> {
    let mut bytes = [0; N];
    reader.read_exact(&mut bytes)?;
    Ok(bytes)
}

/// Passes over so many bytes.
fn skip(reader: &mut impl Read, bytes: u64) -> Result<(), Fault> {
    match io::copy(&mut reader.take(bytes), &mut io::sink())? {
        passed if passed == bytes => Ok(()),
        _ => Err(Fault::truncated()),
    }
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
    use snowgrain_film::{
        FilmIdentity, FilmTile, IcePathLayout, Kept, LightLayerNames, PixelRect, Sample,
    };
    use snowgrain_optics::{
        Absorption, Grade, Illuminant, Impurity, ImpurityKind, Load, MeasuredSubstance, Primaries,
        Spectrum, Substance,
    };
    use std::sync::Arc;

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

    /// With ice paths and layers of two lights.
    fn graded(length: f64) -> Film {
        let crop = PixelRect::new(0, 0, 2, 2);
        let identity = FilmIdentity { scene_hash: [3; 32], seed: 1 };
        let layout = IcePathLayout::for_radiance(2, 40.0);
        let names = ["sun", "glints"].map(str::to_owned).to_vec();
        let names = LightLayerNames::new(names, vec![0, 0]).unwrap();
        let film = Film::new(2, 2, crop, identity).unwrap().keeping_ice_paths(layout).unwrap();
        let film = film.keeping_light_layers(names).unwrap();
        let film = film.keeping_shadow_catcher().unwrap();
        let mut film = film.keeping_learnt_light().unwrap();
        film.vertical_fov_degrees = Some(33.5);
        film.recipe = Some([7; 32]);
        film.grade = Grade {
            primaries: Primaries::AcesCg,
            lights: vec![Illuminant::A, Illuminant::D65],
            absorption: Absorption::Grey(0.1 + length),
            impurities: vec![
                Impurity { kind: ImpurityKind::BlackCarbon, load: Load::MassFraction(3e-7) },
                Impurity { kind: ImpurityKind::SnowAlgae, load: Load::CellsPerKilogram(1e7) },
            ],
            enhancement: 1.253_5,
            exposure_stops: -14.75 * length,
        };
        let kept = Kept {
            ice_paths: Some(layout),
            light_layers: 2,
            shadow_catcher: true,
            learnt_light: true,
        };
        let mut tile = FilmTile::keeping(crop, kept).unwrap();
        let layers = [[0.5, -0.25, 1e9], [0.25, 0.0, -3.0]];
        tile.add_light_layers(0, 1, [0.75, -0.25, 999_999_997.0], &layers).unwrap();
        tile.add_caught_light(1, 1, [0.5; 3], [0.25, 1.0, -1e-3]).unwrap();
        tile.add_learnt_light(0, 0, 0.5, 1e-3).unwrap();
        tile.add_ice_path(1, 0, length, &[[0.5, 0.25, -0.1], [40.0, 0.0, 3.0]]).unwrap();
        film.merge_tile(&tile).unwrap();
        film
    }

    #[test]
    fn a_film_of_other_lights_than_its_ice_paths_or_layers_is_refused() {
        let mut film = graded(1.0);
        film.grade.lights.pop();
        let error = read_bytes(&written(&film)).unwrap_err().to_string();
        assert!(error.contains("ice paths"), "{error}");
        let names = LightLayerNames::new(vec!["sky".into()], vec![0]).unwrap();
        let film = self::film(&[1.0]).keeping_light_layers(names).unwrap();
        assert!(film.grade.lights.is_empty());
        let error = read_bytes(&written(&film)).unwrap_err().to_string();
        assert!(error.contains("layers of light"), "{error}");
    }

    fn written(film: &Film) -> Vec<u8> {
        let mut bytes = Vec::new();
        write(&mut bytes, film).unwrap();
        bytes
    }

    fn read_bytes(bytes: &[u8]) -> Result<Film, FormatsError> {
        read(bytes, bytes.len() as u64).map_err(|fault| fault.of(Path::new("a.film")))
    }

    #[test]
    fn grades_of_other_substances_come_back_as_they_were() {
        let spectrum = |values: [f64; 2]| Spectrum::new(vec![380.0, 780.5], values.to_vec());
        let measured = MeasuredSubstance {
            index: spectrum([1.7, 1.0 / 3.0 + 1.0]).unwrap(),
            imaginary: spectrum([0.0, 1e-7]).unwrap(),
            density: None,
        };
        let substances = [Substance::Salt, Substance::Measured(Arc::new(measured))];
        for substance in substances {
            let grade = Grade { absorption: Absorption::Of(substance), ..graded(1.0).grade };
            let text = grade::to_toml(&grade);
            assert_eq!(grade::from_toml(text.as_bytes()).unwrap(), grade);
        }
        let broken =
            grade::to_toml(&graded(1.0).grade).replace("absorption = 1.1", "absorption = \"mud\"");
        assert!(grade::from_toml(broken.as_bytes()).is_err());
    }

    proptest! {
        #[test]
        fn films_come_back_as_they_were(values in prop::collection::vec(0.0..1e9f32, 1..15)) {
            let film = film(&values);
            prop_assert_eq!(read_bytes(&written(&film)).unwrap(), film);
        }

        #[test]
        fn ice_paths_layers_and_grades_come_back_as_they_were(length in 0.0..2000.0f64) {
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
            prop_assert!(read_bytes(&[&MAGIC[..], &[4, 0, 0, 0], &bytes].concat()).is_err());
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
        bytes[8] = 2;
        let error = read_bytes(&bytes).unwrap_err().to_string();
        assert!(error.contains("version 2 of film files is not read"), "{error}");
        bytes[0] = b'X';
        let error = read_bytes(&bytes).unwrap_err().to_string();
        assert!(error.contains("not a film"), "{error}");
    }
}
