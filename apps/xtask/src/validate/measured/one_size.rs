//! How far the shape of grains moves the albedo where light does not reach the ground: whether any snow of grains of one
//! size could be as dark there as thin packs were measured.

use super::fit::{DENSITY, FITTED_MM, Radii, fit, predicted};
use crate::report::{Comparison, Section};
use crate::table::Table;
use crate::validate::Bench;
use anyhow::Result;

/// Shapes that lie as far apart as snow crystals do, and what stands in the file that names them.
const SHAPES: [(&str, &str); 6] = [
    ("thin-plates", "shape = \"hexagonal-plate\"\naspect = 0.05"),
    ("plates", "shape = \"hexagonal-plate\"\naspect = 0.15"),
    ("columns", "shape = \"hexagonal-column\"\naspect = 2.5"),
    ("needles", "shape = \"hexagonal-column\"\naspect = 8"),
    ("cubes", "shape = \"cube\""),
    ("lenses", "shape = \"spheroid\"\naspect = 0.3"),
];
/// Wide enough for cubes, which have the largest radius of these shapes.
const RADII: Radii = Radii { series: "60um:600um:20um", stderr: 0.001 };
/// The wavelength, nm.
const OPAQUE: &str = "1300";
/// The pack through which light does not pass there, and which is thin elsewhere.
const THIN_MM: &str = "45";
/// What chance may part two depths of one snow by.
const CHANCE: f64 = 0.003;

/// Shapes, each with its own fitted radius, at the wavelength where the thin packs are off.
pub(super) fn compare(bench: &Bench, section: &mut Section, measured: &Table) -> Result<()> {
    section.say(format!(
        "At {OPAQUE} nm light does not come through {THIN_MM} mm: snow of grains of one size has the same albedo there \
         as the deep pack, and the fit at 1100 nm says which, nearly the same for all shapes. Each of these has a \
         radius of its own, fitted as above:"
    ));
    let mut same = Comparison::new(
        format!("albedo at {OPAQUE} nm, {THIN_MM} mm by the deep pack, every shape"),
        ".003",
    );
    let mut rows = Vec::new();
    for (name, shape) in ["spheres", "faceted"]
        .map(|kind| (kind, None))
        .into_iter()
        .chain(SHAPES.map(|(n, s)| (n, Some(s))))
    {
        let shapes = match shape {
            None => name.to_owned(),
            Some(shape) => {
                let file = format!("{name}.toml");
                std::fs::write(bench.folder().join(&file), format!("[[shapes]]\n{shape}\n"))?;
                file
            }
        };
        let radius_um = fit(bench, section, (measured, &shapes), &RADII)?;
        let command = format!(
            "optics albedo --method homogeneous --shapes {shapes} --radius {radius_um:.2}um --density {DENSITY} \
             --depth {FITTED_MM}mm,{THIN_MM}mm --wavelengths {OPAQUE} --stderr {} --quiet",
            bench.choose(0.0005, 0.001)
        );
        let found = bench.table(section, &command)?;
        let at = |depth: &str| predicted(&found, DENSITY, depth, OPAQUE);
        let (deep, thin) = (at(FITTED_MM)?, at(THIN_MM)?);
        same.compare(name, thin, deep, CHANCE);
        let mut row = vec![
            name.to_owned(),
            format!("{radius_um:.1}"),
            format!("{deep:.3}"),
            format!("{thin:.3}"),
        ];
        for depth in measured.distinct("depth_mm")? {
            let albedo = measured
                .find(&[("depth_mm", &depth), ("wavelength_nm", OPAQUE)])?
                .number("albedo")?;
            row.push(format!("{:+.3}", thin - albedo));
        }
        rows.push(row);
    }
    section.add(same);
    let differences = measured
        .distinct("depth_mm")?
        .into_iter()
        .map(|depth| format!("by that measured, {depth} mm"));
    let thin = format!("albedo, {THIN_MM} mm");
    let heads: Vec<String> = ["shape", "fitted radius, um", "albedo, deep", &thin]
        .map(str::to_owned)
        .into_iter()
        .chain(differences)
        .collect();
    section.table(&heads.iter().map(String::as_str).collect::<Vec<_>>(), &rows);
    Ok(())
}
