//! The pictures of `snowgrain inspect`.

use crate::command::optics::plot::{Chart, Charts, Line, Scale};
use snowgrain_grains::ICE_DENSITY;
use snowgrain_grains::measures::{Directed, Structure};

/// Millimetres of a metre.
const MM: f64 = 1e3;

/// Chords, correlation, profile and sizes, side by side.
pub(super) fn charts(structure: &Structure) -> Charts {
    let linear = [Scale::Linear, Scale::Linear];
    let chords = Chart {
        names: ["chord, mm", "density of chords, 1/mm"],
        scales: [Scale::Linear, Scale::Logarithmic],
        y_range: None,
        lines: directed(structure, |along, medium| {
            let chords = if medium == 0 { &along.air_chords } else { &along.ice_chords };
            chords.iter().map(|(at, density)| [MM * at, density / MM, 0.0]).collect()
        }),
    };
    let correlation = Chart {
        names: ["distance, mm", "both in ice"],
        scales: linear,
        y_range: None,
        lines: directed(structure, |along, medium| {
            let points = along.correlation.iter().map(|(at, both)| [MM * at, *both, 0.0]);
            if medium == 1 { points.collect() } else { Vec::new() }
        }),
    };
    let step = 1.0 / structure.profile.len().max(1) as f64;
    let depths = structure.profile.iter().enumerate();
    let profile = Chart {
        names: ["part of the depth", "density, kg/m3"],
        scales: linear,
        y_range: Some([0.0, 1.2 * ICE_DENSITY * greatest(structure.profile.iter().copied())]),
        lines: vec![line(
            "",
            0,
            depths.map(|(at, part)| [(at as f64 + 0.5) * step, ICE_DENSITY * part, 0.0]).collect(),
        )],
    };
    let sizes = structure.sizes.classes.iter();
    let sizes = Chart {
        names: ["radius, mm", "part of the grains"],
        scales: linear,
        y_range: Some([0.0, 1.2 * greatest(structure.sizes.classes.iter().map(|class| class.1))]),
        lines: vec![line("", 0, sizes.map(|(at, part)| [MM * at, *part, 0.0]).collect())],
    };
    Charts {
        title: format!("Snow of {:.0} kg/m3", structure.density()),
        subtitle: format!(
            "specific surface {:.2} m2/kg, anisotropy {:.3}",
            structure.specific_surface(),
            structure.anisotropy
        ),
        charts: vec![chords, correlation, profile, sizes],
    }
}

/// A line for each axis and medium, air (0, dashed) and ice (1).
fn directed(
    structure: &Structure,
    points: impl Fn(&Directed, usize) -> Vec<[f64; 3]>,
) -> Vec<Line> {
    let mut lines = Vec::new();
    for (medium, name) in ["air", "ice"].into_iter().enumerate() {
        for (axis, along) in structure.along.iter().enumerate() {
            let label = format!("{name}, along {}", ["x", "y", "z"][axis]);
            let dashed = medium == 0;
            lines.push(Line { dashed, ..line(&label, axis, points(along, medium)) });
        }
    }
    lines
}

fn greatest(values: impl Iterator<Item = f64>) -> f64 {
    values.fold(f64::MIN_POSITIVE, f64::max)
}

fn line(label: &str, case: usize, points: Vec<[f64; 3]>) -> Line {
    Line { label: label.to_owned(), points, case, dashed: false }
}
