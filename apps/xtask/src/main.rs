//! Tasks of the project: `cargo xtask validate`, `look`, `packings`, `deep`, `roads` and `stress`.

mod deep;
mod figure;
mod look;
mod packings;
mod program;
mod report;
mod roads;
mod sections;
#[cfg(unix)]
mod stress;
mod table;
mod validate;

use clap::{Parser, Subcommand};
use std::process::ExitCode;

/// Tasks of the project.
#[derive(Parser)]
struct Arguments {
    #[command(subcommand)]
    task: Task,
}

#[derive(Subcommand)]
enum Task {
    /// Compares the program with everything that is known, and writes VALIDATION.md and its figures
    Validate(validate::Options),
    /// Measures close pictures of snow against what real snow shows, and writes look.md
    Look(look::Options),
    /// Makes snow of twelve densities, and writes packings.md
    Packings(packings::Options),
    /// Compares light that ends deep in the snow with light that is followed to its end, and writes deep.md
    Deep(deep::Options),
    /// Compares ways in which light may go through snow with light that meets every grain, and writes roads.md
    Roads(roads::Options),
    /// Kills, stops and starves renders, and counts what becomes of them
    #[cfg(unix)]
    Stress(stress::Options),
}

fn main() -> anyhow::Result<ExitCode> {
    let passed = match Arguments::parse().task {
        Task::Validate(options) => validate::validate(&options)?,
        Task::Look(options) => look::look(&options)?,
        Task::Packings(options) => packings::packings(&options)?,
        Task::Deep(options) => deep::deep(&options)?,
        Task::Roads(options) => roads::roads(&options)?,
        #[cfg(unix)]
        Task::Stress(options) => stress::stress(&options)?,
    };
    Ok(if passed { ExitCode::SUCCESS } else { ExitCode::FAILURE })
}
