//! Renders that are killed, or meet a full or broken disk, at every step of the writing of a film.
//!
//! The steps are those of `crates/formats/src/fault_injection.rs`.

use super::ends::{ENDLESS, FILM, compare_with_whole, film};
use super::{Bench, SNOW, ended};
use anyhow::{Context as _, Result, ensure};
use snowgrain_math::sampler::split_mix;
use std::process::{ExitStatus, Stdio};

/// A film of [`super::SNOW`] takes a little more than these bytes.
const FILM_BYTES: u64 = 18_700_000;

/// A step, and whether the new film has its name afterwards.
struct Step {
    name: String,
    is_named: bool,
}

/// Every step once; the bytes after which a write is broken off differ from round to round.
fn steps(round: u64) -> Vec<Step> {
    let before = ["create", "sync", "rename"].map(str::to_owned);
    let cuts = [0, 1, split_mix(round) % FILM_BYTES, FILM_BYTES - split_mix(!round) % 4096];
    let cuts = cuts.map(|bytes| format!("write:{bytes}"));
    let after = ["sync-folder", "end"].map(str::to_owned);
    let step = |is_named| move |name| Step { name, is_named };
    let before = before.into_iter().chain(cuts).map(step(false));
    before.chain(after.into_iter().map(step(true))).collect()
}

/// Goes on with the film and is killed at a step of its `nth` writing.
fn run_to_its_kill(bench: &Bench, step: &Step, nth: u64) -> Result<ExitStatus> {
    let fault = format!("film-{}=kill@{nth}", step.name);
    let mut command = bench.command(&[&ENDLESS[..], &["--checkpoint-every", "1ms"]].concat());
    ended(&mut command.env("SNOWGRAIN_FAULT", fault).spawn()?)
}

/// Kills at each step of the first, second and third film that a process writes, and so on.
pub(super) fn kills(bench: &Bench, rounds: u64) -> Result<String> {
    use std::os::unix::process::ExitStatusExt as _;
    let (mut held, mut count, mut inside) = (0, 0, 0);
    let others = bench.path(".snowgrain-0-other.partial");
    let held_by_another = std::fs::File::create(&others)?;
    held_by_another.lock()?;
    for round in 0..rounds {
        let nth = 1 + round % 3;
        for step in steps(round) {
            let before = std::fs::read(bench.path(FILM)).ok();
            let status = run_to_its_kill(bench, &step, nth)?;
            let name = &step.name;
            ensure!(
                status.signal() == Some(9),
                "{name}: it was not killed but ended with {status}"
            );
            let now = film(bench, held)?.map_or(0, |film| film.samples().total());
            let same = std::fs::read(bench.path(FILM)).ok() == before;
            if nth == 1 {
                ensure!(same != step.is_named, "{name}: old film {same}, samples {held} -> {now}");
            }
            let left = bench.partial_files()?;
            let expected = 1 + usize::from(!step.is_named);
            ensure!(left == expected, "{name}: {left} temporary files, not {expected}");
            ensure!(others.exists(), "{name}: the temporary file of another worker was swept");
            inside += u64::from(!step.is_named);
            count += 1;
            held = now;
        }
    }
    bench.render(&["--spp", "1", "-o", "b.film"])?;
    ensure!(bench.partial_files()? == 1, "what the last kill left was not swept");
    drop(held_by_another);
    std::fs::remove_file(&others)?;
    let samples = compare_with_whole(bench)?;
    Ok(format!(
        "{count} kills at {} steps, {inside} of them before the film had its name; 0 torn films; the film of \
         {samples} samples has the bytes of one without a break",
        steps(0).len()
    ))
}

/// What a render with a fault said and how it ended.
fn faulty(bench: &Bench, arguments: &[&str], fault: &str) -> Result<(ExitStatus, String)> {
    let mut command = bench.program(arguments);
    let output = command.env("SNOWGRAIN_FAULT", fault).stderr(Stdio::piped()).output()?;
    Ok((output.status, String::from_utf8_lossy(&output.stderr).into_owned()))
}

/// Each step fails as on a full and on a broken disk, at the end of a render and at a checkpoint.
pub(super) fn broken_disk(bench: &Bench) -> Result<String> {
    bench.render(&["--samples", "0..1", "-o", "old.film"])?;
    bench.render(&["--spp", "12", "-o", "whole.film"])?;
    let (old, whole) = (bench.path("old.film"), std::fs::read(bench.path("whole.film"))?);
    let before = std::fs::read(&old)?;
    let mut count = 0;
    for step in steps(7) {
        for (kind, said) in [("enospc", "no storage space"), ("eio", "input/output error")] {
            let fault = format!("film-{}={kind}", step.name);
            std::fs::write(&old, &before)?;
            let more = ["--samples", "0..2", "--resume", "-o", "old.film"];
            let more = [&["render"], &SNOW[..], &more].concat();
            let (status, words) = faulty(bench, &more, &fault)?;
            ensure!(status.code() == Some(74), "{fault}: {status}: {words}");
            ensure!(words.contains(said), "{fault}: {words}");
            let same = std::fs::read(&old)? == before;
            ensure!(same != step.is_named, "{fault}: the old film is there: {same}");
            ensure!(bench.partial_files()? == 0, "{fault}: a temporary file was left");
            count += 1;
        }
        // A checkpoint that fails costs nothing but itself.
        let fault = format!("film-{}=enospc", step.name);
        std::fs::write(&old, &before)?;
        let more = ["--spp", "12", "--resume", "--checkpoint-every", "1ms", "-o", "old.film"];
        let aloud = &SNOW[..SNOW.len() - 1];
        let (status, words) = faulty(bench, &[&["render"], aloud, &more].concat(), &fault)?;
        ensure!(status.success(), "{fault}: {status}: {words}");
        ensure!(words.contains("no checkpoint"), "{fault}: {words}");
        ensure!(std::fs::read(&old)? == whole, "{fault}: the film differs after it");
        count += 1;
    }
    for file in ["old.film", "whole.film"] {
        std::fs::remove_file(bench.path(file)).context(file)?;
    }
    Ok(format!(
        "{count} faults at {} steps: 74 at the end, the old film intact where the new one had no name; a checkpoint \
         that fails is told, and the film has the same bytes",
        steps(0).len()
    ))
}
