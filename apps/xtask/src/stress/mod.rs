//! `cargo xtask stress`: what happens to renders that are killed, stopped, and starved.

mod cost;
mod ends;
mod faults;
mod inputs;
mod limits;

use crate::program::Program;
use anyhow::{Context as _, Result, ensure};
use std::path::PathBuf;
use std::process::{Child, Command, ExitStatus, Stdio};
use std::time::{Duration, Instant};

/// Options of the task.
#[derive(clap::Args)]
pub(crate) struct Options {
    /// Kills at random times
    #[arg(long, value_name = "N", default_value_t = 100)]
    kills: u64,

    /// Rounds of kills at each of nine steps of the writing of a film
    #[arg(long, value_name = "N", default_value_t = 6)]
    fault_rounds: u64,

    /// Stops at random times
    #[arg(long, value_name = "N", default_value_t = 20)]
    stops: u64,

    /// Seconds of each of the two renders that tell what checkpoints cost
    #[arg(long, value_name = "SECONDS", default_value_t = 60)]
    long: u64,

    /// Generated inputs of each reader; 0: none
    #[arg(long, value_name = "N", default_value_t = 10_000)]
    inputs: u64,
}

/// A render of snow that would take days; 19 MB of film.
const SNOW: [&str; 8] = [
    "snowy-teapot",
    "--size",
    "300x300",
    "--set",
    "snow.grains=2000",
    "--set",
    "snow.radius=2.5mm",
    "--quiet",
];

/// The program and a folder to run it in.
struct Bench {
    program: PathBuf,
    folder: tempfile::TempDir,
}

impl Bench {
    fn path(&self, name: &str) -> PathBuf {
        self.folder.path().join(name)
    }

    /// The program in the folder.
    fn program(&self, arguments: &[&str]) -> Command {
        let mut command = Command::new(&self.program);
        command.current_dir(self.folder.path()).args(arguments).stderr(Stdio::null());
        command
    }

    /// A render of [`SNOW`].
    fn command(&self, arguments: &[&str]) -> Command {
        self.program(&[&["render"], &SNOW[..], arguments].concat())
    }

    /// Starts a render of [`SNOW`].
    fn start(&self, arguments: &[&str]) -> Result<Child> {
        Ok(self.command(arguments).spawn()?)
    }

    /// Renders [`SNOW`] to its end.
    fn render(&self, arguments: &[&str]) -> Result<()> {
        let status = self.start(arguments)?.wait()?;
        ensure!(status.success(), "render {arguments:?}: {status}");
        Ok(())
    }

    /// Runs the program under limits of the shell; gives its exit code and what it said.
    fn limited(&self, limits: &str, arguments: &[&str]) -> Result<(Option<i32>, String)> {
        let output = Command::new("sh")
            .current_dir(self.folder.path())
            .args(["-c", &format!("{limits}; exec \"$0\" \"$@\"")])
            .arg(&self.program)
            .args(arguments)
            .output()?;
        Ok((output.status.code(), String::from_utf8_lossy(&output.stderr).into_owned()))
    }

    /// Temporary files that are there.
    fn partial_files(&self) -> Result<usize> {
        let mut count = 0;
        for entry in std::fs::read_dir(self.folder.path())? {
            count += usize::from(entry?.file_name().to_string_lossy().ends_with(".partial"));
        }
        Ok(count)
    }
}

/// Waits for a child, at most a minute.
fn ended(child: &mut Child) -> Result<ExitStatus> {
    let start = Instant::now();
    loop {
        if let Some(status) = child.try_wait()? {
            return Ok(status);
        }
        ensure!(start.elapsed() < Duration::from_secs(60), "a render did not end in a minute");
        std::thread::sleep(Duration::from_millis(5));
    }
}

/// Runs everything; false where something is not as it should be.
pub(crate) fn stress(options: &Options) -> Result<bool> {
    let program = Program::build()?.executable().to_path_buf();
    let bench = Bench { program, folder: tempfile::tempdir()? };
    let mut passed = true;
    let mut tell = |name: &str, outcome: Result<String>| match outcome {
        Ok(said) => println!("{name}: {said}"),
        Err(error) => {
            passed = false;
            println!("{name}: FAIL: {error:#}");
        }
    };
    tell("kills", ends::kills(&bench, options.kills).context("kill -9"));
    tell("kills at steps", faults::kills(&bench, options.fault_rounds).context("kill -9"));
    tell("broken disk", faults::broken_disk(&bench));
    tell("stops", ends::stops(&bench, options.stops).context("SIGTERM"));
    tell("signal storm", ends::storm(&bench));
    tell("file size", limits::file_size(&bench));
    tell("full disk", limits::full_disk(&bench));
    tell("memory", limits::memory(&bench));
    tell("checkpoints", cost::checkpoints(&bench, options.long));
    if options.inputs > 0 {
        tell("inputs", inputs::generated(options.inputs));
    }
    Ok(passed)
}
