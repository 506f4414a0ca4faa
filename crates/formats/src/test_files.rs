//! Files that the tests of several readers need.

use crate::FormatsError;
use exr::math::Vec2;
use exr::prelude::{Image, SpecificChannels, WritableImage};
use std::io::Cursor;

/// An OpenEXR picture of these colours.
pub(crate) fn openexr(
    size: (usize, usize),
    colour: impl Fn(Vec2<usize>) -> [f32; 3] + Sync,
) -> Vec<u8> {
    let channels = SpecificChannels::rgb(|at: Vec2<usize>| <(f32, f32, f32)>::from(colour(at)));
    let mut bytes = Vec::new();
    let image = Image::from_channels(size, channels);
    image.write().non_parallel().to_buffered(Cursor::new(&mut bytes)).unwrap();
    bytes
}

/// What is said of input that is refused.
pub(crate) fn refusal<T: std::fmt::Debug>(result: Result<T, FormatsError>) -> String {
    let error = result.unwrap_err();
    assert_eq!(error.exit_code(), 65, "{error}");
    error.to_string()
}
