//! Maps of the radiance of all directions, from Radiance (.hdr) and OpenEXR pictures.

use crate::error::{Fault, FormatsError, room};
use crate::image::exr;
use crate::input;
use image::ImageDecoder;
use image::codecs::hdr::HdrDecoder;
use snowgrain_render::RenderError;
use snowgrain_render::light::{EnvironmentMap, check_map_size};
use std::io::Cursor;
use std::path::Path;

/// First bytes of a Radiance picture.
pub(crate) const RADIANCE_MAGIC: &[u8] = b"#?";

/// Bytes of which a Radiance picture makes a pixel at the least: four in runs of up to 127.
const PIXELS_PER_RUN: u64 = 127;

/// Reads an equirectangular picture: Radiance with colours of RGB, or the first part of an OpenEXR file that
/// has R, G and B and is not deep, of the primaries of sRGB. The exposure that a Radiance picture notes is
/// not undone.
///
/// # Errors
/// A missing or unreadable file, another format, damaged content, claimed sizes that the file cannot hold;
/// a picture that is not twice as wide as high; a pixel that is negative, infinite or not a number, by its
/// place.
pub fn load_environment(path: &Path) -> Result<EnvironmentMap, FormatsError> {
    decode(&input::read_whole(path)?).map_err(|fault| fault.of(path))
}

fn decode(bytes: &[u8]) -> Result<EnvironmentMap, Fault> {
    let (width, height, pixels) = if bytes.starts_with(exr::MAGIC) {
        exr::decode_colours(bytes, &|width, height| check_map_size(width, height).map_err(fault))?
    } else if bytes.starts_with(RADIANCE_MAGIC) {
        decode_radiance(bytes, &|width, height| check_map_size(width, height).map_err(fault))?
    } else {
        let what = "this is not a map that Snowgrain reads";
        return Err(Fault::whole(what, "give a Radiance (.hdr) or an OpenEXR (.exr) picture"));
    };
    EnvironmentMap::new(width, height, pixels).map_err(fault)
}

fn fault(error: RenderError) -> Fault {
    let mend = match error {
        RenderError::MapValue { .. } => "mend the pixel",
        _ => "give an equirectangular picture, or scale it down",
    };
    Fault::whole(error.to_string(), mend)
}

/// Pixels across and down, and linear values from the top; `check_size` is asked before memory is taken.
pub(crate) fn decode_radiance(
    bytes: &[u8],
    check_size: &dyn Fn(usize, usize) -> Result<(), Fault>,
) -> Result<(usize, usize, Vec<[f32; 3]>), Fault> {
    let invalid = |error: image::ImageError| {
        Fault::whole(format!("not a valid Radiance picture: {error}"), "make the picture again")
    };
    let decoder = HdrDecoder::new_nonstrict(Cursor::new(bytes)).map_err(invalid)?;
    let (width, height) = decoder.dimensions();
    check_size(width as usize, height as usize)?;
    let (claimed, file) = (u64::from(width) * u64::from(height), bytes.len() as u64);
    if claimed > file.saturating_mul(PIXELS_PER_RUN) {
        let what = format!(
            "the picture claims {width}x{height} pixels, which a file of {file} bytes does not hold"
        );
        return Err(Fault::whole(what, "the file is damaged: make it again"));
    }
    let count = width as usize * height as usize;
    let mut pixels: Vec<[f32; 3]> = room(count, "pixels")?;
    pixels.resize(count, [0.0; 3]);
    decoder.read_image(bytemuck::cast_slice_mut(&mut pixels)).map_err(invalid)?;
    Ok((width as usize, height as usize, pixels))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::test_files;
    use ::exr::prelude::*;
    use proptest::prelude::*;
    use snowgrain_math::DVec3;

    /// A Radiance picture of 8 x 4 pixels without runs: rows of 1, 2, 3, 4.
    fn radiance() -> Vec<u8> {
        let mut bytes = b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 4 +X 8\n".to_vec();
        for row in 1..=4u8 {
            bytes.extend([row * 16, row * 8, 0, 132].repeat(8)); // 16 / 256 * 2^4 = 1
        }
        bytes
    }

    /// A picture whose red is `value`.
    fn openexr(width: usize, height: usize, value: impl Fn(Vec2<usize>) -> f32 + Sync) -> Vec<u8> {
        test_files::openexr((width, height), |at| [value(at), 0.5, 0.25])
    }

    fn refusal(bytes: &[u8]) -> String {
        test_files::refusal(decode(bytes).map_err(|fault| fault.of(Path::new("a.map"))))
    }

    #[test]
    fn both_formats_give_their_pixels_from_the_top() {
        let map = decode(&radiance()).unwrap();
        assert_eq!((map.width(), map.height()), (8, 4));
        assert_eq!(map.pixels()[0], [1.0, 0.5, 0.0]);
        assert_eq!(map.radiance(DVec3::NEG_Y), [4.0, 2.0, 0.0]);
        let map = decode(&openexr(8, 4, |at| at.1 as f32)).unwrap();
        assert_eq!(map.pixels()[8], [1.0, 0.5, 0.25]);
    }

    #[test]
    fn pixels_that_are_no_radiance_are_named() {
        for (value, name) in [(f32::NAN, "NaN"), (-2.0, "-2"), (f32::INFINITY, "inf")] {
            let bytes = openexr(8, 4, |at| if at == Vec2(5, 2) { value } else { 1.0 });
            let message = refusal(&bytes);
            let expected = format!("a.map: pixel (5, 2) of the map holds {name};");
            assert!(message.starts_with(&expected), "{message}");
        }
    }

    #[test]
    fn sizes_that_are_no_map_or_cannot_be_held_are_refused_before_memory_is_taken() {
        assert!(refusal(&openexr(8, 8, |_| 1.0)).contains("8x8 pixels; a map"));
        let square = b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 60000 +X 60000\n";
        assert!(refusal(square).contains("60000x60000"));
        let wide = b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 8192 +X 16384\n\x02\x02\x40\x00";
        assert!(refusal(wide).contains("which a file of"), "{}", refusal(wide));
        let mut bytes = openexr(8, 4, |_| 1.0);
        let name = b"dataWindow\0box2i\0\x10\0\0\0";
        let at = bytes.windows(name.len()).position(|w| w == name).unwrap() + name.len();
        for (corner, value) in [0i32, 0, 59_999, 59_999].into_iter().enumerate() {
            bytes[at + 4 * corner..][..4].copy_from_slice(&value.to_le_bytes());
        }
        bytes.truncate(395);
        assert!(refusal(&bytes).contains("60000x60000"), "{}", refusal(&bytes));
    }

    #[test]
    fn files_that_hold_no_colours_say_so() {
        let channels =
            SpecificChannels::build().with_channel("Y").with_pixel_fn(|_: Vec2<usize>| (1.0f32,));
        let mut bytes = Vec::new();
        let image = Image::from_channels((8, 4), channels);
        image.write().non_parallel().to_buffered(Cursor::new(&mut bytes)).unwrap();
        let message = refusal(&bytes);
        assert!(message.contains("part 0 has the channels Y, not R, G and B"), "{message}");
        assert!(refusal(b"hello").contains("not a map that Snowgrain reads"));
        let xyz = b"#?RADIANCE\nFORMAT=32-bit_rle_xyze\n\n-Y 4 +X 8\n";
        assert!(refusal(xyz).contains("not a valid Radiance picture"), "{}", refusal(xyz));
    }

    proptest! {
        #[test]
        fn damaged_files_are_read_or_refused(
            changes in prop::collection::vec((any::<prop::sample::Index>(), any::<u8>()), 1..6),
            cut in any::<prop::sample::Index>(),
            is_exr in any::<bool>(),
        ) {
            let mut bytes = if is_exr { openexr(8, 4, |at| at.0 as f32) } else { radiance() };
            for (at, value) in changes {
                let at = at.index(bytes.len());
                bytes[at] = value;
            }
            let _ = decode(&bytes);
            let _ = decode(&bytes[..cut.index(bytes.len())]);
        }
    }
}
