//! The snowgrain command line: see `snowgrain --help`.

mod arguments;
mod budget;
mod command;
mod failure;
mod load;
mod output;
mod process;
mod progress;
mod signals;
mod summary;
mod threads;

use clap::Parser;
use failure::{Failure, exit};
use std::panic;
use std::process::ExitCode;
use std::sync::{Arc, Mutex};

fn main() -> ExitCode {
    let arguments = match arguments::Arguments::try_parse() {
        Ok(arguments) => arguments,
        Err(error) => return arguments::answer(&error),
    };
    match catching_panics(|| command::run(&arguments.command)) {
        Ok(code) => ExitCode::from(code),
        Err(failure) => {
            eprintln!("{failure}");
            ExitCode::from(failure.code)
        }
    }
}

/// Runs `work`; a panic in it, on whatever thread, becomes a failure of one line that asks for a
/// report.
fn catching_panics(work: impl FnOnce() -> Result<u8, Failure>) -> Result<u8, Failure> {
    let first: Arc<Mutex<Option<String>>> = Arc::default();
    let seen = Arc::clone(&first);
    panic::set_hook(Box::new(move |info| {
        if let Ok(mut seen) = seen.lock() {
            seen.get_or_insert_with(|| info.to_string());
        }
    }));
    panic::catch_unwind(panic::AssertUnwindSafe(work)).unwrap_or_else(|_| {
        let what = first.lock().ok().and_then(|mut seen| seen.take()).unwrap_or_default();
        Err(Failure::new(
            exit::BUG,
            format!(
                "a fault of the program ({what}); please report it with this command line, the \
                 scene, and Snowgrain's version, {}",
                env!("CARGO_PKG_VERSION")
            ),
        ))
    })
}
