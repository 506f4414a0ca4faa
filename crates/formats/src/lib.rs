//! Every byte that enters or leaves Snowgrain: scenes, meshes, grains, pictures and films.
//!
//! Readers trust nothing: counts and sizes are compared with the length of the file before any
//! memory is taken, and a fault is one [`FormatsError`] that names file, place and mend. Writers go
//! through [`atomic::write`], so that a file appears whole or not at all. What is written depends
//! on the content alone, never on time, host or threads.
//!
//! | content | read | write |
//! |---|---|---|
//! | scene (TOML) | [`scene`] | |
//! | mesh (OBJ, PLY, glTF) | [`load_mesh`] | |
//! | shot (glTF) | [`read_gltf`] | |
//! | grains (PLY) | [`read_grains`] | [`write_grains`] |
//! | film | [`read_film`] | [`write_film`] |
//! | layers of snow (TOML) | [`laboratory::read_layers`] | |
//! | map of all directions (HDR, EXR) | [`load_environment`] | |
//! | picture on an object (PNG, JPEG, EXR, HDR) | [`load_texture`] | |
//! | heights of snow, masks (the same) | [`load_plan_image`] | |
//! | sizes of grains (text) | [`read_sizes`] | |
//! | indices of refraction (text) | [`read_optical_constants`] | |
//! | picture | [`image::read_picture`] | [`image::write_exr`], [`image::write_png_8`] |

pub mod atomic;
mod claim;
mod environment;
mod error;
mod fault_injection;
mod film_file;
mod folder;
mod gltf;
mod grains;
#[cfg(test)]
mod hostile_tests;
pub mod image;
mod input;
pub mod laboratory;
mod learnt;
mod mesh;
mod optical_constants;
mod ply;
pub mod scene;
mod sizes;
#[cfg(test)]
mod test_files;
pub mod tev;
mod texture;

pub use claim::Claim;
pub use environment::load_environment;
pub use error::{FormatsError, Place};
pub use film_file::{FilmSummary, film_summary, read_film, write_film};
pub use gltf::{
    ImportedCamera, ImportedLight, ImportedLightKind, ImportedMaterial, ImportedObject,
    ImportedProjection, ImportedScene, read_gltf,
};
pub use grains::{read_grains, write_grains};
pub use learnt::{read_learnt, write_learnt};
pub use mesh::{PlyContent, load_mesh, ply_content};
pub use optical_constants::read_optical_constants;
pub use sizes::read_sizes;
pub use texture::{load_plan_image, load_texture};
