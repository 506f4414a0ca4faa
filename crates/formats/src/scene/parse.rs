//! First stage: from text to a [`SceneFile`].

use super::document::SceneDocument;
use super::source::{SceneSource, printable};
use super::{SceneError, keys, overrides};
use serde::Deserialize;
use std::io::Read as _;
use std::path::Path;
use toml::de::DeTable;

/// Longest scene file that is read, in bytes: large data stands in files of its own.
pub const MAX_SCENE_BYTES: usize = 1 << 20;

/// Longest message of the deserialiser that is passed on, in characters.
const LONGEST_MESSAGE: usize = 200;

/// The version of the format that this program reads.
pub const SCENE_VERSION: u32 = 1;

/// A scene file as written: every key is known and of the right type; what the values mean, and
/// whether they are in range, is the matter of [`super::resolve`].
#[derive(Clone, Debug, PartialEq)]
pub struct SceneFile {
    /// What is written, and what the kinds of snow add to it.
    pub document: SceneDocument,
    pub(super) source: SceneSource,
}

impl SceneFile {
    /// Reads the file at `path` and applies `overrides` (`path=value`, as of `--set`).
    ///
    /// # Errors
    /// [`SceneError::Read`] where the file cannot be read, else as [`SceneFile::parse`].
    pub fn read(path: &Path, overrides: &[String]) -> Result<Self, SceneError> {
        let failed = |cause| SceneError::Read { path: path.to_owned(), cause };
        let mut bytes = Vec::new();
        // Asked before it is opened: opening a pipe would wait for whoever writes into it.
        if !path.metadata().map_err(failed)?.is_file() {
            return Err(failed(std::io::Error::other("not a regular file; name a scene file")));
        }
        let file = std::fs::File::open(path).map_err(failed)?;
        file.take(MAX_SCENE_BYTES as u64 + 1).read_to_end(&mut bytes).map_err(failed)?;
        Self::parse_bytes(&bytes, path, overrides)
    }

    /// As [`SceneFile::parse`], from bytes that may be anything.
    ///
    /// # Errors
    /// Bytes that are not UTF-8; else as [`SceneFile::parse`].
    pub fn parse_bytes(
        bytes: &[u8],
        origin: &Path,
        overrides: &[String],
    ) -> Result<Self, SceneError> {
        if bytes.len() > MAX_SCENE_BYTES {
            let file = origin.display().to_string();
            return Err(SceneError::TooLarge { file, limit: MAX_SCENE_BYTES });
        }
        let text = std::str::from_utf8(bytes).map_err(|error| SceneError::Syntax {
            place: SceneSource::new(origin, "", &[]).place_of(0),
            message: format!(
                "byte {} is not UTF-8 text; a scene is a TOML text file",
                error.valid_up_to()
            ),
        })?;
        Self::parse(text, origin, overrides)
    }

    /// Reads a scene from `text`. `origin` is the path that messages name and that references
    /// (mesh and grain files) are relative to; `overrides` are `path=value` assignments applied
    /// before anything is checked.
    ///
    /// # Errors
    /// Text that is not TOML or nests too deep, unknown or missing keys, values of a wrong type, an
    /// override that fits nowhere.
    pub fn parse(text: &str, origin: &Path, overrides: &[String]) -> Result<Self, SceneError> {
        if text.len() > MAX_SCENE_BYTES {
            let file = origin.display().to_string();
            return Err(SceneError::TooLarge { file, limit: MAX_SCENE_BYTES });
        }
        if let Some(assignment) = overrides.iter().find(|o| o.contains(['\n', '\r'])) {
            return Err(SceneError::Override {
                assignment: assignment.escape_debug().to_string(),
                mend: "write it on one line".into(),
            });
        }
        let mut source = SceneSource::new(origin, text, overrides);
        let document = read_document(&mut source)?;
        Ok(Self { document, source })
    }

    /// The path that references are relative to.
    #[must_use]
    pub fn origin(&self) -> &Path {
        self.source.path()
    }
}

fn read_document(source: &mut SceneSource) -> Result<SceneDocument, SceneError> {
    let text = source.clone();
    let known = keys::scene_keys();
    let mut table =
        DeTable::parse(text.file_text()).map_err(|error| syntax_error(source, &error))?;
    for (start, assignment) in text.overrides() {
        overrides::apply(table.get_mut(), known, assignment, start)?;
    }
    check_version(table.get_ref(), &text)?;
    source.read_keys(table.get_ref(), known)?;
    let mut document = SceneDocument::deserialize(toml::de::Deserializer::from(table))
        .map_err(|error| bad_value(source, known, &error))?;
    for snow in &mut document.snow {
        if let Some(kind) = snow.kind {
            kind.complete(snow);
        }
    }
    Ok(document)
}

fn syntax_error(source: &SceneSource, error: &toml::de::Error) -> SceneError {
    let too_deep = ["recursion limit", "cannot recurse further; max recursion depth met"];
    let place = match error.span() {
        Some(span) => source.place_of(span.start),
        None => source.path().display().to_string(),
    };
    let message = if too_deep.contains(&error.message()) {
        "brackets or dotted keys nest deeper than in any scene".to_owned()
    } else {
        format!("not TOML: {}", error.message().replace('\n', ", "))
    };
    SceneError::Syntax { place, message }
}

/// A later version has other keys, so its number is looked at before any of them.
fn check_version(table: &DeTable<'_>, source: &SceneSource) -> Result<(), SceneError> {
    let Some(version) = table.get("version") else {
        return Err(SceneError::MissingKey {
            place: source.path().display().to_string(),
            key: "version".into(),
            mend: format!("write `version = {SCENE_VERSION}` at the top"),
        });
    };
    let number = version
        .get_ref()
        .as_integer()
        .and_then(|i| i64::from_str_radix(i.as_str(), i.radix()).ok());
    if number == Some(i64::from(SCENE_VERSION)) {
        return Ok(());
    }
    Err(SceneError::BadValue {
        place: source.place_of(version.span().start),
        key: "version".into(),
        value: source.text_of(version.span()),
        mend: format!("this program reads version {SCENE_VERSION}"),
    })
}

/// What the deserialiser says, with the key it says it of and what that key means.
fn bad_value(source: &SceneSource, known: &[keys::Key], error: &toml::de::Error) -> SceneError {
    let offset = error.span().map_or(0, |span| span.start);
    let key = source.key_at(offset).unwrap_or_default().to_owned();
    let message = printable(error.message(), LONGEST_MESSAGE);
    // "invalid type: string "x", expected u32": the value is quoted already.
    let expected = match (message.starts_with("invalid"), message.rfind("expected ")) {
        (true, Some(at)) => message[at..].to_owned(),
        _ => message,
    };
    let expected = ["u32", "u64"].iter().fold(expected, |text, kind| {
        text.replace(&format!("expected {kind}"), "expected a whole number that is not negative")
    });
    let expected = expected.replace("expected f64", "expected a number");
    let mend = match keys::meaning(known, &key) {
        Some(meaning) => format!("{expected}. {meaning}"),
        None => expected,
    };
    SceneError::BadValue {
        place: source.place_of(offset),
        value: source.written(&key).unwrap_or_default(),
        key,
        mend,
    }
}
