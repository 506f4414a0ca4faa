//! Exact accumulation of samples, the layers they develop into, and the comparison of pictures.
//!
//! A [`Film`] adds samples as integers, so sums are associative: tiles, threads and separately
//! rendered sample ranges merge in any order to the same bytes (contract 2 of `ARCHITECTURE.md`).
//! A [`Picture`] is the film read off as `f32` layers; [`develop`] turns it into display values and
//! [`compare`] says how far two pictures are apart.
//!
//! ```
//! use snowgrain_film::{Film, FilmIdentity, FilmTile, Layer, Picture, PixelRect, Sample};
//! let whole = PixelRect::new(0, 0, 2, 1);
//! let mut film = Film::new(2, 1, whole, FilmIdentity { scene_hash: [0; 32], seed: 7 })?;
//! let mut tile = FilmTile::new(whole)?;
//! for x in 0..2 {
//!     tile.add(x, 0, &Sample { radiance: [1.0, 0.5, 0.25], alpha: 1.0, ..Sample::default() })?;
//! }
//! film.merge_tile(&tile)?;
//! film.record_samples(0..1)?;
//! let picture = Picture::from_film(&film)?;
//! assert_eq!(picture.layer(Layer::G), Some(&[0.5, 0.5][..]));
//! # Ok::<(), snowgrain_film::FilmError>(())
//! ```

mod assemble;
pub mod compare;
pub mod develop;
mod error;
mod exact;
mod film;
pub mod ice_paths;
pub mod learnt_light;
pub mod light_layers;
mod mix;
pub mod noise;
mod picture;
mod pixel;
mod rect;
mod regrade;
mod sample;
mod sample_ranges;
pub mod shadow_catcher;
mod tile;

pub use error::FilmError;
pub use film::{Film, FilmIdentity};
pub use ice_paths::{IcePathLayout, IcePaths};
pub use learnt_light::{LearntLight, LearntSums};
pub use light_layers::{GLINTS, LightLayerNames, LightLayers};
pub use mix::LightMix;
pub use noise::{BlockCounts, BlockNoise};
pub use picture::{Layer, LightLayer, Picture, Provenance};
pub use pixel::{PixelSums, Refusal};
pub use rect::PixelRect;
pub use regrade::{SpectralLayer, spectral_layers};
pub use sample::{LARGEST_GUIDE, Sample, SampleFault};
pub use sample_ranges::SampleRanges;
pub use shadow_catcher::{CaughtLight, ShadowSums};
pub use tile::{FilmTile, FilmTileMut, Kept};
