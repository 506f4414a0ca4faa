//! `snowgrain optics`.

mod albedo;
mod colour;
mod phase;
mod profile;
mod snow;
mod swatches;
mod table;
mod wet;

use crate::arguments::{OpticsArguments, OpticsKind};
use crate::failure::Failure;

pub(super) fn run(arguments: &OpticsArguments) -> Result<u8, Failure> {
    match &arguments.kind {
        OpticsKind::Albedo(arguments) => albedo::run(arguments),
        OpticsKind::Colour(arguments) => colour::run(arguments),
        OpticsKind::Phase(arguments) => phase::run(arguments),
        OpticsKind::Profile(arguments) => profile::run(arguments),
        OpticsKind::Wet(arguments) => wet::run(arguments),
    }
}
