//! Shapes of grains as users of the laboratory name them.

use crate::error::{Fault, FormatsError, Place};
use crate::input;
use crate::mesh::load_mesh;
use crate::scene::document::{OrientationName, ShapeName, ShapeTable, SnowKindName};
use serde::Deserialize;
use snowgrain_geometry::Shape;
use snowgrain_grains::{GrainsError, MixedShape, Orientation, ShapeMix};
use snowgrain_render::laboratory::{Scatterers, ScatteringMix};
use std::path::Path;
use std::sync::Arc;

/// What a file of shapes begins with.
const EXAMPLE: &str =
    "write [[shapes]] tables, as shape = \"hexagonal-plate\", aspect = 0.2, fraction = 0.5";

#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct ShapesFile {
    #[serde(default)]
    shapes: Vec<ShapeTable>,
}

/// The grains of this name: `spheres`, the shapes of a kind of snow (`docs/snows.md`), or those of a file whose name
/// ends in `.toml`, of `[[shapes]]` tables with the keys of `[[snow.shapes]]`. `seed` draws what is sampled of them.
///
/// # Errors
/// A name that there is not, a file that cannot be read or is no such file, a key with a wrong value, grains that do
/// not take all orientations alike; every message names the file and the key.
pub fn read_scatterers(name: &str, seed: u64) -> Result<Scatterers, FormatsError> {
    if name == "spheres" {
        return Ok(Scatterers::Spheres);
    }
    let path = Path::new(name);
    let tables = match SnowKindName::from_name(name) {
        Some(kind) => kind.shapes(),
        None if path.extension().is_some_and(|end| end == "toml") => read_tables(path)?,
        None => return Err(unknown(name)),
    };
    let mut shapes = Vec::new();
    for (index, table) in tables.iter().enumerate() {
        shapes.push(mixed(path, index, table)?);
    }
    let mix = ShapeMix::new(shapes, 0);
    let mix = mix.map_err(|error| bad(path, "shapes", &error.to_string()))?;
    // Spheres need no samples.
    if mix.is_all_spheres() {
        return Ok(Scatterers::Spheres);
    }
    Ok(Scatterers::Shapes(Arc::new(ScatteringMix::new(name, mix, seed))))
}

fn unknown(name: &str) -> FormatsError {
    let kinds = SnowKindName::ALL.map(SnowKindName::name).join(", ");
    let mend = format!("write spheres, a kind of snow ({kinds}), or a file that ends in .toml");
    Fault::whole("there are no shapes of this name", mend).of(Path::new(name))
}

fn bad(path: &Path, key: &str, reason: &str) -> FormatsError {
    Fault::whole(format!("{key} cannot be used"), reason).of(path)
}

fn read_tables(path: &Path) -> Result<Vec<ShapeTable>, FormatsError> {
    let bytes = input::read_whole(path)?;
    let text =
        String::from_utf8(bytes).map_err(|_| Fault::whole("this is not text", EXAMPLE).of(path))?;
    let file: ShapesFile = toml::from_str(&text).map_err(|error| {
        let line = error.span().map_or(1, |span| 1 + text[..span.start].matches('\n').count());
        Fault::new(Place::Line(line as u64), error.message(), EXAMPLE).of(path)
    })?;
    if file.shapes.is_empty() {
        return Err(Fault::whole("there is no shape", EXAMPLE).of(path));
    }
    Ok(file.shapes)
}

fn mixed(path: &Path, index: usize, table: &ShapeTable) -> Result<MixedShape, FormatsError> {
    let at = |key: &str, reason: &str| bad(path, &format!("shapes.{index}.{key}"), reason);
    if let Some(key) = foreign_key(table) {
        return Err(at(key, "it is not a key of this shape; remove it"));
    }
    if table.orientation != OrientationName::Random {
        let reason = "grains that are met at random take all orientations alike; leave it out";
        return Err(at("orientation", reason));
    }
    let out_of_range = |error: GrainsError| match error.setting_and_reason() {
        Some((key, reason)) => at(key, reason),
        None => at("shape", &error.to_string()),
    };
    let kind = table.kind().map_err(|(key, mend)| at(key, mend))?;
    let shape = match (kind, &table.file) {
        (Some(kind), _) => Shape::new(kind).map_err(|error| out_of_range(error.into()))?,
        (None, Some(file)) => {
            let beside = path.parent().unwrap_or(Path::new("")).join(file);
            let mesh = load_mesh(&beside)?;
            Shape::of_mesh(&mesh).map_err(|error| at("file", &error.to_string()))?
        }
        (None, None) => return Err(at("file", "name the mesh, as file = \"crystal.obj\"")),
    };
    let fraction = table.fraction.unwrap_or(1.0);
    let shape = MixedShape { shape: Arc::new(shape), orientation: Orientation::Random, fraction };
    ShapeMix::new(vec![shape.clone()], 0).map_err(out_of_range)?;
    Ok(shape)
}

/// A key that is written and that the shape does not take.
fn foreign_key(table: &ShapeTable) -> Option<&'static str> {
    let written = [
        ("aspect", table.aspect.is_some()),
        ("rounding", table.rounding.is_some()),
        ("faces", table.faces.is_some()),
        ("seed", table.seed.is_some()),
        ("arms", table.arms.is_some()),
        ("file", table.file.is_some()),
        ("spread", table.spread.is_some()),
        ("axis", table.axis.is_some()),
    ];
    let keys = ShapeName::keys(table.shape);
    written.iter().find(|(key, is)| *is && !keys.contains(key)).map(|(key, _)| *key)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(text: &str) -> Result<Scatterers, String> {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("mix.toml");
        std::fs::write(&path, text).unwrap();
        read_scatterers(path.to_str().unwrap(), 0).map_err(|error| error.to_string())
    }

    #[test]
    fn shapes_are_named_by_kinds_of_snow_and_files() {
        assert_eq!(read_scatterers("spheres", 0).unwrap(), Scatterers::Spheres);
        for kind in SnowKindName::ALL {
            let Scatterers::Shapes(mix) = read_scatterers(kind.name(), 0).unwrap() else {
                panic!("{}", kind.name());
            };
            assert_eq!(mix.name(), kind.name());
        }
        let file = "[[shapes]]\nshape = \"cube\"\n[[shapes]]\nshape = \"sphere\"\nfraction = 3\n";
        let Scatterers::Shapes(mix) = read(file).unwrap() else { panic!("{file}") };
        assert_eq!(mix.mix().shapes().len(), 2);
        assert_eq!(read("[[shapes]]\nshape = \"sphere\"\n").unwrap(), Scatterers::Spheres);
    }

    #[test]
    fn what_is_wrong_with_shapes_is_named_with_its_key() {
        let error = read_scatterers("slush", 0).unwrap_err().to_string();
        assert!(error.contains("slush") && error.contains("depth-hoar"), "{error}");
        for (keys, told) in [
            ("shape = \"cube\"\naspect = 2", "shapes.0.aspect"),
            ("shape = \"spheroid\"\naspect = 2000", "shapes.0.aspect"),
            ("shape = \"hexagonal-plate\"\naspect = 3", "a plate's is at most 1"),
            ("shape = \"cube\"\nfraction = 0", "shapes.0.fraction"),
            ("shape = \"cube\"\norientation = \"horizontal\"", "shapes.0.orientation"),
            ("shape = \"mesh\"", "shapes.0.file"),
            ("shape = \"mesh\"\nfile = \"none.obj\"", "none.obj"),
            ("shape = \"cubes\"", "line 2"),
        ] {
            let message = read(&format!("[[shapes]]\n{keys}\n")).unwrap_err();
            assert!(message.contains(told), "{keys}: {message}");
        }
        assert!(read("").unwrap_err().contains("there is no shape"));
    }
}
