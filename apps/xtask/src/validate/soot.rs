//! Soot of a known mass absorption against discrete ordinates.

use super::{Bench, list, name_of};
use crate::report::{Comparison, Section};
use anyhow::Result;

/// The load, ng/g, at which what a visit costs is no longer small.
const MOST: &str = "10000";

pub(super) fn section(bench: &Bench) -> Result<Section> {
    let mut section = Section::new("Soot");
    section.say(
        "Deep snow with black carbon of 7.5 m^2/g at 550 nm, falling as 1/wavelength, between the grains, \
         against discrete ordinates with the same absorption (`albedo_soot.csv`). The reference adds what soot absorbs at a grain to the co-albedo of ice; the program lets \
         it weaken light along the path in ice, which is the same to first order only. With 10000 ng/g a visit to a \
         grain of 1 mm costs more than a tenth of the light, and the two differ: told, not judged.",
    );
    let reference = bench.reference("albedo_soot.csv")?;
    let every = bench.choose(1, 2);
    let radii: Vec<_> = reference.distinct("r_um")?.into_iter().step_by(every).collect();
    // Without soot it is the deep snow of another section.
    let loads = reference.distinct("soot_ng_per_g")?.into_iter().skip(1).step_by(every);
    let mut comparison = Comparison::new("albedo with soot, at most 1000 ng/g", ".005");
    let mut most = Comparison::reported("albedo with soot, 10000 ng/g (not judged)", ".005");
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
            let judge = if load == MOST { &mut most } else { &mut comparison };
            judge.compare(&name, row.number("R")?, expected.number(column)?, 0.005);
        }
    }
    section.add(comparison);
    if !bench.quick {
        section.add(most);
    }
    Ok(section)
}
