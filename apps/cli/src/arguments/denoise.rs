//! The denoiser as typed.

use clap::Args;
use std::path::PathBuf;

/// Whether and how noise is removed.
#[derive(Clone, Debug, Args)]
pub(crate) struct DenoiseArguments {
    /// Removes noise from .png and .exr files with Intel Open Image Denoise 2, which must be installed;
    /// pleasant, but a guess: never for measurements
    #[arg(long)]
    pub(crate) denoise: bool,

    /// The library of Open Image Denoise, or the folder that holds it [default: SNOWGRAIN_OIDN, else where
    /// the system looks]
    #[arg(long, value_name = "PATH", requires = "denoise")]
    pub(crate) denoise_library: Option<PathBuf>,
}
