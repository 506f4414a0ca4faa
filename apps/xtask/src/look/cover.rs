//! Thin snow over coloured ground.

use super::stage::Stage;
use crate::report::{Comparison, Section};
use anyhow::Result;

/// A red ground: its albedos.
const GROUND: [(&str, &str); 3] = [("red", "0.75"), ("green", "0.20"), ("blue", "0.05")];
const TOLERANCE: f64 = 0.03;

pub(super) fn section(stage: &Stage) -> Result<Section> {
    let mut section = Section::new("Thin cover");
    section.say(
        "The colour of thin snow over coloured ground under diffuse light, R' = R + a T^2/(1 - a R), with the R and T \
         of the same snow over black ground (Kubelka's layers, for a ground of albedo a); r = .25 mm, 150 kg/m^3, \
         traced exactly at 550 nm.",
    );
    let mut comparison = Comparison::new("R' of each channel over that of the formula", "3 %");
    let mut rows = Vec::new();
    for depth in ["2mm", "5mm", "10mm"] {
        let grounds: Vec<_> = GROUND.iter().map(|(_, albedo)| *albedo).collect();
        let command = format!(
            "optics albedo --method grains --radius 250um --density 150 --depth {depth} --diffuse --wavelengths \
             550 --ground 0,{} --stderr {}",
            grounds.join(","),
            stage.choose(0.001, 0.002)
        );
        let found = stage.table(&mut section, &command)?;
        let over = |ground: &str| found.find(&[("ground_albedo", ground)]);
        let (r, t) = (over("0")?.number("R")?, over("0")?.number("T")?);
        for (channel, albedo) in GROUND {
            let a: f64 = albedo.parse()?;
            let expected = r + a * t * t / (1.0 - a * r);
            let shown = over(albedo)?.number("R")?;
            comparison.compare(&format!("{depth}, {channel}"), shown / expected, 1.0, TOLERANCE);
            rows.push([depth, channel, albedo].map(str::to_owned).to_vec());
            if let Some(row) = rows.last_mut() {
                row.extend([expected, shown].map(|x| format!("{x:.4}")));
            }
        }
    }
    section.add(comparison);
    section.table(&["depth", "channel", "ground", "R' expected", "R' found"], &rows);
    Ok(section)
}
