//! Comma-separated values under a line of names, after lines of remarks.

use anyhow::{Context as _, Result};

/// A table of the references, or one that the program printed.
pub(crate) struct Table {
    heads: Vec<String>,
    rows: Vec<Vec<String>>,
}

/// A row, whose fields are known by their names.
#[derive(Clone, Copy)]
pub(crate) struct Row<'t> {
    heads: &'t [String],
    fields: &'t [String],
}

impl Table {
    pub(crate) fn parse(text: &str) -> Result<Self> {
        let fields = |line: &str| line.split(',').map(str::to_owned).collect::<Vec<_>>();
        let mut lines = text.lines().filter(|line| !line.starts_with('#')).map(fields);
        let heads = lines.next().context("a table has a line of names")?;
        Ok(Self { heads, rows: lines.collect() })
    }

    pub(crate) fn rows(&self) -> impl Iterator<Item = Row<'_>> {
        self.rows.iter().map(|fields| Row { heads: &self.heads, fields })
    }

    /// The only row in which all these columns have these values.
    pub(crate) fn find(&self, wanted: &[(&str, &str)]) -> Result<Row<'_>> {
        let mut found = self.rows().filter(|row| row.has(wanted));
        let row = found.next().with_context(|| format!("no row has {wanted:?}"))?;
        anyhow::ensure!(found.next().is_none(), "several rows have {wanted:?}");
        Ok(row)
    }

    /// The values of a column, each once, in their order.
    pub(crate) fn distinct(&self, name: &str) -> Result<Vec<String>> {
        let mut values: Vec<String> = Vec::new();
        for row in self.rows() {
            let value = row.text(name)?;
            if !values.iter().any(|known| known == value) {
                values.push(value.to_owned());
            }
        }
        Ok(values)
    }
}

impl<'t> Row<'t> {
    pub(crate) fn text(&self, name: &str) -> Result<&'t str> {
        let at = self.heads.iter().position(|head| head == name);
        let field = at.and_then(|at| self.fields.get(at));
        Ok(field.with_context(|| format!("no field {name} in {:?}", self.heads))?)
    }

    pub(crate) fn number(&self, name: &str) -> Result<f64> {
        let text = self.text(name)?;
        text.parse().with_context(|| format!("{name} is {text:?}, not a number"))
    }

    /// Whether all these columns have these values; numbers are the same to six digits.
    pub(crate) fn has(&self, wanted: &[(&str, &str)]) -> bool {
        wanted.iter().all(|(name, value)| self.text(name).is_ok_and(|text| same(text, value)))
    }
}

fn same(one: &str, other: &str) -> bool {
    match (one.parse::<f64>(), other.parse::<f64>()) {
        (Ok(one), Ok(other)) => (one - other).abs() <= 1e-6 * one.abs().max(other.abs()),
        _ => one == other,
    }
}
