//! Grains of other shapes than spheres: published asymmetries, absorption, and the directions of natural snow.

use super::{Bench, number};
use crate::report::{Comparison, Section};
use anyhow::Result;

/// The refractive index of the published fit.
const INDEX: f64 = 1.3038;
/// What the published fit may be off: it is a polynomial through ray tracing that tracks polarisation.
const PUBLISHED_TOLERANCE: f64 = 0.015;
/// Shapes of which B is at most n^2.
const CONVEX: [&str; 6] = [
    "random-polyhedron --faces 8",
    "random-polyhedron --faces 14",
    "random-polyhedron --faces 14 --rounding 0.7",
    "random-polyhedron --faces 24 --seed 1",
    "cube",
    "spheroid --aspect 0.5",
];
/// B and g of natural snow, between which the mix was chosen.
const NATURAL: [[f64; 2]; 2] = [[1.5, 1.7], [0.63, 0.70]];
/// Views of natural snow, and the greatest ratio of them.
const FORWARD_BY_NADIR: f64 = 1.25;
/// Zenith angles on the side of the light whose scattering angles are 130 to 142 degrees and beside them.
const BEHIND: [&str; 7] = ["0", "5", "10", "15", "20", "25", "30"];

pub(super) fn section(bench: &Bench) -> Result<Section> {
    let mut section = Section::new("Shapes");
    section.say(format!(
        "g without diffraction of hexagonal prisms in all orientations, n = {INDEX}, against the fit of van Diedenhoven \
         et al. 2014 (J. Atmos. Sci. 71, 1763) to ray tracing by the program of Macke et al. 1996 \
         (`go_hexagonal_asymmetry.csv`; their g of ray tracing and diffraction is turned into that of ray tracing by \
         2 g - 1). The fit is a polynomial of the sixth \
         degree in the logarithm of the aspect, and its ray tracing tracks polarisation, which raises g, by .003 for a \
         sphere (here a mean reflectance is drawn anew at each interface): {PUBLISHED_TOLERANCE} is allowed. B of convex \
         shapes is at most n^2."
    ));
    published(bench, &mut section)?;
    absorption(bench, &mut section)?;
    mix(bench, &mut section)?;
    Ok(section)
}

fn published(bench: &Bench, section: &mut Section) -> Result<()> {
    let mut comparison = Comparison::new("g of hexagonal plates and columns", ".015");
    let mut rows = Vec::new();
    for row in bench.reference("go_hexagonal_asymmetry.csv")?.rows() {
        let (aspect, expected) = (row.text("aspect")?, row.number("g")?);
        let found = phase(
            bench,
            section,
            &format!("--ior {INDEX} --shape hexagonal-prism --aspect {aspect}"),
        )?;
        comparison.compare(&format!("aspect {aspect}"), found.g[0], expected, PUBLISHED_TOLERANCE);
        rows.push(vec![
            aspect.to_owned(),
            format!("{:.4} +- {:.4}", found.g[0], found.g[1]),
            format!("{expected:.4}"),
            format!("{:+.4}", found.g[0] - expected),
            format!("{:.3} +- {:.3}", found.b[0], found.b[1]),
        ]);
    }
    section.add(comparison);
    section.table(&["aspect", "g", "published", "difference", "B"], &rows);
    Ok(())
}

fn absorption(bench: &Bench, section: &mut Section) -> Result<()> {
    let mut comparison = Comparison::new("B of convex shapes, at most n^2", "4 sigma");
    let mut rows = Vec::new();
    for shape in CONVEX {
        let found = phase(bench, section, &format!("--ior 1.31 --shape {shape}"))?;
        let [b, error] = found.b;
        comparison.within(shape, b, [0.0, 1.31 * 1.31 + 4.0 * error]);
        rows.push(vec![
            shape.to_owned(),
            format!("{:.4} +- {:.4}", found.g[0], found.g[1]),
            format!("{b:.4} +- {error:.4}"),
        ]);
    }
    section.add(comparison);
    section.table(&["shape, n = 1.31", "g", "B"], &rows);
    Ok(())
}

fn mix(bench: &Bench, section: &mut Section) -> Result<()> {
    section.say(
        "The mix `faceted` (docs/snows.md) was chosen by its B and g alone, in the middle of what is known of natural \
         snow, before any of the measured albedos below was looked at. Bidirectional reflectance of deep snow of it \
         at 550 nm, the light at 60 degrees: smooth spheres send 1.7 times as much forward as up, natural snow 1.11 \
         (Kokhanovsky and Breon 2012), and only spheres have a rainbow, at scattering angles of 130 to 142 degrees.",
    );
    let found = phase(bench, section, "--shapes faceted")?;
    let mut comparison =
        Comparison::new("B and g of the mix of natural snow", "1.5 to 1.7, .63 to .70");
    comparison.within("B", found.b[0], NATURAL[0]);
    comparison.within("g", found.g[0], NATURAL[1]);
    section.add(comparison);
    let error = bench.choose(0.003, 0.01);
    let command = format!(
        "optics brdf --radius 200um --shapes spheres,faceted --sza 60 --vza {},60 --azimuth 0,180 --wavelengths 550 \
         --stderr {error} --quiet",
        BEHIND.join(",")
    );
    let table = bench.table(section, &command)?;
    let factor = |shapes: &str, zenith: &str, azimuth: &str| {
        let wanted = [("shapes", shapes), ("vza_deg", zenith), ("azimuth_deg", azimuth)];
        table.find(&wanted)?.number("BRF")
    };
    let ratio = |shapes: &str| {
        Ok::<_, anyhow::Error>(factor(shapes, "60", "0")? / factor(shapes, "0", "0")?)
    };
    let mut comparison =
        Comparison::new("forward at 60 degrees by nadir, natural shapes", "at most 1.25");
    comparison.within("faceted", ratio("faceted")?, [0.0, FORWARD_BY_NADIR]);
    section.add(comparison);
    let brf = |shapes: &str| {
        let factors = BEHIND.iter().map(|zenith| factor(shapes, zenith, "180"));
        factors.collect::<Result<Vec<f64>>>()
    };
    let (own, spheres) = (brf("faceted")?, brf("spheres")?);
    let falls = |factors: &[f64]| factors.windows(2).map(|two| two[0] - two[1]).collect::<Vec<_>>();
    let allowed = 4.0 * core::f64::consts::SQRT_2 * error;
    let mut smooth =
        Comparison::new("no bump at 130 to 142 degrees", "4 sigma of a step between neighbours");
    for (fall, zenith) in falls(&own).into_iter().zip(&BEHIND[1..]) {
        smooth.within(&format!("fall before {zenith} degrees"), fall, [f64::NEG_INFINITY, allowed]);
    }
    section.add(smooth);
    let mut rainbow =
        Comparison::new("a bump of spheres there", "more than 4 sigma of such a step");
    let largest = falls(&spheres).into_iter().fold(f64::NEG_INFINITY, f64::max);
    rainbow.within("largest fall", largest, [allowed, f64::INFINITY]);
    section.add(rainbow);
    let rows = BEHIND.iter().zip(own.iter().zip(&spheres)).map(|(zenith, (own, sphere))| {
        let angle = 120.0 + zenith.parse::<f64>()?;
        Ok(vec![format!("{angle}"), format!("{own:.3}"), format!("{sphere:.3}")])
    });
    let rows = rows.collect::<Result<Vec<_>>>()?;
    section.say(format!(
        "Forward at 60 degrees by nadir: {:.3} for the mix, {:.3} for spheres (standard errors of the factors up to \
         {error}). On the side of the light, by the scattering angle:",
        ratio("faceted")?,
        ratio("spheres")?
    ));
    section.table(&["scattering angle", "BRF, faceted", "BRF, spheres"], &rows);
    Ok(())
}

/// Means and standard errors.
struct Found {
    g: [f64; 2],
    b: [f64; 2],
}

fn phase(bench: &Bench, section: &mut Section, what: &str) -> Result<Found> {
    let paths = bench.choose(1_000_000, 100_000);
    let command = format!("optics phase {what} --bins 1 --paths {paths} --format json");
    let value = bench.json(section, &command)?;
    let of = |name: &str| {
        Ok::<_, anyhow::Error>([
            number(&value, &format!("/{name}"))?,
            number(&value, &format!("/{name}_standard_error"))?,
        ])
    };
    Ok(Found { g: of("g")?, b: of("B")? })
}
