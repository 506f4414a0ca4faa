//! Pictures that lie on objects, from PNG, JPEG, OpenEXR and Radiance files.

use crate::environment::{RADIANCE_MAGIC, decode_radiance};
use crate::error::{Fault, FormatsError, room};
use crate::image::exr;
use crate::input;
use image::{ColorType, DynamicImage, ImageDecoder, ImageFormat, ImageReader, Limits};
use snowgrain_film::develop::linear_from_srgb;
use snowgrain_render::RenderError;
use snowgrain_render::surface::{LARGEST_TEXTURE, Texture, check_texture_size};
use std::io::Cursor;
use std::path::Path;
use zune_core::bytestream::ZCursor;
use zune_core::colorspace::ColorSpace;
use zune_core::options::DecoderOptions;
use zune_jpeg::JpegDecoder;

/// Most memory that decoding may take, bytes.
const MOST_BYTES: u64 = 1 << 31;

/// How many bytes a byte of deflate can stand for at most.
const DEFLATE: u64 = 1032;

const PNG_MAGIC: &[u8] = b"\x89PNG\r\n\x1a\n";
const JPEG_MAGIC: &[u8] = &[0xff, 0xd8];

/// Reads a picture that lies on objects. PNG and JPEG hold sRGB, whose alpha is left out; OpenEXR and
/// Radiance linear values, which are clamped to [0, 1].
///
/// # Errors
/// A missing or unreadable file, another format, damaged content, claimed sizes that the file cannot hold or
/// that no texture has, a pixel that is not a number.
pub fn load_texture(path: &Path) -> Result<Texture, FormatsError> {
    decode(&input::read_whole(path)?).map_err(|fault| fault.of(path))
}

/// The picture of a file.
pub(crate) fn decode(bytes: &[u8]) -> Result<Texture, Fault> {
    if bytes.starts_with(PNG_MAGIC) {
        png(bytes)
    } else if bytes.starts_with(JPEG_MAGIC) {
        jpeg(bytes)
    } else if bytes.starts_with(exr::MAGIC) {
        let (width, height, pixels) = exr::decode_colours(bytes, &check_size)?;
        Texture::of_floats([width, height], pixels).map_err(fault)
    } else if bytes.starts_with(RADIANCE_MAGIC) {
        let (width, height, pixels) = decode_radiance(bytes, &check_size)?;
        Texture::of_floats([width, height], pixels).map_err(fault)
    } else {
        let what = "this is not a picture that Snowgrain puts on objects";
        Err(Fault::whole(what, "give a PNG, JPEG, OpenEXR (.exr) or Radiance (.hdr) file"))
    }
}

/// Of a picture whose numbers are no colours, the mean of each channel, 0 to 1.
pub(crate) fn mean_of_numbers(bytes: &[u8]) -> Option<[f32; 3]> {
    let numbers = if bytes.starts_with(JPEG_MAGIC) {
        decode_jpeg(bytes).ok()?.1
    } else {
        decode_png(bytes).ok()?.to_rgb8().into_raw()
    };
    let mut sums = [0u64; 3];
    for pixel in numbers.chunks_exact(3) {
        sums.iter_mut().zip(pixel).for_each(|(sum, &value)| *sum += u64::from(value));
    }
    let count = numbers.len() / 3;
    (count > 0).then(|| sums.map(|sum| (sum as f64 / (255.0 * count as f64)) as f32))
}

fn png(bytes: &[u8]) -> Result<Texture, Fault> {
    let image = decode_png(bytes)?;
    let size = [image.width() as usize, image.height() as usize];
    let deep = matches!(
        image.color(),
        ColorType::L16 | ColorType::La16 | ColorType::Rgb16 | ColorType::Rgba16
    );
    if !deep {
        return Texture::of_bytes(size, in_threes(image.into_rgb8().into_raw())?).map_err(fault);
    }
    let values = image.into_rgb16().into_raw();
    let mut pixels = room(values.len() / 3, "pixels")?;
    let linear = |value: u16| linear_from_srgb(f64::from(value) / 65_535.0) as f32;
    pixels.extend(values.chunks_exact(3).map(|p| [p[0], p[1], p[2]].map(linear)));
    Texture::of_floats(size, pixels).map_err(fault)
}

fn decode_png(bytes: &[u8]) -> Result<DynamicImage, Fault> {
    let invalid = |error: image::ImageError| {
        Fault::whole(format!("not a valid PNG file: {error}"), "make the picture again")
    };
    let mut reader = ImageReader::with_format(Cursor::new(bytes), ImageFormat::Png);
    let mut limits = Limits::default();
    limits.max_image_width = Some(LARGEST_TEXTURE as u32);
    limits.max_image_height = Some(LARGEST_TEXTURE as u32);
    limits.max_alloc = Some(MOST_BYTES);
    reader.limits(limits);
    let decoder = reader.into_decoder().map_err(invalid)?;
    let (width, height) = decoder.dimensions();
    check_plausible([width as usize, height as usize], bytes)?;
    let pixels = u64::from(width) * u64::from(height);
    check_held([width as usize, height as usize], pixels * bits_a_pixel(bytes) / 8, bytes)?;
    // What the decoder takes must be there: it cannot be told that it is not.
    let count = usize::try_from(decoder.total_bytes()).unwrap_or(usize::MAX);
    drop(room::<u8>(count, "bytes of a picture")?);
    DynamicImage::from_decoder(decoder).map_err(invalid)
}

/// Bits of a pixel of a PNG file, before they are compressed.
fn bits_a_pixel(bytes: &[u8]) -> u64 {
    let (depth, kind) = (bytes.get(24).copied(), bytes.get(25).copied());
    let channels = match kind {
        Some(2) => 3,
        Some(4) => 2,
        Some(6) => 4,
        _ => 1,
    };
    u64::from(depth.unwrap_or(1)) * channels
}

fn jpeg(bytes: &[u8]) -> Result<Texture, Fault> {
    let (size, values) = decode_jpeg(bytes)?;
    Texture::of_bytes(size, in_threes(values)?).map_err(fault)
}

/// Pixels across and down, and R, G, B of all, by plain arithmetic: what instructions a machine has must
/// not show.
fn decode_jpeg(bytes: &[u8]) -> Result<([usize; 2], Vec<u8>), Fault> {
    let invalid = |error: &dyn std::fmt::Display| {
        Fault::whole(format!("not a valid JPEG file: {error}"), "make the picture again")
    };
    let options = DecoderOptions::default()
        .set_use_unsafe(false)
        .set_max_width(LARGEST_TEXTURE)
        .set_max_height(LARGEST_TEXTURE)
        .jpeg_set_out_colorspace(ColorSpace::RGB);
    let mut decoder = JpegDecoder::new_with_options(ZCursor::new(bytes), options);
    decoder.decode_headers().map_err(|error| invalid(&error))?;
    let info = decoder.info().ok_or_else(|| invalid(&"it has no size"))?;
    let size = [usize::from(info.width), usize::from(info.height)];
    check_plausible(size, bytes)?;
    Ok((size, decoder.decode().map_err(|error| invalid(&error))?))
}

fn in_threes(values: Vec<u8>) -> Result<Vec<[u8; 3]>, Fault> {
    bytemuck::try_cast_vec(values)
        .map_err(|_| Fault::whole("its pixels are not of three values", "make the picture again"))
}

/// Refuses sizes that no texture has, or that a file of these bytes cannot hold.
fn check_plausible([width, height]: [usize; 2], bytes: &[u8]) -> Result<(), Fault> {
    check_size(width, height)?;
    // Eight pixels of one bit in a byte; JPEG files hold fewer.
    check_held([width, height], width as u64 * height as u64 / 8, bytes)
}

/// Refuses a picture that takes so many bytes before they are compressed, more than a file can hold.
fn check_held([width, height]: [usize; 2], plain: u64, bytes: &[u8]) -> Result<(), Fault> {
    if plain <= bytes.len() as u64 * DEFLATE {
        return Ok(());
    }
    let what = format!(
        "the picture claims {width}x{height} pixels, which a file of {} bytes does not hold",
        bytes.len()
    );
    Err(Fault::whole(what, "the file is damaged: make it again"))
}

fn check_size(width: usize, height: usize) -> Result<(), Fault> {
    check_texture_size(width, height).map_err(fault)
}

fn fault(error: RenderError) -> Fault {
    let mend = match error {
        RenderError::TextureValue { .. } => "mend the pixel",
        _ => "scale the picture down",
    };
    Fault::whole(error.to_string(), mend)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_files;
    use image::{ExtendedColorType, ImageEncoder};
    use proptest::prelude::*;

    fn encoded(pixels: &[u8], size: [u32; 2], colour: ExtendedColorType) -> Vec<u8> {
        let mut bytes = Vec::new();
        let encoder = image::codecs::png::PngEncoder::new(&mut bytes);
        encoder.write_image(pixels, size[0], size[1], colour).unwrap();
        bytes
    }

    fn openexr(red: f32) -> Vec<u8> {
        test_files::openexr((2, 1), |_| [red, 0.5, 2.0])
    }

    fn refusal(bytes: &[u8]) -> String {
        test_files::refusal(decode(bytes).map_err(|fault| fault.of(Path::new("bark.png"))))
    }

    #[test]
    fn colours_are_linear_whatever_the_format() {
        let eight = encoded(&[188, 0, 255, 188, 0, 255], [2, 1], ExtendedColorType::Rgb8);
        let [r, g, b] = decode(&eight).unwrap().at([0.3, 0.5]);
        assert!((r - 0.5029).abs() < 1e-4 && g == 0.0 && b == 1.0, "{r} {g} {b}");
        let half = 48_059u16.to_ne_bytes(); // .7333 of sRGB
        let sixteen = encoded(&half, [1, 1], ExtendedColorType::L16);
        let grey = decode(&sixteen).unwrap().at([0.0; 2]);
        assert!(grey.iter().all(|c| (c - 0.4969).abs() < 1e-3), "{grey:?}");
        assert_eq!(decode(&openexr(0.25)).unwrap().at([0.9; 2]), [0.25, 0.5, 1.0]);
        assert_eq!(mean_of_numbers(&eight), Some([188.0 / 255.0, 0.0, 1.0]));
    }

    #[test]
    fn what_is_no_texture_is_refused_before_memory_is_taken() {
        assert!(refusal(b"hello").contains("not a picture that Snowgrain puts on objects"));
        assert!(refusal(&openexr(f32::NAN)).contains("pixel (0, 0) of the texture"));
        let mut huge = encoded(&[0; 3], [1, 1], ExtendedColorType::Rgb8);
        huge[16..24].copy_from_slice(&[0, 0, 0x3f, 0, 0, 0, 0x3f, 0]);
        assert!(refusal(&huge).contains("not a valid PNG") || refusal(&huge).contains("16128"));
        let radiance = b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 60000 +X 60000\n";
        assert!(refusal(radiance).contains("60000x60000"));
    }

    proptest! {
        #[test]
        fn damaged_files_are_read_or_refused(
            changes in prop::collection::vec((any::<prop::sample::Index>(), any::<u8>()), 1..6),
            cut in any::<prop::sample::Index>(),
            is_exr in any::<bool>(),
        ) {
            let png = encoded(&[7; 27], [3, 3], ExtendedColorType::Rgb8);
            let mut bytes = if is_exr { openexr(0.3) } else { png };
            for (at, value) in changes {
                let at = at.index(bytes.len());
                bytes[at] = value;
            }
            let _ = decode(&bytes);
            let _ = decode(&bytes[..cut.index(bytes.len())]);
        }
    }
}
