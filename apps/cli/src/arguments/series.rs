//! Options that take several numbers: `a,b,c`, a range `FROM:TO:STEP`, or both.

/// Most numbers of a range.
const MOST: f64 = 100_000.0;

/// The numbers, in the order in which they were asked for.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Series(pub(crate) Vec<f64>);

impl Series {
    /// All numbers of an option that may be repeated.
    pub(crate) fn all(several: &[Self]) -> Vec<f64> {
        several.iter().flat_map(|series| series.0.iter().copied()).collect()
    }
}

/// Reads a series of which `one` reads a number and says how it is written, and `step` the step of a
/// range. What a number must lie within has no gaps, so that the ends of a range speak for the rest.
pub(super) fn series(
    text: &str,
    one: impl Fn(&str) -> Result<f64, String>,
    step: impl Fn(&str) -> Result<f64, String>,
) -> Result<Series, String> {
    let mut all = Vec::new();
    for part in text.split(',') {
        match part.split(':').collect::<Vec<_>>()[..] {
            [value] => all.push(one(value.trim())?),
            [from, to, by] => {
                let (from, to) = (one(from.trim())?, one(to.trim())?);
                let by = step(by.trim()).map_err(|_| bad_range())?;
                // What rounding takes from the last number is given back.
                let steps = ((to - from) / by + 1e-9).floor();
                if !(by > 0.0 && (0.0..MOST).contains(&steps)) {
                    return Err(bad_range());
                }
                all.extend((0..=steps as u32).map(|i| from + by * f64::from(i)));
            }
            _ => return Err(bad_range()),
        }
    }
    Ok(Series(all))
}

fn bad_range() -> String {
    format!("write a range as FROM:TO:STEP, upwards in at most {MOST} steps above 0")
}

/// A number without a unit, as a step.
pub(super) fn plain(text: &str) -> Result<f64, String> {
    text.parse().map_err(|_| "write a number".to_owned())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lists_and_ranges_can_be_mixed() {
        let small = |text: &str| {
            plain(text).and_then(|n| if n <= 100.0 { Ok(n) } else { Err("too much".into()) })
        };
        let of = |text: &str| series(text, small, plain).map(|series| series.0);
        assert_eq!(of("3, 1,2").unwrap(), [3.0, 1.0, 2.0]);
        assert_eq!(of("0:1:0.1").unwrap().len(), 11);
        assert_eq!(of("5,10:30:10,7").unwrap(), [5.0, 10.0, 20.0, 30.0, 7.0]);
        assert_eq!(of("5:5:1").unwrap(), [5.0]);
        for bad in [
            "", "a", "2:1:1", "1:2:0", "1:2", "1:2:3:4", "1:2:-1", "0:1:1e-9", "101", "1:101:1",
            "nan",
        ] {
            assert!(of(bad).is_err(), "{bad}");
        }
        assert!(of("1:2").unwrap_err().contains("FROM:TO:STEP"));
    }
}
