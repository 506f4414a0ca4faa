//! The tables that are compiled in: columns of comma-separated numbers under a line of names, after
//! comments that begin with `#`. Their sources and licences are in `data/SOURCES.md`.

use crate::Spectrum;

/// A column of a table, over its first column, which is wavelength in nm.
///
/// # Panics
/// If the table, which is part of the program, has no such column or is no table.
pub(crate) fn column(table: &str, name: &str) -> Spectrum {
    let mut lines = table.lines().filter(|line| !line.starts_with('#') && !line.is_empty());
    let heads = lines.next().expect("a table has a line of names");
    let index = heads.split(',').position(|head| head.trim() == name).expect("the column exists");
    let numbers = |line: &str| {
        let field = |index: usize| {
            let field = line.split(',').nth(index).expect("every line has all columns");
            field.trim().parse::<f64>().expect("every field is a number")
        };
        (field(0), field(index))
    };
    let (wavelengths, values) = lines.map(numbers).unzip();
    Spectrum::new(wavelengths, values).expect("wavelengths increase")
}
