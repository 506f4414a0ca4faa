//! Measured albedo of fresh snow: one radius is fitted, everything else predicted, by spheres and by shapes.

use super::Bench;
use crate::figure::{Axis, Figure, Series};
use crate::report::{Comparison, Section};
use crate::table::Table;
use anyhow::{Context as _, Result};

/// Assumed of the fresh snow, kg/m^3.
const DENSITY: f64 = 100.0;
/// Others, to show what the assumption does.
const OTHER_DENSITIES: [f64; 2] = [70.0, 150.0];
/// The wavelength of the fit, nm, at which the depth of 34 cm is no less than infinite.
const FITTED: &str = "1100";
const DEEP_MM: &str = "340";

/// What the grains are: smooth spheres, and shapes of natural snow, which were chosen by their B and g alone.
const SHAPES: [&str; 2] = ["spheres", "faceted"];
/// Radii among which the fitted one is sought, um.
const RADII_UM: &str = "40um:200um:10um";

pub(super) fn section(bench: &Bench) -> Result<Section> {
    let mut section = Section::new("Measured albedo of fresh snow");
    section.say(format!(
        "Letcher et al. 2022 (The Cryosphere 16, 4343, figure 12): a pack of 34 cm, and 4.5 and 2.5 cm over black \
         panels (`measured_albedo.csv`). The radius is fitted to one figure, the deep pack at {FITTED} nm, \
         which the density does not touch; the other fourteen are predicted, once with spheres and once with the mix of \
         shapes `faceted`, which was fixed before by its B and g (see Shapes). Assumed, since the source at hand \
         does not give them: a density of {DENSITY} kg/m^3 (the range of fresh snow is some 50 to 150), diffuse \
         light, snow without impurities, black ground of albedo 0. Nothing else was fitted. Lines that fail here \
         do not fail the task: they are of the model, not of the program."
    ));
    let measured = bench.reference("measured_albedo.csv")?;
    for shapes in SHAPES {
        let radius_um = fit(bench, &mut section, (&measured, shapes))?;
        let surface = match shapes {
            "spheres" => {
                format!(", a specific surface area of {:.1} m^2/kg", 3e6 / (917.0 * radius_um))
            }
            _ => String::new(),
        };
        section.say(format!("Fitted, {shapes}: r = {radius_um:.1} um{surface}."));
        let found = predict(bench, &mut section, &measured, (shapes, radius_um))?;
        compare(&mut section, (&measured, shapes), &found)?;
        let file = match shapes {
            "spheres" => "measured.svg".to_owned(),
            shapes => format!("measured-{shapes}.svg"),
        };
        draw(bench, (&measured, shapes), &found, &file)?;
        section.figure(&file, &format!("Measured and predicted albedo of fresh snow, {shapes}"));
    }
    Ok(section)
}

/// The radius, um: between the two of a series whose albedos are on either side of the measured one.
fn fit(bench: &Bench, section: &mut Section, (measured, shapes): (&Table, &str)) -> Result<f64> {
    let wanted = [("depth_mm", DEEP_MM), ("wavelength_nm", FITTED)];
    let target = measured.find(&wanted)?.number("albedo")?;
    let command = format!(
        "optics albedo --method homogeneous --shapes {shapes} --radius {RADII_UM} --density {DENSITY} \
         --depth {DEEP_MM}mm --wavelengths {FITTED} --stderr {} --quiet",
        bench.choose(0.0005, 0.001)
    );
    let table = bench.table(section, &command)?;
    let points: Result<Vec<[f64; 2]>> =
        table.rows().map(|row| Ok([row.number("radius_um")?, row.number("R")?])).collect();
    let points = points?;
    let pair = points.windows(2).find(|pair| pair[0][1] >= target && pair[1][1] < target);
    let [[low, above], [high, below]] = *pair.context("no radius of the series has the albedo")?
    else {
        unreachable!("windows are pairs");
    };
    Ok(low + (high - low) * (above - target) / (above - below))
}

/// All depths and wavelengths, at all densities.
fn predict(
    bench: &Bench,
    section: &mut Section,
    measured: &Table,
    (shapes, radius_um): (&str, f64),
) -> Result<Table> {
    let densities: Vec<String> =
        [DENSITY].iter().chain(&OTHER_DENSITIES).map(f64::to_string).collect();
    let command = format!(
        "optics albedo --method homogeneous --shapes {shapes} --radius {radius_um:.2}um --density {} --depth {} \
         --wavelengths {} --stderr {} --quiet",
        densities.join(","),
        super::list(&measured.distinct("depth_mm")?, "mm"),
        measured.distinct("wavelength_nm")?.join(","),
        bench.choose(0.001, 0.002)
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

fn compare(section: &mut Section, (measured, shapes): (&Table, &str), found: &Table) -> Result<()> {
    let mut rows = Vec::new();
    for depth in measured.distinct("depth_mm")? {
        let mut comparison =
            Comparison::reported(format!("measured albedo, {depth} mm, {shapes}"), ".03");
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

fn draw(
    bench: &Bench,
    (measured, shapes): (&Table, &str),
    found: &Table,
    file: &str,
) -> Result<()> {
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
        title: match shapes {
            "spheres" => "Fresh snow over black: predicted with spheres, and measured",
            _ => "Fresh snow over black: predicted with shapes, and measured",
        },
        x: Axis { name: "wavelength, nm", from: 400.0, to: 1400.0, step: 100.0 },
        y: Axis { name: "albedo", from: 0.3, to: 1.0, step: 0.1 },
        series,
        remark: "points: measured",
    };
    figure.write(&bench.figure(file))
}
