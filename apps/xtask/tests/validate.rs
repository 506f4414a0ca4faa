//! The report of one cheap section: what is right passes, and a wrong reference fails.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;

fn references() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../../tests/data")
}

/// Whether the quick report of the section of one sphere passes, and its text.
fn validate(data: &Path) -> (bool, String) {
    let out = tempfile::tempdir().expect("a folder");
    let status = Command::new(env!("CARGO_BIN_EXE_snowgrain-xtask"))
        .args(["validate", "--quick", "--sections", "grain", "--data"])
        .arg(data)
        .arg("--out")
        .arg(out.path())
        .status()
        .expect("the task runs");
    let report = fs::read_to_string(out.path().join("VALIDATION.md")).expect("a report");
    assert!(out.path().join("validation/phase.svg").is_file());
    (status.success(), report)
}

#[test]
fn the_quick_report_of_a_section_passes() {
    let (passed, report) = validate(&references());
    assert!(passed && report.contains("| pass |") && !report.contains("FAIL"), "{report}");
    assert!(report.contains("snowgrain optics phase --ior 1.31"), "{report}");
}

#[test]
fn a_wrong_reference_fails() {
    let data = tempfile::tempdir().unwrap();
    for file in ["go_single_sphere.csv", "wet_relative_index.csv"] {
        fs::copy(references().join(file), data.path().join(file)).unwrap();
    }
    let file = data.path().join("go_single_sphere.csv");
    let right = fs::read_to_string(&file).unwrap();
    let wrong = right.replace("0.781657", "0.782657");
    assert_ne!(right, wrong);
    fs::write(&file, wrong).unwrap();
    let (passed, report) = validate(data.path());
    assert!(!passed && report.contains("**FAIL** (1 of 80)"), "{report}");
    assert!(report.contains("fails: g, n = 1.31: 0.78166, expected 0.78266"), "{report}");
}
