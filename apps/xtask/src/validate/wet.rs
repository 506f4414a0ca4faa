//! Wet snow: what water in the pores does.

use super::Bench;
use crate::report::{Comparison, Section};
use anyhow::Result;

pub(super) fn section(bench: &Bench) -> Result<Section> {
    let mut section = Section::new("Wet snow");
    section.say(
        "R and T while water fills the pores (r = 500 um, 300 kg/m^3, 2 cm over black, 550 nm): exactly, by films \
         about the grains (`films`), and by either thing that water does alone: larger grains, and grains that lie in \
         water (`submerged`). No measurement is compared; dry snow must be what `albedo --method grains` finds, and \
         films must let more light through when the pores are full.",
    );
    let paths = bench.choose(20_000, 3_000);
    let snow = "--radius 500um --density 300 --depth 2cm --wavelengths 550";
    let command = format!("optics wet {snow} --paths {paths}");
    let found = bench.table_and_plot(&mut section, &command, "wet.svg")?;
    let command = format!("optics albedo {snow} --method grains --stderr 0.002");
    let dry = bench.table(&mut section, &command)?;
    let dry = dry.find(&[("method", "grains")])?;
    let films = found.find(&[("model", "films"), ("saturation", "0")])?;
    let full = found.find(&[("model", "films"), ("saturation", "1")])?;
    let mut comparison = Comparison::new("dry films against grains", "4 sigma");
    for flux in ["R", "T"] {
        let name = format!("{flux}_stderr");
        let allowed = 4.0 * (films.number(&name)? + dry.number(&name)?);
        comparison.compare(flux, films.number(flux)?, dry.number(flux)?, allowed);
    }
    section.add(comparison);
    let mut darker = Comparison::new("R of full pores over R of dry snow", "0 to 1");
    darker.compare("films", full.number("R")? / films.number("R")?, 0.5, 0.5);
    section.add(darker);
    let mut rows = Vec::new();
    for saturation in found.distinct("saturation")? {
        let mut row = vec![saturation.clone()];
        for model in ["films", "larger-grains", "submerged"] {
            // Full pores leave no surface to air, and so no larger grains.
            let cell = found.find(&[("model", model), ("saturation", &saturation)]);
            row.push(match cell {
                Ok(cell) => format!("{:.3} / {:.3}", cell.number("R")?, cell.number("T")?),
                Err(_) => String::new(),
            });
        }
        rows.push(row);
    }
    section.say("R / T:");
    section.table(&["saturation", "films", "larger grains", "submerged"], &rows);
    section.figure("wet.svg", "Wet snow, 550 nm");
    Ok(section)
}
