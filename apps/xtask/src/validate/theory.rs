//! Theories of albedo: an identity of Wiscombe and Warren's, and how far each is from discrete
//! ordinates.

use super::{Bench, incidences, list};
use crate::figure::{Axis, Figure, Series};
use crate::report::{Comparison, Section};
use crate::table::Table;
use anyhow::Result;
use snowgrain_optics::theory::{Incidence, SingleScattering, wiscombe_warren};

const METHODS: [&str; 3] = ["wiscombe-warren", "two-stream", "kokhanovsky-zege"];

pub(super) fn section(bench: &Bench) -> Result<Section> {
    let mut section = Section::new("Theories");
    section.say(
        "Wiscombe and Warren's diffuse albedo is the integral of their direct one (asked of the library, \
         `snowgrain_optics::theory`). Then how far three theories are from discrete ordinates (`disort_go_unpol`): \
         this is their error, which is reported, not judged; only Kokhanovsky and Zege's is held to the .01 that \
         is known of it for the sun at 60 degrees or higher and albedos above .6.",
    );
    section.add(identity());
    let reference = bench.reference("albedo_semi_infinite.csv")?;
    let command = format!(
        "optics albedo --radius {} {} --wavelengths {} --method {}",
        list(&reference.distinct("r_um")?, "um"),
        incidences(&reference.distinct("sza_deg")?),
        list(&reference.distinct("wavelength_nm")?, ""),
        METHODS.join(",")
    );
    let found = bench.table(&mut section, &command)?;
    distances(&mut section, &reference, &found)?;
    draw(bench, &reference, &found)?;
    section.figure("theory.svg", "Theories minus discrete ordinates");
    Ok(section)
}

fn identity() -> Comparison {
    let what = "Wiscombe and Warren: diffuse = integral of direct";
    let mut comparison = Comparison::new(what, "1e-6");
    for co_albedo in [1e-6, 1e-4, 0.01, 0.3] {
        for asymmetry in [0.78, 0.89] {
            let grain = SingleScattering { co_albedo, asymmetry };
            let albedo = |light| wiscombe_warren(grain, f64::INFINITY, light).reflectance;
            // Simpson's rule of the smooth 2 mu R(mu); nothing comes from the horizon.
            const PARTS: u32 = 200;
            let sum: f64 = (1..=PARTS)
                .map(|part| {
                    let cosine = f64::from(part) / f64::from(PARTS);
                    let weight = if part == PARTS {
                        1.0
                    } else if part % 2 == 1 {
                        4.0
                    } else {
                        2.0
                    };
                    weight * 2.0 * cosine * albedo(Incidence::Parallel(cosine))
                })
                .sum();
            let name = format!("1 - w = {co_albedo}, g = {asymmetry}");
            let integral = sum / f64::from(3 * PARTS);
            comparison.compare(&name, albedo(Incidence::Diffuse), integral, 1e-6);
        }
    }
    comparison
}

/// Theory, discrete ordinates of every row of a method and an angle.
fn pairs(reference: &Table, found: &Table, method: &str, angle: &str) -> Result<Vec<[f64; 2]>> {
    let rows = found.rows().filter(|row| row.has(&[("method", method), ("sza_deg", angle)]));
    rows.map(|row| {
        let expected = reference.find(&[
            ("r_um", row.text("radius_um")?),
            ("sza_deg", angle),
            ("wavelength_nm", row.text("wavelength_nm")?),
        ])?;
        Ok([row.number("R")?, expected.number("disort_go_unpol")?])
    })
    .collect()
}

fn distances(section: &mut Section, reference: &Table, found: &Table) -> Result<()> {
    let mut asymptotic =
        Comparison::new("Kokhanovsky and Zege, sun at 60 degrees or higher, R > .6", ".01");
    let angles = reference.distinct("sza_deg")?;
    let mut rows = Vec::new();
    for method in METHODS {
        let mut row = vec![method.to_owned()];
        for angle in &angles {
            let pairs = pairs(reference, found, method, angle)?;
            let worst = |pairs: &mut dyn Iterator<Item = &[f64; 2]>| {
                pairs.map(|[found, expected]| (found - expected).abs()).fold(0.0, f64::max)
            };
            let bright = worst(&mut pairs.iter().filter(|pair| pair[1] > 0.6));
            row.push(format!("{bright:.4} / {:.4}", worst(&mut pairs.iter())));
            let high = angle == "diffuse" || angle.parse::<f64>().is_ok_and(|angle| angle <= 60.0);
            if method == "kokhanovsky-zege" && high {
                for [found, expected] in pairs.iter().filter(|pair| pair[1] > 0.6) {
                    asymptotic.compare(angle, *found, *expected, 0.01);
                }
            }
        }
        rows.push(row);
    }
    section.say("Largest distance from discrete ordinates, where R > .6 / everywhere, by the angle of the sun:");
    let heads: Vec<&str> =
        ["theory"].into_iter().chain(angles.iter().map(String::as_str)).collect();
    section.table(&heads, &rows);
    section.add(asymptotic);
    Ok(())
}

fn draw(bench: &Bench, reference: &Table, found: &Table) -> Result<()> {
    let mut series = Vec::new();
    // Under the sun two streams are Wiscombe and Warren's.
    let lines = [
        ("wiscombe-warren", "diffuse"),
        ("two-stream", "diffuse"),
        ("kokhanovsky-zege", "diffuse"),
        ("wiscombe-warren", "60"),
        ("kokhanovsky-zege", "60"),
    ];
    for (method, angle) in lines {
        let mut line = Vec::new();
        for [found, expected] in pairs(reference, found, method, angle)? {
            line.push([expected, found - expected]);
        }
        line.sort_by(|one, other| one[0].total_cmp(&other[0]));
        series.push(Series { name: format!("{method}, {angle}"), line, points: Vec::new() });
    }
    let figure = Figure {
        title: "Theories minus discrete ordinates, all radii and wavelengths",
        x: Axis { name: "albedo (discrete ordinates)", from: 0.0, to: 1.0, step: 0.1 },
        y: Axis { name: "difference", from: -0.06, to: 0.06, step: 0.02 },
        series,
        remark: "sun at 60 degrees, or diffuse",
    };
    figure.write(&bench.figure("theory.svg"))
}
