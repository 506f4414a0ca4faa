//! Generated inputs for every reader: the property tests of the formats, with more cases.

use anyhow::{Result, ensure};
use std::process::Command;
use std::time::Instant;

/// Tests that give bytes of any kind, or damaged files, to a reader.
const READERS: [&str; 9] = [
    "hostile_tests",
    "scene::tests::never_panics",
    "mesh::tests",
    "grains::tests",
    "gltf::tests",
    "film_file::tests",
    "image::",
    "environment::tests",
    "texture::tests",
];

pub(super) fn generated(count: u64) -> Result<String> {
    let start = Instant::now();
    let cargo = std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into());
    for reader in READERS {
        let status = Command::new(&cargo)
            .args([
                "test",
                "--release",
                "--quiet",
                "--package",
                "snowgrain-formats",
                "--lib",
                reader,
            ])
            .env("PROPTEST_CASES", count.to_string())
            .stdout(std::process::Stdio::null())
            .status()?;
        ensure!(status.success(), "{reader} fails with {count} inputs");
    }
    Ok(format!(
        "{count} inputs for each property of {} readers without a panic, in {:.0} s",
        READERS.len(),
        start.elapsed().as_secs_f64()
    ))
}
