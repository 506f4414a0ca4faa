//! Renders that are starved of disk and memory.

use super::{Bench, SNOW};
use anyhow::{Context as _, Result, ensure};
use std::process::Command;

/// A film of a few samples, which must still be there afterwards.
fn old_film(bench: &Bench) -> Result<Vec<u8>> {
    bench.render(&["--samples", "0..1", "-o", "old.film"])?;
    Ok(std::fs::read(bench.path("old.film"))?)
}

fn check_untouched(bench: &Bench, before: &[u8]) -> Result<()> {
    ensure!(std::fs::read(bench.path("old.film"))? == before, "the old film was touched");
    ensure!(bench.partial_files()? == 0, "a temporary file was left");
    std::fs::remove_file(bench.path("old.film"))?;
    Ok(())
}

/// More samples of the same render, into the same file.
fn more(checkpoints: bool) -> Vec<&'static str> {
    let every = if checkpoints { &["--checkpoint-every", "10ms"][..] } else { &[] };
    [&["render"], &SNOW[..], &["--spp", "3", "--resume", "-o", "old.film"], every].concat()
}

pub(super) fn file_size(bench: &Bench) -> Result<String> {
    let before = old_film(bench)?;
    for checkpoints in [false, true] {
        // In blocks of 512 bytes: 2 MB, of 19.
        let (code, said) = bench.limited("ulimit -f 4000", &more(checkpoints))?;
        ensure!(code == Some(74), "exit code {code:?}, not 74: {said}");
    }
    check_untouched(bench, &before)?;
    Ok("exit code 74, the old film is intact".into())
}

/// A disk of 28 MB: room for the old film, and for a part of a new one. A render looks at the disk before
/// anything is made (69), a merger does not and meets its end (74).
pub(super) fn full_disk(bench: &Bench) -> Result<String> {
    let before = old_film(bench)?;
    let script = "cd \"$DISK\" && mount -t tmpfs -o size=28m tmpfs . && cd \"$DISK\" || exit 97; \
                  cp \"$OLD\" old.film; \"$@\"; render=$?; \"$1\" merge old.film -o new.film; merge=$?; \
                  cmp -s old.film \"$OLD\" || exit 99; test \"$(ls -A)\" = old.film || exit 98; \
                  test $merge = 74 || exit 96; exit $render";
    let disk = bench.path("disk");
    std::fs::create_dir(&disk)?;
    let output = Command::new("unshare")
        .args(["--user", "--map-root-user", "--mount", "sh", "-c"])
        .arg(script)
        .arg("sh")
        .arg(&bench.program)
        .args(more(false))
        .env("DISK", &disk)
        .env("OLD", bench.path("old.film"))
        .output();
    std::fs::remove_dir_all(&disk)?;
    check_untouched(bench, &before)?;
    let Ok(output) = output else {
        return Ok("SKIPPED: there is no unshare to mount a small disk with".into());
    };
    let said = String::from_utf8_lossy(&output.stderr);
    match output.status.code() {
        Some(69) => {
            Ok("exit code 69 before a render, 74 while a film is written; the old one is intact"
                .into())
        }
        Some(99) => anyhow::bail!("the old film was touched"),
        Some(98) => anyhow::bail!("something was left on the disk"),
        Some(96) => anyhow::bail!("a merger onto the full disk did not end with 74: {said}"),
        _ if said.contains("unshare") || said.contains("mount") => {
            Ok(format!("SKIPPED: a small disk cannot be mounted here ({})", said.trim()))
        }
        code => anyhow::bail!("exit code {code:?}: {said}"),
    }
}

pub(super) fn memory(bench: &Bench) -> Result<String> {
    let large = ["render", "snowy-teapot", "--set", "snow.grains=40000000", "-o", "large.png"];
    let (code, said) = bench.limited("ulimit -v 2000000", &large)?;
    ensure!(code == Some(69), "exit code {code:?}, not 69: {said}");
    let line = said.lines().last().context("a refusal says why")?;
    ensure!(line.contains("address space"), "{line}");
    let (code, said) = bench.limited(":", &[&large[..], &["--max-memory", "100MiB"]].concat())?;
    ensure!(code == Some(69), "exit code {code:?}, not 69: {said}");
    Ok(format!("exit code 69 before anything is made ({})", line.trim()))
}
