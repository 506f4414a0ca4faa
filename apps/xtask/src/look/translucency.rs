//! How much light a slab lets through that is lit from behind.

use super::stage::Stage;
use crate::report::{Comparison, Section};
use anyhow::Result;

/// Density of the slab and radius of its grains; depths in mm and the light expected through them, from
/// T = 1/(1.072 + .75 tau (1 - g_eff)).
const SLAB: &str = "--method grains --density 150 --radius 250um";
const EXPECTED: [(&str, f64); 4] = [("5", 0.69), ("10", 0.55), ("20", 0.39), ("50", 0.21)];
const TOLERANCE: f64 = 0.05;

pub(super) fn section(stage: &Stage) -> Result<Section> {
    let mut section = Section::new("Translucency");
    section.say(
        "Diffuse light through a slab of grains at random places, 150 kg/m^3 and r = .25 mm, traced exactly at 500 nm, \
         where ice hardly absorbs (Warren and Brandt 2008) and its index is that of the figures expected (at 400 nm it is \
         1.319, and 6 % less comes through 50 mm). A Lambertian slab lets nothing through.",
    );
    let found = stage.table(
        &mut section,
        &format!(
            "optics albedo {SLAB} --depth 5mm,10mm,20mm,50mm --diffuse --wavelengths 500 --ice-k \
             warren-brandt-2008 --stderr {}",
            stage.choose(0.001, 0.002)
        ),
    )?;
    let mut comparison = Comparison::new("light let through, over that expected", "5 %");
    for (row, (depth, expected)) in found.rows().zip(EXPECTED) {
        let through = row.number("T")?;
        let name = format!("{depth} mm: T = {through:.3}");
        comparison.compare(&name, through / expected, 1.0, TOLERANCE);
    }
    section.add(comparison);
    Ok(section)
}
