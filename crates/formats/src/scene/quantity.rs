//! Values that may be written in more than one way.

use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::Deserialize;
use serde::de::{Deserializer, Error, SeqAccess, Visitor};
use snowgrain_optics::IceAbsorption;
use std::borrow::Cow;
use std::fmt;

/// A length: a number (metres) or a string with a unit (`"0.5 mm"`).
///
/// Metric lengths are converted exactly: `"0.5 mm"`, `"500 um"` and `0.0005` are the same number.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Length {
    /// Metres.
    pub metres: f64,
}

/// Units of length: names, and metres as `factor * 10^exponent`.
const UNITS: [(&[&str], f64, i32); 6] = [
    (&["um", "\u{b5}m", "\u{3bc}m"], 1.0, -6),
    (&["mm"], 1.0, -3),
    (&["cm"], 1.0, -2),
    (&["m"], 1.0, 0),
    (&["km"], 1.0, 3),
    (&["in"], 254.0, -4),
];

const UNIT_NAMES: &str = "um, mm, cm, m, km or in";

impl Length {
    /// Reads `"0.5 mm"`, `"150um"`, `"3 cm"`, `"1 in"`.
    ///
    /// # Errors
    /// A line that says what is wrong and which units there are.
    pub fn parse(text: &str) -> Result<Self, String> {
        let text = text.trim();
        let digits =
            text.find(|c: char| !(c.is_ascii_digit() || "+-.eE".contains(c))).unwrap_or(text.len());
        let (number, unit) = (&text[..digits], text[digits..].trim());
        if unit.is_empty() {
            return Err(format!(
                "a length in quotes needs a unit ({UNIT_NAMES}), as in \"0.5 mm\""
            ));
        }
        let Some(&(_, factor, exponent)) = UNITS.iter().find(|(names, ..)| names.contains(&unit))
        else {
            return Err(format!("unknown unit of length `{unit}`; use {UNIT_NAMES}"));
        };
        decimal(number, factor, exponent)
            .map(|metres| Self { metres })
            .ok_or_else(|| "no number before the unit; write a length like \"0.5 mm\"".to_owned())
    }
}

/// `number * factor * 10^exponent`, rounded once where `factor` is 1.
fn decimal(number: &str, factor: f64, exponent: i32) -> Option<f64> {
    let (mantissa, written) = number.split_once(['e', 'E']).unwrap_or((number, "0"));
    let exponent = written.parse::<i32>().ok()?.checked_add(exponent)?;
    let value = mantissa.parse::<f64>().ok()?;
    if factor == 1.0 {
        return format!("{mantissa}e{exponent}").parse().ok();
    }
    format!("{}e{exponent}", value * factor).parse().ok()
}

impl<'de> Deserialize<'de> for Length {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct Reader;
        impl Visitor<'_> for Reader {
            type Value = Length;

            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str("a length: a number of metres, or a string like \"0.5 mm\"")
            }

            fn visit_f64<E: Error>(self, metres: f64) -> Result<Length, E> {
                Ok(Length { metres })
            }

            fn visit_i64<E: Error>(self, metres: i64) -> Result<Length, E> {
                Ok(Length { metres: metres as f64 })
            }

            fn visit_str<E: Error>(self, text: &str) -> Result<Length, E> {
                Length::parse(text).map_err(E::custom)
            }
        }
        deserializer.deserialize_any(Reader)
    }
}

impl JsonSchema for Length {
    fn schema_name() -> Cow<'static, str> {
        "Length".into()
    }

    fn json_schema(_: &mut SchemaGenerator) -> Schema {
        json_schema!({
            "description": "A length: a number (metres) or a string with a unit (um, mm, cm, m, km, in).",
            "anyOf": [
                { "type": "number" },
                { "type": "string", "pattern": "^\\s*[-+0-9.eE]+\\s*(um|\u{b5}m|\u{3bc}m|mm|cm|m|km|in)\\s*$" }
            ]
        })
    }
}

/// What ice absorbs: the name of a source, or a number of 1/m.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Absorption(pub snowgrain_optics::Absorption);

impl<'de> Deserialize<'de> for Absorption {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct Reader;
        impl Visitor<'_> for Reader {
            type Value = Absorption;

            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                write!(f, "{} or a number of 1/m", source_names())
            }

            fn visit_f64<E: Error>(self, per_metre: f64) -> Result<Absorption, E> {
                Ok(Absorption(snowgrain_optics::Absorption::Grey(per_metre)))
            }

            fn visit_i64<E: Error>(self, per_metre: i64) -> Result<Absorption, E> {
                self.visit_f64(per_metre as f64)
            }

            fn visit_str<E: Error>(self, name: &str) -> Result<Absorption, E> {
                let source = IceAbsorption::ALL.into_iter().find(|source| source.name() == name);
                source
                    .map(|source| Absorption(snowgrain_optics::Absorption::Measured(source)))
                    .ok_or_else(|| {
                        E::custom(format!("expected {} or a number of 1/m", source_names()))
                    })
            }
        }
        deserializer.deserialize_any(Reader)
    }
}

fn source_names() -> String {
    IceAbsorption::ALL.map(|source| format!("\"{}\"", source.name())).join(", ")
}

impl JsonSchema for Absorption {
    fn schema_name() -> Cow<'static, str> {
        "Absorption".into()
    }

    fn json_schema(_: &mut SchemaGenerator) -> Schema {
        json_schema!({
            "description": "The name of a source, or a number of 1/m.",
            "anyOf": [
                { "type": "number", "minimum": 0 },
                { "enum": IceAbsorption::ALL.map(IceAbsorption::name) }
            ]
        })
    }
}

/// A load of an impurity as written: a number or text with a unit.
#[derive(Clone, Debug, PartialEq)]
pub struct LoadText(pub String);

impl<'de> Deserialize<'de> for LoadText {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct Reader;
        impl Visitor<'_> for Reader {
            type Value = LoadText;

            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str("a load: a mass fraction, or a string like \"200 ppb\"")
            }

            fn visit_f64<E: Error>(self, fraction: f64) -> Result<LoadText, E> {
                Ok(LoadText(fraction.to_string()))
            }

            fn visit_i64<E: Error>(self, fraction: i64) -> Result<LoadText, E> {
                Ok(LoadText(fraction.to_string()))
            }

            fn visit_str<E: Error>(self, text: &str) -> Result<LoadText, E> {
                Ok(LoadText(text.to_owned()))
            }
        }
        deserializer.deserialize_any(Reader)
    }
}

impl JsonSchema for LoadText {
    fn schema_name() -> Cow<'static, str> {
        "Load".into()
    }

    fn json_schema(_: &mut SchemaGenerator) -> Schema {
        json_schema!({
            "description": "A load: a mass fraction, or a string with a unit (ppb, ng/g, ppm, ug/g, mg/kg, vol; cells/mL for algae).",
            "anyOf": [{ "type": "number", "minimum": 0 }, { "type": "string" }]
        })
    }
}

/// One number for all three, or three numbers: a colour (linear RGB) or a scale along x, y, z.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Triple(pub [f64; 3]);

impl<'de> Deserialize<'de> for Triple {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct Reader;
        impl<'de> Visitor<'de> for Reader {
            type Value = Triple;

            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str("a number or three numbers [a, b, c]")
            }

            fn visit_f64<E: Error>(self, value: f64) -> Result<Triple, E> {
                Ok(Triple([value; 3]))
            }

            fn visit_i64<E: Error>(self, value: i64) -> Result<Triple, E> {
                Ok(Triple([value as f64; 3]))
            }

            fn visit_seq<A: SeqAccess<'de>>(self, mut seq: A) -> Result<Triple, A::Error> {
                let mut triple = [0.0; 3];
                for (have, value) in triple.iter_mut().enumerate() {
                    *value =
                        seq.next_element()?.ok_or_else(|| A::Error::invalid_length(have, &self))?;
                }
                match seq.next_element::<serde::de::IgnoredAny>()? {
                    None => Ok(Triple(triple)),
                    Some(_) => Err(A::Error::custom("expected three numbers, found more")),
                }
            }
        }
        deserializer.deserialize_any(Reader)
    }
}

impl JsonSchema for Triple {
    fn schema_name() -> Cow<'static, str> {
        "Triple".into()
    }

    fn json_schema(_: &mut SchemaGenerator) -> Schema {
        json_schema!({
            "description": "One number for all three, or three numbers.",
            "anyOf": [
                { "type": "number" },
                { "type": "array", "items": { "type": "number" }, "minItems": 3, "maxItems": 3 }
            ]
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn metres(text: &str) -> f64 {
        Length::parse(text).unwrap().metres
    }

    #[test]
    fn metric_lengths_are_the_decimal_numbers_they_say() {
        assert_eq!(metres("0.5 mm"), 0.0005);
        assert_eq!(metres("500um"), 0.0005);
        assert_eq!(metres("500 \u{b5}m"), 0.0005);
        assert_eq!(metres("500 \u{3bc}m"), 0.0005);
        assert_eq!(metres("5e-1 mm"), 0.0005);
        assert_eq!(metres(" 3 cm "), 0.03);
        assert_eq!(metres("-1.5 m"), -1.5);
        assert_eq!(metres("2 km"), 2000.0);
        assert_eq!(metres("1 in"), 0.0254);
    }

    #[test]
    fn what_is_not_a_length_says_why() {
        for (text, why) in [
            ("0.5", "needs a unit"),
            ("0.5 furlongs", "unknown unit of length `furlongs`"),
            ("mm", "no number"),
            ("1e mm", "no number"),
            ("1-1 mm", "no number"),
            ("1e99999999999 mm", "no number"),
            ("", "needs a unit"),
        ] {
            let error = Length::parse(text).unwrap_err();
            assert!(error.contains(why), "{text}: {error}");
        }
    }
}
