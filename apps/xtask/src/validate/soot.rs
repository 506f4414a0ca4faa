//! Soot of a known mass absorption against discrete ordinates.

use super::{Bench, list, name_of};
use crate::report::{Comparison, Section};
use anyhow::Result;

pub(super) fn section(bench: &Bench) -> Result<Section> {
    let mut section = Section::new("Soot");
    section.say(
        "Deep snow with black carbon of 7.5 m^2/g at 550 nm, falling as 1/wavelength, between the grains, \
         against discrete ordinates with the same absorption (`albedo_soot.csv`). Both give a grain the \
         co-albedo of its ice and its soot together.",
    );
    let reference = bench.reference("albedo_soot.csv")?;
    let every = bench.choose(1, 2);
    let radii: Vec<_> = reference.distinct("r_um")?.into_iter().step_by(every).collect();
    // Without soot it is the deep snow of another section.
    let loads = reference.distinct("soot_ng_per_g")?.into_iter().skip(1).step_by(every);
    let mut comparison = Comparison::new("albedo with soot, 10 to 10000 ng/g", ".005");
    for load in loads {
        let command = format!(
            "optics albedo --radius {} --diffuse --sza 60 --wavelengths {} --impurity \
             black-carbon-bond-2006={load}ng/g --stderr 0.00125",
            list(&radii, "um"),
            list(&reference.distinct("wavelength_nm")?, "")
        );
        for row in bench.table(&mut section, &command)?.rows() {
            let diffuse = row.text("sza_deg")? == "diffuse";
            let column = if diffuse { "R_diffuse_disort" } else { "R_sza60_disort" };
            let expected = reference.find(&[
                ("r_um", row.text("radius_um")?),
                ("soot_ng_per_g", &load),
                ("wavelength_nm", row.text("wavelength_nm")?),
            ])?;
            let names = [("radius_um", "um"), ("sza_deg", "degrees"), ("wavelength_nm", "nm")];
            let name = format!("{load} ng/g, {}", name_of(&row, &names)?);
            comparison.compare(&name, row.number("R")?, expected.number(column)?, 0.005);
        }
    }
    section.add(comparison);
    Ok(section)
}
