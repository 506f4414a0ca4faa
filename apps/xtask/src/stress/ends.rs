//! Renders that are ended from outside at random times.

use super::{Bench, ended};
use anyhow::{Context as _, Result, ensure};
use snowgrain_film::Film;
use snowgrain_formats::read_film;
use snowgrain_math::sampler::split_mix;
use std::process::{Child, Command};
use std::time::{Duration, Instant};

pub(super) const FILM: &str = "a.film";
pub(super) const ENDLESS: [&str; 5] = ["--spp", "4000000000", "--resume", "-o", FILM];

/// Begins the film with one sample; how long that takes says when there is something to end.
fn begin(bench: &Bench) -> Result<Duration> {
    let start = Instant::now();
    bench.render(&["--spp", "1", "-o", FILM])?;
    Ok(start.elapsed())
}

/// A random time from shortly before the first sample to well after it.
fn wait(seed: u64, first_sample: Duration) {
    let unit = split_mix(seed) as f64 / u64::MAX as f64;
    std::thread::sleep(first_sample.mul_f64(0.3 + 1.7 * unit));
}

fn send(child: &Child, signal: &str) -> Result<()> {
    let sent = Command::new("kill").args(["-s", signal, &child.id().to_string()]).status()?;
    ensure!(sent.success(), "{signal} cannot be sent");
    Ok(())
}

/// The film that is there, which must be whole and hold at least what it did before.
pub(super) fn film(bench: &Bench, before: u64) -> Result<Option<Film>> {
    if !bench.path(FILM).exists() {
        ensure!(before == 0, "the film is gone");
        return Ok(None);
    }
    let film = read_film(&bench.path(FILM))?;
    let held = film.samples().total();
    ensure!(held >= before, "the film had {before} samples and has {held}");
    Ok(Some(film))
}

/// Whether the film has the bytes of a render of its samples without a break.
pub(super) fn compare_with_whole(bench: &Bench) -> Result<u64> {
    let film = film(bench, 0)?.context("no film was ever saved")?;
    ensure!(film.samples().total() > 1, "nothing was rendered beyond the first sample");
    let held = film.samples().to_string();
    bench.render(&["--samples", &held, "-o", "whole.film"])?;
    let same = std::fs::read(bench.path(FILM))? == std::fs::read(bench.path("whole.film"))?;
    ensure!(same, "the film of samples {held} differs from one without a break");
    let total = film.samples().total();
    for name in [FILM, "whole.film"] {
        std::fs::remove_file(bench.path(name))?;
    }
    Ok(total)
}

pub(super) fn kills(bench: &Bench, count: u64) -> Result<String> {
    let first_sample = begin(bench)?;
    let (mut held, mut inside) = (1, 0);
    for kill in 0..count {
        let mut child = bench.start(&[&ENDLESS[..], &["--checkpoint-every", "1ms"]].concat())?;
        wait(kill, first_sample);
        child.kill()?;
        child.wait()?;
        let left = bench.partial_files()?;
        ensure!(left <= 1, "{left} temporary files: what was left before was not swept");
        inside += left;
        held = film(bench, held)?.map_or(held, |film| film.samples().total());
    }
    // Another worker's file is let be, and what kills left is swept.
    let others = bench.path(".snowgrain-0-other.partial");
    let held_by_another = std::fs::File::create(&others)?;
    held_by_another.lock()?;
    bench.render(&["--spp", "1", "-o", "b.film"])?;
    ensure!(others.exists(), "the temporary file of another worker was swept");
    ensure!(bench.partial_files()? == 1, "what the last kill left was not swept");
    drop(held_by_another);
    std::fs::remove_file(&others)?;
    let samples = compare_with_whole(bench)?;
    Ok(format!(
        "{count} kills, {inside} of them while a film was written; 0 torn films; the film of {samples} \
         samples has the bytes of one without a break"
    ))
}

pub(super) fn stops(bench: &Bench, count: u64) -> Result<String> {
    let first_sample = begin(bench)?;
    let mut held = 1;
    for stop in 0..count {
        let mut child = bench.start(&ENDLESS)?;
        wait(1000 + stop, first_sample);
        send(&child, "TERM")?;
        let status = ended(&mut child)?;
        ensure!(status.code() == Some(143), "a stopped render ended with {status}");
        held = film(bench, held)?.map_or(held, |film| film.samples().total());
    }
    ensure!(bench.partial_files()? == 0, "a stop left a temporary file");
    let samples = compare_with_whole(bench)?;
    Ok(format!("{count} stops; the film of {samples} samples has the bytes of one without a break"))
}

/// Signals one after another, as fast as they can be sent.
pub(super) fn storm(bench: &Bench) -> Result<String> {
    let first_sample = begin(bench)?;
    let (mut held, mut sent) = (1, 0);
    for round in 0..10 {
        let mut child = bench.start(&[&ENDLESS[..], &["--checkpoint-every", "20ms"]].concat())?;
        wait(2000 + round, first_sample);
        for signal in ["TERM", "HUP", "INT", "TERM", "HUP", "TERM"] {
            if child.try_wait()?.is_none() {
                send(&child, signal)?;
                sent += 1;
            }
        }
        let status = ended(&mut child)?;
        let stopped = [129, 130, 143].map(Some).contains(&status.code());
        ensure!(stopped, "it ended with {status}");
        held = film(bench, held)?.map_or(held, |film| film.samples().total());
    }
    let samples = compare_with_whole(bench)?;
    Ok(format!("{sent} signals to 10 renders; the film of {samples} samples is whole"))
}
