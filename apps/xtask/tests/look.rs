//! The report of one cheap section, and a section that there is not.

use std::path::Path;
use std::process::Command;

fn look(section: &str, out: &Path) -> std::process::Output {
    Command::new(env!("CARGO_BIN_EXE_snowgrain-xtask"))
        .args(["look", "--quick", "--sections", section, "--out"])
        .arg(out)
        .output()
        .expect("the task runs")
}

#[test]
fn the_quick_report_of_a_section_passes_and_tells_its_commands() {
    let out = tempfile::tempdir().expect("a folder");
    let ran = look("cover", out.path());
    let report = std::fs::read_to_string(out.path().join("look.md")).expect("a report");
    assert!(ran.status.success() && report.contains("| pass |"), "{report}");
    assert!(report.contains("snowgrain optics albedo --method grains"), "{report}");
}

#[test]
fn a_section_that_there_is_not_is_refused() {
    let out = tempfile::tempdir().expect("a folder");
    let ran = look("sparkle", out.path());
    let told = String::from_utf8_lossy(&ran.stderr).into_owned();
    assert!(!ran.status.success() && told.contains("there is no section sparkle"), "{told}");
}
