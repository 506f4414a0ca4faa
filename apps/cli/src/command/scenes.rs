//! `snowgrain scenes`.

use crate::arguments::ScenesArguments;
use crate::failure::{Failure, exit};
use crate::output;
use snowgrain_formats::scene::{builtin_scene, builtin_scenes};

pub(super) fn run(arguments: &ScenesArguments) -> Result<u8, Failure> {
    match &arguments.name {
        Some(name) => match builtin_scene(name) {
            Some(scene) => output::print(scene.toml)?,
            None => {
                let message = format!(
                    "{name}: there is no such built-in scene; `snowgrain scenes` lists them"
                );
                return Err(Failure::new(exit::INPUT_MISSING, message));
            }
        },
        None => output::print(&list())?,
    }
    Ok(0)
}

fn list() -> String {
    let widest = builtin_scenes().iter().map(|scene| scene.name.len()).max().unwrap_or(0);
    builtin_scenes()
        .iter()
        .map(|scene| format!("{:widest$}  {}\n", scene.name, scene.summary))
        .collect()
}
