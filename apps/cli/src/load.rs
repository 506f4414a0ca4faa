//! From the SCENE of the command line to a scene.

use crate::arguments::SceneArguments;
use crate::failure::{Failure, exit};
use snowgrain_formats::scene::{
    LoadError, Loader, MeshScene, MeshSceneOptions, MeshUnits, SceneFile, UpAxis, builtin_scene,
    builtin_scenes, resolve, scene_for_mesh, scene_for_shot,
};
use snowgrain_formats::{
    ImportedScene, PlyContent, load_environment, load_mesh, load_plan_image, load_texture,
    ply_content, read_gltf, read_grains, read_optical_constants, read_sizes,
};
use snowgrain_geometry::TriangleMesh;
use snowgrain_render::description::SceneDescription;
use std::path::{Path, PathBuf};

/// A scene that was read.
pub(crate) struct LoadedScene {
    /// What it is called in messages.
    pub(crate) name: String,
    /// What it means.
    pub(crate) description: SceneDescription,
    /// What was assumed where nothing was said, one line each.
    pub(crate) assumptions: Vec<String>,
}

/// What SCENE is, by its name.
enum Kind {
    Builtin(&'static str),
    File,
    Mesh,
    Shot,
}

/// Reads the scene, applies `--set` and then `changes` (of the same form), and everything it refers
/// to.
pub(crate) fn load(
    arguments: &SceneArguments,
    changes: Vec<String>,
) -> Result<LoadedScene, Failure> {
    let path = arguments.scene.as_path();
    let mut overrides = arguments.overrides.clone();
    overrides.extend(changes);
    let kind = kind(path)?;
    match kind {
        Kind::Mesh => {}
        Kind::Shot => refuse_units_and_axis(arguments)?,
        Kind::Builtin(_) | Kind::File => refuse_mesh_options(arguments)?,
    }
    let mut assumptions = Vec::new();
    let (mut given, mut given_shot) = (None, None);
    let file = match kind {
        Kind::Builtin(toml) => SceneFile::parse(toml, path, &overrides)?,
        Kind::File => SceneFile::read(path, &overrides)?,
        Kind::Mesh => {
            let mesh = mesh_alone(path)?;
            let options = MeshSceneOptions {
                units: arguments.units,
                up: arguments.up,
                object_size: arguments.object_size,
                kind: arguments.kind,
            };
            let name = path.file_name().unwrap_or_default().to_string_lossy();
            let made = scene_for_mesh(&name, &mesh.bounds(), &options)?;
            assumptions = made.assumptions;
            given = Some((path.parent().unwrap_or(Path::new("")).join(&*name), mesh));
            SceneFile::parse(&made.toml, path, &overrides)?
        }
        Kind::Shot => {
            let shot = read_gltf(path)?;
            let name = path.file_name().unwrap_or_default().to_string_lossy();
            let made = shot_alone(&name, &shot, arguments)?;
            assumptions = made.assumptions;
            given_shot = Some((path.parent().unwrap_or(Path::new("")).join(&*name), shot));
            SceneFile::parse(&made.toml, path, &overrides)?
        }
    };
    let file = match arguments.frame {
        Some(frame) => file.at_frame(frame)?,
        None => file,
    };
    let loader = Loader {
        mesh: &mut read_mesh(given),
        grains: &mut |path| Ok(read_grains(path)?),
        environment: &mut |path| Ok(load_environment(path)?),
        texture: &mut |path| Ok(load_texture(path)?),
        sizes: &mut |path| Ok(read_sizes(path)?),
        plan_image: &mut |path| Ok(load_plan_image(path)?),
        optical_constants: &mut |path| Ok(read_optical_constants(path)?),
        import: &mut |path| {
            let shot = match given_shot.take_if(|(known, _)| known == path) {
                Some((_, shot)) => shot,
                None => read_gltf(path)?,
            };
            assumptions.extend(passed_over(path, &shot));
            Ok(shot)
        },
    };
    let description = resolve(&file, loader)?;
    Ok(LoadedScene { name: path.display().to_string(), description, assumptions })
}

fn kind(path: &Path) -> Result<Kind, Failure> {
    if let Some(scene) = path.to_str().and_then(builtin_scene) {
        return Ok(Kind::Builtin(scene.toml));
    }
    let extension = path.extension().map(|e| e.to_string_lossy().to_ascii_lowercase());
    match extension.as_deref() {
        Some("toml") => Ok(Kind::File),
        Some("obj" | "ply") => Ok(Kind::Mesh),
        Some("gltf" | "glb") => Ok(Kind::Shot),
        _ if path.exists() => Err(Failure::bad_input(format!(
            "{}: this is not a scene; give a .toml, a mesh (.obj, .ply), a shot (.gltf, .glb) or \
             the name of a built-in scene",
            path.display()
        ))),
        _ => {
            let names: Vec<_> = builtin_scenes().iter().map(|scene| scene.name).collect();
            Err(Failure::new(
                exit::INPUT_MISSING,
                format!(
                    "{}: there is no such file or built-in scene; the built-in ones are {}",
                    path.display(),
                    names.join(", ")
                ),
            ))
        }
    }
}

fn refuse_mesh_options(arguments: &SceneArguments) -> Result<(), Failure> {
    if let Some(kind) = arguments.kind {
        return Err(Failure::usage(format!(
            "--kind is for a mesh given as SCENE; in a scene, the snow has it (--set snow.kind={})",
            kind.name()
        )));
    }
    let options = [
        ("--units", arguments.units.is_some()),
        ("--up", arguments.up.is_some()),
        ("--object-size", arguments.object_size.is_some()),
    ];
    match options.iter().find(|(_, given)| *given) {
        Some((option, _)) => Err(Failure::usage(format!(
            "{option} is for a mesh given as SCENE; in a scene, scale and rotate the object \
             (--set object.0.scale=...)"
        ))),
        None => Ok(()),
    }
}

fn refuse_units_and_axis(arguments: &SceneArguments) -> Result<(), Failure> {
    let options = [("--units", arguments.units.is_some()), ("--up", arguments.up.is_some())];
    match options.iter().find(|(_, given)| *given) {
        Some((option, _)) => Err(Failure::usage(format!(
            "{option} is not for glTF, which is in metres with y up; --object-size says how large a \
             model is"
        ))),
        None => Ok(()),
    }
}

/// The scene for a shot given as SCENE: with its own camera, else that of a mesh.
fn shot_alone(
    name: &str,
    shot: &ImportedScene,
    arguments: &SceneArguments,
) -> Result<MeshScene, Failure> {
    let (units, up) = (Some(MeshUnits::Metres), Some(UpAxis::Y));
    let (object_size, kind) = (arguments.object_size, arguments.kind);
    let options = MeshSceneOptions { units, up, object_size, kind };
    match scene_for_shot(name, shot, kind) {
        Some(_) if arguments.object_size.is_some() => Err(Failure::usage(
            "--object-size is for a model without a camera; scale a shot by [import] scale in a scene",
        )),
        Some(made) => Ok(made),
        None => Ok(scene_for_mesh(name, &shot.bounds(), &options)?),
    }
}

/// What of a shot does not show in the picture, in one line.
fn passed_over(path: &Path, shot: &ImportedScene) -> Option<String> {
    let file = path.display();
    shot.ignored.as_ref().map(|line| format!("{file}: passed over: {line}"))
}

/// The mesh given as SCENE.
fn mesh_alone(path: &Path) -> Result<TriangleMesh, Failure> {
    let is_ply = path.extension().is_some_and(|e| e.eq_ignore_ascii_case("ply"));
    if is_ply && ply_content(path)? == PlyContent::Grains {
        let name = path.display();
        return Err(Failure::bad_input(format!(
            "{name}: this holds grains, not a mesh; write a scene that has [[snow]] with source = \
             \"file\" and file = \"{name}\", and render that"
        )));
    }
    Ok(load_mesh(path)?)
}

/// Reads meshes from files, except for the one that is there already.
fn read_mesh(
    mut given: Option<(PathBuf, TriangleMesh)>,
) -> impl FnMut(&Path) -> Result<TriangleMesh, LoadError> {
    move |path| match given.take_if(|(known, _)| known == path) {
        Some((_, mesh)) => Ok(mesh),
        None => Ok(load_mesh(path)?),
    }
}
