//! `cargo xtask look`: whether close pictures of snow measure what real snow does.

mod bleed;
mod contrast;
mod cover;
mod directions;
mod display;
mod facets;
mod field;
mod lab;
mod light;
mod patch;
mod shade;
mod stage;
mod translucency;

use crate::program::Program;
use crate::sections::{self, Named};
use anyhow::Result;
use stage::Stage;
use std::path::PathBuf;

const TITLE: &str = "The look of snow";

/// Above the table of all comparisons.
const INTRODUCTION: &str = "Written by `cargo xtask look`: what makes snow look like snow, measured in pictures \
(EXR) and by the laboratory, beside a Lambertian surface of the same shape where that has a figure of its own. \
Scenes are in `docs/look/`, from where the commands run; packs of grains (`.ply`) are written by the task before. \
What is expected comes from section 7 of the project's physics: figures of close pictures of snow, of theory, and of \
an earlier tracer of the same spheres. Where that holds for other light or other snow than was measured, \
the section says so and what is compared instead; lines that are told but not judged fail nothing.

What this shows: pictures of real-size grains have the contrast, bleeding, translucency and shade of snow made of \
spheres, and a Lambertian surface has not. What it does not show: that snow is spheres; natural snow sends less \
light forward.
";

/// Options of the task.
#[derive(clap::Args)]
pub(crate) struct Options {
    /// Folder for look.md, and for the scenes in look/ below it
    #[arg(long, value_name = "DIR", default_value = "docs")]
    out: PathBuf,

    /// Fewer samples and cases; tolerances stay
    #[arg(long)]
    quick: bool,

    /// Only these sections
    #[arg(long, value_name = "NAME,...", value_delimiter = ',')]
    sections: Vec<String>,
}

const SECTIONS: [Named<Stage>; 8] = [
    ("contrast", contrast::section),
    ("bleed", bleed::section),
    ("translucency", translucency::section),
    ("shade", shade::section),
    ("directions", directions::section),
    ("display", display::section),
    ("cover", cover::section),
    ("facets", facets::section),
];

/// Writes the report; false where a line that is judged fails.
pub(crate) fn look(options: &Options) -> Result<bool> {
    sections::check_names(&SECTIONS, &options.sections)?;
    let scenes = options.out.join("look");
    std::fs::create_dir_all(&scenes)?;
    let stage = Stage { program: Program::build()?, scenes, quick: options.quick };
    let file = options.out.join("look.md");
    sections::write(&SECTIONS, &options.sections, &stage, (&file, TITLE, INTRODUCTION))
}
