//! `snowgrain merge` as typed.

use super::{DisplayArguments, PictureFile, values};
use clap::Args;
use std::ops::Range;
use std::path::PathBuf;

/// Adds films of the same render: of other samples (`render --samples`) or of other crops.
///
/// The result has the same bytes in whatever order films are given, and those of a film that was rendered at
/// once. Films of another scene, seed or size, samples that are in two films, and damaged files are refused.
#[derive(Debug, Args)]
#[command(after_help = "Examples:\n  \
    snowgrain merge parts/*.film -o whole.film -o whole.exr\n  \
    snowgrain merge parts/*.film --require 0..1024 -o whole.film\n\n\
    Exit code 75: samples are missing (they are listed), or another run is at work on a film that is to be written;\n\
    nothing is written. A film of the same render is only replaced by a sum that holds all of its samples.")]
pub(crate) struct MergeArguments {
    /// The films
    #[arg(required = true, value_name = "FILM")]
    pub(crate) films: Vec<PathBuf>,

    /// Where the sum goes, several times if wanted: .film, .exr or .png
    #[arg(short, long, value_name = "FILE", required = true)]
    pub(crate) output: Vec<PictureFile>,

    /// Samples that must all be there, as 0..1024 [default: no gaps between the first and the last]
    #[arg(long, value_name = "A..B", value_parser = values::samples)]
    pub(crate) require: Option<Range<u64>>,

    /// Writes what there is although samples are missing
    #[arg(long)]
    pub(crate) allow_missing: bool,

    #[command(flatten)]
    pub(crate) display: DisplayArguments,
}
