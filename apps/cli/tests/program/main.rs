//! The program as a whole: what it writes, what it says, and with what exit code.

#![expect(clippy::unwrap_used, reason = "a test may panic, in its helpers too")]

mod cameras;
mod colours;
mod deep;
mod develop;
mod errors;
#[cfg(unix)]
mod hostile;
mod laboratory;
mod lasting;
mod light_in_snow;
mod materials;
mod measures;
mod noise;
mod packings;
mod pictures;
mod roads;
mod shapes;
#[cfg(unix)]
mod signals;
mod surfaces;
mod viewer;

use assert_cmd::Command;
use std::path::{Path, PathBuf};
use tempfile::TempDir;

/// Options that make the scene `snowy-teapot` small enough for a test.
const TINY: [&str; 8] =
    ["--size", "48x48", "--spp", "2", "--set", "snow.grains=2000", "--set", "snow.radius=2.5mm"];

/// A folder of a test's own, and the program to run in it.
struct Workplace(TempDir);

/// How a run ended.
struct Ended {
    code: Option<i32>,
    stdout: String,
    stderr: String,
}

impl Workplace {
    fn new() -> Self {
        Self(tempfile::tempdir().unwrap())
    }

    fn path(&self, name: &str) -> PathBuf {
        self.0.path().join(name)
    }

    /// Writes a file into the folder.
    fn file(&self, name: &str, content: impl AsRef<[u8]>) -> PathBuf {
        let path = self.path(name);
        std::fs::write(&path, content).unwrap();
        path
    }

    fn bytes(&self, name: &str) -> Vec<u8> {
        std::fs::read(self.path(name)).unwrap()
    }

    /// Names of the files in the folder, sorted.
    fn names(&self) -> Vec<String> {
        let entries = std::fs::read_dir(self.0.path()).unwrap();
        let mut names: Vec<_> =
            entries.map(|entry| entry.unwrap().file_name().into_string().unwrap()).collect();
        names.sort();
        names
    }

    /// Runs `snowgrain` in the folder.
    fn run(&self, arguments: &[&str]) -> Ended {
        let output =
            Command::new(program()).current_dir(self.0.path()).args(arguments).output().unwrap();
        Ended {
            code: output.status.code(),
            stdout: String::from_utf8(output.stdout).unwrap(),
            stderr: String::from_utf8(output.stderr).unwrap(),
        }
    }

    /// Runs `snowgrain`, which must succeed.
    fn succeed(&self, arguments: &[&str]) -> Ended {
        let ended = self.run(arguments);
        assert_eq!(ended.code, Some(0), "{arguments:?}: {}", ended.stderr);
        ended
    }

    /// Renders the tiny scene.
    fn tiny(&self, arguments: &[&str]) -> Ended {
        self.succeed(&[&["render", "snowy-teapot", "--quiet"], &TINY[..], arguments].concat())
    }
}

fn program() -> &'static Path {
    assert_cmd::cargo::cargo_bin!("snowgrain")
}
