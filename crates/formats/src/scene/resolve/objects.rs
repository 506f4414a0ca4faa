//! What `[[object]]` means.

use super::super::SceneError;
use super::super::document::{InstanceTable, ObjectTable, ShapeKind};
use super::super::quantity::{Length, Triple};
use super::checks::{Checks, LARGEST, SMALLEST};
use super::{Files, lights, surfaces};
use snowgrain_geometry::TriangleMesh;
use snowgrain_math::{Aabb, DAffine3, DMat3, DVec3, trig};
use snowgrain_render::description::{DirectView, LightDescription, ObjectDescription, ObjectShape};
use std::path::Path;
use std::sync::Arc;

/// The objects after those of a shot, and the lights that are objects.
pub(super) fn objects(
    checks: &Checks<'_>,
    mut objects: Vec<ObjectDescription>,
    files: &mut Files<'_, '_>,
) -> Result<(Vec<ObjectDescription>, Vec<LightDescription>), SceneError> {
    let mut lamps = Vec::new();
    for (i, table) in checks.document().object.iter().enumerate() {
        let path = format!("object.{i}");
        let (object, bounds) = object(checks, &path, table, files)?;
        let first = objects.len();
        if let Some(places) = &table.instances {
            objects.extend(instances(checks, &path, places, &object, &bounds)?);
        } else {
            if matches!(object.shape, ObjectShape::Mesh(_)) {
                check_reach(checks, &format!("{path}.scale"), &bounds, &object.transform)?;
            }
            objects.push(object);
        }
        lamps.extend(lights::of_objects(checks, i, first..objects.len())?);
    }
    Ok((objects, lamps))
}

/// The object in each of its places.
fn instances(
    checks: &Checks<'_>,
    path: &str,
    places: &[InstanceTable],
    object: &ObjectDescription,
    bounds: &Aabb,
) -> Result<Vec<ObjectDescription>, SceneError> {
    if places.is_empty() {
        let mend = "must hold a place, as [{ translate = [1, 0, 0] }]; remove it for a single one";
        return Err(checks.bad(&format!("{path}.instances"), mend));
    }
    let instance = |(i, place): (usize, &InstanceTable)| {
        let path = format!("{path}.instances.{i}");
        let moved =
            Placement { scale: place.scale, rotate: place.rotate, translate: place.translate };
        let transform = transform(checks, &path, &moved)? * object.transform;
        check_reach(checks, &format!("{path}.scale"), bounds, &transform)?;
        let surface = surfaces::with_albedo(checks, &path, place.albedo, &object.surface)?;
        let name = format!("{}.{i}", object.name);
        Ok(ObjectDescription {
            name,
            shape: object.shape.clone(),
            surface,
            transform,
            direct_view: object.direct_view,
        })
    };
    places.iter().enumerate().map(instance).collect()
}

/// Whether the object has a bounding box.
pub(super) fn is_finite(object: &ObjectDescription) -> bool {
    match object.shape {
        ObjectShape::Plane => false,
        ObjectShape::Sphere | ObjectShape::Box | ObjectShape::Teapot | ObjectShape::Mesh(_) => true,
    }
}

/// The object where its own keys place it, and a box in its own space that shows its size.
fn object(
    checks: &Checks<'_>,
    path: &str,
    table: &ObjectTable,
    files: &mut Files<'_, '_>,
) -> Result<(ObjectDescription, Aabb), SceneError> {
    let key = |name: &str| format!("{path}.{name}");
    let surface = surfaces::surface(checks, path, table, files)?;
    let placement =
        Placement { scale: table.scale, rotate: table.rotate, translate: table.translate };
    let transform = transform(checks, path, &placement)?;
    let mut bounds = Aabb::new(-DVec3::ONE, DVec3::ONE);
    let shape = match (table.shape, &table.file) {
        (ShapeKind::Mesh, Some(file)) => {
            let mesh = mesh(checks, &key("file"), file, files)?;
            if table.albedo_texture.is_some() && mesh.coordinates.is_empty() {
                let mend = "the mesh has no texture coordinates (\"vt\" of .obj, s and t of .ply); \
                            export it with them, or bring a glTF file by [import]";
                return Err(checks.bad(&key("albedo_texture"), mend));
            }
            bounds = mesh.bounds();
            ObjectShape::Mesh(mesh)
        }
        (ShapeKind::Mesh, None) => {
            return Err(checks.missing(&key("file"), "name the mesh, as file = \"model.obj\""));
        }
        (_, Some(_)) => {
            let mend = "only a mesh has a file; write shape = \"mesh\" or remove it";
            return Err(checks.misplaced(&key("file"), mend));
        }
        (ShapeKind::Sphere, None) => ObjectShape::Sphere,
        (ShapeKind::Box, None) => ObjectShape::Box,
        (ShapeKind::Plane, None) => ObjectShape::Plane,
        (ShapeKind::Teapot, None) => ObjectShape::Teapot,
    };
    let file_name = table.file.as_deref().and_then(|f| Path::new(f).file_name());
    let name = match (&table.name, file_name) {
        (Some(name), _) => name.clone(),
        (None, Some(file)) => file.to_string_lossy().into_owned(),
        (None, None) => path.to_owned(),
    };
    let direct_view = match (table.holdout, table.shadow_catcher) {
        (false, false) => DirectView::Seen,
        (true, false) => DirectView::Holdout,
        (false, true) => DirectView::ShadowCatcher,
        (true, true) => {
            let mend = "an object is held out or catches shadows, not both; remove one";
            return Err(checks.misplaced(&key("shadow_catcher"), mend));
        }
    };
    Ok((ObjectDescription { name, shape, surface, transform, direct_view }, bounds))
}

pub(super) fn mesh(
    checks: &Checks<'_>,
    key: &str,
    file: &str,
    files: &mut Files<'_, '_>,
) -> Result<Arc<TriangleMesh>, SceneError> {
    let path = checks.reference(key, file)?;
    if let Some((_, mesh)) = files.meshes.iter().find(|(known, _)| *known == path) {
        return Ok(Arc::clone(mesh));
    }
    let mut mesh = (files.mesh)(&path).map_err(|cause| checks.unusable(key, cause))?;
    if checks.document().object.iter().all(|object| object.albedo_texture.is_none()) {
        mesh.coordinates = Vec::new();
    }
    let mesh = Arc::new(mesh);
    files.meshes.push((path, Arc::clone(&mesh)));
    Ok(mesh)
}

/// A mesh may hold any finite vertex, and places may add up; in the world all must stay within
/// reach.
pub(super) fn check_reach(
    checks: &Checks<'_>,
    key: &str,
    bounds: &Aabb,
    transform: &DAffine3,
) -> Result<(), SceneError> {
    let corner = bounds.min.abs().max(bounds.max.abs());
    let size =
        corner.max_element() * transform.matrix3.to_cols_array().map(f64::abs).iter().sum::<f64>();
    let reach = size.max(transform.translation.abs().max_element());
    if reach <= LARGEST {
        return Ok(());
    }
    Err(checks.bad(key, format!("the object reaches {reach:e} m; use a smaller scale")))
}

/// How something is moved: scaled, then rotated, then translated.
pub(super) struct Placement {
    pub(super) scale: Triple,
    pub(super) rotate: [f64; 3],
    pub(super) translate: [Length; 3],
}

pub(super) fn transform(
    checks: &Checks<'_>,
    path: &str,
    placement: &Placement,
) -> Result<DAffine3, SceneError> {
    let key = |name: &str| format!("{path}.{name}");
    let scale = placement.scale.0;
    if !scale.iter().all(|s| (SMALLEST..=LARGEST).contains(&s.abs())) {
        return Err(checks.bad(&key("scale"), "must be finite and not 0"));
    }
    let rotate = checks.finite(&key("rotate"), placement.rotate)?;
    let translate = checks.position(&key("translate"), placement.translate)?;
    let turned = rotation(rotate) * DMat3::from_diagonal(DVec3::from(scale));
    Ok(DAffine3::from_mat3_translation(turned, translate))
}

/// Rotation about x, then y, then z, in degrees, counter-clockwise seen from the axis' tip.
fn rotation([x, y, z]: [f64; 3]) -> DMat3 {
    let about_x = {
        let (s, c) = sin_cos_degrees(x);
        DMat3::from_cols(DVec3::X, DVec3::new(0.0, c, s), DVec3::new(0.0, -s, c))
    };
    let about_y = {
        let (s, c) = sin_cos_degrees(y);
        DMat3::from_cols(DVec3::new(c, 0.0, -s), DVec3::Y, DVec3::new(s, 0.0, c))
    };
    let about_z = {
        let (s, c) = sin_cos_degrees(z);
        DMat3::from_cols(DVec3::new(c, s, 0.0), DVec3::new(-s, c, 0.0), DVec3::Z)
    };
    about_z * about_y * about_x
}

/// Sine and cosine of an angle in degrees, exact at multiples of 90.
fn sin_cos_degrees(degrees: f64) -> (f64, f64) {
    let turned = degrees.rem_euclid(360.0);
    match turned {
        0.0 => (0.0, 1.0),
        90.0 => (1.0, 0.0),
        180.0 => (0.0, -1.0),
        270.0 => (-1.0, 0.0),
        _ => trig::sin_cos(turned.to_radians()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn quarter_turns_are_exact() {
        assert_eq!(rotation([90.0, 0.0, 0.0]) * DVec3::Y, DVec3::Z);
        assert_eq!(rotation([0.0, 90.0, 0.0]) * DVec3::Z, DVec3::X);
        assert_eq!(rotation([0.0, 0.0, 90.0]) * DVec3::X, DVec3::Y);
        assert_eq!(rotation([-90.0, 0.0, 0.0]) * DVec3::Z, DVec3::Y);
        assert_eq!(rotation([360.0, -720.0, 0.0]), DMat3::IDENTITY);
    }

    #[test]
    fn rotations_are_applied_about_x_then_y_then_z() {
        let turned = rotation([90.0, 90.0, 0.0]) * DVec3::Y;
        assert_eq!(turned, DVec3::X);
        let any = rotation([10.0, 20.0, 30.0]);
        assert!((any.determinant() - 1.0).abs() < 1e-12);
        let steps =
            rotation([0.0, 0.0, 30.0]) * rotation([0.0, 20.0, 0.0]) * rotation([10.0, 0.0, 0.0]);
        assert_eq!(any, steps);
    }
}
