//! Kills and faults of the disk at a chosen step of the writing of a file: for tests alone.
//!
//! The variable `SNOWGRAIN_FAULT` of the environment says `EXTENSION-STEP=OUTCOME`, as `film-rename=kill`, and
//! `film-write:100000=enospc@3` of the third film that the process writes. Without it a file costs a few comparisons.
//!
//! | step | when |
//! |---|---|
//! | `create` | the temporary file is made and locked, and empty |
//! | `write:BYTES` | so many bytes are in it and more are to come |
//! | `sync` | all bytes are in it, before they are flushed to the disk |
//! | `rename` | they are flushed, before it gets its name |
//! | `sync-folder` | it has its name, before its folder is flushed |
//! | `end` | all is done |
//!
//! | outcome | what happens |
//! |---|---|
//! | `kill` | the process kills itself (SIGKILL; where there is none it aborts) |
//! | `hold` | the thread waits until the process is ended from outside |
//! | `enospc` | the step fails as on a full disk |
//! | `eio` | the step fails as on a broken disk |

use std::io;
use std::path::Path;
use std::sync::LazyLock;
use std::sync::atomic::{AtomicU64, Ordering};

const VARIABLE: &str = "SNOWGRAIN_FAULT";

/// A step of the writing of a file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Step {
    Create,
    Write { bytes: u64 },
    Sync,
    Rename,
    SyncFolder,
    End,
}

/// What happens there.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Outcome {
    Kill,
    Hold,
    NoSpace,
    BrokenDisk,
}

/// What the variable asks for.
#[derive(Debug, PartialEq, Eq)]
struct Fault {
    extension: String,
    step: Step,
    outcome: Outcome,
    /// Which of the files of that extension, counted from 1.
    nth: u64,
}

/// The variable, read once.
static ASKED: LazyLock<Result<Option<Fault>, String>> = LazyLock::new(|| {
    let Some(text) = std::env::var_os(VARIABLE) else { return Ok(None) };
    let text = text.to_string_lossy();
    let mend = "write EXTENSION-STEP=OUTCOME, as film-rename=kill, or unset it";
    parse(&text).map(Some).ok_or_else(|| format!("{VARIABLE}={text} is not a fault; {mend}"))
});

/// Files of the extension so far.
static FILES: AtomicU64 = AtomicU64::new(0);

fn parse(text: &str) -> Option<Fault> {
    let (place, outcome) = text.split_once('=')?;
    let (extension, step) = place.split_once('-')?;
    let (outcome, nth) = outcome.split_once('@').unwrap_or((outcome, "1"));
    let step = match step.split_once(':') {
        Some(("write", bytes)) => Step::Write { bytes: bytes.parse().ok()? },
        Some(_) => return None,
        None => match step {
            "create" => Step::Create,
            "sync" => Step::Sync,
            "rename" => Step::Rename,
            "sync-folder" => Step::SyncFolder,
            "end" => Step::End,
            _ => return None,
        },
    };
    let outcome = match outcome {
        "kill" => Outcome::Kill,
        "hold" => Outcome::Hold,
        "enospc" => Outcome::NoSpace,
        "eio" => Outcome::BrokenDisk,
        _ => return None,
    };
    let nth = nth.parse().ok().filter(|&nth| nth > 0)?;
    Some(Fault { extension: extension.to_owned(), step, outcome, nth })
}

/// Whether the variable can be understood, where it is set.
pub(crate) fn check() -> Result<(), &'static str> {
    ASKED.as_ref().map(drop).map_err(String::as_str)
}

/// What was asked for the writing of one file.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Injection(Option<&'static Fault>);

impl Injection {
    /// Of the file that is to be written now.
    pub(crate) fn of(path: &Path) -> Self {
        let asked = ASKED.as_ref().ok().and_then(Option::as_ref);
        let of_kind = asked.filter(|fault| {
            path.extension().is_some_and(|extension| *extension == *fault.extension)
        });
        Self(of_kind.filter(|fault| FILES.fetch_add(1, Ordering::SeqCst) + 1 == fault.nth))
    }

    /// Tells that a step is reached.
    ///
    /// # Errors
    /// The fault that was asked for.
    pub(crate) fn reach(self, step: Step) -> io::Result<()> {
        match self.0.filter(|fault| fault.step == step) {
            Some(fault) => fault.outcome.happen(),
            None => Ok(()),
        }
    }

    /// How many bytes may be written before the next step, where `written` are.
    pub(crate) fn room(self, written: u64) -> Option<u64> {
        match self.0?.step {
            Step::Write { bytes } => bytes.checked_sub(written).filter(|&room| room > 0),
            _ => None,
        }
    }
}

impl Outcome {
    fn happen(self) -> io::Result<()> {
        match self {
            Self::Kill => kill(),
            Self::Hold => loop {
                std::thread::park();
            },
            Self::NoSpace => Err(io::ErrorKind::StorageFull.into()),
            Self::BrokenDisk => Err(io::Error::other("input/output error")),
        }
    }
}

#[cfg(unix)]
fn kill() -> ! {
    use rustix::process::{Signal, getpid, kill_process};
    // No process is forbidden to kill itself; and if one were, it would still end here.
    let _ = kill_process(getpid(), Signal::KILL);
    std::process::abort()
}

#[cfg(not(unix))]
fn kill() -> ! {
    std::process::abort()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn faults_are_read_and_anything_else_is_none() {
        let fault = |extension: &str, step, outcome, nth| {
            Some(Fault { extension: extension.to_owned(), step, outcome, nth })
        };
        for (text, expected) in [
            ("film-rename=kill", fault("film", Step::Rename, Outcome::Kill, 1)),
            ("png-sync-folder=eio@2", fault("png", Step::SyncFolder, Outcome::BrokenDisk, 2)),
            (
                "film-write:70=enospc@3",
                fault("film", Step::Write { bytes: 70 }, Outcome::NoSpace, 3),
            ),
            ("exr-create=hold", fault("exr", Step::Create, Outcome::Hold, 1)),
        ] {
            assert_eq!(parse(text), expected, "{text}");
        }
        for text in ["", "film", "film-write=kill", "film-sync:3=kill", "film-sync=die"] {
            assert_eq!(parse(text), None, "{text}");
        }
        for text in ["film-sync=kill@0", "film-sync=kill@x", "film-write:-1=eio", "sync=kill"] {
            assert_eq!(parse(text), None, "{text}");
        }
    }
}
