//! What checkpoints cost.

use super::Bench;
use anyhow::{Context as _, Result, ensure};
use serde_json::Value;

/// Most that a checkpoint every ten seconds may take of the speed.
const MOST: f64 = 0.02;

/// Samples a second of processor time, and most memory, of a render of so many seconds.
fn run(bench: &Bench, seconds: u64, more: &[&str]) -> Result<(f64, f64)> {
    let limit = format!("{seconds}s");
    let film = bench.path("cost.film");
    let ordinary = [
        "--spp",
        "4000000000",
        "--time-limit",
        &limit,
        "--json-stats",
        "cost.json",
        "-o",
        "cost.film",
    ];
    bench.render(&[&ordinary[..], more].concat())?;
    let figures: Value = serde_json::from_slice(&std::fs::read(bench.path("cost.json"))?)?;
    let number = |name: &str| figures[name].as_f64().with_context(|| format!("no {name}"));
    std::fs::remove_file(film)?;
    Ok((number("samples")? / number("render_cpu_seconds")?, number("peak_rss_bytes")?))
}

pub(super) fn checkpoints(bench: &Bench, seconds: u64) -> Result<String> {
    // Ten times as often as is asked for, so that their cost stands out from the noise of the machine.
    let every = ["--checkpoint-every", "1s"];
    let (plain, _) = run(bench, seconds, &[])?;
    let (saving, long) = run(bench, seconds, &every)?;
    let (_, short) = run(bench, seconds.div_ceil(3), &every)?;
    let lost = 0.1 * (1.0 - saving / plain);
    ensure!(lost < MOST, "a checkpoint every 10 s takes {:.2} % of the speed", 100.0 * lost);
    Ok(format!(
        "{plain:.0} samples a CPU second without, {saving:.0} with one a second: {:.2} % are lost with one \
         every 10 s; peak memory {:.1} MB after {} s, {:.1} MB after {seconds} s",
        100.0 * lost,
        short / 1e6,
        seconds.div_ceil(3),
        long / 1e6,
    ))
}
