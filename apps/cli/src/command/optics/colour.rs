//! `snowgrain optics colour`.

use super::cases::find_all;
use super::snow;
use super::swatches::{Swatch, svg};
use super::table::{Cell, Table};
use crate::arguments::ColourArguments;
use crate::failure::Failure;
use crate::output;
use crate::progress::Progress;
use crate::threads::pool;
use snowgrain_math::DVec3;
use snowgrain_optics::Primaries;
use snowgrain_optics::colour::chromaticity;
use snowgrain_render::laboratory::{
    AlbedoSettings, Incidence, SnowStack, Tell, colour_wavelengths_nm, colours, homogeneous_albedo,
};

/// Standard error of the transmittance, as a part of it.
const RELATIVE_ERROR: f64 = 0.02;

const COLUMNS: [&str; 15] = [
    "seen",
    "radius_um",
    "depth_m",
    "X",
    "Y",
    "Z",
    "x",
    "y",
    "red",
    "green",
    "blue",
    "density_kg_m3",
    "ground_albedo",
    "impurities",
    "shapes",
];

pub(super) fn run(arguments: &ColourArguments) -> Result<u8, Failure> {
    let progress = Progress::new(arguments.search.quiet, false);
    let pool = pool(&arguments.search.machine)?;
    let stacks = snow::stacks((&arguments.snow, &arguments.search))?;
    let settings = AlbedoSettings {
        wavelengths_nm: colour_wavelengths_nm(),
        incidence: Incidence::Diffuse,
        standard_error: arguments.stderr,
        relative_error_of_transmittance: RELATIVE_ERROR,
        ..snow::search(&arguments.search)
    };
    let mut table = Table { names: COLUMNS.to_vec(), rows: Vec::new() };
    let mut swatches = Vec::new();
    let find = |stack: &SnowStack, tell: Tell<'_>| Ok(homogeneous_albedo(stack, &settings, tell));
    let found = find_all((&progress, &pool, "colour"), &stacks, snow::share, find)?;
    for (stack, albedos) in stacks.iter().zip(&found) {
        let Some([reflected, transmitted]) = colours(albedos, arguments.illuminant) else {
            continue;
        };
        let white = colours_of_white(arguments);
        table.rows.push(row("R", stack, reflected, arguments.primaries));
        if !stack.is_deep() {
            table.rows.push(row("T", stack, transmitted, arguments.primaries));
        }
        swatches.push(Swatch::new(&label(stack), white, [reflected, transmitted]));
    }
    progress.finish();
    table.tell(&arguments.search)?;
    if let Some(path) = &arguments.swatches {
        output::write_text(path, &svg(&swatches))?;
    }
    Ok(0)
}

/// Tristimulus values of all of the light.
fn colours_of_white(arguments: &ColourArguments) -> DVec3 {
    snowgrain_optics::colour::tristimulus(arguments.illuminant, |_| 1.0)
}

fn row(seen: &str, stack: &SnowStack, xyz: DVec3, primaries: Primaries) -> Vec<Cell> {
    let [x, y] = chromaticity(xyz);
    let rgb = primaries.from_xyz(xyz);
    let numbers = [xyz.x, xyz.y, xyz.z, x, y, rgb.x, rgb.y, rgb.z];
    let mut cells = vec![Cell::Word(seen.into()), snow::radius_um(stack), snow::depth_m(stack)];
    cells.extend(numbers.map(Cell::Number));
    cells.extend([
        snow::density(stack),
        Cell::Number(stack.ground_albedo),
        snow::impurities(stack),
        snow::shapes(stack),
    ]);
    cells
}

/// What a case is, in a few words.
fn label(stack: &SnowStack) -> String {
    let radius = snow::radius_um(stack).text();
    let depth = snow::depth_m(stack).text();
    let impurities = snow::impurities(stack).text().replace(';', ", ");
    let dirt = if impurities.is_empty() { "clean".into() } else { impurities };
    format!("r {radius} um, depth {depth} m, {dirt}")
}
