//! Measured sizes of grains, from text files.

use crate::error::{Fault, FormatsError, Place};
use crate::input;
use crate::scene::Length;
use std::path::Path;

/// Reads sizes of grains: a line for each class, with a radius (metres, or with a unit as `0.2mm`) and a
/// number of grains in any unit, apart by spaces, a tab, a comma or a semicolon. What follows a `#` is
/// passed over. Gives radii in metres and numbers.
///
/// # Errors
/// A missing or unreadable file, a line that does not hold two numbers.
pub fn read_sizes(path: &Path) -> Result<Vec<(f64, f64)>, FormatsError> {
    parse(&input::read_whole(path)?).map_err(|fault| fault.of(path))
}

fn parse(bytes: &[u8]) -> Result<Vec<(f64, f64)>, Fault> {
    let text = str::from_utf8(bytes).map_err(|_| {
        Fault::whole("this is not text", "write lines of a radius and a number of grains")
    })?;
    let mut classes = Vec::new();
    for (line, number) in text.lines().zip(1u64..) {
        let written = line.split('#').next().unwrap_or_default();
        let words: Vec<&str> = written
            .split(|c: char| c.is_whitespace() || c == ',' || c == ';')
            .filter(|word| !word.is_empty())
            .collect();
        if words.is_empty() {
            continue;
        }
        let bad = || {
            let mend = "write a radius and a number of grains, as 0.2mm 0.15";
            Fault::new(Place::Line(number), "this is not a class of sizes", mend)
        };
        let &[radius, count] = words.as_slice() else { return Err(bad()) };
        let metres = radius.parse().ok().or_else(|| Some(Length::parse(radius).ok()?.metres));
        classes.push((metres.ok_or_else(bad)?, count.parse().map_err(|_| bad())?));
    }
    Ok(classes)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn radii_are_metres_or_have_a_unit() {
        let text = b"# radius, part\n0.0002 0.25\n\n0.3mm, 3e-1 # most\n400um;\t.2\n";
        assert_eq!(parse(text).unwrap(), [(0.0002, 0.25), (0.0003, 0.3), (0.0004, 0.2)]);
    }

    #[test]
    fn a_line_that_is_no_class_is_named() {
        for bad in ["0.1mm", "0.1mm 2 3", "a b", "0.1mm x", "1 mm 2"] {
            let error = parse(format!("0.1mm 1\n{bad}\n").as_bytes()).unwrap_err();
            let line = error.of(Path::new("sizes.txt")).to_string();
            assert!(line.starts_with("sizes.txt, line 2: "), "{line}");
        }
        assert!(parse(&[0xff, 0xfe]).is_err());
    }
}
