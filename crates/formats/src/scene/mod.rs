//! Scene files: TOML that says everything that decides a picture.
//!
//! Two stages, parse then mean: [`SceneFile::parse`] gives the file as written (known keys, right
//! types, `--set` applied, each key's line remembered), [`resolve`] gives what it means (values in
//! range, metres, references loaded) as a [`snowgrain_render::description::SceneDescription`].
//! Every error names file and line, the dotted key, the value and the mend.
//!
//! [`builtin_scenes`] are the scenes that come with the program, [`scene_for_mesh`] makes one for a
//! mesh that comes alone, [`scene_for_shot`] for a shot with its camera, [`schema`] is the JSON Schema of the format.

mod animate;
mod builtin;
pub mod document;
mod error;
mod focus;
mod keys;
mod kind_scene;
mod mesh_scene;
mod overrides;
mod parse;
mod quantity;
mod resolve;
mod schema;
mod shot_scene;
mod source;
#[cfg(test)]
mod tests;

pub use builtin::{BuiltinScene, builtin_scene, builtin_scenes};
pub use error::{LoadError, SceneError};
pub use focus::Focus;
pub use mesh_scene::{MeshScene, MeshSceneOptions, MeshUnits, UpAxis, scene_for_mesh};
pub use parse::{MAX_SCENE_BYTES, SCENE_VERSION, SceneFile};
pub use quantity::{Absorption, Length, LoadText, Triple};
pub use resolve::{
    Loader, ReadEnvironment, ReadGrains, ReadImport, ReadMesh, ReadOpticalConstants, ReadPlanImage,
    ReadSizes, ReadTexture, furnace, resolve,
};
pub use schema::schema;
pub use shot_scene::scene_for_shot;
