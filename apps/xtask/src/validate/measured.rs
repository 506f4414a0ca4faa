//! Measured albedo of fresh snow: one radius is fitted, everything else predicted.

use super::Bench;
use crate::figure::{Axis, Figure, Series};
use crate::report::{Comparison, Section};
use crate::table::Table;
use anyhow::Result;

/// Assumed of the fresh snow, kg/m^3.
const DENSITY: f64 = 100.0;
/// Others, to show what the assumption does.
const OTHER_DENSITIES: [f64; 2] = [70.0, 150.0];
/// The wavelength of the fit, nm, at which the depth of 34 cm is no less than infinite.
const FITTED: &str = "1100";
const DEEP_MM: &str = "340";

pub(super) fn section(bench: &Bench) -> Result<Section> {
    let mut section = Section::new("Measured albedo of fresh snow");
    section.say(format!(
        "Letcher et al. 2022 (The Cryosphere 16, 4343, figure 12): a pack of 34 cm, and 4.5 and 2.5 cm over black \
         panels (`measured_albedo.csv`). The radius is fitted to one figure, the deep pack at {FITTED} nm, \
         which the density does not touch; the other fourteen are predicted. Assumed, since the source at hand \
         does not give them: a density of {DENSITY} kg/m^3 (the range of fresh snow is some 50 to 150), diffuse \
         light, snow without impurities, black ground of albedo 0. Nothing else was fitted. Lines that fail here \
         do not fail the task: they are of the model, not of the program."
    ));
    let measured = bench.reference("measured_albedo.csv")?;
    let target =
        measured.find(&[("depth_mm", DEEP_MM), ("wavelength_nm", FITTED)])?.number("albedo")?;
    let radius_um = fit(bench, &mut section, target)?;
    let specific = 3e6 / (917.0 * radius_um);
    section.say(format!(
        "Fitted: r = {radius_um:.1} um, a specific surface area of {specific:.1} m^2/kg."
    ));
    let found = predict(bench, &mut section, &measured, radius_um)?;
    compare(&mut section, &measured, &found)?;
    draw(bench, &measured, &found)?;
    section.figure("measured.svg", "Measured and predicted albedo of fresh snow");
    Ok(section)
}

/// The radius, um, by bisection of its logarithm; all steps share their random numbers.
fn fit(bench: &Bench, section: &mut Section, target: f64) -> Result<f64> {
    let [mut low, mut high] = [20.0f64, 500.0];
    for _ in 0..bench.choose(10, 6) {
        let middle = (low * high).sqrt();
        let command = format!(
            "optics albedo --method homogeneous --radius {middle:.2}um --density {DENSITY} --depth {DEEP_MM}mm \
             --wavelengths {FITTED} --stderr 0.0005"
        );
        let albedo =
            bench.table(section, &command)?.find(&[("wavelength_nm", FITTED)])?.number("R")?;
        if albedo > target { low = middle } else { high = middle }
    }
    Ok((low * high).sqrt())
}

/// All depths and wavelengths, at all densities.
fn predict(
    bench: &Bench,
    section: &mut Section,
    measured: &Table,
    radius_um: f64,
) -> Result<Table> {
    let densities: Vec<String> =
        [DENSITY].iter().chain(&OTHER_DENSITIES).map(f64::to_string).collect();
    let command = format!(
        "optics albedo --method homogeneous --radius {radius_um:.2}um --density {} --depth {} --wavelengths {} \
         --stderr {}",
        densities.join(","),
        super::list(&measured.distinct("depth_mm")?, "mm"),
        measured.distinct("wavelength_nm")?.join(","),
        bench.choose(0.0005, 0.002)
    );
    bench.table(section, &command)
}

fn predicted(found: &Table, density: f64, depth_mm: &str, wavelength: &str) -> Result<f64> {
    let depth = format!("{}", 1e-3 * depth_mm.parse::<f64>()?);
    let density = density.to_string();
    let wanted =
        [("density_kg_m3", density.as_str()), ("depth_m", &depth), ("wavelength_nm", wavelength)];
    found.find(&wanted)?.number("R")
}

fn compare(section: &mut Section, measured: &Table, found: &Table) -> Result<()> {
    let mut rows = Vec::new();
    for depth in measured.distinct("depth_mm")? {
        let mut comparison = Comparison::reported(format!("measured albedo, {depth} mm"), ".03");
        for row in measured.rows().filter(|row| row.has(&[("depth_mm", &depth)])) {
            let (nm, albedo) = (row.text("wavelength_nm")?, row.number("albedo")?);
            let here = predicted(found, DENSITY, &depth, nm)?;
            let fitted = depth == DEEP_MM && nm == FITTED;
            if !fitted {
                comparison.compare(&format!("{nm} nm"), here, albedo, 0.03);
            }
            let note = if fitted { " (fitted)" } else { "" };
            let mut cells =
                vec![format!("{depth} mm"), format!("{nm}{note}"), format!("{albedo:.3}")];
            cells.extend([format!("{here:.3}"), format!("{:+.3}", here - albedo)]);
            for density in OTHER_DENSITIES {
                cells.push(format!("{:+.3}", predicted(found, density, &depth, nm)? - albedo));
            }
            rows.push(cells);
        }
        section.add(comparison);
    }
    let [thin, dense] = OTHER_DENSITIES.map(|density| format!("difference at {density} kg/m^3"));
    section.table(&["depth", "nm", "measured", "predicted", "difference", &thin, &dense], &rows);
    Ok(())
}

fn draw(bench: &Bench, measured: &Table, found: &Table) -> Result<()> {
    let mut series = Vec::new();
    for depth in measured.distinct("depth_mm")? {
        let (mut line, mut points) = (Vec::new(), Vec::new());
        for row in measured.rows().filter(|row| row.has(&[("depth_mm", &depth)])) {
            let nm = row.number("wavelength_nm")?;
            points.push([nm, row.number("albedo")?]);
            line.push([nm, predicted(found, DENSITY, &depth, row.text("wavelength_nm")?)?]);
        }
        series.push(Series { name: format!("{depth} mm"), line, points });
    }
    let figure = Figure {
        title: "Fresh snow over black: predicted and measured",
        x: Axis { name: "wavelength, nm", from: 400.0, to: 1400.0, step: 100.0 },
        y: Axis { name: "albedo", from: 0.3, to: 1.0, step: 0.1 },
        series,
        remark: "points: measured",
    };
    figure.write(&bench.figure("measured.svg"))
}
