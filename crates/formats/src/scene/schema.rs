//! The JSON Schema of scene files, for editors.

use super::document::SceneDocument;
use schemars::generate::SchemaSettings;

/// The JSON Schema (draft 2020-12) of the scene format, ending in a line break.
///
/// `docs/scene.schema.json` holds a copy that a test keeps current.
#[must_use]
pub fn schema() -> String {
    let schema =
        SchemaSettings::draft2020_12().into_generator().into_root_schema_for::<SceneDocument>();
    format!("{:#}\n", schema.as_value())
}
