//! `snowgrain optics brdf`.

use super::cases::{Share, find_all};
use super::snow;
use super::table::{Cell, Table, check_rows};
use crate::arguments::{BrdfArguments, BrdfMethod, Series};
use crate::failure::Failure;
use crate::progress::Progress;
use crate::threads::pool;
use snowgrain_render::laboratory::{
    BrdfSettings, SnowStack, Tell, View, homogeneous_brdf, kokhanovsky_breon_brdf,
};
use snowgrain_render::measure::Estimate;

const COLUMNS: [&str; 12] = [
    "method",
    "wavelength_nm",
    "radius_um",
    "sza_deg",
    "depth_m",
    "vza_deg",
    "azimuth_deg",
    "BRF",
    "BRF_stderr",
    "density_kg_m3",
    "ground_albedo",
    "impurities",
];

/// One search: of all wavelengths in all views.
struct Case {
    stack: SnowStack,
    sun_zenith_degrees: f64,
    method: BrdfMethod,
}

pub(super) fn run(arguments: &BrdfArguments) -> Result<u8, Failure> {
    let progress = Progress::new(arguments.search.quiet, false);
    let pool = pool(&arguments.search.machine)?;
    let (views, wavelengths) = (views(arguments), &arguments.wavelengths.0);
    let mut cases = Vec::new();
    for stack in snow::stacks(&arguments.snow)? {
        for sun_zenith_degrees in Series::all(&arguments.sza) {
            for &method in &arguments.method {
                cases.push(Case { stack: stack.clone(), sun_zenith_degrees, method });
            }
        }
    }
    check_rows(&[cases.len(), wavelengths.len(), views.len()])?;
    let find = |case: &Case, tell: Tell<'_>| {
        let settings = settings(arguments, case, &views);
        factors(case, &settings, tell)
    };
    let found = find_all((&progress, &pool, "BRDF"), &cases, |_| Share::Together, find)?;
    progress.finish();
    let mut table = Table { names: COLUMNS.to_vec(), rows: Vec::new() };
    for (case, factors) in cases.iter().zip(&found) {
        for (wavelength, factors) in wavelengths.iter().zip(factors) {
            let row = |(view, factor): (&View, &Estimate)| row(case, *wavelength, *view, *factor);
            table.rows.extend(views.iter().zip(factors).map(row));
        }
    }
    table.tell(&arguments.search)?;
    Ok(0)
}

/// Every combination of the angles.
fn views(arguments: &BrdfArguments) -> Vec<View> {
    let azimuths = Series::all(&arguments.azimuth);
    let ring = |zenith_degrees: f64| {
        let view = move |&azimuth_degrees: &f64| View { zenith_degrees, azimuth_degrees };
        azimuths.iter().map(view).collect::<Vec<_>>()
    };
    Series::all(&arguments.vza).into_iter().flat_map(ring).collect()
}

fn settings(arguments: &BrdfArguments, case: &Case, views: &[View]) -> BrdfSettings {
    let search = snow::search(&arguments.search);
    BrdfSettings {
        wavelengths_nm: arguments.wavelengths.0.clone(),
        sun_zenith_degrees: case.sun_zenith_degrees,
        views: views.to_vec(),
        polarisation: search.polarisation,
        standard_error: arguments.stderr,
        most_paths: search.most_paths,
        seed: search.seed,
        level: search.level,
    }
}

fn factors(
    case: &Case,
    settings: &BrdfSettings,
    tell: Tell<'_>,
) -> Result<Vec<Vec<Estimate>>, Failure> {
    match case.method {
        BrdfMethod::Homogeneous => Ok(homogeneous_brdf(&case.stack, settings, tell)),
        BrdfMethod::KokhanovskyBreon => {
            kokhanovsky_breon_brdf(&case.stack, settings).ok_or_else(|| {
                Failure::usage(
                    "--method kokhanovsky-breon covers one layer of infinite depth only; use \
                     --method homogeneous",
                )
            })
        }
    }
}

fn name(method: BrdfMethod) -> &'static str {
    match method {
        BrdfMethod::Homogeneous => "homogeneous",
        BrdfMethod::KokhanovskyBreon => "kokhanovsky-breon",
    }
}

fn row(case: &Case, wavelength_nm: f64, view: View, factor: Estimate) -> Vec<Cell> {
    vec![
        Cell::Word(name(case.method).into()),
        Cell::Number(wavelength_nm),
        snow::radius_um(&case.stack),
        Cell::Number(case.sun_zenith_degrees),
        snow::depth_m(&case.stack),
        Cell::Number(view.zenith_degrees),
        Cell::Number(view.azimuth_degrees),
        Cell::Number(factor.mean),
        Cell::Number(factor.standard_error),
        snow::density(&case.stack),
        Cell::Number(case.stack.ground_albedo),
        snow::impurities(&case.stack),
    ]
}
