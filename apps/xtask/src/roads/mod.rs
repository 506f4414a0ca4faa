//! `cargo xtask roads`: other ways of light through snow, and what they are wrong by.

mod calibrate;
mod case;
mod sheet;

use crate::deep::measured::{Comparison, Film};
use crate::program::Program;
use anyhow::Result;
use calibrate::Calibrated;
use case::{Body, Case, Light, Road};
use sheet::Sheet;
use std::fmt::Write as _;
use std::path::PathBuf;

/// Options of the task.
#[derive(clap::Args)]
pub(crate) struct Options {
    /// Folder for roads.md and roads.png
    #[arg(long, value_name = "DIR", default_value = "docs")]
    out: PathBuf,

    /// Prints what the proxy's grains differ by from real ones, as the code holds it, and nothing else
    #[arg(long)]
    calibrate: bool,

    /// Fewer samples: a look, not a measurement
    #[arg(long)]
    quick: bool,
}

/// Error of a pixel at which speeds are compared, relative.
const EQUAL_ERROR: f64 = 0.02;
/// Pixels of the picture that is so compared.
const PICTURE: f64 = 512.0 * 512.0;
/// Greatest part by which visits and ice may differ beyond three standard errors.
const VISITS: f64 = 0.01;

/// Writes the tables; false where the proxy is wrong by more than it should.
pub(crate) fn roads(options: &Options) -> Result<bool> {
    let paths = if options.quick { 1 << 14 } else { 1 << 17 };
    if options.calibrate {
        calibrate::print(paths)?;
        return Ok(true);
    }
    let program = Program::build()?;
    let mut report = String::from(INTRODUCTION);
    let mut passed = true;
    write!(report, "\n## Slabs\n\n{SLABS}{SLAB_HEADS}")?;
    for slab in Calibrated::all(paths, calibrate::JUDGING)? {
        let row = slab.row()?;
        print!("{row}");
        report.push_str(&row);
        passed &= slab.keeps_visits(VISITS)?;
    }
    write!(report, "\n## Pictures\n\n{PICTURES}{PICTURE_HEADS}")?;
    let mut sheet = Sheet::default();
    for body in Body::ALL {
        for light in Light::ALL {
            sheet.begin_row();
            let rows = compare(&program, Case { body, light }, options.quick, &mut sheet)?;
            print!("{rows}");
            report.push_str(&rows);
        }
    }
    report.push_str(FAILURES);
    sheet.write(&options.out.join("roads.png"))?;
    std::fs::write(options.out.join("roads.md"), report)?;
    Ok(passed)
}

/// All roads through one scene.
fn compare(program: &Program, case: Case, quick: bool, sheet: &mut Sheet) -> Result<String> {
    let mut rows = String::new();
    let exact = case.render(program, Road::Exact, quick)?;
    for road in Road::ALL {
        if !road.knows(case.light) {
            sheet.add(None);
            continue;
        }
        let film = match road {
            Road::Exact => &exact,
            _ => &case.render(program, road, quick)?,
        };
        let colours = snowgrain_formats::read_film(&program.folder().join("deep.film"))?;
        sheet.add(Some(&colours));
        rows.push_str(&row(case, road, &exact, film)?);
    }
    Ok(rows)
}

fn row(case: Case, road: Road, exact: &Film, film: &Film) -> Result<String> {
    let samples = film.relative_variance() / (EQUAL_ERROR * EQUAL_ERROR);
    let seconds = film.learning_seconds + samples * PICTURE * film.seconds_per_sample;
    let error = match road {
        Road::Exact => "- | -".to_owned(),
        _ => {
            let Comparison { mean, mean_error, blocks, .. } = Comparison::of(exact, film)?;
            format!("{:+.2} ({:.2}) | {:.2}", 100.0 * mean, 100.0 * mean_error, 100.0 * blocks)
        }
    };
    Ok(format!(
        "| {} | {} | {} | {:.2} | {:.3} | {:.1} | {:.0} | {error} |\n",
        case.body.name(),
        case.light.name(),
        road.name(),
        1e6 * film.seconds_per_sample,
        film.relative_variance(),
        film.learning_seconds,
        seconds,
    ))
}

const INTRODUCTION: &str = "INTRO\n";
const SLABS: &str = "S\n\n";
const SLAB_HEADS: &str = "| solid fraction | tau | exact: T | visits / 2 tau | ice | proxy: T | visits / 2 tau | ice | volume: T | visits / 2 tau | ice |
|---:|---:|---:|---:|---:|---:|---:|---:|---:|---:|---:|
";
const PICTURES: &str = "P\n\n";
const PICTURE_HEADS: &str = "| snow | light | road | us a sample | variance | before, s | s to 2 % | mean, % | blocks, % |
|---|---|---|---:|---:|---:|---:|---:|---:|
";
const FAILURES: &str = "";
