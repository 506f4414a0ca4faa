//! One set of paths for many wavelengths against paths of each one's own.

use super::Bench;
use crate::report::{Comparison, Section};
use anyhow::Result;

pub(super) fn section(bench: &Bench) -> Result<Section> {
    let mut section = Section::new("Interpolation between indices");
    section.say(
        "Wavelengths share paths, which are traced at a few refractive indices between which R is interpolated. \
         Here all are found at once and each alone, whose paths have its own index (r = 200 um, diffuse light). \
         Both have the same random numbers, but lengths of paths differ: the noise of both counts.",
    );
    let step = bench.choose(94, 188);
    let settings = format!("--stderr {}", bench.choose(0.0003, 0.0005));
    let command = format!("optics albedo --radius 200um --wavelengths 350:1290:{step} {settings}");
    let together = bench.table(&mut section, &command)?;
    let mut comparison = Comparison::new("albedo, all at once against each alone", ".001");
    for row in together.rows() {
        let nm = row.text("wavelength_nm")?;
        let command = format!("optics albedo --radius 200um --wavelengths {nm} {settings}");
        let alone =
            bench.table(&mut section, &command)?.find(&[("wavelength_nm", nm)])?.number("R")?;
        comparison.compare(&format!("{nm} nm"), row.number("R")?, alone, 0.001);
    }
    section.add(comparison);
    Ok(section)
}
