//! Tasks of the project: `cargo xtask validate`.

mod figure;
mod program;
mod report;
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
}

fn main() -> anyhow::Result<ExitCode> {
    let Task::Validate(options) = Arguments::parse().task;
    let passed = validate::validate(&options)?;
    Ok(if passed { ExitCode::SUCCESS } else { ExitCode::FAILURE })
}
