//! What can go wrong between Snowgrain and its files.

use std::fmt;
use std::io;
use std::path::{Path, PathBuf};
use thiserror::Error;

/// Where in a file a fault lies.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Place {
    /// The file as a whole.
    Whole,
    /// A line, counted from 1.
    Line(u64),
    /// A vertex, counted from 0.
    Vertex(u64),
    /// A face, counted from 0.
    Face(u64),
}

impl fmt::Display for Place {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::Whole => Ok(()),
            Self::Line(line) => write!(f, ", line {line}"),
            Self::Vertex(vertex) => write!(f, ", vertex {vertex} (from 0)"),
            Self::Face(face) => write!(f, ", face {face} (from 0)"),
        }
    }
}

/// Why a file cannot be read or written. Every message names the file, the place where there is
/// one, what is wrong and how to mend it.
#[derive(Debug, Error)]
pub enum FormatsError {
    /// There is no such file.
    #[error("{}: there is no such file; check the path", path.display())]
    Missing {
        /// The file.
        path: PathBuf,
    },
    /// The file is there but cannot be opened.
    #[error("{}: cannot be opened ({source}); check its permissions", path.display())]
    Unreadable {
        /// The file.
        path: PathBuf,
        /// The cause.
        source: io::Error,
    },
    /// The content is not what it should be.
    #[error("{}{place}: {what}; {mend}", path.display())]
    BadInput {
        /// The file.
        path: PathBuf,
        /// Where in it.
        place: Place,
        /// What is wrong.
        what: String,
        /// How to mend it.
        mend: String,
    },
    /// The content is right but does not fit into memory.
    #[error("{}: {what} does not fit into memory; use a smaller file or a larger machine", path.display())]
    TooLarge {
        /// The file.
        path: PathBuf,
        /// What does not fit.
        what: String,
    },
    /// What should be written cannot be held by the format.
    #[error("{}: {what}; {mend}", path.display())]
    BadOutput {
        /// The file that was to be written.
        path: PathBuf,
        /// What is wrong.
        what: String,
        /// How to mend it.
        mend: String,
    },
    /// The output file cannot be created.
    #[error("{}: cannot be created: {reason}", path.display())]
    CannotCreate {
        /// The file that was to be written.
        path: PathBuf,
        /// Why, and how to mend it.
        reason: String,
    },
    /// Reading failed half-way.
    #[error("{}: reading failed ({source}); check the disk and try again", path.display())]
    Read {
        /// The file.
        path: PathBuf,
        /// The cause.
        source: io::Error,
    },
    /// Writing failed half-way; the file that was there before is untouched.
    #[error(
        "{}: writing failed ({source}); make room on the disk and try again, the file that was \
         there before is untouched",
        path.display()
    )]
    Write {
        /// The file that was to be written.
        path: PathBuf,
        /// The cause.
        source: io::Error,
    },
    /// The file is whole and has its name, but the disk did not confirm the name.
    #[error(
        "{}: it is written, but the disk does not confirm that it keeps its name ({source}); check the disk, and \
         that the file is there",
        path.display()
    )]
    Unconfirmed {
        /// The file.
        path: PathBuf,
        /// The cause.
        source: io::Error,
    },
    /// Another run works on the file.
    #[error(
        "{}: another run{} is at work on this file; wait until it has ended, or name another file",
        path.display(),
        process.map_or_else(String::new, |process| format!(" (process {process})"))
    )]
    Busy {
        /// The file.
        path: PathBuf,
        /// The number of its process, where it is known.
        process: Option<u32>,
    },
}

impl FormatsError {
    /// The exit code of a program that ends with this error (those of BSD's `sysexits`).
    #[must_use]
    pub fn exit_code(&self) -> u8 {
        match self {
            Self::BadInput { .. } => 65,
            Self::Missing { .. } | Self::Unreadable { .. } => 66,
            Self::TooLarge { .. } => 69,
            Self::BadOutput { .. } => 70,
            Self::CannotCreate { .. } => 73,
            Self::Read { .. } | Self::Write { .. } | Self::Unconfirmed { .. } => 74,
            Self::Busy { .. } => 75,
        }
    }

    pub(crate) fn opening(path: &Path, source: io::Error) -> Self {
        let path = path.to_path_buf();
        match source.kind() {
            io::ErrorKind::NotFound | io::ErrorKind::NotADirectory => Self::Missing { path },
            _ => Self::Unreadable { path, source },
        }
    }
}

/// What is wrong with the content of a file, before it is known which file that is: readers work
/// on any stream of bytes.
#[derive(Debug)]
pub(crate) enum Fault {
    /// The content is not what it should be.
    Content { place: Place, what: String, mend: String },
    /// The content does not fit into memory.
    TooLarge(String),
    /// Reading failed.
    Io(io::Error),
}

impl Fault {
    pub(crate) fn new(place: Place, what: impl Into<String>, mend: impl Into<String>) -> Self {
        Self::Content { place, what: what.into(), mend: mend.into() }
    }

    pub(crate) fn whole(what: impl Into<String>, mend: impl Into<String>) -> Self {
        Self::new(Place::Whole, what, mend)
    }

    pub(crate) fn of(self, path: &Path) -> FormatsError {
        let path = path.to_path_buf();
        match self {
            Self::Content { place, what, mend } => {
                FormatsError::BadInput { path, place, what, mend }
            }
            Self::TooLarge(what) => FormatsError::TooLarge { path, what },
            Self::Io(source) if source.kind() == io::ErrorKind::UnexpectedEof => {
                Self::truncated().of(&path)
            }
            Self::Io(source) => FormatsError::Read { path, source },
        }
    }

    pub(crate) fn truncated() -> Self {
        Self::whole("the file ends too early", "make or download it again")
    }
}

impl From<io::Error> for Fault {
    fn from(error: io::Error) -> Self {
        Self::Io(error)
    }
}

/// Text from a file, short enough for a message.
pub(crate) fn abridged(text: &str) -> String {
    text.trim().chars().take(40).collect()
}

/// An empty vector with room for `count` items; `what` names them. `count` must have been checked
/// against the length of the file.
pub(crate) fn room<T>(count: usize, what: &str) -> Result<Vec<T>, Fault> {
    let mut items = Vec::new();
    items
        .try_reserve_exact(count)
        .map_err(|_| Fault::TooLarge(format!("a list of {count} {what}")))?;
    Ok(items)
}
