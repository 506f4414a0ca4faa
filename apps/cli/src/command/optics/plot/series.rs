//! Lines out of the rows of a table.

use crate::command::optics::table::{Cell, Table};

/// A column that tells cases apart, and how its values are told: words before and after.
pub(in crate::command::optics) type Keys = &'static [(&'static str, &'static str, &'static str)];

/// Points with their standard errors.
#[derive(Clone, Debug, PartialEq)]
pub(in crate::command) struct Line {
    /// What it is, apart from the others.
    pub(in crate::command) label: String,
    /// x, y and the standard error of y.
    pub(in crate::command) points: Vec<[f64; 3]>,
    /// Number of its case among all: the same words of a case share a colour.
    pub(in crate::command) case: usize,
    /// Whether it is drawn in dashes.
    pub(in crate::command) dashed: bool,
}

/// Lines of the numbers that `point` takes from rows, one for each case and each word that it says of the
/// row; and what is alike in all cases. Rows without numbers are left out.
pub(in crate::command::optics) fn lines_of(
    table: &Table,
    keys: Keys,
    point: impl Fn(&dyn Fn(&str) -> Option<Cell>) -> Option<(String, [f64; 3])>,
) -> (Vec<Line>, String) {
    let column = |name: &str| table.names.iter().position(|other| *other == name);
    let known: Vec<(usize, &str, &str)> = keys
        .iter()
        .filter_map(|(name, before, after)| Some((column(name)?, *before, *after)))
        .collect();
    let varies = |at: usize| {
        let first = table.rows.first().map(|row| &row[at]);
        table.rows.iter().any(|row| Some(&row[at]) != first)
    };
    let say = |row: &[Cell], differing: bool| {
        let said = known
            .iter()
            .filter(|key| varies(key.0) == differing)
            .filter_map(|key| told(&row[key.0], key.1, key.2));
        said.collect::<Vec<_>>().join(", ")
    };
    let mut lines: Vec<(Line, Vec<Cell>)> = Vec::new();
    let mut cases: Vec<Vec<Cell>> = Vec::new();
    for row in &table.rows {
        let cell = |name: &str| column(name).map(|at| row[at].clone());
        let Some((word, point)) = point(&cell) else { continue };
        let case: Vec<Cell> = known.iter().map(|key| row[key.0].clone()).collect();
        let number = cases.iter().position(|other| *other == case).unwrap_or_else(|| {
            cases.push(case.clone());
            cases.len() - 1
        });
        let case = [case, vec![Cell::Word(word.clone())]].concat();
        if let Some((line, _)) = lines.iter_mut().find(|(_, other)| *other == case) {
            line.points.push(point);
            continue;
        }
        let parts = [word, say(row, true)];
        let label = parts.into_iter().filter(|part| !part.is_empty()).collect::<Vec<_>>();
        let label = label.join(", ");
        let line = Line { label, points: vec![point], case: number, dashed: false };
        lines.push((line, case));
    }
    let alike = table.rows.first().map_or_else(String::new, |row| say(row, false));
    (lines.into_iter().map(|(line, _)| line).collect(), alike)
}

/// A value with the words before it and its unit; words stand for themselves.
fn told(cell: &Cell, before: &str, unit: &str) -> Option<String> {
    let text = cell.text();
    match cell {
        Cell::Word(_) => (!text.is_empty()).then_some(text),
        Cell::Number(value) if value.is_infinite() => Some(format!("{before}{text}")),
        Cell::Number(_) => Some(format!("{before}{text}{unit}")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_say_what_differs_and_the_rest_is_said_once() {
        let row = |method: &str, radius: f64, x: f64| {
            vec![Cell::Word(method.into()), Cell::Number(radius), Cell::Number(x)]
        };
        let rows = vec![row("a", 1.0, 2.0), row("a", 1.0, 3.0), row("b", 1.0, 2.0)];
        let table = Table { names: vec!["method", "radius", "x"], rows };
        let keys: Keys = &[("method", "", ""), ("radius", "r ", " um"), ("other", "", "")];
        let (lines, alike) = lines_of(&table, keys, |cell| {
            let Some(Cell::Number(x)) = cell("x") else { return None };
            Some((String::new(), [x, 2.0 * x, 0.0]))
        });
        assert_eq!(alike, "r 1 um");
        assert_eq!((lines.len(), lines[0].label.as_str(), lines[1].label.as_str()), (2, "a", "b"));
        assert_eq!((lines[0].case, lines[1].case), (0, 1));
        assert_eq!(lines[0].points, [[2.0, 4.0, 0.0], [3.0, 6.0, 0.0]]);
    }
}
