//! What can go wrong on a film.

use crate::{PixelRect, SampleFault};
use thiserror::Error;

/// Why a film, tile or picture is refused.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum FilmError {
    /// A sample holds a value that no light has; the renderer is at fault.
    #[error("pixel ({x}, {y}) was given {fault}")]
    BadSample {
        /// Column of the pixel.
        x: u32,
        /// Row of the pixel.
        y: u32,
        /// What was wrong.
        fault: SampleFault,
    },
    /// A sum leaves the range of its integer.
    #[error("the sums of pixel ({x}, {y}) leave their range; use fewer samples or dimmer lights")]
    Overflow {
        /// Column of the pixel.
        x: u32,
        /// Row of the pixel.
        y: u32,
    },
    /// A pixel is not part of the tile.
    #[error("pixel ({x}, {y}) lies outside the tile {rect}")]
    OutsideTile {
        /// Column of the pixel.
        x: u32,
        /// Row of the pixel.
        y: u32,
        /// The tile.
        rect: PixelRect,
    },
    /// A tile is not part of the film.
    #[error("the tile {tile} does not lie inside the crop {crop} of the film")]
    TileOutsideFilm {
        /// The tile.
        tile: PixelRect,
        /// The crop of the film.
        crop: PixelRect,
    },
    /// A crop holds no pixel, or pixels outside the picture.
    #[error(
        "the crop {crop} holds no pixel or leaves the picture of {width}x{height} pixels; \
         give x0,y0,x1,y1 with x0 < x1 <= {width} and y0 < y1 <= {height}"
    )]
    BadCrop {
        /// The crop.
        crop: PixelRect,
        /// Pixels across.
        width: u32,
        /// Pixels down.
        height: u32,
    },
    /// There is not that much memory.
    #[error("{pixels} pixels need {bytes} bytes, more than there is; make the picture smaller")]
    TooLarge {
        /// Number of pixels.
        pixels: u64,
        /// Bytes they need.
        bytes: u128,
    },
    /// A range of samples holds none.
    #[error("the sample range {start}..{end} is empty")]
    EmptySampleRange {
        /// First sample.
        start: u64,
        /// Sample after the last.
        end: u64,
    },
    /// Samples would be counted twice.
    #[error("samples {start}..{end} are in the film already; merge films of different samples")]
    SamplesTwice {
        /// First such sample.
        start: u64,
        /// Sample after the last of them.
        end: u64,
    },
    /// Counts of samples by block do not fit the film.
    #[error(
        "{counts} counts of samples for {blocks} blocks and a relative error of {relative_error} mean \
         nothing: each block needs a count from 1 up, and the error must be above 0"
    )]
    BadBlockCounts {
        /// Counts given.
        counts: usize,
        /// Blocks of the crop.
        blocks: u64,
        /// The relative error they were chosen for.
        relative_error: f64,
    },
    /// Two films are not of one picture.
    #[error("the films differ in {what} ({ours} and {theirs}), so they cannot be merged")]
    FilmsDiffer {
        /// What differs.
        what: &'static str,
        /// Of the film merged into.
        ours: String,
        /// Of the other film.
        theirs: String,
    },
    /// There is nothing to put together.
    #[error("there is no film to put together")]
    NoFilms,
    /// Films of crops that share pixels.
    #[error(
        "the crops {ours} and {theirs} overlap; films of one crop are merged, others must lie apart"
    )]
    CropsOverlap {
        /// A crop.
        ours: PixelRect,
        /// Another.
        theirs: PixelRect,
    },
    /// Crops that do not fill a rectangle.
    #[error("the crops leave {pixels} pixels of {whole} open; render those, too")]
    CropsLeaveGaps {
        /// The rectangle around all crops.
        whole: PixelRect,
        /// Pixels in no crop.
        pixels: u64,
    },
    /// Crops of a film with a noise target.
    #[error("films with a noise target can be merged but not put together from crops")]
    CropsWithCounts,
    /// A layer does not have one value per pixel.
    #[error("layer {layer} has {values} values for {pixels} pixels")]
    LayerSize {
        /// Name of the layer.
        layer: &'static str,
        /// Its values.
        values: usize,
        /// Pixels of the picture.
        pixels: u64,
    },
    /// A picture has no colour.
    #[error("the picture has no {layer} layer; give a picture with the layers R, G and B")]
    NoColour {
        /// Name of the missing layer.
        layer: &'static str,
    },
    /// Two pictures do not cover the same pixels.
    #[error(
        "the pictures cover different pixels ({ours} and {theirs}); \
         compare pictures of the same size and crop"
    )]
    PicturesDiffer {
        /// Pixels of the first.
        ours: PixelRect,
        /// Pixels of the second.
        theirs: PixelRect,
    },
    /// A film was not told to keep light by its length in ice.
    #[error(
        "the film keeps no ice paths, without which ice and impurities cannot be changed; render it \
         with --keep ice-paths"
    )]
    NoIcePaths,
    /// A film was not told to keep the light of groups of lights apart.
    #[error(
        "the film does not keep the light of its groups of lights apart, without which they cannot be \
         mixed; render it with --keep light-groups"
    )]
    NoLightLayers,
    /// A film with shadow catchers, whose light is to be changed.
    #[error(
        "the film has shadow catchers, whose shadows hold for the lights and the ice that it was \
         rendered with; change those in the scene and render it again"
    )]
    ShadowCatcherIsFixed,
    /// A group of lights that a film does not have.
    #[error("the film has no group of lights {name}; it has {known}")]
    UnknownLightLayer {
        /// The name.
        name: String,
        /// Those that it has.
        known: String,
    },
    /// Glare of the eye needs angles.
    #[error("the field of view of the picture is not known, without which the eye has no glare")]
    NoFieldOfView,
    /// Layers of light that a film cannot have.
    #[error("these layers of light cannot be kept: {what}")]
    BadLightLayers {
        /// What is wrong.
        what: String,
    },
    /// The layers of a sample's light are not all of it; the renderer is at fault.
    #[error("the layers of a sample of pixel ({x}, {y}) do not add up to its radiance")]
    LayersNotTheWhole {
        /// Column of the pixel.
        x: u32,
        /// Row of the pixel.
        y: u32,
    },
    /// Two pictures that are compared have other primaries.
    #[error(
        "the pictures have different primaries ({ours} and {theirs}); render both with the same \
         film.primaries"
    )]
    PrimariesDiffer {
        /// Primaries of the first.
        ours: &'static str,
        /// Primaries of the second.
        theirs: &'static str,
    },
}
