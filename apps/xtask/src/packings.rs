//! `cargo xtask packings`: which densities snow reaches, by what, and at what cost.

use crate::program::Program;
use anyhow::{Context as _, Result};
use serde_json::Value;
use std::fmt::Write as _;
use std::path::PathBuf;

/// Densities asked for, kg/m^3.
const DENSITIES: [f64; 12] =
    [28.0, 60.0, 100.0, 150.0, 200.0, 250.0, 300.0, 400.0, 500.0, 550.0, 600.0, 675.0];
/// Relative difference that passes.
const TOLERANCE: f64 = 0.02;
/// Radius of the grains, metres.
const RADIUS: f64 = 0.5e-3;
/// Density of ice, kg/m^3.
const ICE: f64 = 917.0;

/// Options of the task.
#[derive(clap::Args)]
pub(crate) struct Options {
    /// Folder for packings.md
    #[arg(long, value_name = "DIR", default_value = "docs")]
    out: PathBuf,

    /// Grains of each snow
    #[arg(long, value_name = "N", default_value_t = 300_000.0)]
    grains: f64,

    /// Only these densities, kg/m^3
    #[arg(long, value_name = "D,...", value_delimiter = ',')]
    densities: Vec<f64>,
}

/// Ways to make snow of a density.
const SOURCES: [(&str, &str); 2] = [
    ("deposit", "Snow that falls (`source = \"deposit\"`) on a plane, about 120 radii deep"),
    ("pack", "Packed snow (`source = \"pack\"`), a box 120 radii high"),
];

/// Writes the table; false where a density is missed.
pub(crate) fn packings(options: &Options) -> Result<bool> {
    let program = Program::build()?;
    let densities = if options.densities.is_empty() { &DENSITIES[..] } else { &options.densities };
    let mut report = String::from(INTRODUCTION);
    let mut passed = true;
    for (source, title) in SOURCES {
        write!(report, "\n## {title}\n\n{HEADS}")?;
        for &density in densities {
            let row = row(&program, source, density, options.grains)?;
            let off = row.reached / density - 1.0;
            passed &= off.abs() <= TOLERANCE;
            println!("{source} {density}: {:.1}, {:+.2} %", row.reached, 100.0 * off);
            writeln!(
                report,
                "| {density} | {:.1} | {:+.2} % | {:.2} | {} | {:.1} | {:.0} | {} |",
                row.reached,
                100.0 * off,
                row.connected,
                row.grains,
                row.seconds,
                row.megabytes,
                row.by
            )?;
        }
    }
    std::fs::write(options.out.join("packings.md"), report)?;
    Ok(passed)
}

const INTRODUCTION: &str = "# Densities on request

Written by `cargo xtask packings`: about 300 000 equal grains of .5 mm at each density (`--grains` asks for others). `snowgrain deposit` makes each snow \
and measures what it says here: the density of the union of the ice between 20 and 80 % of the depth at \
each place, the part of the mass that hangs together with the ground (of a box: with itself), processor seconds to make \
the snow with all pilots, and the most memory that the program held at once, for measuring the grains too.

Up to what sticking gives (about 140 kg/m^3), aggregates of grains fall, made by ballistic cluster-cluster \
aggregation; the larger they are, the lighter the snow. Up to what rolling gives (about 530), each grain sticks \
at a contact or rolls on, by a probability. Both leave grains that touch without overlap. Denser snow that falls sinters: \
grains roll with a part of their radius and overlap afterwards. The size of aggregates, the probability or the part is \
found by pilot snowfalls on a small floor, of the same depth, sizes and seed.

Packs are cut from such snow and closed, so that they repeat along all axes; up to a solid fraction of .62 \
(569 kg/m^3) denser ones are pressed together and their overlaps pushed apart, and beyond it they sinter. A density that is \
out of reach is refused with the range that is not.
";

const HEADS: &str =
    "| asked, kg/m^3 | reached | off | connected, % | grains | CPU, s | memory, MB | by |
|---:|---:|---:|---:|---:|---:|---:|---|
";

/// What became of one snow.
struct Row {
    reached: f64,
    connected: f64,
    grains: u64,
    seconds: f64,
    megabytes: f64,
    by: String,
}

fn row(program: &Program, source: &str, density: f64, grains: f64) -> Result<Row> {
    let depth = 120.0 * RADIUS;
    let ball = 4.0 / 3.0 * core::f64::consts::PI * RADIUS * RADIUS * RADIUS;
    let half = 0.5 * (grains * ball * ICE / density / depth).sqrt();
    let place = if source == "deposit" {
        format!("grains = {grains}\narea = [{}, {}, {half}, {half}]", -half, -half)
    } else {
        format!("box = [{}, 0, {}, {half}, {depth}, {half}]", -half, -half)
    };
    let scene = format!(
        "version = 1\n[camera]\nfrom = [0, 1, 1]\nat = [0, 0, 0]\n[[light]]\nkind = \"sky\"\n\
         [[object]]\nshape = \"plane\"\n[[snow]]\nsource = \"{source}\"\nradius = {RADIUS}\n\
         density = {density}\n{place}\n"
    );
    std::fs::write(program.folder().join("snow.toml"), scene)?;
    program.print("deposit snow.toml -o snow.ply --json-stats stats.json --quiet", None)?;
    let stats = std::fs::read_to_string(program.folder().join("stats.json"))?;
    let stats: Value = serde_json::from_str(&stats)?;
    let number = |key: &str| stats[key].as_f64().with_context(|| format!("no {key}"));
    let how = &stats["snowfalls"][0]["density"]["by"];
    Ok(Row {
        reached: number("union_density")?,
        connected: 100.0 * number("connected_fraction")?,
        grains: number("grains")? as u64,
        seconds: number("deposit_cpu_seconds")?,
        megabytes: number("peak_rss_bytes")? / 1e6,
        by: how.as_str().context("it says how")?.to_owned(),
    })
}
