//! Packs (section 3 of the project's physics) against an independent Monte Carlo program.

use super::identities::random_pack_options;
use super::{Bench, number};
use crate::report::{Comparison, Section};
use anyhow::Result;

const TOLERANCE: &str = "max(.004, 4 sigma)";
/// Radius of the grains of `measure slab`, metres.
const RADIUS: f64 = 5e-4;
/// Below this optical depth the faces of a pack at random places count.
const THIN: f64 = 4.0;
/// Optical depth of deep packs.
const DEEP: f64 = 300.0;

pub(super) fn section(bench: &Bench) -> Result<Section> {
    let mut section = Section::new("Packs");
    section.say(
        "Slabs of clear ice over black, and deep packs of absorbing ice, against an independent Monte Carlo \
         program of the same spheres (`packing_slab.csv`, `packing_slab_random.csv`, \
         `packing_semi_infinite_albedo.csv`). Left out: solid fractions beyond random sequential addition; \
         parallel light that is not along an axis of a lattice, which depends on the azimuth; parallel light on deep packs; light from the \
         vertical on the table's thinnest packs, which repeat in depth; ballistic deposits, which \
         `cargo test --test physics` compares. Slabs at random places of tau 2 are told but not judged: the table's \
         are cut out of deeper packs, whose faces are rough, ours hold whole grains between level faces. Nor are deep packs of solid fraction .15 judged: ours reflect more than the \
         table's, which repeats in depth and has channels for light from the vertical; whether that is all of the \
         difference is not known.",
    );
    lattices(bench, &mut section)?;
    random_slabs(bench, &mut section)?;
    deep_packs(bench, &mut section)?;
    Ok(section)
}

/// What a conventional cell of touching grains adds to the optical depth.
fn tau_of_cell(lattice: &str) -> f64 {
    core::f64::consts::PI * if lattice == "sc" { 0.25 } else { 0.5 }
}

fn cells(lattice: &str, tau: f64) -> f64 {
    (tau / tau_of_cell(lattice)).round()
}

fn lattices(bench: &Bench, section: &mut Section) -> Result<()> {
    let mut fluxes = Comparison::new("R and T of slabs of lattices", TOLERANCE);
    let mut visits = Comparison::new("grain visits in slabs of lattices", "1 % or 4 sigma");
    for row in bench.reference("packing_slab.csv")?.rows() {
        let (lattice, tau, light) = (row.text("packing")?, row.number("tau")?, row.text("mu0")?);
        let incidence = if light == "1" { "0" } else { "lambertian" };
        // A conventional cell of fcc has two layers of grains, and some slabs have an odd number.
        let whole = (tau / (cells(lattice, tau) * tau_of_cell(lattice)) - 1.0).abs() < 1e-3;
        if !["sc", "fcc"].contains(&lattice)
            || light == "0.5"
            || !whole
            || tau > bench.choose(200.0, 10.0)
        {
            continue;
        }
        let (layers, paths) = (cells(lattice, tau), bench.choose(200_000, 50_000));
        let found = bench.json(
            section,
            &format!("measure slab --lattice {lattice} --layers {layers} --incidence {incidence} --paths {paths} --json"),
        )?;
        let error =
            number(&found, "/reflectance/standard_error")? + row.number("standard_error")?;
        let name = format!("{lattice}, tau {tau}, {incidence}");
        for flux in ["reflectance", "transmittance"] {
            let mean = number(&found, &format!("/{flux}/mean"))?;
            fluxes.compare(
                &format!("{flux}, {name}"),
                mean,
                row.number(flux)?,
                0.004f64.max(4.0 * error),
            );
        }
        let expected = row.number("visits")?;
        let error = number(&found, "/grain_visits/standard_error")? / expected;
        let ratio = number(&found, "/grain_visits/mean")? / expected;
        visits.compare(&name, ratio, 1.0, 0.01f64.max(4.0 * core::f64::consts::SQRT_2 * error));
    }
    section.add(fluxes);
    section.add(visits);
    Ok(())
}

fn random_slabs(bench: &Bench, section: &mut Section) -> Result<()> {
    let mut packed = Comparison::new("R and T of slabs at random places", TOLERANCE);
    let mut thin = Comparison::reported("the same, tau 2 (not judged)", TOLERANCE);
    let mut dilute = Comparison::new("R and T of slabs of grains met at random", TOLERANCE);
    for row in bench.reference("packing_slab_random.csv")?.rows() {
        let (packing, tau, cosine) = (row.text("packing")?, row.number("tau")?, row.number("mu0")?);
        let solid_fraction = row.number("phi")?;
        let method = match packing {
            "hom" => "homogeneous",
            "f0.05" | "f0.15" | "f0.30" => "grains",
            _ => continue,
        };
        let channels = cosine == 1.0 && ["f0.05", "f0.15"].contains(&packing);
        if channels || tau > bench.choose(150.0, 6.0) {
            continue;
        }
        let incidence = match cosine {
            -1.0 => "--diffuse",
            0.5 => "--sza 60",
            _ => "--sza 0",
        };
        let density = 917.0 * solid_fraction;
        // Radii of 50 um: depth = tau (4/3) r / phi.
        let depth = format!("{:.4}um", tau * 50.0 * 4.0 / (3.0 * solid_fraction));
        let command = format!(
            "optics albedo --method {method} --radius 50um --density {density:.2} --depth {depth} {incidence} \
             --wavelengths 560 --ice-k warren-brandt-2008 --stderr 0.001"
        );
        let found = bench.table(section, &command)?;
        let found = found.find(&[("method", method)])?;
        let comparison = match method {
            "grains" if tau < THIN => &mut thin,
            "grains" => &mut packed,
            _ => &mut dilute,
        };
        for flux in ["R", "T"] {
            let error = found.number(&format!("{flux}_stderr"))? + row.number("stderr")?;
            let name = format!("{flux}, {packing}, tau {tau}, mu0 {cosine}");
            let allowed = 0.004f64.max(4.0 * error);
            comparison.compare(&name, found.number(flux)?, row.number(flux)?, allowed);
        }
    }
    section.add(packed);
    section.add(thin);
    section.add(dilute);
    Ok(())
}

/// Packs so deep (tau = 300, as in the table) that hardly any light comes back from below.
fn deep_packs(bench: &Bench, section: &mut Section) -> Result<()> {
    let mut comparison = Comparison::new("R of deep packs that absorb", TOLERANCE);
    let mut sparse = Comparison::reported("the same, solid fraction .15 (not judged)", TOLERANCE);
    let packs = if bench.quick { &["sc", "fcc"][..] } else { &["sc", "fcc", "f0.15", "f0.30"] };
    for &pack in packs {
        let grains = match pack {
            "f0.15" => random_pack_options(bench, 0.15, DEEP)?,
            "f0.30" => random_pack_options(bench, 0.30, DEEP)?,
            lattice => format!("--lattice {lattice} --layers {}", cells(lattice, DEEP)),
        };
        let paths = if grains.starts_with("--lattice") { 160_000 } else { 40_000 };
        for row in bench.reference("packing_semi_infinite_albedo.csv")?.rows() {
            let kappa = row.number("kappa_gamma_r")?;
            if row.number("mu0")? != -1.0 {
                continue;
            }
            let absorption = kappa / RADIUS;
            let command =
                format!("measure slab {grains} --absorption {absorption} --paths {paths} --json");
            let found = bench.json(section, &command)?;
            let name = format!("{pack}, gamma r {kappa}");
            let error = number(&found, "/reflectance/standard_error")?;
            let mean = number(&found, "/reflectance/mean")?;
            let judge = if pack == "f0.15" { &mut sparse } else { &mut comparison };
            judge.compare(&name, mean, row.number(pack)?, 0.004f64.max(4.0 * error));
        }
    }
    section.add(comparison);
    if !bench.quick {
        section.add(sparse);
    }
    Ok(())
}
