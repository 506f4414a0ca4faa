//! The mean colour of an image.

use image::{DynamicImage, ImageFormat, ImageReader, Limits};
use snowgrain_film::develop::linear_from_srgb;
use std::io::Cursor;

/// Largest edge of an image, pixels, and most memory that decoding may take, bytes.
const LARGEST_EDGE: u32 = 16_384;
const MOST_BYTES: u64 = 1 << 30;

/// The mean of a PNG image of sRGB, linear; `None` for another format or a damaged image.
pub(super) fn mean_colour(bytes: &[u8]) -> Option<[f32; 3]> {
    let mut reader = ImageReader::with_format(Cursor::new(bytes), ImageFormat::Png);
    let mut limits = Limits::default();
    limits.max_image_width = Some(LARGEST_EDGE);
    limits.max_image_height = Some(LARGEST_EDGE);
    limits.max_alloc = Some(MOST_BYTES);
    reader.limits(limits);
    let image: DynamicImage = reader.decode().ok()?;
    let pixels = image.to_rgb8();
    // Counted by value: exact, and a power for each value alone.
    let mut counts = [[0u64; 256]; 3];
    for pixel in pixels.pixels() {
        counts.iter_mut().zip(pixel.0).for_each(|(count, value)| count[usize::from(value)] += 1);
    }
    let total = u64::from(pixels.width()) * u64::from(pixels.height());
    let mean = |count: &[u64; 256]| {
        let weigh = |(value, &n): (usize, &u64)| n as f64 * linear_from_srgb(value as f64 / 255.0);
        count.iter().enumerate().map(weigh).sum::<f64>() / total as f64
    };
    (total > 0).then(|| counts.each_ref().map(|count| mean(count) as f32))
}
