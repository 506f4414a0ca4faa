//! What `[[snow.shapes]]` means.

use super::super::SceneError;
use super::super::document::{OrientationName, ShapeTable, SnowTable};
use super::checks::Checks;
use super::{Files, objects};
use snowgrain_geometry::Shape;
use snowgrain_grains::{GrainsError, MixedShape, Orientation, ShapeMix};
use snowgrain_math::DVec3;
use std::sync::Arc;

/// Keys that every shape takes.
const COMMON: [&str; 3] = ["shape", "fraction", "orientation"];

/// Of each body of snow.
pub(super) fn shapes(
    checks: &Checks<'_>,
    files: &mut Files<'_, '_>,
) -> Result<Vec<Option<ShapeMix>>, SceneError> {
    let snow = checks.document().snow.iter().enumerate();
    snow.map(|(body, table)| mix(checks, files, (body, table))).collect()
}

fn mix(
    checks: &Checks<'_>,
    files: &mut Files<'_, '_>,
    (body, snow): (usize, &SnowTable),
) -> Result<Option<ShapeMix>, SceneError> {
    if snow.shapes.is_empty() {
        return Ok(None);
    }
    let mut shapes = Vec::new();
    for (index, table) in snow.shapes.iter().enumerate() {
        let path = format!("snow.{body}.shapes.{index}");
        let entry = Entry { checks, path, table };
        entry.refuse_foreign_keys()?;
        shapes.push(MixedShape {
            shape: Arc::new(entry.shape(files)?),
            orientation: entry.orientation(),
            fraction: table.fraction.unwrap_or(1.0),
        });
        entry.check(&shapes[index])?;
    }
    let seed = snow.seed.unwrap_or(body as u64);
    let mix = ShapeMix::new(shapes, seed);
    mix.map(Some).map_err(|error| checks.bad(&format!("snow.{body}.shapes"), error.to_string()))
}

/// One `[[snow.shapes]]` under examination.
struct Entry<'a> {
    checks: &'a Checks<'a>,
    path: String,
    table: &'a ShapeTable,
}

impl Entry<'_> {
    fn key(&self, name: &str) -> String {
        format!("{}.{name}", self.path)
    }

    fn refuse_foreign_keys(&self) -> Result<(), SceneError> {
        let (shape, orientation) = (self.table.shape, self.table.orientation);
        let known = |key: &&str| {
            COMMON.contains(key) || shape.keys().contains(key) || orientation.keys().contains(key)
        };
        let foreign = self.checks.written_keys(&self.path).find(|key| !known(key));
        let Some(name) = foreign else { return Ok(()) };
        let all: Vec<&str> = [&COMMON[..], shape.keys(), orientation.keys()].concat();
        let mend = format!(
            "not a key of this shape and orientation, which take {}; remove it or change those",
            all.join(", ")
        );
        Err(self.checks.misplaced(&self.key(name), mend))
    }

    fn shape(&self, files: &mut Files<'_, '_>) -> Result<Shape, SceneError> {
        let kind = self.table.kind();
        let kind = kind.map_err(|(name, mend)| self.checks.bad(&self.key(name), mend))?;
        let Some(kind) = kind else { return self.mesh(files) };
        Shape::new(kind).map_err(|error| self.out_of_range(error.into()))
    }

    fn mesh(&self, files: &mut Files<'_, '_>) -> Result<Shape, SceneError> {
        let key = self.key("file");
        let mend = "name the mesh, as file = \"crystal.obj\"";
        let file = self.table.file.as_deref();
        let file = file.ok_or_else(|| self.checks.missing(&key, mend))?;
        let mesh = objects::mesh(self.checks, &key, file, files)?;
        Shape::of_mesh(&mesh).map_err(|error| self.checks.unusable(&key, error.into()))
    }

    fn orientation(&self) -> Orientation {
        let spread_degrees = self.table.spread.unwrap_or(0.0);
        match self.table.orientation {
            OrientationName::Random => Orientation::Random,
            OrientationName::Horizontal => Orientation::Horizontal { spread_degrees },
            OrientationName::Aligned => Orientation::Aligned {
                axis: DVec3::from_array(self.table.axis.unwrap_or([0.0, 1.0, 0.0])),
                spread_degrees,
            },
        }
    }

    /// Refuses numbers out of range, by the key that holds them.
    fn check(&self, shape: &MixedShape) -> Result<(), SceneError> {
        let checked = ShapeMix::new(vec![shape.clone()], 0);
        checked.map(|_| ()).map_err(|error| self.out_of_range(error))
    }

    fn out_of_range(&self, error: GrainsError) -> SceneError {
        match error.setting_and_reason() {
            Some((key, reason)) => self.checks.bad(&self.key(key), reason),
            None => self.checks.bad(&self.path, error.to_string()),
        }
    }
}
