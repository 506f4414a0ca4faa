//! One sphere (section 1 of the project's physics): the closed form.

use super::{Bench, number};
use crate::report::{Comparison, Section};
use anyhow::Result;
use snowgrain_math::trig;
use snowgrain_optics::sphere::Impact;
use snowgrain_optics::{Dielectric, sphere};

const TOLERANCE: f64 = 0.0005;
/// Light that leaves after as many chords is told apart.
const MOST_ORDER: u32 = 5;

pub(super) fn section(bench: &Bench) -> Result<Section> {
    let mut section = Section::new("One sphere");
    section.say(
        "g, the energy of each order and B of one sphere without diffraction against an independent \
         quadrature (`go_single_sphere.csv`). `--ior` takes no relative index below 1: those of \
         `wet_relative_index.csv` are asked of the library (`snowgrain_optics::sphere`), and so is the energy of \
         the orders of light that keeps its polarisation, which the command does not print.",
    );
    for (mode, column) in [("redrawn", "unpol"), ("tracked", "pol")] {
        let comparison = closed_form(bench, &mut section, mode, column)?;
        section.add(comparison);
    }
    section.add(tracked_energies(bench)?);
    section.add(relative_indices(bench)?);
    bench.table_and_plot(&mut section, "optics phase --ior 1.31 --bins 360", "phase.svg")?;
    section.figure("phase.svg", "The phase function of a sphere of index 1.31");
    Ok(section)
}

fn closed_form(
    bench: &Bench,
    section: &mut Section,
    mode: &str,
    column: &str,
) -> Result<Comparison> {
    let what = if mode == "redrawn" { "g, E0 to E5, B" } else { "g, B" };
    let mut comparison = Comparison::new(format!("{what}; polarisation {mode}"), ".0005");
    for row in bench.reference("go_single_sphere.csv")?.rows() {
        let index = row.number("n")?;
        let command =
            format!("optics phase --ior {index} --bins 1 --polarisation {mode} --format json");
        let found = bench.json(section, &command)?;
        let mut compare = |name: &str, expected: f64| -> Result<()> {
            let value = number(&found, &format!("/{name}"))?;
            comparison.compare(&format!("{name}, n = {index}"), value, expected, TOLERANCE);
            Ok(())
        };
        compare("g", row.number(&format!("g_{column}"))?)?;
        compare("B", row.number("B_absorption_enhancement")?)?;
        if mode == "redrawn" {
            for order in 0..=MOST_ORDER {
                compare(&format!("E{order}"), row.number(&format!("E_p{order}_{column}"))?)?;
            }
        }
    }
    Ok(comparison)
}

fn tracked_energies(bench: &Bench) -> Result<Comparison> {
    let what = "E0 to E5; polarisation tracked, from the library";
    let mut comparison = Comparison::new(what, ".0005");
    for row in bench.reference("go_single_sphere.csv")?.rows() {
        let medium = Dielectric { eta: row.number("n")? };
        for order in 0..=MOST_ORDER {
            let found = sphere::mean_over_disc(medium, |impact| {
                let cosine = trig::sin_cos(impact.theta_i).1;
                let [across, along] = medium
                    .polarised_reflectances_from_outside(cosine)
                    .map(|reflectance| Impact { reflectance, ..*impact }.energy(order));
                0.5 * (across + along)
            });
            let name = format!("E{order}, n = {}", medium.eta);
            let expected = row.number(&format!("E_p{order}_pol"))?;
            comparison.compare(&name, found, expected, TOLERANCE);
        }
    }
    Ok(comparison)
}

fn relative_indices(bench: &Bench) -> Result<Comparison> {
    let mut comparison = Comparison::new("g and B of relative indices, from the library", ".0005");
    for row in bench.reference("wet_relative_index.csv")?.rows() {
        let medium = Dielectric { eta: row.number("n_rel")? };
        for (column, found) in [
            ("g_unpol", sphere::asymmetry(medium)),
            ("g_pol", sphere::asymmetry_of_polarised(medium)),
            ("B", sphere::absorption_enhancement(medium)),
        ] {
            let name = format!("{column}, {}", row.text("name")?);
            comparison.compare(&name, found, row.number(column)?, TOLERANCE);
        }
    }
    Ok(comparison)
}
