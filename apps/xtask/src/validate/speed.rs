//! How long a spectrum takes.

use super::Bench;
use crate::report::Section;
use anyhow::Result;
use std::time::Instant;

/// Runs of which the fastest counts: others on the machine only add.
const RUNS: u32 = 3;

pub(super) fn section(bench: &Bench) -> Result<Section> {
    let mut section = Section::new("Speed");
    let command = "optics albedo --method homogeneous --radius 200um --diffuse --wavelengths 350:1290:2 --stderr \
                   0.001 --threads 1";
    let mut best = f64::INFINITY;
    for _ in 0..bench.choose(RUNS, 1) {
        let start = Instant::now();
        bench.table(&mut section, command)?;
        best = best.min(start.elapsed().as_secs_f64());
    }
    section.say(format!(
        "471 wavelengths of deep snow to a standard error of .001 on one thread: {best:.1} s ({}; the fastest of \
         {RUNS} runs; 2 s of processor time are aimed at, and not judged).",
        processor()
    ));
    Ok(section)
}

fn processor() -> String {
    let known = std::fs::read_to_string("/proc/cpuinfo").ok().and_then(|text| {
        let line = text.lines().find(|line| line.starts_with("model name"))?;
        Some(line.split(':').nth(1)?.trim().to_owned())
    });
    known.unwrap_or_else(|| "unknown processor".into())
}
