//! A scene at one of its frames.

use super::document::{AnimateTable, AnimatedValue, BetweenName};
use super::{SceneError, SceneFile};

impl SceneFile {
    /// The scene at a frame: the keys of `[[animate]]` have their values there, as if by `--set` before all
    /// others. Before the first frame that is given a key has its first value, after the last its last.
    ///
    /// # Errors
    /// Frames that do not ascend or are not one for each value, values that do not go together, a key that
    /// no scene has; else as [`SceneFile::parse`].
    pub fn at_frame(&self, frame: u32) -> Result<Self, SceneError> {
        let mut overrides = Vec::new();
        for (index, table) in self.document.animate.iter().enumerate() {
            let value = value_at(table, frame).map_err(|(name, mend)| {
                let key = format!("animate.{index}.{name}");
                let value = self.source.written(&key).unwrap_or_default();
                SceneError::BadValue { place: self.source.place(&key), key, value, mend }
            })?;
            overrides.push(format!("{}={value}", table.key.trim()));
        }
        overrides.extend(self.source.overrides().map(|(_, assignment)| assignment.to_owned()));
        Self::parse(self.source.file_text(), self.origin(), &overrides)
    }
}

/// The value of a key at a frame, as TOML; else the name of what is wrong and how to mend it.
fn value_at(table: &AnimateTable, frame: u32) -> Result<String, (&'static str, String)> {
    let AnimateTable { frames, values, between, .. } = table;
    if frames.is_empty() || frames.windows(2).any(|pair| pair[0] >= pair[1]) {
        return Err(("frames", "write at least one frame, in ascending order".into()));
    }
    if values.len() != frames.len() {
        let mend = format!("there are {} frames and {} values", frames.len(), values.len());
        return Err(("values", format!("{mend}; write one value for each frame")));
    }
    let next = frames.partition_point(|&known| known <= frame);
    let (Some(before), Some(after)) = (next.checked_sub(1), values.get(next)) else {
        return Ok(written(&values[next.saturating_sub(1)]));
    };
    let [start, end] = [frames[before], frames[next]].map(f64::from);
    let part = (f64::from(frame) - start) / (end - start);
    let part = match between {
        BetweenName::Linear => part,
        BetweenName::Smooth => part * part * (3.0 - 2.0 * part),
        BetweenName::Hold => 0.0,
    };
    mixed(&values[before], after, part).map_err(|mend| ("values", mend))
}

/// A part of the way from one value to another.
fn mixed(from: &AnimatedValue, to: &AnimatedValue, part: f64) -> Result<String, String> {
    let mix = |a: f64, b: f64| if part == 0.0 { a } else { a + (b - a) * part };
    if part == 0.0 {
        return Ok(written(from));
    }
    match (from, to) {
        (AnimatedValue::Text(from), AnimatedValue::Text(to)) => match (amount(from), amount(to)) {
            (Some((a, unit)), Some((b, other))) if unit == other => {
                Ok(written(&AnimatedValue::Text(format!("{} {unit}", mix(a, b)))))
            }
            (Some(_), Some(_)) => Err("write all values in the same unit".into()),
            _ => Ok(written(&AnimatedValue::Text(from.clone()))),
        },
        (AnimatedValue::Numbers(from), AnimatedValue::Numbers(to)) if from.len() == to.len() => {
            let numbers = from.iter().zip(to).map(|(&a, &b)| mix(a, b)).collect();
            Ok(written(&AnimatedValue::Numbers(numbers)))
        }
        _ => {
            match (number(from), number(to)) {
                (Some(a), Some(b)) => {
                    let value = mix(a, b);
                    // A whole number fits where any number does, but not the other way round.
                    let is_whole = value.fract() == 0.0 && value.abs() < 9e15;
                    Ok(if is_whole { format!("{value}") } else { format!("{value:?}") })
                }
                _ => Err("write values of one kind: numbers, lists of as many numbers, or strings"
                    .into()),
            }
        }
    }
}

fn number(value: &AnimatedValue) -> Option<f64> {
    match value {
        AnimatedValue::Whole(number) => Some(*number as f64),
        AnimatedValue::Number(number) => Some(*number),
        AnimatedValue::Numbers(_) | AnimatedValue::Text(_) => None,
    }
}

/// A number and its unit, where a text is that.
fn amount(text: &str) -> Option<(f64, &str)> {
    let text = text.trim();
    let digits = text.find(|c: char| !(c.is_ascii_digit() || "+-.eE".contains(c)))?;
    let number: f64 = text[..digits].parse().ok().filter(|x: &f64| x.is_finite())?;
    Some((number, text[digits..].trim()))
}

/// A value as TOML.
fn written(value: &AnimatedValue) -> String {
    match value {
        AnimatedValue::Whole(number) => number.to_string(),
        AnimatedValue::Number(number) => toml::Value::from(*number).to_string(),
        AnimatedValue::Numbers(numbers) => {
            let numbers: Vec<_> =
                numbers.iter().map(|&number| toml::Value::from(number).to_string()).collect();
            format!("[{}]", numbers.join(", "))
        }
        AnimatedValue::Text(text) => toml::Value::from(text.as_str()).to_string(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::path::Path;

    /// The value of a key at a frame.
    fn at(frame: u32, animate: &str) -> Result<SceneFile, String> {
        let text = format!(
            "version = 1\n[camera]\nfrom = [0, 1, 3]\nat = [0, 0, 0]\n[[light]]\nkind = \"sky\"\n\
             [[object]]\nshape = \"box\"\n[[animate]]\n{animate}"
        );
        let file = SceneFile::parse(&text, Path::new("a.toml"), &["film.width=9".into()]);
        file.and_then(|file| file.at_frame(frame)).map_err(|error| error.to_string())
    }

    #[test]
    fn keys_go_from_value_to_value_and_stay_at_the_ends() {
        let from = "key = \"camera.from\"\nframes = [10, 20]\nvalues = [[0, 1, 3], [1.0, 1, 5]]";
        for (frame, z) in [(0, 3.0), (10, 3.0), (15, 4.0), (20, 5.0), (99, 5.0)] {
            let scene = at(frame, from).unwrap();
            assert_eq!(scene.document.camera.unwrap().from[2].metres, z);
            assert_eq!(scene.document.film.width, 9, "--set holds in every frame");
        }
        let smooth = format!("{from}\nbetween = \"smooth\"");
        let z =
            |frame, text: &str| at(frame, text).unwrap().document.camera.unwrap().from[2].metres;
        assert!((z(12, &smooth) - (3.0 + 2.0 * 0.104)).abs() < 1e-12);
        assert_eq!(z(19, &format!("{from}\nbetween = \"hold\"")), 3.0);
        let seed =
            "key = \"film.seed\"\nframes = [1, 2, 9]\nvalues = [7, 8, 9]\nbetween = \"hold\"";
        assert_eq!(at(5, seed).unwrap().document.film.seed, 8);
        let width = "key = \"film.height\"\nframes = [0, 10]\nvalues = [10, 20]";
        assert_eq!(at(3, width).unwrap().document.film.height, 13);
    }

    #[test]
    fn amounts_change_in_their_unit() {
        let height = |values: &str| {
            let keys = format!("key = \"camera.aperture\"\nframes = [0, 4]\nvalues = {values}");
            at(1, &keys).map(|scene| scene.document.camera.unwrap().aperture.unwrap().metres)
        };
        assert!((height("[\"1 mm\", \"3 mm\"]").unwrap() - 1.5e-3).abs() < 1e-15);
        assert!(height("[\"1 mm\", \"3 cm\"]").unwrap_err().contains("same unit"));
    }

    #[test]
    fn what_cannot_be_animated_is_said_with_its_place() {
        for (keys, said) in [
            ("key = \"film.seed\"\nframes = [2, 1]\nvalues = [1, 2]", "a.toml:11"),
            ("key = \"film.seed\"\nframes = []\nvalues = []", "at least one frame"),
            ("key = \"film.seed\"\nframes = [1]\nvalues = [1, 2]", "1 frames and 2 values"),
            ("key = \"film.seed\"\nframes = [0, 9]\nvalues = [1, \"a\"]", "one kind"),
            ("key = \"camera.form\"\nframes = [0]\nvalues = [1]", "camera.from"),
            ("key = \"film.seed\"\nframes = [0, 9]\nvalues = [0, 3]", "whole number"),
        ] {
            let error = at(5, keys).unwrap_err();
            assert!(error.contains(said), "{error}");
        }
    }
}
