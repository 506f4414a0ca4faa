//! OpenEXR: scene-linear layers in 32-bit floats.
//!
//! One part, channels named as [`Layer::name`] says (the format demands alphabetical order in the
//! file), ZIP compression, chromaticities of the primaries, and where known the attributes
//! `samplesPerPixel`, `seed`, `sceneHash`, `exposureStops` and `software` (name and version). Colours that a
//! denoiser made have `denoised` = 1.
//!
//! Spectral layers are channels `S0.550,0nm` beside the colours, which are their preview, as Fichet,
//! Pacanowski and Wilkie say ("An OpenEXR Layout for Spectral Images", JCGT 10(3), 2021), with the
//! attributes `spectralLayoutVersion` and `emissiveUnits`.
//!
//! The light of each group of lights is in channels `Groups.<name>.R`, `.G` and `.B`, that of glints in
//! `Glints.R`, `.G` and `.B`; together they add up to R, G and B where no shadow catcher is seen. What shadow
//! catchers show is in `ShadowCatcher.lit.R` and so on, what they would show alone in
//! `ShadowCatcher.unoccluded.R` and so on.

mod channels;

use super::{check_size, picture_fault};
use crate::atomic;
use crate::error::{Fault, FormatsError};
use channels::{
    COMPONENTS, light_channel, light_layers, light_prefix, spectral_name, spectral_wavelength,
};
use exr::image::write::WritableImage;
use exr::image::{AnyChannel, AnyChannels, Encoding, FlatSamples, Image, Layer as Part};
use exr::math::Vec2;
use exr::meta::MetaData;
use exr::meta::attribute::{
    AttributeValue, Chromaticities, Compression, IntegerBounds, LineOrder, Text,
};
use exr::meta::header::{Header, ImageAttributes, LayerAttributes};
use exr::prelude::{ReadChannels, ReadLayers};
use snowgrain_film::{Layer, LearntLight, Picture, PixelRect, Provenance, SpectralLayer};
use snowgrain_optics::Primaries;
use std::io::{Cursor, Write};
use std::path::Path;

/// First bytes of an EXR file.
pub(crate) const MAGIC: &[u8] = &[0x76, 0x2f, 0x31, 0x01];

const SAMPLES_PER_PIXEL: &str = "samplesPerPixel";
const EXPOSURE: &str = "exposureStops";
const SEED: &str = "seed";
const SCENE_HASH: &str = "sceneHash";
const DENOISED: &str = "denoised";

/// Writes all layers of a picture. The same picture gives the same bytes.
///
/// # Errors
/// [`FormatsError::BadOutput`] for a picture without layers; what [`atomic::write`] refuses.
pub fn write_exr(path: &Path, picture: &Picture) -> Result<(), FormatsError> {
    let bytes = encode(picture).map_err(|error| FormatsError::BadOutput {
        path: path.to_path_buf(),
        what: format!("the picture cannot be stored: {error}"),
        mend: "give it at least one layer and fewer than 2^30 pixels a side".into(),
    })?;
    atomic::write(path, |writer| writer.write_all(&bytes))
}

fn encode(picture: &Picture) -> exr::error::Result<Vec<u8>> {
    let window = picture.window();
    let channel =
        |name: &str, values: &[f32]| AnyChannel::new(name, FlatSamples::F32(values.to_vec()));
    let layers = picture.layers().map(|(layer, values)| channel(layer.name(), values));
    let spectral = picture
        .spectrum
        .iter()
        .map(|layer| channel(&spectral_name(layer.wavelength_nm), &layer.values));
    let light = picture.light_layers.iter().flat_map(|layer| {
        let prefix = light_prefix(&layer.name);
        let values = COMPONENTS.into_iter().zip(&layer.values);
        values.map(move |(component, values)| channel(&format!("{prefix}.{component}"), values))
    });
    let shadows = picture.shadow_layers.iter().flat_map(|layer| {
        let values = COMPONENTS.into_iter().zip(&layer.values);
        values.map(|(component, values)| {
            channel(&format!("ShadowCatcher.{}.{component}", layer.name), values)
        })
    });
    let learnt = |name: &str, value: fn(&LearntLight) -> f64| {
        let values: Vec<f32> = picture.learnt.iter().map(|of| value(of) as f32).collect();
        (!values.is_empty()).then(|| channel(name, &values))
    };
    let learnt_light = learnt("Learnt.light", |of| of.light);
    let learnt_error = learnt("Learnt.error", |of| of.error);
    let channels = layers
        .chain(spectral)
        .chain(light)
        .chain(shadows)
        .chain(learnt_light)
        .chain(learnt_error)
        .collect();
    let position = Vec2(window.x0.cast_signed(), window.y0.cast_signed());
    let mut attributes = LayerAttributes { layer_position: position, ..Default::default() };
    attributes.software_name = Some(Text::from(concat!("Snowgrain ", env!("CARGO_PKG_VERSION"))));
    attributes.vertical_field_of_view = picture.vertical_fov_degrees.map(|degrees| degrees as f32);
    if let Some(provenance) = &picture.provenance {
        attributes.other.extend(described(provenance));
    }
    if picture.exposure_stops != 0.0 {
        let stops = AttributeValue::F64(picture.exposure_stops);
        attributes.other.insert(Text::from(EXPOSURE), stops);
    }
    if picture.denoised {
        attributes.other.insert(Text::from(DENOISED), AttributeValue::I32(1));
    }
    if !picture.spectrum.is_empty() {
        let texts = [("spectralLayoutVersion", "1.0"), ("emissiveUnits", "W.m^-2.sr^-1")];
        let texts = texts.map(|(name, text)| (Text::from(name), AttributeValue::Text(text.into())));
        attributes.other.extend(texts);
    }
    let part = Part::new(
        (window.width() as usize, window.height() as usize),
        attributes,
        Encoding {
            compression: Compression::ZIP16,
            blocks: exr::image::Blocks::ScanLines,
            line_order: LineOrder::Increasing,
        },
        AnyChannels::sort(channels),
    );
    let size = (picture.width() as usize, picture.height() as usize);
    let mut image = Image::new(
        ImageAttributes::new(IntegerBounds::from_dimensions(size)),
        vec![part].into_iter().collect::<exr::image::Layers<_>>(),
    );
    image.attributes.chromaticities = Some(chromaticities(picture.primaries));
    let mut bytes = Vec::new();
    image.write().non_parallel().to_buffered(Cursor::new(&mut bytes))?;
    Ok(with_sorted_attributes(bytes))
}

fn chromaticities(primaries: Primaries) -> Chromaticities {
    let [red, green, blue, white] =
        primaries.chromaticities().map(|[x, y]| Vec2(x as f32, y as f32));
    Chromaticities { red, green, blue, white }
}

/// The primaries of these chromaticities, to the third digit; where there are none, those that the
/// format says (Rec. 709).
fn primaries(written: Option<Chromaticities>) -> Result<Primaries, Fault> {
    let Some(written) = written else { return Ok(Primaries::Srgb) };
    let coordinates = |c: Chromaticities| [c.red, c.green, c.blue, c.white];
    let near = |a: Vec2<f32>, b: Vec2<f32>| (a.0 - b.0).abs().max((a.1 - b.1).abs()) < 1e-3;
    let found = Primaries::ALL.into_iter().find(|&known| {
        let known = coordinates(chromaticities(known));
        coordinates(written).into_iter().zip(known).all(|(a, b)| near(a, b))
    });
    found.ok_or_else(|| {
        let what = format!("its primaries are not known (chromaticities {written:?})");
        Fault::whole(what, "convert it to those of sRGB or ACEScg")
    })
}

fn described(provenance: &Provenance) -> [(Text, AttributeValue); 3] {
    let samples = i32::try_from(provenance.samples_per_pixel).unwrap_or(i32::MAX);
    let hash: String = provenance.scene_hash.iter().map(|byte| format!("{byte:02x}")).collect();
    let seed = provenance.seed.to_string();
    [
        (Text::from(SAMPLES_PER_PIXEL), AttributeValue::I32(samples)),
        (Text::from(SEED), AttributeValue::Text(Text::from(seed.as_str()))),
        (Text::from(SCENE_HASH), AttributeValue::Text(Text::from(hash.as_str()))),
    ]
}

/// The file with the attributes of its header in the order of their names: the `exr` crate keeps
/// its own ones in a hash map, whose order differs from run to run.
fn with_sorted_attributes(mut file: Vec<u8>) -> Vec<u8> {
    const FIRST: usize = 8; // magic number and version
    let mut attributes = Vec::new();
    let mut at = FIRST;
    while let Some(length) = attribute_length(&file[at..]) {
        attributes.push(file[at..at + length].to_vec());
        at += length;
    }
    attributes.sort();
    file[FIRST..at].copy_from_slice(&attributes.concat());
    file
}

/// Bytes of the attribute at the start of `bytes` (name, type, size, value); `None` at the end of
/// the header.
fn attribute_length(bytes: &[u8]) -> Option<usize> {
    let name = bytes.iter().position(|&b| b == 0).filter(|&length| length > 0)? + 1;
    let kind = bytes[name..].iter().position(|&b| b == 0)? + 1;
    let size = bytes.get(name + kind..name + kind + 4)?;
    let size = u32::from_le_bytes([size[0], size[1], size[2], size[3]]);
    Some(name + kind + 4 + size as usize)
}

/// The layers that Snowgrain knows of the first part that has any channels.
pub(super) fn decode(bytes: &[u8]) -> Result<Picture, Fault> {
    let fault = |error: exr::error::Error| {
        Fault::whole(format!("not a valid EXR file: {error}"), "make the picture again")
    };
    let headers = MetaData::read_from_buffered(bytes, false).map_err(fault)?.headers;
    headers.iter().try_for_each(|header| check_header(header, bytes.len()))?;
    let image = exr::prelude::read()
        .no_deep_data()
        .largest_resolution_level()
        .all_channels()
        .first_valid_layer()
        .all_attributes()
        .non_parallel()
        .from_buffered(Cursor::new(bytes))
        .map_err(fault)?;
    let part = &image.layer_data;
    let mut picture = empty_picture(&image.attributes, &part.attributes, part.size)?;
    let mut light = Vec::new();
    for channel in &part.channel_data.list {
        let name = channel.name.to_string();
        if let Some(layer) = Layer::from_name(&name) {
            let values = channel.sample_data.values_as_f32().collect();
            picture.set_layer(layer, values).map_err(|error| picture_fault(&error))?;
        } else if let Some(wavelength_nm) = spectral_wavelength(&name) {
            let values = channel.sample_data.values_as_f32().collect();
            picture.spectrum.push(SpectralLayer { wavelength_nm, values });
        } else if let Some((layer, component)) = light_channel(&name) {
            let values = channel.sample_data.values_as_f32().collect();
            light.push((layer.to_owned(), component, values));
        }
    }
    picture.light_layers = light_layers(light);
    picture.vertical_fov_degrees = part.attributes.vertical_field_of_view.map(f64::from);
    picture.spectrum.sort_by(|a, b| a.wavelength_nm.total_cmp(&b.wavelength_nm));
    picture.primaries = primaries(image.attributes.chromaticities)?;
    picture.exposure_stops = exposure(&part.attributes);
    picture.provenance = provenance(&part.attributes);
    let denoised = part.attributes.other.get(&Text::from(DENOISED));
    picture.denoised = matches!(denoised, Some(AttributeValue::I32(value)) if *value != 0);
    Ok(picture)
}

/// The colours of the first part that is not deep and has R, G and B of the primaries of sRGB: pixels
/// across and down, and linear sRGB from the top. `check_size` is asked before memory is taken.
pub(crate) fn decode_colours(
    bytes: &[u8],
    check_size: &dyn Fn(usize, usize) -> Result<(), Fault>,
) -> Result<(usize, usize, Vec<[f32; 3]>), Fault> {
    let fault = |error: exr::error::Error| {
        Fault::whole(format!("not a valid EXR file: {error}"), "make the picture again")
    };
    let headers = MetaData::read_from_buffered(bytes, false).map_err(fault)?.headers;
    let Some(index) = headers.iter().position(|header| missing(header).is_none()) else {
        let missing = |(index, header): (usize, &Header)| {
            missing(header).map(|missing| format!("part {index} {missing}"))
        };
        let missing: Vec<_> = headers.iter().enumerate().filter_map(missing).collect();
        let mend = "write its colours as channels R, G and B of a part of flat pixels";
        return Err(Fault::whole(missing.join(", "), mend));
    };
    let size = headers[index].layer_size;
    check_size(size.width(), size.height())?;
    headers.iter().try_for_each(|header| check_header(header, bytes.len()))?;
    if primaries(headers[index].shared_attributes.chromaticities)? != Primaries::Srgb {
        return Err(Fault::whole("its primaries are not those of sRGB", "convert it to sRGB"));
    }
    let image = exr::prelude::read()
        .no_deep_data()
        .largest_resolution_level()
        .all_channels()
        .all_layers()
        .all_attributes()
        .non_parallel()
        .from_buffered(Cursor::new(bytes))
        .map_err(fault)?;
    // Deep parts are left out by the reader.
    let flat = headers[..index].iter().filter(|header| !header.deep).count();
    let channels = image.layer_data.get(flat).map(|part| &part.channel_data.list);
    let values = |name: &str| {
        let mut of_name = channels.into_iter().flatten().filter(|channel| channel.name == *name);
        of_name.next().map(|channel| channel.sample_data.values_as_f32())
    };
    let (Some(red), Some(green), Some(blue)) = (values("R"), values("G"), values("B")) else {
        return Err(Fault::whole("its colours cannot be found", "make the picture again"));
    };
    let pixels = red.zip(green).zip(blue).map(|((red, green), blue)| [red, green, blue]);
    Ok((size.width(), size.height(), pixels.collect()))
}

/// What a part lacks to be a picture in colours.
fn missing(header: &Header) -> Option<String> {
    if header.deep {
        return Some("is deep".into());
    }
    let names: Vec<String> = header.channels.list.iter().map(|c| c.name.to_string()).collect();
    let has = |wanted: &str| names.iter().any(|name| name == wanted);
    let colours = has("R") && has("G") && has("B");
    (!colours).then(|| format!("has the channels {}, not R, G and B", names.join(", ")))
}

/// Refuses claims that the file cannot hold: pixels, and chunks of at least a table entry (8
/// bytes) and a head (8 bytes) each.
fn check_header(header: &Header, file_bytes: usize) -> Result<(), Fault> {
    let pixel_bytes = header.channels.bytes_per_pixel as u64;
    let size = header.layer_size;
    check_size(size.width() as u64, size.height() as u64, pixel_bytes, file_bytes)?;
    if header.chunk_count > file_bytes / 16 {
        let what = format!("the header claims {} blocks of pixels", header.chunk_count);
        return Err(Fault::whole(what, "the file is cut off or damaged: make it again"));
    }
    Ok(())
}

/// The picture of the display window, of which the data window is known; of the data window alone
/// where that leaves the display window.
fn empty_picture(
    image: &ImageAttributes,
    part: &LayerAttributes,
    size: Vec2<usize>,
) -> Result<Picture, Fault> {
    let unsigned = |x: i64| u32::try_from(x).ok();
    let side = |x: usize| u32::try_from(x).unwrap_or(u32::MAX);
    let (across, down) = (side(size.width()), side(size.height()));
    let display = image.display_window;
    let x0 = unsigned(i64::from(part.layer_position.x()) - i64::from(display.position.x()));
    let y0 = unsigned(i64::from(part.layer_position.y()) - i64::from(display.position.y()));
    let inside = x0.zip(y0).and_then(|(x0, y0)| {
        let window = PixelRect::new(x0, y0, x0.checked_add(across)?, y0.checked_add(down)?);
        Picture::new(side(display.size.width()), side(display.size.height()), window).ok()
    });
    match inside {
        Some(picture) => Ok(picture),
        None => Picture::new(across, down, PixelRect::new(0, 0, across, down))
            .map_err(|error| picture_fault(&error)),
    }
}

fn exposure(attributes: &LayerAttributes) -> f64 {
    match attributes.other.get(&Text::from(EXPOSURE)) {
        Some(AttributeValue::F64(stops)) if stops.is_finite() => *stops,
        _ => 0.0,
    }
}

fn provenance(attributes: &LayerAttributes) -> Option<Provenance> {
    let attribute = |name: &str| attributes.other.get(&Text::from(name));
    let text = |name: &str| match attribute(name) {
        Some(AttributeValue::Text(text)) => Some(text.to_string()),
        _ => None,
    };
    let samples_per_pixel = match attribute(SAMPLES_PER_PIXEL)? {
        AttributeValue::I32(samples) => u64::try_from(*samples).ok()?,
        _ => return None,
    };
    let seed = text(SEED)?.parse().ok()?;
    let hash = text(SCENE_HASH)?;
    let digits = hash.as_bytes();
    if digits.len() != 64 {
        return None;
    }
    let mut scene_hash = [0; 32];
    for (byte, pair) in scene_hash.iter_mut().zip(digits.chunks_exact(2)) {
        *byte = u8::from_str_radix(std::str::from_utf8(pair).ok()?, 16).ok()?;
    }
    Some(Provenance { scene_hash, seed, samples_per_pixel })
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use snowgrain_film::LightLayer;
    use snowgrain_film::light_layers::GLINTS;
    use std::sync::LazyLock;

    /// A file of two blocks that tests damage, made once.
    static ENCODED: LazyLock<Vec<u8>> =
        LazyLock::new(|| encode(&picture_of(PixelRect::new(3, 2, 4, 20))).unwrap());

    /// Channels of learnt light are there where it is known, and do not hinder a reader.
    #[test]
    fn what_was_learnt_has_channels_of_its_own() {
        let has =
            |bytes: &[u8], name: &str| bytes.windows(name.len()).any(|at| at == name.as_bytes());
        let mut picture = picture();
        assert!(!has(&encode(&picture).unwrap(), "Learnt."));
        picture.learnt =
            vec![LearntLight { light: 0.5, error: 1e-3 }; picture.window().area() as usize];
        let bytes = encode(&picture).unwrap();
        assert!(has(&bytes, "Learnt.light") && has(&bytes, "Learnt.error"));
        picture.learnt.clear();
        assert_eq!(decode(&bytes).unwrap(), picture);
    }

    fn picture() -> Picture {
        picture_of(PixelRect::new(3, 2, 13, 42))
    }

    fn picture_of(window: PixelRect) -> Picture {
        let count = window.area() as usize;
        let mut picture = Picture::new(20, 50, window).unwrap();
        for (k, layer) in Layer::ALL.into_iter().enumerate() {
            let value = |i: u64| (i as f32).sqrt() * 1e3 + k as f32;
            picture.set_layer(layer, (0..window.area()).map(value).collect()).unwrap();
        }
        picture.set_layer(Layer::Depth, vec![f32::INFINITY; count]).unwrap();
        picture.spectrum = [400.0, 555.5, 700.0]
            .map(|nm| SpectralLayer { wavelength_nm: nm, values: vec![nm as f32 * 1e-3; count] })
            .to_vec();
        picture.light_layers = ["moon", "sun-and-the-stars-and-x", GLINTS]
            .map(|name| {
                let values = [0.0, 0.5, -1e-3].map(|x| vec![x + name.len() as f32; count]);
                LightLayer { name: name[..name.len().min(22)].into(), values }
            })
            .to_vec();
        picture.vertical_fov_degrees = Some(22.5);
        let hash = std::array::from_fn(|i| i as u8 * 7);
        picture.exposure_stops = -15.25;
        picture.provenance =
            Some(Provenance { scene_hash: hash, seed: u64::MAX, samples_per_pixel: 64 });
        picture
    }

    #[test]
    fn layers_windows_and_provenance_come_back_exactly() {
        assert_eq!(decode(&encode(&picture()).unwrap()).unwrap(), picture());
        let mut denoised = picture();
        denoised.denoised = true;
        assert_eq!(decode(&encode(&denoised).unwrap()).unwrap(), denoised);
    }

    #[test]
    fn primaries_come_back_and_unknown_ones_are_refused() {
        let mut aces = picture();
        aces.primaries = Primaries::AcesCg;
        assert_eq!(decode(&encode(&aces).unwrap()).unwrap(), aces);
        let mut bytes = encode(&picture()).unwrap();
        let name = b"chromaticities\0chromaticities\0\x20\0\0\0";
        let at = bytes.windows(name.len()).position(|w| w == name).unwrap() + name.len();
        bytes[at..][..4].copy_from_slice(&0.9f32.to_le_bytes());
        let error = decode(&bytes).unwrap_err().of(Path::new("a.exr")).to_string();
        assert!(error.contains("primaries") && error.contains("ACEScg"), "{error}");
    }

    #[test]
    fn the_same_picture_gives_the_same_bytes() {
        let first = encode(&picture()).unwrap();
        for _ in 0..20 {
            assert_eq!(encode(&picture()).unwrap(), first); // every hash map has another order
        }
    }

    #[test]
    fn a_picture_of_claimed_size_is_refused_by_arithmetic() {
        let mut bytes = encode(&picture()).unwrap();
        let name = b"dataWindow\0box2i\0\x10\0\0\0";
        let at = bytes.windows(name.len()).position(|w| w == name).unwrap() + name.len();
        for (corner, value) in [0i32, 0, 59_999, 59_999].into_iter().enumerate() {
            bytes[at + 4 * corner..][..4].copy_from_slice(&value.to_le_bytes());
        }
        let mut end = 8;
        while let Some(length) = attribute_length(&bytes[end..]) {
            end += length;
        }
        bytes.truncate(end + 50);
        let error = decode(&bytes).unwrap_err().of(Path::new("a.exr")).to_string();
        assert!(error.starts_with("a.exr: the picture claims 60000x60000 pixels"), "{error}");
    }

    proptest! {
        #[test]
        fn damaged_files_are_read_or_refused(
            changes in prop::collection::vec((any::<prop::sample::Index>(), any::<u8>()), 1..6),
            in_header in any::<bool>(),
            cut in any::<prop::sample::Index>(),
        ) {
            let mut bytes = ENCODED.clone();
            let reach = if in_header { 1000 } else { bytes.len() };
            for (at, value) in changes {
                bytes[at.index(reach)] = value;
            }
            let _ = decode(&bytes);
            let _ = decode(&bytes[..cut.index(bytes.len())]);
        }

        #[test]
        fn any_bytes_are_read_or_refused(bytes in prop::collection::vec(any::<u8>(), 0..300)) {
            let _ = decode(&bytes);
            let _ = decode(&[MAGIC, &[2, 0, 0, 0], &bytes].concat());
        }
    }
}
