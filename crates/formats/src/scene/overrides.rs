//! `--set path=value`: changes to a scene before it is read; `--set path+=value` adds to a list.

use super::SceneError;
use super::keys::{self, Key, KeyShape};
use std::borrow::Cow;
use std::ops::Range;
use toml::Spanned;
use toml::de::{DeArray, DeTable, DeValue};

/// Applies `assignment`, which starts at byte `start` of the scene's text.
///
/// The path is dotted, `snow.0.radius`, or `snow.radius` where there is one snow; the value is
/// TOML, or a bare string. With `+=` it is one more item of a list.
pub(super) fn apply<'i>(
    table: &mut DeTable<'i>,
    known: &[Key],
    assignment: &'i str,
    start: usize,
) -> Result<(), SceneError> {
    let refuse = |mend: String| SceneError::Override { assignment: assignment.to_owned(), mend };
    let (path, value) = assignment
        .split_once('=')
        .ok_or_else(|| refuse("write path=value, as snow.0.radius=0.3mm".into()))?;
    let value_start = start + path.len() + 1;
    let value = read_value(value, value_start);
    let (path, change) = match path.trim_end().strip_suffix('+') {
        Some(path) => (path, Change::Add(value)),
        None => (path, Change::Set(value)),
    };
    let segments: Vec<&str> = path.trim().split('.').map(str::trim).collect();
    let span = start..start + path.len();
    set_in_table(table, known, "", &segments, &span, change).map_err(refuse)
}

/// What becomes of a key.
enum Change<'i> {
    /// It has this value.
    Set(Spanned<DeValue<'i>>),
    /// It is a list, and this is one more item of it.
    Add(Spanned<DeValue<'i>>),
}

impl<'i> Change<'i> {
    /// Makes it at `name` of a table, which messages call `path`.
    fn make(
        self,
        table: &mut DeTable<'i>,
        name: Spanned<Cow<'i, str>>,
        path: &str,
    ) -> Result<(), String> {
        match self {
            Self::Set(value) => {
                table.insert(name, value);
            }
            Self::Add(value) => {
                let empty = || Spanned::new(value.span(), DeValue::Array(DeArray::new()));
                let DeValue::Array(items) = table.entry(name).or_insert_with(empty).get_mut()
                else {
                    return Err(format!("{path} is not a list; write {path}=value"));
                };
                items.push(value);
            }
        }
        Ok(())
    }

    /// The value of an item, whose list messages call `path`.
    fn value(self, path: &str) -> Result<Spanned<DeValue<'i>>, String> {
        match self {
            Self::Set(value) => Ok(value),
            Self::Add(_) => Err(format!("+= adds to a list; write {path}+=value")),
        }
    }
}

/// The text as a TOML value, else as a string.
fn read_value(text: &str, start: usize) -> Spanned<DeValue<'_>> {
    let trimmed = text.trim();
    let start = start + (text.len() - text.trim_start().len());
    match DeValue::parse(trimmed) {
        Ok(value) => shifted(value, start),
        Err(_) => {
            Spanned::new(start..start + trimmed.len(), DeValue::String(Cow::Borrowed(trimmed)))
        }
    }
}

/// The value with every span moved by `offset` bytes.
fn shifted<'i>(value: Spanned<DeValue<'i>>, offset: usize) -> Spanned<DeValue<'i>> {
    let moved = |span: Range<usize>| span.start + offset..span.end + offset;
    let span = moved(value.span());
    let inner = match value.into_inner() {
        DeValue::Array(items) => {
            DeValue::Array(items.into_iter().map(|item| shifted(item, offset)).collect())
        }
        DeValue::Table(entries) => DeValue::Table(
            entries
                .into_iter()
                .map(|(key, value)| {
                    let span = moved(key.span());
                    (Spanned::new(span, key.into_inner()), shifted(value, offset))
                })
                .collect(),
        ),
        leaf => leaf,
    };
    Spanned::new(span, inner)
}

fn set_in_table<'i>(
    table: &mut DeTable<'i>,
    known: &[Key],
    prefix: &str,
    segments: &[&'i str],
    span: &Range<usize>,
    change: Change<'i>,
) -> Result<(), String> {
    let (name, rest) = (segments[0], &segments[1..]);
    let key = keys::find(known, name).ok_or_else(|| {
        format!("unknown key {prefix}{name}; {}", keys::suggestion(known, prefix, name))
    })?;
    let path = format!("{prefix}{name}");
    let spanned_name = || Spanned::new(span.clone(), Cow::Borrowed(name));
    if rest.is_empty() {
        return change.make(table, spanned_name(), &path);
    }
    let absent = match key.shape {
        KeyShape::Leaf => return set_item(table.get_mut(name), &path, rest, change),
        KeyShape::Table(_) => DeValue::Table(DeTable::new()),
        KeyShape::List(_) => DeValue::Array(DeArray::new()),
    };
    let entry = table.entry(spanned_name()).or_insert_with(|| Spanned::new(span.clone(), absent));
    match (&key.shape, entry.get_mut()) {
        (KeyShape::Table(inner), DeValue::Table(inside)) => {
            set_in_table(inside, inner, &format!("{path}."), rest, span, change)
        }
        (KeyShape::List(inner), DeValue::Array(items)) => {
            let (index, rest) = choose(items.len(), &path, rest)?;
            let item = &mut items.as_mut()[index];
            if rest.is_empty() {
                *item = change.value(&path)?;
                return Ok(());
            }
            let DeValue::Table(inside) = item.get_mut() else {
                return Err(format!("{path}.{index} is not a table"));
            };
            set_in_table(inside, inner, &format!("{path}.{index}."), rest, span, change)
        }
        _ => Err(format!("{path} holds no {}", rest.join("."))),
    }
}

/// Sets one item of a list of numbers, as `camera.at.1`.
fn set_item<'i>(
    list: Option<&mut Spanned<DeValue<'i>>>,
    path: &str,
    rest: &[&str],
    change: Change<'i>,
) -> Result<(), String> {
    let list = list.ok_or_else(|| format!("{path} is not written; give the whole of it"))?;
    let slot = match (list.get_mut(), rest) {
        (DeValue::Array(items), [index]) => {
            index.parse::<usize>().ok().and_then(|index| items.as_mut().get_mut(index))
        }
        _ => None,
    };
    *slot.ok_or_else(|| format!("{path} has no item {}", rest.join(".")))? = change.value(path)?;
    Ok(())
}

/// Which item of a list of `count` tables the path means, and what follows.
fn choose<'a, 'i>(
    count: usize,
    path: &str,
    rest: &'a [&'i str],
) -> Result<(usize, &'a [&'i str]), String> {
    match (rest[0].parse::<usize>(), count) {
        (Ok(index), _) if index < count => Ok((index, &rest[1..])),
        (_, 0) => Err(format!("the scene has no [[{path}]]; add it to the file")),
        (Ok(_), _) => Err(format!("the scene has {path}.0 to {path}.{} only", count - 1)),
        (Err(_), 1) => Ok((0, rest)),
        (Err(_), _) => Err(format!(
            "the scene has {count} of {path}; say which, as {path}.0.{}",
            rest.join(".")
        )),
    }
}
