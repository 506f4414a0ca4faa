//! Depth over which light in snow falls to 1/e.

use super::Bench;
use crate::report::{Comparison, Section};
use anyhow::{Context as _, Result};

pub(super) fn section(bench: &Bench) -> Result<Section> {
    let mut section = Section::new("E-folding depth");
    section.say(
        "Depth over which the downward flux falls to 1/e (300 kg/m^3), from a depth of 40 radii, where light is \
         diffuse, over one expected e-folding depth, against discrete ordinates (`efolding_depth.csv`, k of \
         Picard et al. 2016). The tolerance is asked for 500 um; the other radii are held to it as well.",
    );
    let radii = if bench.quick { &["500"][..] } else { &["500", "50", "100", "200", "1000"] };
    let wavelengths = bench.choose(&["600", "700", "800", "900", "1030"][..], &["700", "900"]);
    let mut rows = Vec::new();
    for radius in radii {
        let mut comparison = Comparison::new(format!("e-folding depth, r = {radius} um"), "3 %");
        let mut row = vec![format!("{radius} um")];
        for wavelength in wavelengths {
            let [found, expected] = fold(bench, &mut section, radius, wavelength)?;
            comparison.compare(&format!("{wavelength} nm"), found / expected, 1.0, 0.03);
            row.push(format!("{found:.1} / {expected:.1}"));
        }
        section.add(comparison);
        rows.push(row);
    }
    section.say("Found / expected, mm:");
    let heads: Vec<String> = wavelengths.iter().map(|nm| format!("{nm} nm")).collect();
    let heads: Vec<&str> = ["radius"].into_iter().chain(heads.iter().map(String::as_str)).collect();
    section.table(&heads, &rows);
    Ok(section)
}

/// Found and expected, mm.
fn fold(bench: &Bench, section: &mut Section, radius: &str, wavelength: &str) -> Result<[f64; 2]> {
    let reference = bench.reference("efolding_depth.csv")?;
    let row = reference.find(&[("r_um", radius), ("wavelength_nm", wavelength)])?;
    let expected = row.number("efold_mm_p2016")?;
    let from = 0.04 * row.number("r_um")?;
    let to = from + expected;
    let command = format!(
        "optics profile --radius {radius}um --at 0,{from:.2}mm,{to:.2}mm --wavelengths {wavelength} \
         --stderr 0.01 --max-paths 60000"
    );
    let found = bench.table(section, &command)?;
    let row = found.rows().nth(1).context("the profile has three depths")?;
    Ok([1e3 * row.number("efold_m")?, expected])
}
