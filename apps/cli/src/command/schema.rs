//! `snowgrain schema`.

use crate::failure::Failure;
use crate::output;

pub(super) fn run() -> Result<u8, Failure> {
    output::print(&snowgrain_formats::scene::schema())?;
    Ok(0)
}
