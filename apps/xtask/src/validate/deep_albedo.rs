//! Spectral albedo of deep snow against discrete ordinates.

use super::{Bench, incidences, list, name_of};
use crate::figure::{Axis, Figure, Series};
use crate::report::{Comparison, Section};
use crate::table::{Row, Table};
use anyhow::Result;

pub(super) fn section(bench: &Bench) -> Result<Section> {
    let mut section = Section::new("Deep snow");
    section.say(
        "Spectral albedo of semi-infinite snow at 18 wavelengths, under diffuse light and six angles of the \
         sun (three where light keeps its polarisation within a grain), against discrete ordinates with 32 streams (`albedo_semi_infinite.csv`). Both sides know snow as \
         spheres met at random: this tests the code, not the physics.",
    );
    let reference = bench.reference("albedo_semi_infinite.csv")?;
    for (column, mode) in [("disort_go_unpol", "redrawn"), ("disort_go_pol", "tracked")] {
        let found = find(bench, &mut section, &reference, mode)?;
        compare(&mut section, &reference, &found, column, mode)?;
        if mode == "redrawn" {
            draw(bench, &reference, &found)?;
            section.figure("deep_albedo.svg", "Deep snow under diffuse light");
        }
    }
    Ok(section)
}

fn find(bench: &Bench, section: &mut Section, reference: &Table, mode: &str) -> Result<Table> {
    let every = bench.choose(1, 3);
    let radii: Vec<_> = reference.distinct("r_um")?.into_iter().step_by(every).collect();
    // Polarisation is found at every second angle, for the time that it takes.
    let every = if mode == "tracked" { bench.choose(2, 6) } else { every };
    let angles: Vec<_> = reference.distinct("sza_deg")?.into_iter().step_by(every).collect();
    let wavelengths = list(&reference.distinct("wavelength_nm")?, "");
    let command = format!(
        "optics albedo --radius {} {} --wavelengths {wavelengths} --polarisation {mode} --stderr {}",
        list(&radii, "um"),
        incidences(&angles),
        bench.choose(0.0012, 0.002)
    );
    bench.table(section, &command)
}

/// The row of the reference for a row of the program.
fn expected<'r>(reference: &'r Table, row: &Row<'_>) -> Result<Row<'r>> {
    reference.find(&[
        ("r_um", row.text("radius_um")?),
        ("sza_deg", row.text("sza_deg")?),
        ("wavelength_nm", row.text("wavelength_nm")?),
    ])
}

fn compare(
    section: &mut Section,
    reference: &Table,
    found: &Table,
    column: &str,
    mode: &str,
) -> Result<()> {
    let what = format!("albedo, polarisation {mode}, against {column}");
    let mut comparison = Comparison::new(what, "max(.002, 4 sigma)");
    for row in found.rows() {
        let name =
            name_of(&row, &[("radius_um", "um"), ("sza_deg", "degrees"), ("wavelength_nm", "nm")])?;
        let allowed = 0.002f64.max(4.0 * row.number("R_stderr")?);
        let expected = expected(reference, &row)?.number(column)?;
        comparison.compare(&name, row.number("R")?, expected, allowed);
    }
    section.add(comparison);
    Ok(())
}

fn draw(bench: &Bench, reference: &Table, found: &Table) -> Result<()> {
    let mut series = Vec::new();
    for radius in found.distinct("radius_um")? {
        let (mut line, mut points) = (Vec::new(), Vec::new());
        for row in found.rows() {
            if row.has(&[("radius_um", &radius), ("sza_deg", "diffuse")]) {
                let nm = row.number("wavelength_nm")?;
                line.push([nm, row.number("R")?]);
                points.push([nm, expected(reference, &row)?.number("disort_go_unpol")?]);
            }
        }
        series.push(Series { name: format!("r = {radius} um"), line, points });
    }
    let figure = Figure {
        title: "Albedo of deep snow under diffuse light",
        x: Axis { name: "wavelength, nm", from: 300.0, to: 1300.0, step: 100.0 },
        y: Axis { name: "albedo", from: 0.0, to: 1.0, step: 0.1 },
        series,
        remark: "points: discrete ordinates",
    };
    figure.write(&bench.figure("deep_albedo.svg"))
}
