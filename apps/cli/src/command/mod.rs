//! The commands.

mod render;
mod scenes;
mod schema;

use crate::arguments::Command;
use crate::failure::Failure;

/// Does what was asked; gives the exit code.
pub(crate) fn run(command: &Command) -> Result<u8, Failure> {
    match command {
        Command::Render(arguments) => render::run(arguments),
        Command::Scenes(arguments) => scenes::run(arguments),
        Command::Schema => schema::run(),
    }
}
