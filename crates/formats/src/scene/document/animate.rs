//! `[[animate]]`: keys of a scene that change from frame to frame.

use schemars::JsonSchema;
use serde::Deserialize;

/// A key of the scene that has another value in each frame (`render --frame`).
#[derive(Clone, Debug, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct AnimateTable {
    /// The key, as for --set: "camera.from", "snow.0.wetness".
    pub key: String,
    /// Frames at which its value is given: whole numbers, ascending.
    pub frames: Vec<u32>,
    /// Its values at these frames: numbers, lists of numbers, or strings. Strings of a number and one unit ("3 cm")
    /// change as numbers do, others at the next frame that is given.
    pub values: Vec<AnimatedValue>,
    /// What it has between: "linear", "smooth" (it comes to rest at each) or "hold" (it stays until the
    /// next); default "linear".
    #[serde(default)]
    pub between: BetweenName,
}

/// A value at a frame.
#[derive(Clone, Debug, PartialEq, Deserialize, JsonSchema)]
#[serde(untagged)]
pub enum AnimatedValue {
    /// A whole number.
    Whole(i64),
    /// A number.
    Number(f64),
    /// Numbers.
    Numbers(Vec<f64>),
    /// Text, or a number with its unit.
    Text(String),
}

/// What a key has between two frames at which it is given.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum BetweenName {
    /// A straight way.
    #[default]
    Linear,
    /// A way that begins and ends slowly.
    Smooth,
    /// The value before.
    Hold,
}
