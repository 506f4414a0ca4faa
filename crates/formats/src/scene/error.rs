//! Why a scene is refused.

use std::path::PathBuf;
use thiserror::Error;

/// What a [`crate::scene::Loader`] answers when a file cannot be used; the program may look inside
/// ([`std::error::Error::source`]) to tell a missing file from a bad one.
pub type LoadError = Box<dyn std::error::Error + Send + Sync>;

/// Why a scene is refused. Each message is one line that names the place (`FILE:LINE`, or the
/// `--set` that said so), the dotted key, the value, and the mend.
#[derive(Debug, Error)]
pub enum SceneError {
    /// The scene file itself cannot be read.
    #[error("{}: cannot be read: {cause}; check its name and its rights (`snowgrain scenes` lists the built-in ones)", path.display())]
    Read {
        /// The file.
        path: PathBuf,
        /// What the system says.
        #[source]
        cause: std::io::Error,
    },
    /// The file is larger than any scene.
    #[error("{file}: longer than {limit} bytes; a scene file refers to large data by `file = ...`")]
    TooLarge {
        /// The file.
        file: String,
        /// Most bytes that are read.
        limit: usize,
    },
    /// The text is not TOML.
    #[error("{place}: {message}")]
    Syntax {
        /// Where.
        place: String,
        /// What the parser says.
        message: String,
    },
    /// A key that no scene has.
    #[error("{place}: {key}: unknown key; {mend}")]
    UnknownKey {
        /// Where.
        place: String,
        /// The dotted key.
        key: String,
        /// The nearest key, or all that may stand there.
        mend: String,
    },
    /// A key that must be there.
    #[error("{place}: {key} is missing: {mend}")]
    MissingKey {
        /// Where.
        place: String,
        /// The dotted key.
        key: String,
        /// What to write.
        mend: String,
    },
    /// A key that may not stand beside the others.
    #[error("{place}: {key} = {value}: {mend}")]
    MisplacedKey {
        /// Where.
        place: String,
        /// The dotted key.
        key: String,
        /// The value as written.
        value: String,
        /// Why not, and what to do.
        mend: String,
    },
    /// A value of the wrong kind or out of range.
    #[error("{place}: {key} = {value}: {mend}")]
    BadValue {
        /// Where.
        place: String,
        /// The dotted key.
        key: String,
        /// The value as written.
        value: String,
        /// What is expected.
        mend: String,
    },
    /// A `--set` that cannot be applied.
    #[error("--set {assignment}: {mend}")]
    Override {
        /// The assignment as written.
        assignment: String,
        /// Why not, and what to write.
        mend: String,
    },
    /// A file that the scene refers to cannot be used.
    #[error("{place}: {key} = {value}: {cause}")]
    Reference {
        /// Where.
        place: String,
        /// The dotted key.
        key: String,
        /// The value as written.
        value: String,
        /// What the reader of that file says.
        #[source]
        cause: LoadError,
    },
}
