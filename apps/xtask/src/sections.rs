//! A report that is made section by section.

use crate::report::{Section, markdown, put, sections_of};
use anyhow::{Context as _, Result, ensure};
use std::path::Path;

/// What makes a section with a bench, by its name.
pub(crate) type Named<Bench> = (&'static str, fn(&Bench) -> Result<Section>);

/// Refuses names of sections that there are not, before anything is built.
pub(crate) fn check_names<Bench>(known: &[Named<Bench>], wanted: &[String]) -> Result<()> {
    for name in wanted {
        ensure!(known.iter().any(|(known, _)| known == name), "there is no section {name}");
    }
    Ok(())
}

/// Makes the sections that are wanted, all where none is named, and writes the report to a file after each, so
/// that what is known so far is there at any time; false where a line that is judged fails. Where some are named the
/// others stay as the file has them.
pub(crate) fn write<Bench>(
    known: &[Named<Bench>],
    wanted: &[String],
    bench: &Bench,
    (file, title, introduction): (&Path, &str, &str),
) -> Result<bool> {
    let old = if wanted.is_empty() { None } else { std::fs::read_to_string(file).ok() };
    let mut sections = old.map_or_else(Vec::new, |report| sections_of(&report));
    let mut passed = true;
    for (name, make) in known {
        if wanted.is_empty() || wanted.iter().any(|wanted| wanted == name) {
            let section = make(bench).with_context(|| (*name).to_owned())?;
            println!("{name}: {}", if section.passed() { "pass" } else { "FAIL" });
            passed &= section.passed();
            put(&mut sections, section.written());
            std::fs::write(file, markdown(title, introduction, &sections))?;
        }
    }
    Ok(passed)
}
