//! Scenes that the task writes, rendered by the program.

use crate::program::Program;
use crate::report::Section;
use crate::table::Table;
use anyhow::{Context as _, Result};
use snowgrain_film::Picture;
use snowgrain_formats::image::read_picture;
use snowgrain_formats::write_grains;
use snowgrain_grains::{ICE_DENSITY, RandomSettings, random_pack};
use std::path::PathBuf;

/// Radius of the grains of all scenes, metres.
pub(super) const RADIUS: f64 = 5e-4;

/// What sections are made with.
pub(crate) struct Stage {
    pub(super) program: Program,
    /// Where scenes are kept for readers.
    pub(super) scenes: PathBuf,
    pub(super) quick: bool,
}

/// A pack of grains at random places, none touching another, its lowest corner in the origin.
pub(super) struct Pack {
    pub(super) file: &'static str,
    pub(super) solid_fraction: f64,
    /// Metres.
    pub(super) width: f64,
    pub(super) depth: f64,
}

impl Stage {
    /// `full`, or `quick` where that is asked for.
    pub(super) fn choose<T>(&self, full: T, quick: T) -> T {
        if self.quick { quick } else { full }
    }

    /// The picture of a scene; the section tells the command.
    pub(super) fn render(
        &self,
        section: &mut Section,
        (name, scene): (&str, &str),
        options: &str,
    ) -> Result<Picture> {
        self.write_scene(name, scene)?;
        let command = format!("render {name}.toml -o {name}.exr {options}");
        section.command(format!("snowgrain {command}"));
        self.program.print(&format!("{command} --quiet"), None)?;
        Ok(read_picture(&self.program.folder().join(format!("{name}.exr")))?)
    }

    /// Writes a scene where the program runs, and where readers find it.
    pub(super) fn write_scene(&self, name: &str, scene: &str) -> Result<()> {
        for folder in [self.scenes.as_path(), self.program.folder()] {
            std::fs::write(folder.join(format!("{name}.toml")), scene)?;
        }
        Ok(())
    }

    /// The table that a command prints; the section tells the command.
    pub(super) fn table(&self, section: &mut Section, arguments: &str) -> Result<Table> {
        section.command(format!("snowgrain {arguments}"));
        self.program.table(arguments, None)
    }

    /// What the program tells of a snowfall, by the names that lead to it.
    pub(super) fn deposit(&self, section: &mut Section, name: &str) -> Result<serde_json::Value> {
        let command = format!("deposit {name}.toml -o {name}.ply --json-stats {name}.json");
        section.command(format!("snowgrain {command}"));
        self.program.print(&format!("{command} --quiet"), None)?;
        let text = std::fs::read_to_string(self.program.folder().join(format!("{name}.json")))?;
        Ok(serde_json::from_str(&text)?)
    }

    /// Writes a pack where scenes find it.
    pub(super) fn write_pack(&self, pack: &Pack) -> Result<()> {
        let file = self.program.folder().join(pack.file);
        if file.exists() {
            return Ok(());
        }
        let (grains, _) = random_pack(&RandomSettings {
            radius: RADIUS,
            density: pack.solid_fraction * ICE_DENSITY,
            depth: pack.depth,
            width: pack.width,
            seed: 1,
        })?;
        write_grains(&file, &grains).with_context(|| pack.file.to_owned())
    }
}
