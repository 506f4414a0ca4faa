//! Scenes good and bad, end to end.

mod accepted;
mod lights;
mod mesh_scenes;
mod never_panics;
mod packed;
mod refused;
mod substances;

use super::{LoadError, Loader, SceneError, SceneFile, resolve};
use crate::gltf::{
    ImportedCamera, ImportedLight, ImportedLightKind, ImportedMaterial, ImportedObject,
    ImportedProjection, ImportedScene,
};
use snowgrain_geometry::TriangleMesh;
use snowgrain_grains::GrainField;
use snowgrain_math::{DAffine3, DVec3};
use snowgrain_optics::{MeasuredSubstance, Spectrum};
use snowgrain_render::description::SceneDescription;
use snowgrain_render::light::EnvironmentMap;
use snowgrain_render::surface::Texture;
use std::path::Path;
use std::sync::Arc;

/// The least scene; tests add to it.
const LEAST: &str = "\
version = 1
[camera]
from = [0, 1, 3]
at = [0, 0, 0]
[[light]]
kind = \"sky\"
[[object]]
shape = \"sphere\"
[[snow]]
source = \"deposit\"
grains = 1000
radius = \"0.5 mm\"
";

fn triangle() -> TriangleMesh {
    TriangleMesh::new(vec![DVec3::ZERO, DVec3::X, DVec3::Z], vec![[0, 1, 2]]).unwrap()
}

/// Two triangles one over the other, seen by two cameras.
fn shot() -> ImportedScene {
    let mesh = Arc::new(triangle());
    let base_colour = [0.2, 0.3, 0.4];
    let material = ImportedMaterial { base_colour, texture: None, metallic: 0.0, roughness: 1.0 };
    let object = |height: f64| ImportedObject {
        name: format!("at {height}"),
        mesh: Arc::clone(&mesh),
        transform: DAffine3::from_translation(DVec3::Y * height),
        material: material.clone(),
    };
    let camera = |name: &str, projection| ImportedCamera {
        name: name.into(),
        from: DVec3::new(0.0, 0.0, 2.0),
        gaze: DVec3::NEG_Z,
        up: DVec3::Y,
        projection,
        aspect: Some(1.5),
    };
    ImportedScene {
        objects: vec![object(0.0), object(0.5)],
        cameras: vec![
            camera("eye", ImportedProjection::Perspective { vertical_fov_degrees: 30.0 }),
            camera("plan", ImportedProjection::Orthographic { height: 3.0 }),
        ],
        ..ImportedScene::default()
    }
}

/// The same under a sun, a bulb and a torch.
fn lit_shot() -> ImportedScene {
    let light = |name: &str, colour, kind| ImportedLight { name: name.into(), colour, kind };
    let (direction, position) = (DVec3::NEG_Y, DVec3::new(0.0, 3.0, 0.5));
    let torch = ImportedLightKind::Spot {
        position,
        direction,
        candela: 50.0,
        inner_radians: 0.0,
        outer_radians: 0.5,
    };
    let lights = vec![
        light("sun", [1.0, 0.9, 0.8], ImportedLightKind::Directional { direction, lux: 1e5 }),
        light("bulb", [1.0; 3], ImportedLightKind::Point { position, candela: 100.0 }),
        light("torch", [0.5; 3], torch),
    ];
    ImportedScene { lights, ..shot() }
}

fn meaning_of(file: &SceneFile) -> Result<SceneDescription, SceneError> {
    let read_mesh = |path: &Path| match path.to_str() {
        Some("folder/model.obj") => Ok(triangle()),
        _ => Err(LoadError::from("no such file")),
    };
    let read_grains = |_: &Path| Err::<GrainField, _>(LoadError::from("a header without end"));
    let read_environment = |path: &Path| match path.to_str() {
        Some("folder/sky.hdr") => Ok(EnvironmentMap::new(2, 1, vec![[1.0; 3]; 2])?),
        _ => Err(LoadError::from("no such file")),
    };
    let read_import = |path: &Path| match path.to_str() {
        Some("folder/shot.glb") => Ok(shot()),
        Some("folder/lit.glb") => Ok(lit_shot()),
        _ => Err(LoadError::from("no such file")),
    };
    let read_texture = |path: &Path| match path.to_str() {
        Some("folder/bark.png") => Ok(Texture::of_bytes([2, 1], vec![[255; 3], [0; 3]])?),
        _ => Err(LoadError::from("no such file")),
    };
    let read_sizes = |path: &Path| match path.to_str() {
        Some("folder/sizes.txt") => Ok(vec![(0.2e-3, 1.0), (0.4e-3, 3.0)]),
        _ => Err(LoadError::from("no such file")),
    };
    let read_plan_image = |path: &Path| match path.to_str() {
        Some("folder/drift.png") => Ok(([2, 1], vec![0.0, 1.0])),
        _ => Err(LoadError::from("no such file")),
    };
    let read_optical_constants = |path: &Path| match path.to_str() {
        Some("folder/topaz.csv") => {
            let spectrum = |values: [f64; 2]| Spectrum::new(vec![380.0, 780.0], values.to_vec());
            Ok(MeasuredSubstance {
                index: spectrum([1.64, 1.62]).unwrap(),
                imaginary: spectrum([0.0, 1e-7]).unwrap(),
                density: None,
            })
        }
        _ => Err(LoadError::from("no such file")),
    };
    let loader = Loader {
        mesh: &mut { read_mesh },
        grains: &mut { read_grains },
        environment: &mut { read_environment },
        import: &mut { read_import },
        texture: &mut { read_texture },
        sizes: &mut { read_sizes },
        plan_image: &mut { read_plan_image },
        optical_constants: &mut { read_optical_constants },
    };
    resolve(file, loader)
}

/// Reads `text` as the file `folder/scene.toml`, with overrides.
fn read(text: &str, overrides: &[&str]) -> Result<SceneDescription, SceneError> {
    let overrides: Vec<String> = overrides.iter().map(|&o| o.to_owned()).collect();
    meaning_of(&SceneFile::parse(text, Path::new("folder/scene.toml"), &overrides)?)
}

/// The message that `text` is refused with.
fn refusal(text: &str, overrides: &[&str]) -> String {
    match read(text, overrides) {
        Ok(_) => format!("accepted: {overrides:?}\n{text}"),
        Err(error) => error.to_string(),
    }
}
