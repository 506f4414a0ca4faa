//! Where each key of a scene was written, so that every later error can say so.

use super::SceneError;
use super::keys::{self, Key, KeyShape};
use std::collections::BTreeMap;
use std::ops::Range;
use std::path::{Path, PathBuf};
use toml::Spanned;
use toml::de::{DeTable, DeValue};

/// Longest value that is quoted in a message, in characters.
const LONGEST_QUOTE: usize = 60;

/// The text of a scene file followed by the overrides, one a line, and where each key stands in it.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct SceneSource {
    path: PathBuf,
    text: String,
    file_length: usize,
    spans: BTreeMap<String, Range<usize>>,
}

impl SceneSource {
    /// The file at `path` with `text`, changed by `overrides` (`path=value`).
    pub(super) fn new(path: &Path, text: &str, overrides: &[String]) -> Self {
        let mut all = text.to_owned();
        for assignment in overrides {
            all.push('\n');
            all.push_str(assignment);
        }
        Self { path: path.to_owned(), text: all, file_length: text.len(), spans: BTreeMap::new() }
    }

    /// The scene file's path.
    pub(super) fn path(&self) -> &Path {
        &self.path
    }

    /// The text of the file alone.
    pub(super) fn file_text(&self) -> &str {
        &self.text[..self.file_length]
    }

    /// The overrides and where each starts.
    pub(super) fn overrides(&self) -> impl Iterator<Item = (usize, &str)> {
        let mut start = self.file_length;
        // Each follows a line break; the first piece is the empty text before the first break.
        self.text[self.file_length..].split('\n').skip(1).map(move |line| {
            start += 1;
            let at = start;
            start += line.len();
            (at, line)
        })
    }

    /// `FILE:LINE` or `--set path=value` for a byte of the text.
    pub(super) fn place_of(&self, offset: usize) -> String {
        if offset > self.file_length {
            let within = |&(start, line): &(usize, &str)| offset <= start + line.len();
            if let Some((_, assignment)) = self.overrides().find(within) {
                return format!("--set {assignment}");
            }
        }
        let before = &self.text.as_bytes()[..offset.min(self.file_length)];
        let line = 1 + before.iter().filter(|&&b| b == b'\n').count();
        format!("{}:{line}", self.path.display())
    }

    /// Where the key was written; where it was not, the nearest table that holds it, else the file.
    pub(super) fn place(&self, key: &str) -> String {
        let mut key = key;
        loop {
            if let Some(span) = self.spans.get(key) {
                return self.place_of(span.start);
            }
            match key.rfind('.') {
                Some(dot) => key = &key[..dot],
                None => return self.path.display().to_string(),
            }
        }
    }

    /// The value as written (shortened), `None` where the key was not.
    pub(super) fn written(&self, key: &str) -> Option<String> {
        self.spans.get(key).map(|span| self.text_of(span.clone()))
    }

    /// Whether the key has its value by an override.
    pub(super) fn is_override(&self, key: &str) -> bool {
        self.spans.get(key).is_some_and(|span| span.start > self.file_length)
    }

    /// The keys written in a table, given without its trailing dot.
    pub(super) fn written_keys<'a>(&'a self, table: &'a str) -> impl Iterator<Item = &'a str> {
        self.spans
            .range(format!("{table}.")..)
            .map_while(move |(key, _)| key.strip_prefix(table)?.strip_prefix('.'))
    }

    /// The innermost key whose value holds this byte.
    pub(super) fn key_at(&self, offset: usize) -> Option<&str> {
        self.spans
            .iter()
            .filter(|(_, span)| span.contains(&offset))
            .min_by_key(|(_, span)| span.len())
            .map(|(key, _)| key.as_str())
    }

    /// The text of a span, shortened and on one line.
    pub(super) fn text_of(&self, span: Range<usize>) -> String {
        let text = self.text.get(span).unwrap_or_default();
        let line = text.split_whitespace().collect::<Vec<_>>().join(" ");
        printable(&line, LONGEST_QUOTE)
    }

    /// Notes where every key stands and refuses those that no scene has or that are missing.
    pub(super) fn read_keys(
        &mut self,
        root: &DeTable<'_>,
        known: &[Key],
    ) -> Result<(), SceneError> {
        let mut spans = BTreeMap::new();
        let outcome = self.read_table(root, known, "", &mut spans);
        self.spans = spans;
        outcome.map_err(|missing| match missing {
            KeyFault::Missing { key, mend } => {
                SceneError::MissingKey { place: self.place(&key), key, mend }
            }
            KeyFault::Other(error) => error,
        })
    }

    fn read_table(
        &self,
        table: &DeTable<'_>,
        known: &[Key],
        prefix: &str,
        spans: &mut BTreeMap<String, Range<usize>>,
    ) -> Result<(), KeyFault> {
        for (name, value) in table {
            let (at, name) = (name.span().start, name.get_ref().as_ref());
            let Some(key) = keys::find(known, name) else {
                return Err(KeyFault::Other(SceneError::UnknownKey {
                    place: self.place_of(at),
                    key: printable(&format!("{prefix}{name}"), LONGEST_QUOTE),
                    mend: keys::suggestion(known, prefix, name),
                }));
            };
            let path = format!("{prefix}{name}");
            spans.insert(path.clone(), value.span());
            self.read_value(value, key, &path, spans)?;
        }
        let absent =
            known.iter().find(|key| key.required && !table.contains_key(key.name.as_str()));
        absent.map_or(Ok(()), |key| {
            Err(KeyFault::Missing {
                key: format!("{prefix}{}", key.name),
                mend: key.meaning.clone(),
            })
        })
    }

    fn read_value(
        &self,
        value: &Spanned<DeValue<'_>>,
        key: &Key,
        path: &str,
        spans: &mut BTreeMap<String, Range<usize>>,
    ) -> Result<(), KeyFault> {
        let wrong = |span: Range<usize>, mend: String| {
            Err(KeyFault::Other(SceneError::BadValue {
                place: self.place_of(span.start),
                key: path.to_owned(),
                value: self.text_of(span),
                mend,
            }))
        };
        match (&key.shape, value.get_ref()) {
            (KeyShape::Leaf, _) => Ok(()),
            (KeyShape::Table(inner), DeValue::Table(table)) => {
                self.read_table(table, inner, &format!("{path}."), spans)
            }
            (KeyShape::Table(_), DeValue::Array(_)) => {
                wrong(value.span(), format!("there is only one; write [{path}]"))
            }
            (KeyShape::Table(_), _) => wrong(value.span(), format!("write a table, [{path}]")),
            (KeyShape::List(inner), DeValue::Array(items)) => {
                for (i, item) in items.iter().enumerate() {
                    let path = format!("{path}.{i}");
                    let DeValue::Table(table) = item.get_ref() else {
                        return wrong(item.span(), format!("write tables, [[{}]]", key.name));
                    };
                    spans.insert(path.clone(), item.span());
                    self.read_table(table, inner, &format!("{path}."), spans)?;
                }
                Ok(())
            }
            (KeyShape::List(_), _) => {
                wrong(value.span(), format!("there may be several; write [[{path}]]"))
            }
        }
    }
}

/// A fault of keys; a missing key's place is known only when all spans are.
enum KeyFault {
    Missing { key: String, mend: String },
    Other(SceneError),
}

/// Text that may hold anything, on one line of at most `longest` characters.
pub(super) fn printable(text: &str, longest: usize) -> String {
    let line: String =
        text.chars().take(longest).map(|c| if c.is_control() { '\u{fffd}' } else { c }).collect();
    if text.chars().nth(longest).is_some() {
        return line + "...";
    }
    line
}
