//! Which keys a scene may hold, read from the one definition in [`super::document`] through its
//! JSON Schema, so that messages, schema and reader cannot disagree.

use super::document::SceneDocument;
use schemars::generate::SchemaSettings;
use serde_json::Value;
use std::sync::LazyLock;

/// What may stand at a key.
#[derive(Clone, Debug)]
pub(super) enum KeyShape {
    /// A table with these keys.
    Table(Vec<Key>),
    /// A list of tables (`[[name]]`) with these keys.
    List(Vec<Key>),
    /// A value.
    Leaf,
}

/// A key that a table may hold.
#[derive(Clone, Debug)]
pub(super) struct Key {
    pub(super) name: String,
    /// What it means: its documentation, in one line.
    pub(super) meaning: String,
    pub(super) required: bool,
    pub(super) shape: KeyShape,
}

/// The keys at the top of a scene file; made once, as that takes longer than to read a scene.
pub(super) fn scene_keys() -> &'static [Key] {
    static KEYS: LazyLock<Vec<Key>> = LazyLock::new(|| {
        let settings = SchemaSettings::draft2020_12().with(|s| s.inline_subschemas = true);
        table_keys(settings.into_generator().into_root_schema_for::<SceneDocument>().as_value())
    });
    &KEYS
}

fn table_keys(schema: &Value) -> Vec<Key> {
    let required = |name: &str| {
        schema["required"].as_array().is_some_and(|r| r.iter().any(|v| v.as_str() == Some(name)))
    };
    let Some(properties) = schema["properties"].as_object() else { return Vec::new() };
    properties
        .iter()
        .map(|(name, property)| Key {
            name: name.clone(),
            meaning: property["description"].as_str().unwrap_or_default().replace('\n', " "),
            required: required(name),
            shape: shape(property),
        })
        .collect()
}

fn shape(property: &Value) -> KeyShape {
    if property["properties"].is_object() {
        KeyShape::Table(table_keys(property))
    } else if property["items"]["properties"].is_object() {
        KeyShape::List(table_keys(&property["items"]))
    } else {
        KeyShape::Leaf
    }
}

/// The key called `name`.
pub(super) fn find<'a>(keys: &'a [Key], name: &str) -> Option<&'a Key> {
    keys.iter().find(|key| key.name == name)
}

/// The meaning of the value at a dotted path like `snow.0.radius`.
pub(super) fn meaning(keys: &[Key], path: &str) -> Option<String> {
    let mut keys = keys;
    let mut meaning = None;
    for segment in path.split('.').filter(|s| s.parse::<usize>().is_err()) {
        let key = find(keys, segment)?;
        meaning = Some(key.meaning.clone());
        keys = match &key.shape {
            KeyShape::Table(inner) | KeyShape::List(inner) => inner,
            KeyShape::Leaf => &[],
        };
    }
    meaning
}

/// What to say of an unknown key `name` under `prefix` (empty or ending in a dot): the nearest
/// known key, or all of them where none is near.
pub(super) fn suggestion(keys: &[Key], prefix: &str, name: &str) -> String {
    const LONGEST_COMPARED: usize = 64;
    let near = keys
        .iter()
        .filter(|_| name.len() <= LONGEST_COMPARED)
        .map(|key| (edit_distance(&key.name, &name.to_lowercase()), &key.name))
        .min()
        .filter(|&(distance, _)| distance <= 2.max(name.chars().count() / 2));
    match near {
        Some((_, nearest)) => format!("did you mean `{prefix}{nearest}`?"),
        None => {
            let names: Vec<_> = keys.iter().map(|key| key.name.as_str()).collect();
            format!("known here: {}", names.join(", "))
        }
    }
}

/// Levenshtein's distance: insertions, deletions and replacements of characters.
fn edit_distance(a: &str, b: &str) -> usize {
    let b: Vec<char> = b.chars().collect();
    let mut row: Vec<usize> = (0..=b.len()).collect();
    for (i, x) in a.chars().enumerate() {
        let mut diagonal = row[0];
        row[0] = i + 1;
        for (j, &y) in b.iter().enumerate() {
            let replaced = diagonal + usize::from(x != y);
            diagonal = row[j + 1];
            row[j + 1] = replaced.min(row[j] + 1).min(diagonal + 1);
        }
    }
    row[b.len()]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn edit_distances() {
        assert_eq!(edit_distance("", ""), 0);
        assert_eq!(edit_distance("radius", "radius"), 0);
        assert_eq!(edit_distance("radius", "radus"), 1);
        assert_eq!(edit_distance("kitten", "sitting"), 3);
        assert_eq!(edit_distance("", "abc"), 3);
    }

    #[test]
    fn every_key_is_documented() {
        fn check(keys: &[Key]) {
            assert!(!keys.is_empty());
            for key in keys {
                assert!(!key.meaning.is_empty(), "{} has no description", key.name);
                match &key.shape {
                    KeyShape::Table(inner) | KeyShape::List(inner) => check(inner),
                    KeyShape::Leaf => {}
                }
            }
        }
        check(scene_keys());
    }

    #[test]
    fn tables_lists_and_leaves_are_told_apart() {
        let keys = scene_keys();
        assert!(matches!(find(keys, "film").unwrap().shape, KeyShape::Table(_)));
        assert!(matches!(find(keys, "snow").unwrap().shape, KeyShape::List(_)));
        assert!(matches!(find(keys, "version").unwrap().shape, KeyShape::Leaf));
        assert!(matches!(find(keys, "camera").unwrap().shape, KeyShape::Table(_)));
        assert!(find(keys, "version").unwrap().required);
        assert!(!find(keys, "film").unwrap().required);
        assert!(meaning(keys, "snow.0.radius").unwrap().starts_with("Grain radius"));
    }
}
