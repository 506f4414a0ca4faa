//! The mean colour of an image.

use image::{DynamicImage, ImageDecoder, ImageFormat, ImageReader, Limits};
use snowgrain_film::develop::linear_from_srgb;
use std::io::Cursor;
use zune_core::bytestream::ZCursor;
use zune_core::colorspace::ColorSpace;
use zune_core::options::DecoderOptions;
use zune_jpeg::JpegDecoder;

/// Largest edge of an image, pixels, and most memory that decoding may take, bytes.
const LARGEST_EDGE: u32 = 16_384;
const MOST_BYTES: u64 = 1 << 30;

/// Most pixels that a byte of a file can stand for: eight of one bit, as often as deflate repeats one
/// (1032 times); JPEG files hold fewer.
const MOST_PIXELS_A_BYTE: u64 = 8 * 1032;

/// The mean of a PNG or JPEG image of sRGB, linear; `None` for another format or a damaged image.
pub(super) fn mean_colour(bytes: &[u8]) -> Option<[f32; 3]> {
    let pixels = if bytes.starts_with(&[0xff, 0xd8]) { jpeg(bytes)? } else { png(bytes)? };
    // Counted by value: exact, and a power for each value alone.
    let mut counts = [[0u64; 256]; 3];
    for pixel in pixels.chunks_exact(3) {
        counts.iter_mut().zip(pixel).for_each(|(count, &value)| count[usize::from(value)] += 1);
    }
    let total = pixels.len() as u64 / 3;
    let mean = |count: &[u64; 256]| {
        let weigh = |(value, &n): (usize, &u64)| n as f64 * linear_from_srgb(value as f64 / 255.0);
        count.iter().enumerate().map(weigh).sum::<f64>() / total as f64
    };
    (total > 0).then(|| counts.each_ref().map(|count| mean(count) as f32))
}

/// R, G, B of all pixels.
fn png(bytes: &[u8]) -> Option<Vec<u8>> {
    let mut reader = ImageReader::with_format(Cursor::new(bytes), ImageFormat::Png);
    let mut limits = Limits::default();
    limits.max_image_width = Some(LARGEST_EDGE);
    limits.max_image_height = Some(LARGEST_EDGE);
    limits.max_alloc = Some(MOST_BYTES);
    reader.limits(limits);
    let decoder = reader.into_decoder().ok()?;
    is_plausible(decoder.dimensions(), bytes).then_some(())?;
    Some(DynamicImage::from_decoder(decoder).ok()?.to_rgb8().into_raw())
}

/// R, G, B of all pixels, by plain arithmetic: what instructions a machine has must not show.
fn jpeg(bytes: &[u8]) -> Option<Vec<u8>> {
    let options = DecoderOptions::default()
        .set_use_unsafe(false)
        .set_max_width(LARGEST_EDGE as usize)
        .set_max_height(LARGEST_EDGE as usize)
        .jpeg_set_out_colorspace(ColorSpace::RGB);
    let mut decoder = JpegDecoder::new_with_options(ZCursor::new(bytes), options);
    decoder.decode_headers().ok()?;
    let info = decoder.info()?;
    is_plausible((info.width.into(), info.height.into()), bytes).then_some(())?;
    decoder.decode().ok()
}

/// Whether a file of these bytes can hold an image of this size.
fn is_plausible((width, height): (u32, u32), bytes: &[u8]) -> bool {
    let pixels = u64::from(width) * u64::from(height);
    pixels <= bytes.len() as u64 * MOST_PIXELS_A_BYTE && pixels * 4 <= MOST_BYTES
}
