//! `cargo xtask validate`: reruns everything that the program is compared with.

mod brdf;
mod colour;
mod deep_albedo;
mod folding;
mod grain;
mod identities;
mod interpolation;
mod layers;
mod measured;
mod packing;
mod shapes;
mod soot;
mod speed;
mod spread;
mod theory;
mod wet;

use crate::program::Program;
use crate::report::Section;
use crate::sections::{self, Named};
use crate::table::{Row, Table};
use anyhow::{Context as _, Result};
use std::path::{Path, PathBuf};

/// Above the table of all comparisons.
const INTRODUCTION: &str = "Written by `cargo xtask validate`: every figure here was printed by the commands \
under its section, or, where none is given, comes from that task itself. Deviations are absolute, or, where the \
tolerance is in per cent, parts of what was expected; sigma is the standard error of Monte Carlo.

What this shows: the program solves the problem that it states, light in spheres of ice by geometric optics, as \
independent programs and exact identities do. Discrete ordinates know snow as the same spheres met at random: they \
test the code, not the physics. What it does not show: that snow is spheres. Only the measured albedos are of real \
snow; where they fail, the model of smooth spheres, or an assumption about the snow, does not hold. No parameter was \
tuned to pass. Those lines, and others that are said not to be judged, do not fail the task.
";

/// Options of the task.
#[derive(clap::Args)]
pub(crate) struct Options {
    /// Folder for VALIDATION.md, and for figures in validation/ below it
    #[arg(long, value_name = "DIR", default_value = "docs")]
    out: PathBuf,

    /// Fewer cases and larger standard errors
    #[arg(long)]
    quick: bool,

    /// Folder of the reference tables
    #[arg(long, value_name = "DIR", default_value = "tests/data")]
    data: PathBuf,

    /// Only these sections
    #[arg(long, value_name = "NAME,...", value_delimiter = ',')]
    sections: Vec<String>,
}

/// What sections are made with.
pub(crate) struct Bench {
    program: Program,
    data: PathBuf,
    figures: PathBuf,
    quick: bool,
}

const SECTIONS: [Named<Bench>; 16] = [
    ("grain", grain::section),
    ("shapes", shapes::section),
    ("identities", identities::section),
    ("packing", packing::section),
    ("deep-albedo", deep_albedo::section),
    ("layers", layers::section),
    ("soot", soot::section),
    ("folding", folding::section),
    ("colour", colour::section),
    ("theory", theory::section),
    ("measured", measured::section),
    ("interpolation", interpolation::section),
    ("brdf", brdf::section),
    ("spread", spread::section),
    ("wet", wet::section),
    ("speed", speed::section),
];

/// Writes the report; false where a line fails.
pub(crate) fn validate(options: &Options) -> Result<bool> {
    sections::check_names(&SECTIONS, &options.sections)?;
    let figures = options.out.join("validation");
    std::fs::create_dir_all(&figures)?;
    let (data, quick) = (options.data.clone(), options.quick);
    let bench = Bench { program: Program::build()?, data, figures, quick };
    let file = options.out.join("VALIDATION.md");
    sections::write(&SECTIONS, &options.sections, &bench, (&file, "Validation", INTRODUCTION))
}

impl Bench {
    /// `full`, or `quick` where that is asked for.
    fn choose<T>(&self, full: T, quick: T) -> T {
        if self.quick { quick } else { full }
    }

    fn reference(&self, file: &str) -> Result<Table> {
        let path = self.data.join(file);
        let text = std::fs::read_to_string(&path).with_context(|| path.display().to_string())?;
        Table::parse(&text)
    }

    /// The table that a command prints; the section tells the command.
    fn table(&self, section: &mut Section, arguments: &str) -> Result<Table> {
        section.command(format!("snowgrain {arguments}"));
        self.program.table(arguments, None)
    }

    /// The same, and the figure that it draws.
    fn table_and_plot(&self, section: &mut Section, arguments: &str, file: &str) -> Result<Table> {
        section.command(format!("snowgrain {arguments} --plot docs/validation/{file}"));
        self.program.table(arguments, Some(&self.figure(file)))
    }

    fn json(&self, section: &mut Section, arguments: &str) -> Result<serde_json::Value> {
        section.command(format!("snowgrain {arguments}"));
        Ok(serde_json::from_str(&self.program.print(arguments, None)?)?)
    }

    fn figure(&self, file: &str) -> PathBuf {
        self.figures.join(file)
    }

    fn folder(&self) -> &Path {
        self.program.folder()
    }
}

/// A number of a JSON document, by the names that lead to it.
fn number(value: &serde_json::Value, pointer: &str) -> Result<f64> {
    let found = value.pointer(pointer).and_then(serde_json::Value::as_f64);
    found.with_context(|| format!("no number {pointer}"))
}

/// `a,b,c` with a unit behind each.
fn list(values: &[String], unit: &str) -> String {
    let with_unit: Vec<String> = values.iter().map(|value| format!("{value}{unit}")).collect();
    with_unit.join(",")
}

/// Angles as options: all that are numbers, and diffuse light.
fn incidences(angles: &[String]) -> String {
    let degrees: Vec<String> = angles.iter().filter(|angle| *angle != "diffuse").cloned().collect();
    let diffuse = if degrees.len() < angles.len() { "--diffuse" } else { "" };
    if degrees.is_empty() {
        diffuse.into()
    } else {
        format!("{diffuse} --sza {}", list(&degrees, ""))
    }
}

/// What identifies a row, for a reader.
fn name_of(row: &Row<'_>, names: &[(&str, &str)]) -> Result<String> {
    let parts = names.iter().map(|(name, unit)| {
        let value = row.text(name)?;
        Ok(if value == "diffuse" { value.to_owned() } else { format!("{value} {unit}") })
    });
    Ok(parts.collect::<Result<Vec<_>>>()?.join(", "))
}
