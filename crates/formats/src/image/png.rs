//! PNG: 8 or 16 bits per channel, sRGB.

use super::{LARGEST_SIDE, check_size, picture_fault};
use crate::atomic;
use crate::error::{Fault, FormatsError, room};
use image::codecs::png::{PngDecoder, PngEncoder};
use image::{ColorType, DynamicImage, ExtendedColorType, ImageDecoder, ImageEncoder, Limits};
use snowgrain_film::develop::{Developed, linear_from_srgb};
use snowgrain_film::{Layer, Picture, PixelRect};
use std::io::{self, Cursor, Write};
use std::path::Path;

/// First bytes of a PNG file.
pub(super) const SIGNATURE: &[u8] = b"\x89PNG\r\n\x1a\n";

/// Writes 8 bits per channel; a crop becomes a picture of its own size.
///
/// # Errors
/// What [`atomic::write`] refuses.
pub fn write_png_8(path: &Path, developed: &Developed<u8>) -> Result<(), FormatsError> {
    atomic::write(path, |writer| {
        encode(writer, &developed.values, developed.window, ExtendedColorType::Rgb8)
    })
}

/// Writes 16 bits per channel; a crop becomes a picture of its own size.
///
/// # Errors
/// What [`atomic::write`] refuses.
pub fn write_png_16(path: &Path, developed: &Developed<u16>) -> Result<(), FormatsError> {
    atomic::write(path, |writer| {
        let bytes = bytemuck::cast_slice(&developed.values);
        encode(writer, bytes, developed.window, ExtendedColorType::Rgb16)
    })
}

/// `bytes` in the byte order of the machine.
fn encode(
    writer: &mut impl Write,
    bytes: &[u8],
    window: PixelRect,
    colour: ExtendedColorType,
) -> io::Result<()> {
    PngEncoder::new(writer).write_image(bytes, window.width(), window.height(), colour).map_err(
        |error| match error {
            image::ImageError::IoError(error) => error,
            error => io::Error::other(error),
        },
    )
}

/// The linear picture; alpha, where there is one, becomes the layer A.
pub(super) fn decode(bytes: &[u8]) -> Result<Picture, Fault> {
    let fault = |error: image::ImageError| {
        Fault::whole(format!("not a valid PNG file: {error}"), "make the picture again")
    };
    let mut limits = Limits::no_limits();
    limits.max_image_width = Some(LARGEST_SIDE);
    limits.max_image_height = Some(LARGEST_SIDE);
    let decoder = PngDecoder::with_limits(Cursor::new(bytes), limits).map_err(fault)?;
    let (width, height) = decoder.dimensions();
    let colour = decoder.color_type();
    let pixel_bytes = u64::from(colour.bytes_per_pixel());
    check_size(width.into(), height.into(), pixel_bytes, bytes.len())?;
    let image = DynamicImage::from_decoder(decoder).map_err(fault)?;
    let mut picture = Picture::new(width, height, PixelRect::new(0, 0, width, height))
        .map_err(|error| picture_fault(&error))?;
    let is_8_bit =
        matches!(colour, ColorType::L8 | ColorType::La8 | ColorType::Rgb8 | ColorType::Rgba8);
    let largest = if is_8_bit { 255.0 } else { 65_535.0 };
    let linear = |value: u16| {
        let value = if is_8_bit { value / 257 } else { value }; // 16-bit values of 8-bit ones are 257 times as large
        linear_from_srgb(f64::from(value) / largest) as f32
    };
    let pixels = image.into_rgba16();
    let count = pixels.len() / 4;
    for (channel, layer) in Layer::COLOUR.into_iter().enumerate() {
        let mut values = room(count, "pixels")?;
        values.extend(pixels.pixels().map(|pixel| linear(pixel.0[channel])));
        picture.set_layer(layer, values).map_err(|error| picture_fault(&error))?;
    }
    if colour.has_alpha() {
        let mut values = room(count, "pixels")?;
        values.extend(pixels.pixels().map(|pixel| f32::from(pixel.0[3]) / 65_535.0));
        picture.set_layer(Layer::A, values).map_err(|error| picture_fault(&error))?;
    }
    Ok(picture)
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;
    use snowgrain_film::develop::{self, Development};
    use std::sync::LazyLock;

    /// A picture that tests damage, made once.
    static ENCODED: LazyLock<Vec<u8>> = LazyLock::new(encoded);

    const WINDOW: PixelRect = PixelRect::new(2, 1, 5, 3);

    fn encoded() -> Vec<u8> {
        let values: Vec<u8> = (0..18).map(|i| i * 15).collect();
        let mut bytes = Vec::new();
        encode(&mut bytes, &values, WINDOW, ExtendedColorType::Rgb8).unwrap();
        bytes
    }

    #[test]
    fn eight_and_sixteen_bits_come_back() {
        let picture = decode(&encoded()).unwrap();
        assert_eq!((picture.width(), picture.height()), (3, 2));
        let developed = develop::to_8_bit(&picture, &Development::default()).unwrap();
        assert_eq!(developed.values, (0..18).map(|i| i * 15).collect::<Vec<u8>>());

        let values: Vec<u16> = (0..18).map(|i| i * 3_777).collect();
        let mut bytes = Vec::new();
        let raw = bytemuck::cast_slice(&values);
        encode(&mut bytes, raw, WINDOW, ExtendedColorType::Rgb16).unwrap();
        let developed =
            develop::to_16_bit(&decode(&bytes).unwrap(), &Development::default()).unwrap();
        assert_eq!(developed.values, values);
    }

    #[test]
    fn a_picture_of_claimed_size_is_refused_by_arithmetic() {
        let mut bytes = encoded();
        bytes[16..24].copy_from_slice(&[0, 0, 0xea, 0x60, 0, 0, 0xea, 0x60]); // 60000 x 60000
        let checksum = crc32(&bytes[12..29]).to_be_bytes();
        bytes[29..33].copy_from_slice(&checksum);
        let error = decode(&bytes).unwrap_err().of(Path::new("a.png")).to_string();
        assert!(error.starts_with("a.png: the picture claims 60000x60000 pixels"), "{error}");
    }

    /// The checksum of PNG chunks (ISO 3309), bit by bit.
    fn crc32(bytes: &[u8]) -> u32 {
        !bytes.iter().fold(!0, |crc, &byte| {
            (0..8).fold(crc ^ u32::from(byte), |c, _| (c >> 1) ^ (0xedb8_8320 * (c & 1)))
        })
    }

    /// Mends the checksums of all chunks that are whole, so that what was damaged gets past them.
    fn mend_checksums(bytes: &mut [u8]) {
        let mut at = SIGNATURE.len();
        while let Some(&length) = bytes.get(at..).and_then(<[u8]>::first_chunk) {
            let end = at.saturating_add(8).saturating_add(u32::from_be_bytes(length) as usize);
            let Some(content) = bytes.get(at + 4..end) else { return };
            let checksum = crc32(content).to_be_bytes();
            let Some(written) = bytes.get_mut(end..end + 4) else { return };
            written.copy_from_slice(&checksum);
            at = end + 4;
        }
    }

    #[test]
    fn mended_checksums_are_those_of_the_format() {
        let mut bytes = ENCODED.clone();
        bytes[29] ^= 1; // the checksum of the header
        decode(&bytes).unwrap_err();
        mend_checksums(&mut bytes);
        assert_eq!(bytes, *ENCODED);
    }

    proptest! {
        #[test]
        fn damaged_files_are_read_or_refused(
            changes in prop::collection::vec((any::<prop::sample::Index>(), any::<u8>()), 1..6),
            is_mended in any::<bool>(),
            cut in any::<prop::sample::Index>(),
        ) {
            let mut bytes = ENCODED.clone();
            for (at, value) in changes {
                let at = at.index(bytes.len());
                bytes[at] = value;
            }
            if is_mended {
                mend_checksums(&mut bytes);
            }
            let _ = decode(&bytes);
            let _ = decode(&bytes[..cut.index(bytes.len())]);
        }

        #[test]
        fn any_bytes_are_read_or_refused(bytes in prop::collection::vec(any::<u8>(), 0..300)) {
            let _ = decode(&bytes);
            let _ = decode(&[SIGNATURE, &bytes].concat());
        }
    }
}
