//! What `[[object]]` means.

use super::super::SceneError;
use super::super::document::{ObjectTable, ShapeKind};
use super::checks::{Checks, LARGEST, SMALLEST};
use super::{Meshes, ReadMesh};
use snowgrain_geometry::TriangleMesh;
use snowgrain_math::{DAffine3, DMat3, DVec3, trig};
use snowgrain_render::description::{ObjectDescription, ObjectShape};
use std::path::Path;
use std::sync::Arc;

pub(super) fn objects(
    checks: &Checks<'_>,
    read_mesh: &mut ReadMesh<'_>,
) -> Result<Vec<ObjectDescription>, SceneError> {
    let mut meshes = Meshes::new();
    let tables = checks.document().object.iter().enumerate();
    tables.map(|(i, table)| object(checks, i, table, &mut meshes, read_mesh)).collect()
}

/// Whether the object has a bounding box.
pub(super) fn is_finite(object: &ObjectDescription) -> bool {
    match object.shape {
        ObjectShape::Plane => false,
        ObjectShape::Sphere | ObjectShape::Box | ObjectShape::Teapot | ObjectShape::Mesh(_) => true,
    }
}

fn object(
    checks: &Checks<'_>,
    index: usize,
    table: &ObjectTable,
    meshes: &mut Meshes,
    read_mesh: &mut ReadMesh<'_>,
) -> Result<ObjectDescription, SceneError> {
    let path = format!("object.{index}");
    let key = |name: &str| format!("{path}.{name}");
    let albedo = table.albedo.0;
    if !albedo.iter().all(|a| (0.0..=1.0).contains(a)) {
        return Err(checks.bad(&key("albedo"), "each must be 0 to 1"));
    }
    let transform = transform(checks, &path, table)?;
    let shape = match (table.shape, &table.file) {
        (ShapeKind::Mesh, Some(file)) => {
            let mesh = mesh(checks, &key("file"), file, meshes, read_mesh)?;
            check_reach(checks, &key("scale"), &mesh, &transform)?;
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
        (None, None) => path,
    };
    Ok(ObjectDescription { name, shape, albedo: albedo.map(|a| a as f32), transform })
}

fn mesh(
    checks: &Checks<'_>,
    key: &str,
    file: &str,
    meshes: &mut Meshes,
    read_mesh: &mut ReadMesh<'_>,
) -> Result<Arc<TriangleMesh>, SceneError> {
    let path = checks.reference(key, file)?;
    if let Some((_, mesh)) = meshes.iter().find(|(known, _)| *known == path) {
        return Ok(Arc::clone(mesh));
    }
    let mesh = Arc::new(read_mesh(&path).map_err(|cause| checks.unusable(key, cause))?);
    meshes.push((path, Arc::clone(&mesh)));
    Ok(mesh)
}

/// A mesh may hold any finite vertex; placed in the world it must stay within reach.
fn check_reach(
    checks: &Checks<'_>,
    key: &str,
    mesh: &TriangleMesh,
    transform: &DAffine3,
) -> Result<(), SceneError> {
    let bounds = mesh.bounds();
    let corner = bounds.min.abs().max(bounds.max.abs());
    let reach =
        corner.max_element() * transform.matrix3.to_cols_array().map(f64::abs).iter().sum::<f64>();
    if reach <= LARGEST {
        return Ok(());
    }
    Err(checks.bad(key, format!("the mesh reaches {reach:e} m; use a smaller scale")))
}

fn transform(checks: &Checks<'_>, path: &str, table: &ObjectTable) -> Result<DAffine3, SceneError> {
    let key = |name: &str| format!("{path}.{name}");
    let scale = table.scale.0;
    if !scale.iter().all(|s| (SMALLEST..=LARGEST).contains(&s.abs())) {
        return Err(checks.bad(&key("scale"), "must be finite and not 0"));
    }
    let rotate = checks.finite(&key("rotate"), table.rotate)?;
    let translate = checks.position(&key("translate"), table.translate)?;
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
