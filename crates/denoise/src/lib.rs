//! Removes noise from pictures with Intel Open Image Denoise (<https://www.openimagedenoise.org>, version
//! 2), where that is installed.
//!
//! The library is found when it is asked for ([`Denoiser::open`]); nothing is linked or downloaded. What
//! it gives is a guess by a neural network: pleasant to look at, biased, and not the same bits on every
//! machine. It is never part of a measurement, and a denoised picture has no layers of variance.
//!
//! The network is guided by layers of every film: the albedo of what is met first (1 for ice, as little is
//! lost in it, so that snow is a white surface to the network and an object in it is not) and its normal
//! (of the grains as they are rendered, not of the body of snow: where a pixel holds a few grains their
//! relief is kept, where it holds many their normals average to nothing much). Where nothing is met both
//! are 0.

mod error;
mod library;
mod picture;

pub use error::DenoiseError;
pub use library::Denoiser;
