//! Indices of refraction and of absorption over the wavelength, from text files.

use crate::error::{Fault, FormatsError, Place};
use crate::input;
use snowgrain_optics::colour::VISIBLE_NM;
use snowgrain_optics::substance::INDICES;
use snowgrain_optics::{MeasuredSubstance, Spectrum};
use std::path::Path;

/// Most wavelengths of a table.
const MOST_LINES: usize = 10_000;

/// Greatest imaginary part of an index: what has more is no clear substance.
const GREATEST_IMAGINARY: f64 = 0.1;

/// Reads what a substance does to light: a line for each wavelength (nm, or with a unit as `0.38um`), rising, with
/// the real part n of its index of refraction and the imaginary part k, which may be left out in all lines
/// and is 0 then; apart by spaces, a tab, a comma or a semicolon. A first line of names and what follows a `#` are
/// passed over. The wavelengths must reach from 380 to 780 nm; n is 1 to 4, k at least 0 and at most .1.
///
/// # Errors
/// A missing or unreadable file, a line that does not hold such numbers, wavelengths that do not rise or do not
/// reach over the visible.
pub fn read_optical_constants(path: &Path) -> Result<MeasuredSubstance, FormatsError> {
    parse(&input::read_whole(path)?).map_err(|fault| fault.of(path))
}

fn parse(bytes: &[u8]) -> Result<MeasuredSubstance, Fault> {
    let text = str::from_utf8(bytes).map_err(|_| {
        Fault::whole("this is not text", "write lines of a wavelength in nm, n and k")
    })?;
    let mut rows: Vec<[f64; 3]> = Vec::new();
    let (mut columns, mut is_first) = (None, true);
    for (line, number) in text.lines().zip(1u64..) {
        let written = line.split('#').next().unwrap_or_default();
        let apart = |c: char| c.is_whitespace() || c == ',' || c == ';';
        let words: Vec<&str> = written.split(apart).filter(|word| !word.is_empty()).collect();
        if words.is_empty() || std::mem::take(&mut is_first) && is_names(&words) {
            continue;
        }
        let before = rows.last().map(|row| row[0]);
        let fault = |what: String, mend| Fault::new(Place::Line(number), what, mend);
        let row = row(&words, before).map_err(|(what, mend)| fault(what, mend))?;
        if *columns.get_or_insert(words.len()) != words.len() {
            return Err(fault("k stands in some lines only".into(), "write it in all or in none"));
        }
        if rows.len() == MOST_LINES {
            let mend = "write fewer: between them the indices run straight";
            return Err(fault(format!("more than {MOST_LINES} wavelengths"), mend));
        }
        rows.push(row);
    }
    let [first, last] = [rows.first(), rows.last()].map(|row| row.map_or(0.0, |row| row[0]));
    if !(first <= VISIBLE_NM[0] && last >= VISIBLE_NM[1]) {
        let what = format!("it reaches from {first} to {last} nm");
        return Err(Fault::whole(what, "write all of the visible light, 380 to 780 nm"));
    }
    let column = |index: usize| {
        let wavelengths = rows.iter().map(|row| row[0]).collect();
        let spectrum = Spectrum::new(wavelengths, rows.iter().map(|row| row[index]).collect());
        spectrum.ok_or_else(|| Fault::whole("this is no table", "write a line a wavelength"))
    };
    Ok(MeasuredSubstance { index: column(1)?, imaginary: column(2)?, density: None })
}

/// Whether a line is the names of the columns.
fn is_names(words: &[&str]) -> bool {
    words.iter().all(|word| word.starts_with(|c: char| c.is_alphabetic()))
}

/// Wavelength in nm, n and k of a line, after one of the wavelength `before`; else what is wrong, and the mend.
fn row(words: &[&str], before: Option<f64>) -> Result<[f64; 3], (String, &'static str)> {
    let numbers = match words {
        [wavelength, n] => [nanometres(wavelength), n.parse().ok(), Some(0.0)],
        [wavelength, n, k] => [nanometres(wavelength), n.parse().ok(), k.parse().ok()],
        _ => [None; 3],
    };
    let [Some(nm), Some(n), Some(k)] = numbers else {
        let mend = "write a wavelength in nm (or as 0.55um), n and k, as 550 1.5163 1.2e-8";
        return Err(("this is no wavelength with its indices".into(), mend));
    };
    if !(nm > 0.0 && nm.is_finite()) {
        return Err((format!("the wavelength is {nm} nm"), "write one above 0"));
    }
    if before.is_some_and(|before| nm <= before) {
        return Err((
            format!("{nm} nm does not come after the line before"),
            "let wavelengths rise",
        ));
    }
    if !(INDICES[0]..=INDICES[1]).contains(&n) {
        return Err((format!("n is {n}"), "write an index of refraction of 1 to 4"));
    }
    if !(0.0..=GREATEST_IMAGINARY).contains(&k) {
        return Err((format!("k is {k}"), "write an imaginary index of 0 to 0.1"));
    }
    Ok([nm, n, k])
}

/// A wavelength: a number of nm, or a number with nm or um.
fn nanometres(word: &str) -> Option<f64> {
    let micrometres = ["um", "\u{b5}m", "\u{3bc}m"];
    if let Some(number) = micrometres.iter().find_map(|unit| word.strip_suffix(unit)) {
        return number.parse::<f64>().ok().map(|um| um * 1000.0);
    }
    word.strip_suffix("nm").unwrap_or(word).parse().ok()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_table_has_names_remarks_and_units_or_not() {
        let text =
            b"# glass\nwavelength, n, k\n0.38um, 1.53, 1e-7\n550nm;1.52;2e-8 # green\n780 1.51 0\n";
        let read = parse(text).unwrap();
        assert_eq!(read.index.at(380.0), 1.53);
        assert_eq!(read.imaginary.at(550.0), 2e-8);
        assert_eq!(read.index.range_nm(), [380.0, 780.0]);
        let without = parse(b"380 1.5\n780 1.4\n").unwrap();
        assert!((without.index.at(580.0) - 1.45).abs() < 1e-12);
        assert_eq!(without.imaginary.at(580.0), 0.0);
    }

    #[test]
    fn what_is_no_table_is_refused_by_its_line() {
        for (line, what) in [
            ("400", "line 2: this is no wavelength with its indices"),
            ("400 1.5 0 0", "line 2: this is no wavelength"),
            ("400 n 0", "line 2: this is no wavelength"),
            ("380 1.5 0", "line 2: 380 nm does not come after"),
            ("400 0.9 0", "line 2: n is 0.9; write an index"),
            ("400 nan 0", "line 2: n is NaN"),
            ("400 1.5 -1e-9", "line 2: k is -0.000000001; write"),
            ("400 1.5 2", "line 2: k is 2"),
            ("inf 1.5 0", "line 2: the wavelength is inf nm"),
            ("400 1.5", "line 2: k stands in some lines only"),
            ("700 1.5 0", ": it reaches from 380 to 700 nm; write all"),
        ] {
            let error = parse(format!("380 1.5 0\n{line}\n").as_bytes()).unwrap_err();
            let message = error.of(Path::new("n.csv")).to_string();
            assert!(message.contains(what), "{line}: {message}");
        }
        let micrometres = parse(b"0.38 1.5\n0.78 1.5\n").unwrap_err().of(Path::new("n.csv"));
        assert!(micrometres.to_string().contains("from 0.38 to 0.78 nm"), "{micrometres}");
        assert!(parse(b"").is_err() && parse(&[0xff, 0xfe]).is_err());
        let many: String = (0..10_002).map(|i| format!("{} 1.5\n", 300 + i)).collect();
        assert!(parse(many.as_bytes()).is_err());
    }
}
