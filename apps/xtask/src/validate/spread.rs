//! How far light bleeds in deep snow.

use super::Bench;
use crate::report::{Comparison, Section};
use anyhow::Result;

/// Transport length of packed grains of half a millimetre at 275 kg/m^3, metres (section 7 of the
/// project's physics).
const TRANSPORT_LENGTH: f64 = 0.0116;

pub(super) fn section(bench: &Bench) -> Result<Section> {
    let mut section = Section::new("Spread of light");
    section.say(
        "Diffuse light that enters deep white snow at a point: half of what leaves does so within 2.0 transport \
         lengths, 90 % within 11.8 (11.6 mm at 275 kg/m^3, r = .5 mm).",
    );
    let command = format!(
        "optics spread --radius 500um --density 275 --diffuse --wavelengths 400 --ice-k warren-brandt-2008 \
         --stderr {} --max-paths 300000",
        bench.choose(0.01, 0.02)
    );
    let found = bench.table(&mut section, &command)?;
    let mut comparison = Comparison::new("radii of half and 90 %, over those expected", "15 %");
    for (quantity, lengths) in [("R_median_radius_m", 2.0), ("R_radius_90_m", 11.8)] {
        let radius = found.find(&[("quantity", quantity)])?.number("value")?;
        comparison.compare(quantity, radius / (lengths * TRANSPORT_LENGTH), 1.0, 0.15);
        section.say(format!("{quantity}: {:.2} transport lengths.", radius / TRANSPORT_LENGTH));
    }
    section.add(comparison);
    Ok(section)
}
