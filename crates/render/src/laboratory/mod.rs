//! The snow laboratory: what layers of snow do to light at each wavelength, exactly or by theory.
//!
//! Layers are flat and endless. A path carries its length in ice instead of a colour, so that one set
//! of paths serves all wavelengths and loads of impurities (white Monte Carlo); the refractive index,
//! which bends paths, is taken at a few nodes between which results are interpolated.

mod albedo;
mod batches;
mod brdf;
mod broadband;
mod colour;
mod grains;
mod kernel;
mod lengths;
mod nodes;
mod passed;
mod profile;
mod progress;
mod scatterers;
mod scattering;
mod snow;
mod spread;
mod wet;

pub use albedo::{
    Albedo, AlbedoSettings, Theory, grain_albedo, homogeneous_albedo, theoretical_albedo,
};
pub use brdf::{BrdfSettings, View, homogeneous_brdf, kokhanovsky_breon_brdf};
pub use broadband::{Band, broadband, broadband_wavelengths_nm};
pub use colour::{colour_wavelengths_nm, colours};
pub use grains::{GrainLayer, Pack};
pub(crate) use passed::{Passed, passed};
pub use profile::{Flux, flux_profile};
pub use progress::Tell;
pub use scatterers::{Scatterers, ScatteringMix};
pub(crate) use scattering::scattered;
pub use scattering::{Scattering, scattering, scattering_of_mix};
pub use snow::{Incidence, SnowLayer, SnowStack};
pub use snowgrain_accel::homogeneous::MOST_LAYERS;
pub use snowgrain_optics::sphere::Polarisation;
pub use spread::{FaceSpread, Spread, SpreadBin, SpreadSettings, grain_spread, homogeneous_spread};
pub use wet::{WetAlbedo, WetLayer, WetSettings};
