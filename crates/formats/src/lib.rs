//! Every byte that enters or leaves: scenes, meshes, grains, images and films.

pub mod scene;
