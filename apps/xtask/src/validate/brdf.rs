//! Into which directions deep snow reflects.

use super::{Bench, list};
use crate::figure::{Axis, Figure, Series};
use crate::report::{Comparison, Section};
use crate::table::{Row, Table};
use anyhow::Result;
use snowgrain_math::trig;

/// Angles by which light is turned in the rainbow. It is a caustic, which has no bound at its angle and
/// which the 300 Legendre terms of the reference blur.
const RAINBOW_DEGREES: std::ops::Range<f64> = 129.0..143.0;

pub(super) fn section(bench: &Bench) -> Result<Section> {
    let mut section = Section::new("Directions");
    section.say(
        "Bidirectional reflectance factors of deep snow against the solver of Mishchenko et al. 1999 \
         (`brf_semi_infinite.csv`). The rainbow of smooth spheres, light turned by 129 to 143 degrees, is reported \
         but not judged: it is a caustic, which the solver's 300 Legendre terms blur. Natural snow has none, and \
         sends less light forward: this compares spheres with spheres.",
    );
    let reference = bench.reference("brf_semi_infinite.csv")?;
    let mut comparison = Comparison::new("BRF outside the rainbow", "2 % and 4 sigma");
    let (mut rainbow, mut series) = (0.0f64, Vec::new());
    for sun in bench.choose(&["0", "30", "60", "75"][..], &["60"][..]) {
        for (radius, wavelengths) in
            bench.choose(&[("200", "550,900,1300"), ("1000", "550")][..], &[("200", "1300")][..])
        {
            let found = find(bench, &mut section, &reference, (radius, wavelengths, sun))?;
            rainbow = rainbow.max(compare(&mut comparison, &reference, &found)?);
            if *sun == "60" && *radius == "200" {
                series.extend(principal_plane(&reference, &found)?);
            }
        }
    }
    section.add(comparison);
    section.say(format!("In the rainbow the largest deviation is {:.1} %.", 100.0 * rainbow));
    draw(bench, series)?;
    section.figure("brdf.svg", "The principal plane, r = 200 um, sun at 60 degrees");
    Ok(section)
}

fn find(
    bench: &Bench,
    section: &mut Section,
    reference: &Table,
    (radius, wavelengths, sun): (&str, &str, &str),
) -> Result<Table> {
    let command = format!(
        "optics brdf --radius {radius}um --sza {sun} --vza {} --azimuth {} --wavelengths {wavelengths} --stderr \
         0.02 --max-paths 100000",
        list(&reference.distinct("vza_deg")?, ""),
        list(&reference.distinct("relaz_deg")?, "")
    );
    bench.table(section, &command)
}

fn expected<'r>(reference: &'r Table, row: &Row<'_>) -> Result<Row<'r>> {
    reference.find(&[
        ("wavelength_nm", row.text("wavelength_nm")?),
        ("r_um", row.text("radius_um")?),
        ("sza_deg", row.text("sza_deg")?),
        ("vza_deg", row.text("vza_deg")?),
        ("relaz_deg", row.text("azimuth_deg")?),
    ])
}

/// Compares what is outside the rainbow; the largest part that is off in it.
fn compare(comparison: &mut Comparison, reference: &Table, found: &Table) -> Result<f64> {
    let mut rainbow = 0.0f64;
    for row in found.rows() {
        let [sun, view, azimuth] =
            ["sza_deg", "vza_deg", "azimuth_deg"].map(|name| row.number(name));
        let (sun, view, azimuth) = (sun?, view?, azimuth?);
        let expected = expected(reference, &row)?.number("BRF_mishchenko_go")?;
        let ratio = row.number("BRF")? / expected;
        if RAINBOW_DEGREES.contains(&turned_degrees(sun, view, azimuth)) {
            rainbow = rainbow.max((ratio - 1.0).abs());
            continue;
        }
        let name = format!(
            "{} um, {} nm, sun {sun}, seen from {view} at {azimuth} degrees",
            row.text("radius_um")?,
            row.text("wavelength_nm")?
        );
        let allowed = 0.02 + 4.0 * row.number("BRF_stderr")? / expected;
        comparison.compare(&name, ratio, 1.0, allowed);
    }
    Ok(rainbow)
}

/// By how much light is turned from the sun into a view.
fn turned_degrees(sun: f64, view: f64, azimuth: f64) -> f64 {
    let (sun_sin, sun_cos) = trig::sin_cos(sun.to_radians());
    let (sin, cos) = trig::sin_cos(view.to_radians());
    trig::acos(sun_sin * sin * trig::sin_cos(azimuth.to_radians()).1 - sun_cos * cos).to_degrees()
}

/// A line for each wavelength, the views away from the sun to the right.
fn principal_plane(reference: &Table, found: &Table) -> Result<Vec<Series>> {
    let mut series = Vec::new();
    for wavelength in found.distinct("wavelength_nm")? {
        let (mut line, mut points) = (Vec::new(), Vec::new());
        for row in found.rows().filter(|row| row.has(&[("wavelength_nm", &wavelength)])) {
            let side = match row.text("azimuth_deg")? {
                "0" => 1.0,
                "180" => -1.0,
                _ => continue,
            };
            let view = side * row.number("vza_deg")?;
            line.push([view, row.number("BRF")?]);
            points.push([view, expected(reference, &row)?.number("BRF_mishchenko_go")?]);
        }
        line.sort_by(|one, other| one[0].total_cmp(&other[0]));
        series.push(Series { name: format!("{wavelength} nm"), line, points });
    }
    Ok(series)
}

fn draw(bench: &Bench, series: Vec<Series>) -> Result<()> {
    let figure = Figure {
        title: "Deep snow in the principal plane, r = 200 um, sun at 60 degrees",
        x: Axis {
            name: "zenith angle of the view, degrees (right: away from the sun)",
            from: -80.0,
            to: 80.0,
            step: 20.0,
        },
        y: Axis { name: "bidirectional reflectance factor", from: 0.0, to: 3.0, step: 0.5 },
        series,
        remark: "points: Mishchenko et al.",
    };
    figure.write(&bench.figure("brdf.svg"))
}
