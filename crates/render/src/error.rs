//! Why a scene cannot be rendered.

use snowgrain_accel::GridError;
use snowgrain_film::FilmError;
use snowgrain_grains::GrainsError;
use snowgrain_math::DVec3;
use thiserror::Error;

/// Why a scene cannot be rendered.
#[derive(Debug, Error)]
pub enum RenderError {
    /// Snow cannot be made.
    #[error("snow.{index}: {source}")]
    Snow {
        /// Which `[[snow]]`, from 0.
        index: usize,
        /// Why.
        source: GrainsError,
    },
    /// A layer of the laboratory cannot be made of grains.
    #[error("{0}")]
    Layer(#[from] GrainsError),
    /// Snow of which no slab can be made, with which what stands for it would be compared.
    #[error(
        "integrator: the proxy is measured on a slab of such snow, but none can be made: {source}; follow light from grain to \
         grain, or use deep = \"learnt\""
    )]
    Calibration {
        /// Why.
        source: GrainsError,
    },
    /// Snow cannot be packed for light.
    #[error("{0}")]
    Grid(#[from] GridError),
    /// A picture that is no map of all directions.
    #[error(
        "the picture has {width}x{height} pixels; a map of all directions is twice as wide as high, and at most {} wide",
        crate::light::LARGEST_MAP
    )]
    MapSize {
        /// Pixels across.
        width: usize,
        /// Pixels down.
        height: usize,
    },
    /// Pixels that do not make the picture.
    #[error("{pixels} pixels do not make a map of {width}x{height}")]
    MapPixels {
        /// Pixels across.
        width: usize,
        /// Pixels down.
        height: usize,
        /// Pixels given.
        pixels: usize,
    },
    /// A pixel that is no radiance.
    #[error("pixel ({x}, {y}) of the map holds {value}; radiances are finite and not negative")]
    MapValue {
        /// Column, from 0.
        x: usize,
        /// Row, from 0.
        y: usize,
        /// The value.
        value: f32,
    },
    /// A picture on an object that is too large, or none.
    #[error(
        "the picture has {width}x{height} pixels; a texture has 1 to {} across and down",
        crate::surface::LARGEST_TEXTURE
    )]
    TextureSize {
        /// Pixels across.
        width: usize,
        /// Pixels down.
        height: usize,
    },
    /// A pixel of a texture that is no number.
    #[error("pixel ({x}, {y}) of the texture is not a number")]
    TextureValue {
        /// Column, from 0.
        x: usize,
        /// Row, from 0.
        y: usize,
    },
    /// The film refused a sample or a size.
    #[error("{0}")]
    Film(#[from] FilmError),
    /// Objects that absorb nothing enclose the light.
    #[error(
        "light seen in pixel ({x}, {y}) is enclosed by objects of albedo 1 and never gets out; give them a lower albedo, or an opening"
    )]
    Enclosed {
        /// Column of the pixel.
        x: u32,
        /// Row of the pixel.
        y: u32,
    },
    /// A camera ray would start in ice.
    #[error(
        "camera: its rays start within grains of snow, near [{}, {}, {}]; move the camera out of the snow, or give it a smaller aperture",
        point.x,
        point.y,
        point.z
    )]
    CameraInIce {
        /// Where, metres.
        point: DVec3,
    },
    /// The scene needs more memory than there is.
    #[error(
        "the scene needs about {needed} of memory and {available} may be used ({limit}); use fewer or larger grains, `integrator.packing = \"compact\"`, a smaller picture, or raise --max-memory"
    )]
    Memory {
        /// Estimated need, formatted.
        needed: String,
        /// Limit, formatted.
        available: String,
        /// Where the limit comes from.
        limit: String,
    },
}
