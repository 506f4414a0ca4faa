//! The commands.

mod compare;
mod denoise;
mod deposit;
mod develop;
mod job;
mod measure;
mod merge;
mod optics;
mod pictures;
mod render;
mod scenes;
mod schema;

use crate::arguments::Command;
use crate::failure::Failure;

/// Does what was asked; gives the exit code.
pub(crate) fn run(command: &Command) -> Result<u8, Failure> {
    match command {
        Command::Render(arguments) => render::run(arguments),
        Command::Deposit(arguments) => deposit::run(arguments),
        Command::Develop(arguments) => develop::run(arguments),
        Command::Job(arguments) => job::run(arguments),
        Command::Merge(arguments) => merge::run(arguments),
        Command::Scenes(arguments) => scenes::run(arguments),
        Command::Compare(arguments) => compare::run(arguments),
        Command::Measure(arguments) => measure::run(arguments),
        Command::Optics(arguments) => optics::run(arguments),
        Command::Schema => schema::run(),
    }
}
