//! What `[import]` means.

mod lights;

use super::super::SceneError;
use super::super::document::ImportTable;
use super::ReadImport;
use super::checks::Checks;
use super::objects::{Placement, check_reach, transform};
use crate::gltf::{ImportedCamera, ImportedMaterial, ImportedProjection, ImportedScene};
use snowgrain_math::DAffine3;
use snowgrain_render::description::{
    CameraDescription, DirectView, LightDescription, ObjectDescription, ObjectShape, Projection,
    Surface,
};
use snowgrain_render::surface::{Reflectance, TextureMap};

/// What a shot gives to a scene.
#[derive(Default)]
pub(super) struct Import {
    pub(super) objects: Vec<ObjectDescription>,
    pub(super) camera: Option<CameraDescription>,
    pub(super) lights: Vec<LightDescription>,
}

pub(super) fn import(checks: &Checks<'_>, read: &mut ReadImport<'_>) -> Result<Import, SceneError> {
    let Some(table) = &checks.document().import else { return Ok(Import::default()) };
    let path = checks.reference("import.file", &table.file)?;
    let shot = read(&path).map_err(|cause| checks.unusable("import.file", cause))?;
    let placement =
        Placement { scale: table.scale, rotate: table.rotate, translate: table.translate };
    let moved = transform(checks, "import", &placement)?;
    let camera = match (&table.camera, checks.document().camera.is_some()) {
        (Some(_), true) => {
            let mend = "[camera] is there already; remove one of them";
            return Err(checks.misplaced("import.camera", mend));
        }
        (None, true) => None,
        (_, false) => camera(checks, table, &shot, &moved)?,
    };
    let lights = lights::lights(checks, table, &shot.lights, &moved)?;
    Ok(Import { objects: objects(checks, shot, &moved)?, camera, lights })
}

fn objects(
    checks: &Checks<'_>,
    shot: ImportedScene,
    moved: &DAffine3,
) -> Result<Vec<ObjectDescription>, SceneError> {
    let describe = |object: crate::gltf::ImportedObject| {
        let transform = *moved * object.transform;
        check_reach(checks, "import.scale", &object.mesh.bounds(), &transform)?;
        Ok(ObjectDescription {
            name: object.name,
            shape: ObjectShape::Mesh(object.mesh),
            surface: surface(object.material),
            direct_view: DirectView::Seen,
            transform,
        })
    };
    shot.objects.into_iter().map(describe).collect()
}

/// Metals are conductors, all else is diffuse whatever its gloss.
fn surface(material: ImportedMaterial) -> Surface {
    let metal = material.is_metal();
    let colour = material.base_colour;
    let reflectance = match material.texture {
        Some(texture) => Reflectance::Texture(TextureMap { texture, factor: colour, metres: 1.0 }),
        None => Reflectance::Colour(colour),
    };
    if metal {
        let roughness = f64::from(material.roughness);
        return Surface::Conductor { reflectance, edge: [0.0; 3], roughness };
    }
    Surface::Diffuse { albedo: reflectance }
}

/// The camera that the table names, or the first.
fn camera(
    checks: &Checks<'_>,
    table: &ImportTable,
    shot: &ImportedScene,
    moved: &DAffine3,
) -> Result<Option<CameraDescription>, SceneError> {
    let chosen = match &table.camera {
        None => shot.cameras.first(),
        Some(name) => {
            let found = shot.cameras.iter().find(|camera| camera.name == *name);
            let there = || {
                let names: Vec<_> =
                    shot.cameras.iter().map(|camera| format!("{:?}", camera.name)).collect();
                let names = if names.is_empty() { "none".to_owned() } else { names.join(", ") };
                checks.bad("import.camera", format!("the cameras of the file are {names}"))
            };
            Some(found.ok_or_else(there)?)
        }
    };
    chosen.map(|camera| describe_camera(checks, camera, moved)).transpose()
}

fn describe_camera(
    checks: &Checks<'_>,
    camera: &ImportedCamera,
    moved: &DAffine3,
) -> Result<CameraDescription, SceneError> {
    let up = moved.transform_vector3(camera.up);
    let projection = match camera.projection {
        ImportedProjection::Perspective { vertical_fov_degrees } => {
            Projection::pinhole(vertical_fov_degrees)
        }
        ImportedProjection::Orthographic { height } => {
            Projection::Orthographic { height: height * up.length() }
        }
    };
    let from = moved.transform_point3(camera.from);
    let gaze = moved.transform_vector3(camera.gaze);
    if !(from.is_finite() && from.abs().max_element() <= super::checks::LARGEST)
        || gaze.normalize_or_zero().cross(up.normalize_or_zero()).length() < 1e-6
    {
        let mend = format!("the camera {:?} cannot be used; write a [camera]", camera.name);
        return Err(checks.bad("import.file", mend));
    }
    Ok(CameraDescription { from, at: from + gaze, up, projection, backdrop: [0.0; 3] })
}
