//! Second stage: from a [`SceneFile`] to the [`SceneDescription`] that it means.

mod camera;
mod checks;
mod deep;
mod import;
mod lights;
mod objects;
mod roads;
mod shapes;
mod snow;
mod substance;
mod surfaces;

use super::document::{IntegratorName, KeepName, PackingName, PrimariesName, SamplerName};
use super::quantity::LoadText;
use super::{LoadError, SceneError, SceneFile};
use crate::gltf::ImportedScene;
use crate::laboratory::{impurity_kind, parse_load};
use checks::Checks;
use snowgrain_geometry::TriangleMesh;
use snowgrain_grains::GrainField;
use snowgrain_optics::{Impurity, MeasuredSubstance, Primaries};
use snowgrain_render::description::{
    DirectView, FilmDescription, IntegratorKind, LightDescription, LightFinding, LightKind,
    Packing, Sampler, SceneDescription, Surface,
};
use snowgrain_render::light::EnvironmentMap;
use snowgrain_render::surface::Texture;
use snowgrain_render::transport::medium::MediumKind;
use snowgrain_render::{STRATA, Strata};
use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;

/// Reads a mesh file, in metres.
pub type ReadMesh<'a> = dyn FnMut(&Path) -> Result<TriangleMesh, LoadError> + 'a;

/// Reads a grain file.
pub type ReadGrains<'a> = dyn FnMut(&Path) -> Result<GrainField, LoadError> + 'a;

/// Reads a shot made elsewhere.
pub type ReadImport<'a> = dyn FnMut(&Path) -> Result<ImportedScene, LoadError> + 'a;

/// Reads a map of all directions.
pub type ReadEnvironment<'a> = dyn FnMut(&Path) -> Result<EnvironmentMap, LoadError> + 'a;

/// Reads a picture that lies on objects.
pub type ReadTexture<'a> = dyn FnMut(&Path) -> Result<Texture, LoadError> + 'a;

/// Reads a file of sizes: radii, metres, and numbers of grains.
pub type ReadSizes<'a> = dyn FnMut(&Path) -> Result<Vec<(f64, f64)>, LoadError> + 'a;

/// Reads a picture of numbers: columns and rows, and the grey values as they stand, white 1.
pub type ReadPlanImage<'a> = dyn FnMut(&Path) -> Result<([usize; 2], Vec<f32>), LoadError> + 'a;

/// Reads a table of indices of refraction.
pub type ReadOpticalConstants<'a> = dyn FnMut(&Path) -> Result<MeasuredSubstance, LoadError> + 'a;

/// How the files that a scene refers to are read.
pub struct Loader<'a> {
    /// Reads a mesh.
    pub mesh: &'a mut ReadMesh<'a>,
    /// Reads grains.
    pub grains: &'a mut ReadGrains<'a>,
    /// Reads a shot.
    pub import: &'a mut ReadImport<'a>,
    /// Reads a map.
    pub environment: &'a mut ReadEnvironment<'a>,
    /// Reads a picture on an object.
    pub texture: &'a mut ReadTexture<'a>,
    /// Reads sizes of grains.
    pub sizes: &'a mut ReadSizes<'a>,
    /// Reads heights of snow or a mask.
    pub plan_image: &'a mut ReadPlanImage<'a>,
    /// Reads indices of refraction.
    pub optical_constants: &'a mut ReadOpticalConstants<'a>,
}

/// What the scene means: every value checked, units converted, references loaded (relative to the
/// scene file's folder, each mesh once), defaults filled in.
///
/// # Errors
/// A value out of range, keys that do not belong together, a file that cannot be used.
///
/// ```
/// use snowgrain_formats::scene::{Loader, SceneFile, builtin_scene, resolve};
/// let scene = builtin_scene("snowy-teapot").unwrap();
/// let file = SceneFile::parse(scene.toml, "snowy-teapot".as_ref(), &["film.width=64".into()])?;
/// let none = |_: &std::path::Path| Err("it refers to no file".into());
/// let loader = Loader {
///     mesh: &mut { none },
///     grains: &mut |_| Err("nor here".into()),
///     environment: &mut |_| Err("nor here".into()),
///     texture: &mut |_| Err("nor here".into()),
///     sizes: &mut |_| Err("nor here".into()),
///     plan_image: &mut |_| Err("nor here".into()),
///     optical_constants: &mut |_| Err("nor here".into()),
///     import: &mut |_| Err("nor here".into()),
/// };
/// let description = resolve(&file, loader)?;
/// assert_eq!(description.film.width, 64);
/// # Ok::<(), snowgrain_formats::scene::SceneError>(())
/// ```
pub fn resolve(file: &SceneFile, loader: Loader<'_>) -> Result<SceneDescription, SceneError> {
    let checks = Checks::new(file);
    let Loader { mesh, grains, environment, import, texture, sizes, plan_image, optical_constants } =
        loader;
    let film = film(&checks)?;
    let written_camera = camera::camera(&checks)?;
    let mut ice = substance::grains(&checks, optical_constants)?;
    let shot = import::import(&checks, import)?;
    let mut lights = lights::lights(&checks, shot.lights, environment)?;
    let no_camera =
        || checks.missing("camera", "add [camera] with from = [0, 1, 3], at = [0, 0, 0]");
    let camera = written_camera.or(shot.camera).ok_or_else(no_camera)?;
    let mut files = Files { mesh, texture, meshes: Vec::new(), textures: Vec::new() };
    let (objects, lamps) = objects::objects(&checks, shot.objects, &mut files)?;
    lights.extend(lamps);
    let bounded = objects.iter().any(objects::is_finite);
    let mut snow_files = snow::SnowFiles { grains, sizes, plan_image, objects: &mut files };
    let snow = snow::snow(&checks, bounded, &ice, &mut snow_files)?;
    let shapes = shapes::shapes(&checks, &mut files)?;
    let (everywhere, strata) = strata(&checks, film.keep_ice_paths)?;
    ice.impurities.extend(everywhere);
    if objects.is_empty() && snow.is_empty() {
        return Err(checks.missing("snow", "the scene is empty; add [[snow]] or [[object]]"));
    }
    let light_finding = lights::finding(&checks, &lights)?;
    let has_small_lights = light_finding != LightFinding::Exact;
    let integrator = match file.document.integrator.kind {
        IntegratorName::Grains => deep::proxy(&checks, has_small_lights)?
            .map_or(IntegratorKind::Grains, IntegratorKind::ProxyInDepth),
        IntegratorName::Volume => IntegratorKind::Medium(MediumKind::Volume),
        IntegratorName::Proxy => IntegratorKind::Medium(MediumKind::Proxy),
        IntegratorName::Dipole => IntegratorKind::Medium(MediumKind::Dipole),
    };
    let packing = file.document.integrator.packing.map(|name| match name {
        PackingName::Fast => Packing::Fast,
        PackingName::Compact => Packing::Compact,
    });
    let deep = deep::deep(&checks, has_small_lights)?;
    let scene = SceneDescription {
        film,
        camera,
        ice,
        lights,
        objects,
        snow,
        shapes,
        strata,
        integrator,
        light_finding,
        deep,
        packing,
        tiled: file.document.integrator.tiled,
    };
    if !scene.can_be_tiled_as_told() {
        let mend = "needs snow of source \"pack\" or \"fill\" alone, of spheres with the same settings, without mask, density_map, shapes or impurities of its own; remove it";
        return Err(checks.bad("integrator.tiled", mend));
    }
    roads::refuse_beyond(&checks, &scene)?;
    Ok(scene)
}

fn film(checks: &Checks<'_>) -> Result<FilmDescription, SceneError> {
    let film = &checks.document().film;
    for (key, pixels) in [("film.width", film.width), ("film.height", film.height)] {
        if !(1..=65536).contains(&pixels) {
            return Err(checks.bad(key, "must be 1 to 65536 pixels"));
        }
    }
    if film.samples_per_pixel == 0 {
        return Err(checks.bad("film.samples_per_pixel", "must be at least 1"));
    }
    Ok(FilmDescription {
        width: film.width,
        height: film.height,
        samples_per_pixel: film.samples_per_pixel,
        seed: film.seed,
        sampler: match film.sampler {
            SamplerName::Independent => Sampler::Independent,
            SamplerName::Sobol => Sampler::Sobol,
        },
        primaries: match film.primaries {
            PrimariesName::Srgb => Primaries::Srgb,
            PrimariesName::Acescg => Primaries::AcesCg,
        },
        keep_ice_paths: film.keep.contains(&KeepName::IcePaths),
        exposure_stops: camera::exposure_stops(checks)?,
        keep_light_groups: film.keep.contains(&KeepName::LightGroups),
    })
}

/// The impurities of bodies of snow: those that all have, and those of single ones.
fn strata(
    checks: &Checks<'_>,
    keeps_ice_paths: bool,
) -> Result<(Vec<Impurity>, Strata), SceneError> {
    let loads = |(index, snow): (usize, &super::document::SnowTable)| {
        impurities(checks, &format!("snow.{index}.impurities"), &snow.impurities)
    };
    let bodies: Vec<_> =
        checks.document().snow.iter().enumerate().map(loads).collect::<Result<_, _>>()?;
    if let [first, others @ ..] = bodies.as_slice()
        && others.iter().all(|other| other == first)
    {
        return Ok((first.clone(), Strata::default()));
    }
    let strata = Strata::of(&bodies).ok_or_else(|| {
        let mend = format!(
            "at most {STRATA} loads may differ; give all snow what it shares by ice.impurities"
        );
        checks.bad("snow", mend)
    })?;
    if keeps_ice_paths && !strata.loads.is_empty() {
        let mend = "ice paths do not tell one snow from another: leave them out, or give all snow the \
                    same by ice.impurities";
        return Err(checks.misplaced("film.keep", mend));
    }
    Ok((Vec::new(), strata))
}

/// The loads at a key.
fn impurities(
    checks: &Checks<'_>,
    key: &str,
    loads: &BTreeMap<String, LoadText>,
) -> Result<Vec<Impurity>, SceneError> {
    let impurity = |(name, load): (&String, &LoadText)| {
        let kind = impurity_kind(name)?;
        Ok(Impurity { kind, load: parse_load(kind, &load.0)? })
    };
    loads.iter().map(impurity).collect::<Result<_, String>>().map_err(|mend| checks.bad(key, mend))
}

/// The scene as a furnace: all objects diffuse of albedo 1 and seen, no absorption, and for light only a uniform sphere of
/// radiance 1. Nothing is lost and nothing is gained, so every pixel must be exactly 1.
#[must_use]
pub fn furnace(mut scene: SceneDescription) -> SceneDescription {
    scene.ice.absorption = scene.ice.absorption.none();
    scene.ice.impurities.clear();
    scene.strata = Strata::default();
    scene.lights = vec![LightDescription::new(LightKind::Uniform, [1.0; 3])];
    scene.light_finding = LightFinding::Exact;
    scene.deep = None;
    scene.camera.backdrop = [1.0; 3];
    for object in &mut scene.objects {
        object.surface = Surface::diffuse([1.0; 3]);
        object.direct_view = DirectView::Seen;
    }
    scene
}

/// The files of objects, each read once, in the order of their first use.
struct Files<'a, 'b> {
    mesh: &'b mut ReadMesh<'a>,
    texture: &'b mut ReadTexture<'a>,
    meshes: Vec<(PathBuf, Arc<TriangleMesh>)>,
    textures: Vec<(PathBuf, Arc<Texture>)>,
}
