//! Sweeps: keys of a scene with lists of values.

use crate::failure::{Failure, exit};
use std::path::Path;

/// Most points of a sweep.
const MOST_POINTS: usize = 1_000_000;

/// Reads a sweep, `"snow.radius" = ["0.2 mm", "0.4 mm"]` line by line, and gives what each point sets: all
/// combinations, keys in alphabetical order, the values of the last one changing first.
///
/// # Errors
/// A file that is missing or no sweep, or too many points.
pub(super) fn read(path: &Path) -> Result<Vec<Vec<String>>, Failure> {
    let name = path.display();
    let text = std::fs::read_to_string(path)
        .map_err(|error| Failure::new(exit::INPUT_MISSING, format!("{name}: {error}")))?;
    points(&text).map_err(|what| Failure::bad_input(format!("{name}: {what}")))
}

fn points(text: &str) -> Result<Vec<Vec<String>>, String> {
    let table: toml::Table =
        text.parse().map_err(|error: toml::de::Error| format!("not TOML: {}", error.message()))?;
    let mut axes = Vec::new();
    flatten(&table, "", &mut axes)?;
    if axes.is_empty() {
        return Err("it changes nothing; write a key with a list of values".into());
    }
    let mut points = vec![Vec::new()];
    for (key, values) in axes {
        if values.is_empty() {
            return Err(format!("{key} has no values; write at least one"));
        }
        if points.len().saturating_mul(values.len()) > MOST_POINTS {
            return Err(format!("it has more than {MOST_POINTS} points; make it smaller"));
        }
        let with = |point: &Vec<String>, value: &toml::Value| {
            let set = format!("{key}={value}");
            point.iter().cloned().chain([set]).collect()
        };
        points = points
            .iter()
            .flat_map(|point| values.iter().map(move |value| with(point, value)))
            .collect();
    }
    Ok(points)
}

/// The keys with their values; dotted keys and quoted ones mean the same.
fn flatten<'a>(
    table: &'a toml::Table,
    prefix: &str,
    axes: &mut Vec<(String, &'a Vec<toml::Value>)>,
) -> Result<(), String> {
    for (name, value) in table {
        let key = format!("{prefix}{name}");
        match value {
            toml::Value::Array(values) => axes.push((key, values)),
            toml::Value::Table(inner) => flatten(inner, &format!("{key}."), axes)?,
            _ => return Err(format!("{key} is not a list of values; write {key} = [{value}]")),
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_sweep_is_all_combinations() {
        let both = points("snow.radius = [\"0.2 mm\", 1e-3]\n\"film.seed\" = [1, 2]").unwrap();
        assert_eq!(both.len(), 4);
        assert_eq!(both[1], ["film.seed=1", "snow.radius=0.001"]);
        assert_eq!(both[2], ["film.seed=2", "snow.radius=\"0.2 mm\""]);
        for (text, said) in [
            ("", "changes nothing"),
            ("a = []", "no values"),
            ("a = 3", "write a = [3]"),
            ("a = [", "not TOML"),
        ] {
            let error = points(text).unwrap_err();
            assert!(error.contains(said), "{error}");
        }
    }
}
