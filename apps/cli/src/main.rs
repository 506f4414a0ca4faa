//! The snowgrain command line: see `snowgrain --help`.

mod arguments;
mod budget;
mod command;
mod disk;
mod failure;
mod load;
mod output;
mod process;
mod progress;
mod signals;
mod summary;
mod threads;
mod viewer;

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
    signals::survive_file_size_limit();
    match catching_panics(|| command::run(&arguments.command)) {
        Ok(code) => ExitCode::from(code),
        Err(failure) => {
            output::tell(&failure.to_string());
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_panic_on_any_thread_becomes_a_failure_that_asks_for_a_report() {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(2).build().unwrap();
        let ended = catching_panics(|| pool.install(|| panic!("it broke\nhere")));
        drop(panic::take_hook());
        let failure = ended.unwrap_err();
        assert_eq!(failure.code, 70);
        let line = failure.to_string();
        for part in ["it broke here", "main.rs", "report", env!("CARGO_PKG_VERSION")] {
            assert!(line.contains(part), "{line}");
        }
        assert_eq!(line.lines().count(), 1);
        assert_eq!(catching_panics(|| Ok(3)).unwrap(), 3);
        drop(panic::take_hook());
    }
}
