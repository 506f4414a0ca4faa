//! The program `snowgrain`, built and run.

use crate::table::Table;
use anyhow::{Context as _, Result, ensure};
use std::path::{Path, PathBuf};
use std::process::Command;

/// The release binary.
pub(crate) struct Program {
    path: PathBuf,
    /// Where it runs, so that files it reads have short names.
    folder: tempfile::TempDir,
}

impl Program {
    /// Builds the program; it lies beside this one.
    pub(crate) fn build() -> Result<Self> {
        let cargo = std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into());
        let mut build = Command::new(cargo);
        build.args(["build", "--release", "--quiet", "--package", "snowgrain-cli"]);
        ensure!(build.status()?.success(), "the program does not build");
        let own = std::env::current_exe()?;
        let profile = own.parent().context("a program lies in a folder")?;
        let target = profile.parent().context("a profile lies in a folder")?;
        let path =
            target.join("release").join(format!("snowgrain{}", std::env::consts::EXE_SUFFIX));
        Ok(Self { path, folder: tempfile::tempdir()? })
    }

    pub(crate) fn executable(&self) -> &Path {
        &self.path
    }

    pub(crate) fn folder(&self) -> &Path {
        self.folder.path()
    }

    /// What it prints, given arguments that are set apart by spaces.
    pub(crate) fn print(&self, arguments: &str, plot: Option<&Path>) -> Result<String> {
        let mut command = Command::new(&self.path);
        command.args(arguments.split_whitespace()).current_dir(self.folder());
        if let Some(file) = plot {
            command.arg("--plot").arg(std::path::absolute(file)?);
        }
        let output = command.output().with_context(|| format!("{} runs", self.path.display()))?;
        let told = String::from_utf8_lossy(&output.stderr);
        ensure!(output.status.success(), "snowgrain {arguments}: {told}");
        Ok(String::from_utf8(output.stdout)?)
    }

    pub(crate) fn table(&self, arguments: &str, plot: Option<&Path>) -> Result<Table> {
        Table::parse(&self.print(arguments, plot)?)
    }
}
