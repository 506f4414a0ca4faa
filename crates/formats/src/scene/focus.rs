//! What a camera is focused on, as written.

use super::quantity::Length;
use schemars::{JsonSchema, Schema, SchemaGenerator, json_schema};
use serde::Deserialize;
use serde::de::{Deserializer, Error, SeqAccess, Visitor};
use std::borrow::Cow;
use std::fmt;

/// What is in focus: a plane at a distance along the view, the plane through a point, or what is seen.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Focus {
    /// Distance along the view.
    Distance(Length),
    /// A point in the plane.
    Point([Length; 3]),
    /// What the middle of the picture shows.
    Surface,
}

impl<'de> Deserialize<'de> for Focus {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct Reader;
        impl<'de> Visitor<'de> for Reader {
            type Value = Focus;

            fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
                f.write_str("a distance like \"30 cm\", a point [x, y, z] or \"surface\"")
            }

            fn visit_f64<E: Error>(self, metres: f64) -> Result<Focus, E> {
                Ok(Focus::Distance(Length { metres }))
            }

            fn visit_i64<E: Error>(self, metres: i64) -> Result<Focus, E> {
                self.visit_f64(metres as f64)
            }

            fn visit_str<E: Error>(self, text: &str) -> Result<Focus, E> {
                if text == "surface" {
                    return Ok(Focus::Surface);
                }
                Length::parse(text).map(Focus::Distance).map_err(E::custom)
            }

            fn visit_seq<A: SeqAccess<'de>>(self, mut seq: A) -> Result<Focus, A::Error> {
                let mut point = [Length { metres: 0.0 }; 3];
                for (have, coordinate) in point.iter_mut().enumerate() {
                    *coordinate =
                        seq.next_element()?.ok_or_else(|| A::Error::invalid_length(have, &self))?;
                }
                match seq.next_element::<serde::de::IgnoredAny>()? {
                    None => Ok(Focus::Point(point)),
                    Some(_) => Err(A::Error::custom("expected three lengths, found more")),
                }
            }
        }
        deserializer.deserialize_any(Reader)
    }
}

impl JsonSchema for Focus {
    fn schema_name() -> Cow<'static, str> {
        "Focus".into()
    }

    fn json_schema(generator: &mut SchemaGenerator) -> Schema {
        let length = generator.subschema_for::<Length>();
        json_schema!({
            "description": "A distance, a point [x, y, z], or \"surface\".",
            "anyOf": [
                length,
                { "const": "surface" },
                { "type": "array", "items": length, "minItems": 3, "maxItems": 3 }
            ]
        })
    }
}
