//! `snowgrain optics`.

mod albedo;
mod brdf;
mod cases;
mod colour;
mod phase;
pub(super) mod plot;
mod profile;
mod snow;
mod spread;
mod swatches;
mod table;
mod wet;

use crate::arguments::{OpticsArguments, OpticsKind};
use crate::failure::Failure;

pub(super) fn run(arguments: &OpticsArguments) -> Result<u8, Failure> {
    match &arguments.kind {
        OpticsKind::Albedo(arguments) => albedo::run(arguments),
        OpticsKind::Brdf(arguments) => brdf::run(arguments),
        OpticsKind::Colour(arguments) => colour::run(arguments),
        OpticsKind::Phase(arguments) => phase::run(arguments),
        OpticsKind::Profile(arguments) => profile::run(arguments),
        OpticsKind::Spread(arguments) => spread::run(arguments),
        OpticsKind::Wet(arguments) => wet::run(arguments),
    }
}
