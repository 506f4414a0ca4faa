//! What was compared, and how it is written: Markdown.

use std::fmt::Write as _;

/// Figures against what they should be, all by one tolerance.
pub(crate) struct Comparison {
    what: String,
    tolerance: String,
    lines: usize,
    worst: Option<(f64, String)>,
    failures: Vec<String>,
    /// Whether a line that fails fails the task.
    judged: bool,
}

impl Comparison {
    pub(crate) fn new(what: impl Into<String>, tolerance: impl Into<String>) -> Self {
        let (what, tolerance) = (what.into(), tolerance.into());
        Self { what, tolerance, lines: 0, worst: None, failures: Vec::new(), judged: true }
    }

    /// Told, not judged: where it fails, the program is not to blame.
    pub(crate) fn reported(what: impl Into<String>, tolerance: impl Into<String>) -> Self {
        Self { judged: false, ..Self::new(what, tolerance) }
    }

    /// One line: a figure that may be `allowed` off. What is not a number fails.
    pub(crate) fn compare(&mut self, name: &str, found: f64, expected: f64, allowed: f64) {
        self.lines += 1;
        let off = (found - expected).abs();
        let line = format!("{name}: {found:.5}, expected {expected:.5}, allowed {allowed:.5}");
        if self.worst.as_ref().is_none_or(|(worst, _)| off.is_nan() || off > *worst) {
            self.worst = Some((off, name.to_owned()));
        }
        if off.is_nan() || off > allowed {
            self.failures.push(line);
        }
    }

    /// One line: a figure that must lie between two. What is not a number fails.
    pub(crate) fn within(&mut self, name: &str, found: f64, [low, high]: [f64; 2]) {
        let outside = (low - found).max(found - high).max(0.0);
        let outside = if found.is_nan() { f64::NAN } else { outside };
        self.compare(&format!("{name}: {found:.3}, {low} to {high}"), outside, 0.0, 0.0);
    }

    /// A comparison of nothing is no check.
    pub(crate) fn passed(&self) -> bool {
        self.failures.is_empty() && self.lines > 0
    }

    fn only_told(&self) -> bool {
        !self.judged && self.lines > 0
    }

    fn row(&self) -> String {
        let (off, name) = self.worst.as_ref().map_or((f64::NAN, ""), |(off, name)| (*off, name));
        let result = match (self.passed(), self.failures.len()) {
            (true, _) => "pass".to_owned(),
            (false, failed) => format!("**FAIL** ({failed} of {})", self.lines),
        };
        let number =
            if off != 0.0 && off < 1e-4 { format!("{off:.1e}") } else { format!("{off:.4}") };
        format!(
            "{} | {} | {number} ({name}) | {} | {result} |",
            self.what, self.lines, self.tolerance
        )
    }
}

/// A part of the report.
pub(crate) struct Section {
    title: &'static str,
    /// Paragraphs, tables and figures, in Markdown.
    blocks: Vec<String>,
    commands: Vec<String>,
    comparisons: Vec<Comparison>,
}

impl Section {
    pub(crate) fn new(title: &'static str) -> Self {
        Self { title, blocks: Vec::new(), commands: Vec::new(), comparisons: Vec::new() }
    }

    pub(crate) fn say(&mut self, paragraph: impl Into<String>) {
        self.blocks.push(paragraph.into());
    }

    pub(crate) fn command(&mut self, command: String) {
        if !self.commands.contains(&command) {
            self.commands.push(command);
        }
    }

    pub(crate) fn add(&mut self, comparison: Comparison) {
        self.comparisons.push(comparison);
    }

    pub(crate) fn table(&mut self, heads: &[&str], rows: &[Vec<String>]) {
        let line = |fields: &[String]| format!("| {} |", fields.join(" | "));
        let heads: Vec<String> = heads.iter().map(|&head| head.to_owned()).collect();
        let mut lines = vec![line(&heads), format!("|{}", "---|".repeat(heads.len()))];
        lines.extend(rows.iter().map(|row| line(row)));
        self.blocks.push(lines.join("\n"));
    }

    pub(crate) fn figure(&mut self, file: &str, caption: &str) {
        self.blocks.push(format!("![{caption}](validation/{file})\n\n{caption}"));
    }

    /// Whether the program is right wherever it can be told.
    pub(crate) fn passed(&self) -> bool {
        self.comparisons.iter().all(|comparison| comparison.passed() || comparison.only_told())
    }

    /// As it stands in a report.
    pub(crate) fn written(&self) -> WrittenSection {
        let row = |comparison: &Comparison| format!("| {} | {}", self.title, comparison.row());
        WrittenSection {
            title: self.title.to_owned(),
            rows: self.comparisons.iter().map(row).collect(),
            text: self.text(),
        }
    }

    fn text(&self) -> String {
        let mut text = String::new();
        for block in &self.blocks {
            let _ = writeln!(text, "{block}\n");
        }
        if !self.comparisons.is_empty() {
            let _ = writeln!(text, "| comparison | lines | worst deviation | tolerance | result |");
            let _ = writeln!(text, "|---|---|---|---|---|");
            for comparison in &self.comparisons {
                let _ = writeln!(text, "| {}", comparison.row());
            }
            let _ = writeln!(text);
        }
        for failure in self.comparisons.iter().flat_map(|comparison| &comparison.failures) {
            let _ = writeln!(text, "- fails: {failure}");
        }
        if !self.commands.is_empty() {
            let _ = writeln!(text, "\n<details><summary>Commands</summary>\n\n```sh");
            for command in &self.commands {
                let _ = writeln!(text, "{command}");
            }
            let _ = writeln!(text, "```\n\n</details>");
        }
        text
    }
}

/// A section as it stands in a report.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct WrittenSection {
    title: String,
    /// Its lines in the table of all comparisons.
    rows: Vec<String>,
    /// What is below its title.
    text: String,
}

const HEADS: &str = "| section | comparison | lines | worst deviation | tolerance | result |\n|---|---|---|---|---|---|\n";

/// The whole report: all comparisons first, then the sections.
pub(crate) fn markdown(title: &str, introduction: &str, sections: &[WrittenSection]) -> String {
    let mut text = format!("# {title}\n\n{introduction}\n{HEADS}");
    for row in sections.iter().flat_map(|section| &section.rows) {
        let _ = writeln!(text, "{row}");
    }
    for WrittenSection { title, text: below, .. } in sections {
        let _ = write!(text, "\n## {title}\n\n{below}");
    }
    text
}

/// The sections of such a report.
pub(crate) fn sections_of(report: &str) -> Vec<WrittenSection> {
    let mut parts = report.split("\n## ");
    let table = parts.next().and_then(|head| head.split_once(HEADS)).map_or("", |(_, rows)| rows);
    let section = |part: &str| {
        let (title, text) = part.split_once("\n\n").unwrap_or((part, ""));
        let begins = format!("| {title} | ");
        let rows = table.lines().filter(|row| row.starts_with(&begins)).map(str::to_owned);
        WrittenSection { title: title.to_owned(), rows: rows.collect(), text: text.to_owned() }
    };
    parts.map(section).collect()
}

/// Puts a section into the place of that of its title, or after all others.
pub(crate) fn put(sections: &mut Vec<WrittenSection>, made: WrittenSection) {
    match sections.iter_mut().find(|section| section.title == made.title) {
        Some(place) => *place = made,
        None => sections.push(made),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// What is read of a report writes the same report, and one section takes the place of that of its title.
    #[test]
    fn a_report_is_read_back_and_a_section_put_in_its_place() {
        let section = |title, figure: f64| {
            let mut comparison = Comparison::new("it", ".1");
            comparison.compare("near", figure, 1.0, 0.1);
            let mut section = Section::new(title);
            section.say(format!("A figure is {figure}."));
            section.command("snowgrain measure".to_owned());
            section.add(comparison);
            section.written()
        };
        let sections = vec![section("One", 1.0), section("Two", 1.5), section("Three", 1.02)];
        let report = markdown("Figures", "Of all kinds.\n", &sections);
        let mut read = sections_of(&report);
        assert_eq!(read, sections);
        assert_eq!(markdown("Figures", "Of all kinds.\n", &read), report);
        put(&mut read, section("Two", 1.05));
        put(&mut read, section("Four", 1.0));
        let titles: Vec<&str> = read.iter().map(|section| &*section.title).collect();
        assert_eq!(titles, ["One", "Two", "Three", "Four"]);
        let merged = markdown("Figures", "Of all kinds.\n", &read);
        assert!(merged.contains("1.05") && !merged.contains("FAIL"), "{merged}");
    }

    #[test]
    fn what_lies_without_two_bounds_fails() {
        let mut comparison = Comparison::new("it", "as named");
        comparison.within("in", 1.0, [1.0, 2.0]);
        assert!(comparison.passed());
        comparison.within("over", 2.5, [1.0, 2.0]);
        comparison.within("none", f64::NAN, [1.0, 2.0]);
        assert_eq!(comparison.failures.len(), 2);
    }

    #[test]
    fn what_is_off_or_no_number_or_nothing_fails() {
        let mut comparison = Comparison::new("it", ".1");
        assert!(!comparison.passed());
        comparison.compare("near", 1.05, 1.0, 0.1);
        assert!(comparison.passed());
        comparison.compare("none", f64::NAN, 1.0, 0.1);
        comparison.compare("far", 1.2, 1.0, 0.1);
        assert_eq!(comparison.failures.len(), 2);
        assert!(comparison.row().contains("**FAIL** (2 of 3)"));
    }
}
