//! What the layers of a film's light are, as TOML: their `names`, and the index of the layer of each
//! slot (`layer_of_slot`). Empty where none are kept.

use serde::Deserialize;
use snowgrain_film::LightLayerNames;

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct LayersTable {
    names: Vec<String>,
    layer_of_slot: Vec<u32>,
}

pub(super) fn to_toml(layers: Option<&LightLayerNames>) -> String {
    let Some(layers) = layers else { return String::new() };
    format!("names = {:?}\nlayer_of_slot = {:?}\n", layers.names(), layers.layer_of_slot())
}

/// # Errors
/// What is wrong.
pub(super) fn from_toml(bytes: &[u8]) -> Result<LightLayerNames, String> {
    let text = std::str::from_utf8(bytes).map_err(|_| "the names of its layers are not text")?;
    let table: LayersTable = toml::from_str(text)
        .map_err(|error| format!("the names of its layers: {}", error.message()))?;
    LightLayerNames::new(table.names, table.layer_of_slot).map_err(|error| error.to_string())
}
