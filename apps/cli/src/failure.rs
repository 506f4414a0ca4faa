//! How the program ends when it cannot do what was asked: one line and an exit code.

use snowgrain_denoise::DenoiseError;
use snowgrain_film::FilmError;
use snowgrain_formats::FormatsError;
use snowgrain_formats::scene::SceneError;
use snowgrain_grains::GrainsError;
use snowgrain_render::RenderError;
use std::fmt;
use std::io;

/// Exit codes: those of BSD's `sysexits`, and 128 + signal.
pub(crate) mod exit {
    /// The command line means nothing.
    pub(crate) const USAGE: u8 = 2;
    /// Bad input.
    pub(crate) const BAD_INPUT: u8 = 65;
    /// An input is missing.
    pub(crate) const INPUT_MISSING: u8 = 66;
    /// Refused: memory, limits.
    pub(crate) const REFUSED: u8 = 69;
    /// A fault of the program.
    pub(crate) const BUG: u8 = 70;
    /// An output cannot be created.
    pub(crate) const CANNOT_CREATE: u8 = 73;
    /// Reading or writing failed half-way.
    pub(crate) const INPUT_OUTPUT: u8 = 74;
    /// Not all is there yet; what is can be gone on with.
    pub(crate) const INCOMPLETE: u8 = 75;
}

/// Why the program cannot do what was asked.
#[derive(Debug)]
pub(crate) struct Failure {
    /// Exit code.
    pub(crate) code: u8,
    /// What is wrong, where, and how to mend it; one line.
    pub(crate) message: String,
}

impl Failure {
    pub(crate) fn new(code: u8, message: impl Into<String>) -> Self {
        Self { code, message: message.into() }
    }

    pub(crate) fn usage(message: impl Into<String>) -> Self {
        Self::new(exit::USAGE, message)
    }

    pub(crate) fn bad_input(message: impl Into<String>) -> Self {
        Self::new(exit::BAD_INPUT, message)
    }

    pub(crate) fn refused(message: impl Into<String>) -> Self {
        Self::new(exit::REFUSED, message)
    }

    /// The same, said of `what` (a scene or a file).
    pub(crate) fn of(mut self, what: &str) -> Self {
        self.message = format!("{what}: {}", self.message);
        self
    }
}

impl fmt::Display for Failure {
    /// One line, whatever names of files hold.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("snowgrain: error: ")?;
        for character in self.message.trim().chars() {
            match character {
                '\n' | '\t' => f.write_str(" ")?,
                c if c.is_control() => write!(f, "{}", c.escape_default())?,
                c => write!(f, "{c}")?,
            }
        }
        Ok(())
    }
}

impl From<FormatsError> for Failure {
    fn from(error: FormatsError) -> Self {
        Self::new(error.exit_code(), error.to_string())
    }
}

impl From<SceneError> for Failure {
    fn from(error: SceneError) -> Self {
        let code = match &error {
            SceneError::Read { cause, .. } => match cause.kind() {
                io::ErrorKind::NotFound
                | io::ErrorKind::NotADirectory
                | io::ErrorKind::PermissionDenied => exit::INPUT_MISSING,
                io::ErrorKind::IsADirectory => exit::BAD_INPUT,
                _ => exit::INPUT_OUTPUT,
            },
            SceneError::Reference { cause, .. } => {
                cause.downcast_ref::<FormatsError>().map_or(exit::BAD_INPUT, |e| e.exit_code())
            }
            _ => exit::BAD_INPUT,
        };
        Self::new(code, error.to_string())
    }
}

impl From<GrainsError> for Failure {
    fn from(error: GrainsError) -> Self {
        let code = match error {
            GrainsError::Stacks(_) => exit::REFUSED,
            _ => exit::BAD_INPUT,
        };
        Self::new(code, error.to_string())
    }
}

impl From<RenderError> for Failure {
    fn from(error: RenderError) -> Self {
        let message = error.to_string();
        let code = match error {
            RenderError::Snow { source, .. }
            | RenderError::Layer(source)
            | RenderError::Calibration { source } => Self::from(source).code,
            RenderError::Grid(_) | RenderError::Memory { .. } | RenderError::Enclosed { .. } => {
                exit::REFUSED
            }
            RenderError::CameraInIce { .. }
            | RenderError::MapSize { .. }
            | RenderError::MapPixels { .. }
            | RenderError::MapValue { .. }
            | RenderError::TextureSize { .. }
            | RenderError::TextureValue { .. } => exit::BAD_INPUT,
            RenderError::Film(source) => Self::from(source).code,
        };
        Self::new(code, message)
    }
}

impl From<DenoiseError> for Failure {
    fn from(error: DenoiseError) -> Self {
        let message = error.to_string();
        let code = match error {
            DenoiseError::NotFound { .. }
            | DenoiseError::Unsuitable { .. }
            | DenoiseError::Failed(_) => exit::REFUSED,
            DenoiseError::NoGuide(_) => exit::BAD_INPUT,
            DenoiseError::Size { .. } => exit::BUG,
            DenoiseError::Film(source) => Self::from(source).code,
        };
        Self::new(code, message)
    }
}

impl From<FilmError> for Failure {
    fn from(error: FilmError) -> Self {
        let code = match error {
            FilmError::TooLarge { .. } => exit::REFUSED,
            FilmError::BadCrop { .. } => exit::USAGE,
            _ => exit::BAD_INPUT,
        };
        Self::new(code, error.to_string())
    }
}
