//! What objects are made of, and the pictures on them.

use super::super::SceneError;
use super::super::document::{MaterialName, MetalName, ObjectTable, ShapeKind};
use super::super::quantity::Triple;
use super::Files;
use super::checks::Checks;
use snowgrain_optics::Metal;
use snowgrain_render::description::Surface;
use snowgrain_render::surface::{Reflectance, TextureMap};
use std::sync::Arc;

/// Roughness of metals where none is written: brushed.
const ROUGHNESS_OF_METAL: f64 = 0.3;
/// Index of refraction of dielectrics where none is written: window glass.
const IOR_OF_GLASS: f64 = 1.5;

/// Keys of an object that only some materials take, with those.
const KEYS: [(&str, &[MaterialName]); 7] = [
    ("albedo", &[MaterialName::Diffuse]),
    ("albedo_texture", &[MaterialName::Diffuse, MaterialName::Conductor]),
    ("texture_scale", &[MaterialName::Diffuse, MaterialName::Conductor]),
    ("metal", &[MaterialName::Conductor]),
    ("reflectance", &[MaterialName::Conductor]),
    ("roughness", &[MaterialName::Conductor, MaterialName::Dielectric]),
    ("ior", &[MaterialName::Dielectric]),
];

/// Whether a key of an object tells what it is made of.
pub(super) fn is_of_material(key: &str) -> bool {
    ["material", "holdout", "shadow_catcher"].contains(&key)
        || KEYS.iter().any(|(name, _)| *name == key)
}

/// What the object at `path` is made of.
pub(super) fn surface(
    checks: &Checks<'_>,
    path: &str,
    table: &ObjectTable,
    files: &mut Files<'_, '_>,
) -> Result<Surface, SceneError> {
    refuse_others(checks, path, table.material)?;
    let texture = texture(checks, path, table, files)?.map(Reflectance::Texture);
    Ok(match table.material {
        MaterialName::Diffuse => Surface::Diffuse {
            albedo: match texture {
                Some(texture) => texture,
                None => Reflectance::Colour(albedo(checks, path, table.albedo)?),
            },
        },
        MaterialName::Conductor => Surface::Conductor {
            reflectance: match texture {
                Some(texture) => texture,
                None => Reflectance::Colour(reflectance(checks, path, table)?),
            },
            edge: table.metal.map_or([0.0; 3], |metal| known(metal).edge()),
            roughness: roughness(checks, path, table, ROUGHNESS_OF_METAL)?,
        },
        MaterialName::Dielectric => {
            let ior = table.ior.unwrap_or(IOR_OF_GLASS);
            if !(1.0..=4.0).contains(&ior) {
                let mend = "must be 1 to 4 (water has 1.33, glass 1.5, diamond 2.4)";
                return Err(checks.bad(&format!("{path}.ior"), mend));
            }
            Surface::Dielectric { ior, roughness: roughness(checks, path, table, 0.0)? }
        }
    })
}

/// The picture on an object.
fn texture(
    checks: &Checks<'_>,
    path: &str,
    table: &ObjectTable,
    files: &mut Files<'_, '_>,
) -> Result<Option<TextureMap>, SceneError> {
    let key = |name: &str| format!("{path}.{name}");
    let Some(file) = &table.albedo_texture else {
        return match table.texture_scale {
            Some(_) => Err(checks.misplaced(&key("texture_scale"), "there is no albedo_texture")),
            None => Ok(None),
        };
    };
    let instead = |name: &&str| ["albedo", "metal", "reflectance"].contains(name);
    if let Some(other) = checks.written_keys(path).find(instead) {
        let mend = "the picture of albedo_texture stands for it; remove one of them";
        return Err(checks.misplaced(&key(other), mend));
    }
    let metres = match (table.texture_scale, table.shape) {
        (None, _) => 1.0,
        (Some(scale), ShapeKind::Plane) => checks.size(&key("texture_scale"), scale)?,
        (Some(_), _) => {
            let mend = "only a plane takes it; other shapes have coordinates of their own";
            return Err(checks.misplaced(&key("texture_scale"), mend));
        }
    };
    let key = key("albedo_texture");
    let path = checks.reference(&key, file)?;
    let known = files.textures.iter().find(|(known, _)| *known == path);
    let texture = match known {
        Some((_, texture)) => Arc::clone(texture),
        None => {
            let read = (files.texture)(&path).map_err(|cause| checks.unusable(&key, cause))?;
            let texture = Arc::new(read);
            files.textures.push((path, Arc::clone(&texture)));
            texture
        }
    };
    Ok(Some(TextureMap { texture, factor: [1.0; 3], metres }))
}

/// The surface of an object in a place that has an albedo of its own.
pub(super) fn with_albedo(
    checks: &Checks<'_>,
    path: &str,
    own: Option<Triple>,
    surface: &Surface,
) -> Result<Surface, SceneError> {
    let Some(own) = own else { return Ok(surface.clone()) };
    match surface {
        Surface::Diffuse { albedo: Reflectance::Texture(_) } => {
            let mend = "the picture of albedo_texture stands for it; remove it";
            Err(checks.misplaced(&format!("{path}.albedo"), mend))
        }
        Surface::Diffuse { .. } => Ok(Surface::diffuse(albedo(checks, path, own)?)),
        Surface::Conductor { .. } | Surface::Dielectric { .. } => {
            let mend = "only diffuse objects have an albedo; remove it";
            Err(checks.misplaced(&format!("{path}.albedo"), mend))
        }
    }
}

/// Refuses keys of other materials.
fn refuse_others(
    checks: &Checks<'_>,
    path: &str,
    material: MaterialName,
) -> Result<(), SceneError> {
    for (name, materials) in KEYS {
        if !materials.contains(&material) && checks.written_keys(path).any(|key| key == name) {
            let takes: Vec<_> = materials.iter().map(|of| format!("{:?}", written(*of))).collect();
            let mend = format!("only material = {} takes it", takes.join(" or "));
            return Err(checks.misplaced(&format!("{path}.{name}"), mend));
        }
    }
    Ok(())
}

fn written(material: MaterialName) -> &'static str {
    match material {
        MaterialName::Diffuse => "diffuse",
        MaterialName::Conductor => "conductor",
        MaterialName::Dielectric => "dielectric",
    }
}

fn albedo(checks: &Checks<'_>, path: &str, albedo: Triple) -> Result<[f32; 3], SceneError> {
    parts(checks, &format!("{path}.albedo"), albedo)
}

fn reflectance(
    checks: &Checks<'_>,
    path: &str,
    table: &ObjectTable,
) -> Result<[f32; 3], SceneError> {
    let key = format!("{path}.reflectance");
    match (table.metal, table.reflectance) {
        (Some(metal), None) => Ok(known(metal).reflectance()),
        (None, Some(colour)) => parts(checks, &key, colour),
        (Some(_), Some(_)) => Err(checks.misplaced(&key, "the metal has one; remove one of them")),
        (None, None) => {
            let mend = "name the metal, as metal = \"gold\", or give reflectance = [r, g, b]";
            Err(checks.missing(&format!("{path}.metal"), mend))
        }
    }
}

fn known(metal: MetalName) -> Metal {
    match metal {
        MetalName::Aluminium => Metal::Aluminium,
        MetalName::Chromium => Metal::Chromium,
        MetalName::Copper => Metal::Copper,
        MetalName::Gold => Metal::Gold,
        MetalName::Iron => Metal::Iron,
        MetalName::Silver => Metal::Silver,
    }
}

fn roughness(
    checks: &Checks<'_>,
    path: &str,
    table: &ObjectTable,
    default: f64,
) -> Result<f64, SceneError> {
    let roughness = table.roughness.unwrap_or(default);
    if (0.0..=1.0).contains(&roughness) {
        return Ok(roughness);
    }
    Err(checks.bad(&format!("{path}.roughness"), "must be 0 (smooth) to 1"))
}

/// A colour of parts of the light.
fn parts(checks: &Checks<'_>, key: &str, colour: Triple) -> Result<[f32; 3], SceneError> {
    if colour.0.iter().all(|part| (0.0..=1.0).contains(part)) {
        return Ok(colour.0.map(|part| part as f32));
    }
    Err(checks.bad(key, "each must be 0 to 1"))
}
