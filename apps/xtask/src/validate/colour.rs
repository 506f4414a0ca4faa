//! Colours of daylight on snow and through it.

use super::Bench;
use crate::report::{Comparison, Section};
use anyhow::Result;

pub(super) fn section(bench: &Bench) -> Result<Section> {
    let mut section = Section::new("Colours");
    section.say(
        "x and y of D65 on layers over black and through them, r = 500 um, 300 kg/m^3, against discrete \
         ordinates (`colour_reflect_transmit.csv`).",
    );
    let reference = bench.reference("colour_reflect_transmit.csv")?;
    let depths = bench.choose("10cm,50cm,1m", "10cm");
    let command =
        format!("optics colour --radius 500um --depth {depths} --stderr 0.002 --max-paths 200000");
    let found = bench.table(&mut section, &command)?;
    let mut comparison = Comparison::new("x and y of D65", ".01");
    let mut rows = Vec::new();
    for row in found.rows() {
        let (seen, metres) = (row.text("seen")?, row.number("depth_m")?);
        let depth = format!("{:.6}", 1e3 * metres);
        let expected = reference.find(&[
            ("k_set", "k_p2016"),
            ("r_um", "500"),
            ("depth_mm", &depth),
            ("quantity", seen),
        ])?;
        let mut cells = vec![seen.to_owned(), format!("{metres} m")];
        for axis in ["x", "y"] {
            let (found, expected) = (row.number(axis)?, expected.number(axis)?);
            comparison.compare(&format!("{axis} of {seen}, {metres} m"), found, expected, 0.01);
            cells.push(format!("{found:.4} / {expected:.4}"));
        }
        rows.push(cells);
    }
    section.say("Found / expected:");
    section.table(&["", "depth", "x", "y"], &rows);
    section.add(comparison);
    Ok(section)
}
