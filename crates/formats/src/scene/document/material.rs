//! What objects are made of, by name.

use schemars::JsonSchema;
use serde::Deserialize;

/// What an object is made of.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum MaterialName {
    /// Reflects light evenly.
    #[default]
    Diffuse,
    /// A metal.
    Conductor,
    /// A clear solid.
    Dielectric,
}

/// Metals of known reflectance.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum MetalName {
    /// Al.
    #[serde(alias = "aluminum")]
    Aluminium,
    /// Cr.
    Chromium,
    /// Cu.
    Copper,
    /// Au.
    Gold,
    /// Fe.
    Iron,
    /// Ag.
    Silver,
}
