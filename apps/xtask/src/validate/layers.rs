//! Layers over black ground against discrete ordinates.

use super::{Bench, incidences, list, name_of};
use crate::report::{Comparison, Section};
use anyhow::Result;

pub(super) fn section(bench: &Bench) -> Result<Section> {
    let mut section = Section::new("Layers over black ground");
    section.say(
        "R and T of layers of 1 mm to 1 m (300 kg/m^3) against discrete ordinates \
         (`albedo_vs_depth_black_ground.csv`). Again this tests the code.",
    );
    let reference = bench.reference("albedo_vs_depth_black_ground.csv")?;
    let every = bench.choose(1, 3);
    let radii: Vec<_> = reference.distinct("r_um")?.into_iter().step_by(every).collect();
    let depths: Vec<_> = reference.distinct("depth_mm")?.into_iter().step_by(every).collect();
    let command = format!(
        "optics albedo --radius {} --depth {} {} --wavelengths {} --stderr {}",
        list(&radii, "um"),
        list(&depths, "mm"),
        incidences(&reference.distinct("sza_deg")?),
        list(&reference.distinct("wavelength_nm")?, ""),
        bench.choose(0.0015, 0.002)
    );
    let found = bench.table(&mut section, &command)?;
    for (flux, column) in [("R", "R_disort"), ("T", "T_disort")] {
        let mut comparison = Comparison::new(format!("{flux} of layers"), "max(.002, 4 sigma)");
        for row in found.rows() {
            let depth = format!("{:.6}", 1e3 * row.number("depth_m")?);
            let expected = reference.find(&[
                ("r_um", row.text("radius_um")?),
                ("depth_mm", &depth),
                ("sza_deg", row.text("sza_deg")?),
                ("wavelength_nm", row.text("wavelength_nm")?),
            ])?;
            let names = [
                ("radius_um", "um"),
                ("depth_m", "m"),
                ("sza_deg", "degrees"),
                ("wavelength_nm", "nm"),
            ];
            let allowed = 0.002f64.max(4.0 * row.number(&format!("{flux}_stderr"))?);
            let name = name_of(&row, &names)?;
            comparison.compare(&name, row.number(flux)?, expected.number(column)?, allowed);
        }
        section.add(comparison);
    }
    Ok(section)
}
