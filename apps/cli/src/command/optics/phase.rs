//! `snowgrain optics phase`.

use super::plot::{self, Chart, Charts, Scale, lines_of};
use super::table::{Cell, Table, number};
use crate::arguments::PhaseArguments;
use crate::failure::Failure;
use core::f64::consts::PI;
use snowgrain_formats::read_optical_constants;
use snowgrain_math::trig;
use snowgrain_optics::sphere::{self, Polarisation};
use snowgrain_optics::{Dielectric, Substance};
use std::sync::Arc;

/// Orders that are told one by one.
const ORDERS: u32 = 6;

mod shape;

pub(super) fn run(arguments: &PhaseArguments) -> Result<u8, Failure> {
    if arguments.shape.shape.is_some() || arguments.shape.shapes.is_some() {
        return shape::run(arguments);
    }
    let (eta, name) = index(arguments)?;
    let medium = Dielectric { eta };
    let polarisation = arguments.polarisation.into();
    let asymmetry = match polarisation {
        Polarisation::Redrawn => sphere::asymmetry(medium),
        Polarisation::Tracked => sphere::asymmetry_of_polarised(medium),
    };
    let mut figures = vec![
        ("refractive_index", eta),
        ("g", asymmetry),
        ("B", sphere::absorption_enhancement(medium)),
    ];
    // These are of the mean reflectance, whichever polarisation counts within a grain.
    if polarisation == Polarisation::Redrawn {
        const NAMES: [&str; ORDERS as usize] = ["E0", "E1", "E2", "E3", "E4", "E5"];
        figures.extend(NAMES.into_iter().zip((0..).map(|order| sphere::energy(medium, order))));
    }
    let bins = usize::from(arguments.bins);
    let edge = |bin: usize| 180.0 * bin as f64 / bins as f64;
    let energies = sphere::energy_by_angle(medium, polarisation, bins);
    let row = |(bin, energy): (usize, f64)| {
        let [from, to] = [edge(bin), edge(bin + 1)];
        let cosine = |degrees: f64| trig::sin_cos(degrees.to_radians()).1;
        let solid_angle = 2.0 * PI * (cosine(from) - cosine(to));
        let phase_function = 4.0 * PI * energy / solid_angle;
        [from, to, energy, phase_function].map(Cell::Number).to_vec()
    };
    let table = Table {
        names: vec!["from_deg", "to_deg", "energy", "phase_function"],
        rows: energies.into_iter().enumerate().map(row).collect(),
    };
    table.tell_with(&figures, arguments.format, arguments.output.as_deref())?;
    if let Some(file) = &arguments.plot {
        let title = format!("Scattering by a sphere of {name}, without diffraction");
        plot::write(file, &charts(&title, &table, [eta, asymmetry]))?;
    }
    Ok(0)
}

/// The index of refraction, and of what.
fn index(arguments: &PhaseArguments) -> Result<(f64, &'static str), Failure> {
    if let Some(eta) = arguments.ior {
        return Ok((eta, "this index"));
    }
    let substance = match &arguments.indices {
        Some(file) => Substance::Measured(Arc::new(read_optical_constants(file)?)),
        None => arguments.material.clone(),
    };
    Ok((substance.refractive_index(arguments.wavelength), substance.name()))
}

fn charts(title: &str, table: &Table, [eta, asymmetry]: [f64; 2]) -> Charts {
    let (lines, _) = lines_of(table, &[], |cell| {
        let number = |name: &str| cell(name)?.number();
        let middle = 0.5 * (number("from_deg")? + number("to_deg")?);
        Some((String::new(), [middle, number("phase_function")?, 0.0]))
    });
    let chart = Chart {
        names: ["scattering angle / degrees", "phase function (mean 1)"],
        scales: [Scale::Linear, Scale::Logarithmic],
        y_range: None,
        lines,
    };
    Charts {
        title: title.into(),
        subtitle: format!("n = {}, g = {}", number(eta), number(asymmetry)),
        charts: vec![chart],
    }
}
