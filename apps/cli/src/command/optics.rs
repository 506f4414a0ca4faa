//! `snowgrain optics`.

mod albedo;
mod table;

use crate::arguments::{OpticsArguments, OpticsKind};
use crate::failure::Failure;

pub(super) fn run(arguments: &OpticsArguments) -> Result<u8, Failure> {
    match &arguments.kind {
        OpticsKind::Albedo(arguments) => albedo::run(arguments),
    }
}
