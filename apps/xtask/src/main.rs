//! Tasks of the project: `cargo xtask validate` and `cargo xtask look`.

mod figure;
mod look;
mod program;
mod report;
mod sections;
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
}

fn main() -> anyhow::Result<ExitCode> {
    let passed = match Arguments::parse().task {
        Task::Validate(options) => validate::validate(&options)?,
        Task::Look(options) => look::look(&options)?,
    };
    Ok(if passed { ExitCode::SUCCESS } else { ExitCode::FAILURE })
}
