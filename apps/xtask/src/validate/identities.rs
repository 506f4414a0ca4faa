//! Identities that hold exactly (section 2 of the project's physics).

use super::{Bench, number};
use crate::report::{Comparison, Section};
use anyhow::Result;
use serde_json::Value;
use snowgrain_formats::write_grains;
use snowgrain_grains::{ICE_DENSITY, RandomSettings, random_pack};

/// Period of random packs along x and z, and radius of their grains, metres.
const WIDTH: f64 = 0.02;
const RADIUS: f64 = 5e-4;

pub(super) fn section(bench: &Bench) -> Result<Section> {
    let mut section = Section::new("Exact identities");
    section.say(
        "Grains that do not overlap, clear ice, diffuse light on one face: whatever the packing, a path \
         visits 2 tau grains, meets two interfaces a visit, and has 2 tau (4/3) B r of ice; the mean chord in \
         air is (4/3) r (1 - phi)/phi. `random_*.ply` are packs by random sequential addition (solid \
         fractions .15 and .30, 40 radii wide), which the task writes before.",
    );
    let paths = bench.choose(400_000, 50_000);
    let mut measured = Vec::new();
    for lattice in ["sc", "bcc", "fcc", "hcp"] {
        let command =
            format!("measure slab --lattice {lattice} --layers 10 --paths {paths} --json");
        measured.push((lattice.to_owned(), bench.json(&mut section, &command)?));
    }
    let command = format!(
        "measure slab --rule stick --width 60mm --grains 100000 --from both --paths {paths} --json"
    );
    measured.push(("stick".to_owned(), bench.json(&mut section, &command)?));
    for solid_fraction in [0.15, 0.30] {
        let pack = random_pack_options(bench, solid_fraction, 20.0)?;
        let command = format!("measure slab {pack} --from both --paths {paths} --json");
        measured.push((format!("random {solid_fraction}"), bench.json(&mut section, &command)?));
    }
    compare(&mut section, &measured)?;
    Ok(section)
}

fn compare(section: &mut Section, measured: &[(String, Value)]) -> Result<()> {
    for (quantity, what) in [
        ("grain_visits", "grain visits = 2 tau"),
        ("interface_events", "interface events = 4 tau"),
        ("ice_path", "path in ice = 2 tau (4/3) B r"),
        ("void_chord", "chord in air = (4/3) r (1 - phi)/phi"),
    ] {
        let mut comparison = Comparison::new(what, "1 % or 4 sigma");
        for (name, value) in measured {
            let part = |part: &str| number(value, &format!("/{quantity}/{part}"));
            let expected = part("expected")?;
            let allowed = 0.01f64.max(4.0 * part("standard_error")? / expected);
            comparison.compare(name, part("mean")? / expected, 1.0, allowed);
        }
        section.add(comparison);
    }
    let mut comparison = Comparison::new("R + T = 1", "1e-9");
    for (name, value) in measured {
        let sum = number(value, "/reflectance/mean")? + number(value, "/transmittance/mean")?;
        comparison.compare(name, sum, 1.0, 1e-9);
    }
    section.add(comparison);
    Ok(())
}

/// Writes a random pack of this optical depth; the options of `measure slab` that read it.
pub(super) fn random_pack_options(bench: &Bench, solid_fraction: f64, tau: f64) -> Result<String> {
    let (pack, period) = random_pack(&RandomSettings {
        radius: RADIUS,
        density: solid_fraction * ICE_DENSITY,
        depth: tau * 4.0 * RADIUS / (3.0 * solid_fraction),
        width: WIDTH,
        seed: 1,
    })?;
    let file = format!("random_{solid_fraction:.2}_tau_{tau}.ply");
    write_grains(&bench.folder().join(&file), &pack)?;
    let [x, z] = period.map(|quanta| 1e3 * quanta as f64 * pack.quantisation.quantum());
    Ok(format!("--file {file} --period {x:.9}mm,{z:.9}mm"))
}
