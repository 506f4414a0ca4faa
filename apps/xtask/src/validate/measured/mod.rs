//! Measured albedo of fresh snow: one radius is fitted, everything else predicted, by spheres and by shapes.

mod fit;
mod one_size;

use super::Bench;
use crate::figure::{Axis, Figure, Series};
use crate::report::{Comparison, Section};
use crate::table::Table;
use anyhow::Result;
use fit::{DENSITY, FITTED, FITTED_MM, Radii, fit, predicted};

/// Others, to show what the assumption does.
const OTHER_DENSITIES: [f64; 2] = [70.0, 150.0];

/// What the grains are: smooth spheres, and shapes of natural snow, which were chosen by their B and g alone.
const SHAPES: [&str; 2] = ["spheres", "faceted"];
const RADII: Radii = Radii { series: "40um:200um:10um", stderr: 0.0005 };

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
        let radius_um = fit(bench, &mut section, (&measured, shapes), &RADII)?;
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
    one_size::compare(bench, &mut section, &measured)?;
    Ok(section)
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

fn compare(section: &mut Section, (measured, shapes): (&Table, &str), found: &Table) -> Result<()> {
    let mut rows = Vec::new();
    for depth in measured.distinct("depth_mm")? {
        let mut comparison =
            Comparison::reported(format!("measured albedo, {depth} mm, {shapes}"), ".03");
        for row in measured.rows().filter(|row| row.has(&[("depth_mm", &depth)])) {
            let (nm, albedo) = (row.text("wavelength_nm")?, row.number("albedo")?);
            let here = predicted(found, DENSITY, &depth, nm)?;
            let fitted = depth == FITTED_MM && nm == FITTED;
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
