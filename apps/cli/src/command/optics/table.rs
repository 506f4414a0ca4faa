//! Tables of results, as text.

use crate::arguments::{SearchArguments, TableFormat};
use crate::failure::Failure;
use crate::output;
use serde::Serialize;
use std::path::Path;

/// Most lines of a table.
const MOST_ROWS: usize = 10_000_000;

/// # Errors
/// More lines than a table may have, from as many cases, wavelengths and so on.
pub(super) fn check_rows(counts: &[usize]) -> Result<(), Failure> {
    let rows = counts.iter().fold(1usize, |rows, &count| rows.saturating_mul(count));
    if rows <= MOST_ROWS {
        return Ok(());
    }
    Err(Failure::refused(format!(
        "what was asked for makes {rows} lines, more than {MOST_ROWS}; ask for fewer at a time"
    )))
}

/// A number with six significant digits, without an exponent; nothing where it is none.
pub(super) fn number(value: f64) -> String {
    if value.is_nan() {
        return String::new();
    }
    if value.is_infinite() {
        return "inf".into();
    }
    let rounded: f64 = format!("{value:.5e}").parse().unwrap_or(value);
    rounded.to_string()
}

/// A cell of a table: a number or a word.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(untagged)]
pub(super) enum Cell {
    Number(f64),
    Word(String),
}

impl Cell {
    pub(super) fn text(&self) -> String {
        match self {
            Self::Number(value) => number(*value),
            Self::Word(word) => word.clone(),
        }
    }

    /// The number, if it is one.
    pub(super) fn number(&self) -> Option<f64> {
        match self {
            Self::Number(value) => Some(*value),
            Self::Word(_) => None,
        }
    }
}

/// Rows under names.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Table {
    pub(super) names: Vec<&'static str>,
    pub(super) rows: Vec<Vec<Cell>>,
}

impl Table {
    /// Comma-separated values.
    fn csv(&self) -> String {
        let mut text = self.names.join(",") + "\n";
        for row in &self.rows {
            text += &row.iter().map(Cell::text).collect::<Vec<_>>().join(",");
            text.push('\n');
        }
        text
    }

    /// Prints it, or writes it to the file that was asked for.
    pub(super) fn tell(&self, arguments: &SearchArguments) -> Result<(), Failure> {
        self.tell_with(&[], arguments.format, arguments.output.as_deref())
    }

    /// The same, with figures that are of the whole table: remarks before comma-separated values, or
    /// beside the `rows` of a JSON object.
    pub(super) fn tell_with(
        &self,
        figures: &[(&'static str, f64)],
        format: TableFormat,
        file: Option<&Path>,
    ) -> Result<(), Failure> {
        let text = match format {
            TableFormat::Csv => {
                let remark = |(name, value): &(&str, f64)| format!("# {name} {}\n", number(*value));
                figures.iter().map(remark).collect::<String>() + &self.csv()
            }
            TableFormat::Json if figures.is_empty() => output::json(&self.objects())?,
            TableFormat::Json => {
                let figures = figures.iter().map(|(name, value)| ((*name).into(), (*value).into()));
                let mut all: serde_json::Map<String, serde_json::Value> = figures.collect();
                all.insert("rows".into(), serde_json::json!(self.objects()));
                output::json(&all)?
            }
        };
        match file {
            Some(path) => output::write_text(path, &text),
            None => output::print(&text),
        }
    }

    /// Rows as objects; what JSON has no number for is a word.
    fn objects(&self) -> Vec<serde_json::Map<String, serde_json::Value>> {
        let value = |cell: &Cell| match cell {
            Cell::Number(value) if value.is_nan() => serde_json::Value::Null,
            Cell::Number(value) if value.is_finite() => serde_json::json!(value),
            cell => serde_json::Value::String(cell.text()),
        };
        let object = |row: &Vec<Cell>| {
            self.names.iter().map(|name| (*name).to_owned()).zip(row.iter().map(value)).collect()
        };
        self.rows.iter().map(object).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_have_six_digits_and_tables_both_forms() {
        assert_eq!(number(0.123_456_78), "0.123457");
        assert_eq!(number(0.0), "0");
        assert_eq!(number(1.0e-9), "0.000000001");
        assert_eq!((number(f64::INFINITY).as_str(), number(f64::NAN).as_str()), ("inf", ""));
        let row = vec![Cell::Word("x".into()), Cell::Number(0.5), Cell::Number(f64::INFINITY)];
        let table = Table { names: vec!["a", "b", "c"], rows: vec![row] };
        assert_eq!(table.csv(), "a,b,c\nx,0.5,inf\n");
        let objects = serde_json::to_string(&table.objects()).unwrap();
        assert!(objects.contains("\"b\":0.5") && objects.contains("\"c\":\"inf\""), "{objects}");
    }
}
