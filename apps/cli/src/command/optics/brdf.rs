//! `snowgrain optics brdf`.

use super::cases::find_all;
use super::plot::{self, Chart, Charts, Hemisphere, Hemispheres, Keys, Line, Scale, lines_of};
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

const COLUMNS: [&str; 13] = [
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
    "shapes",
];

/// Azimuths from which on the hemisphere is drawn.
const FEW_AZIMUTHS: usize = 3;

const TITLE: &str = "Bidirectional reflectance factor of snow";

/// What tells cases apart in a plot.
const PLOT_KEYS: Keys = &[
    ("wavelength_nm", "", " nm"),
    ("method", "", ""),
    ("radius_um", "r ", " µm"),
    ("sza_deg", "sun ", "°"),
    ("density_kg_m3", "", " kg/m³"),
    ("depth_m", "depth ", " m"),
    ("ground_albedo", "ground ", ""),
    ("impurities", "", ""),
    ("shapes", "", ""),
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
    for stack in snow::stacks((&arguments.snow, &arguments.search))? {
        for sun_zenith_degrees in Series::all(&arguments.sza) {
            for &method in &arguments.method {
                let case = Case { stack: stack.clone(), sun_zenith_degrees, method };
                if method == BrdfMethod::KokhanovskyBreon {
                    // Refuses what it does not cover, before others take their time.
                    factors(&case, &settings(arguments, &case, &[]), &|_| ())?;
                }
                cases.push(case);
            }
        }
    }
    check_rows(&[cases.len(), wavelengths.len(), views.len()])?;
    let find = |case: &Case, tell: Tell<'_>| {
        let settings = settings(arguments, case, &views);
        factors(case, &settings, tell)
    };
    let found =
        find_all((&progress, &pool, "BRDF"), &cases, |case: &Case| snow::share(&case.stack), find)?;
    progress.finish();
    let mut table = Table { names: COLUMNS.to_vec(), rows: Vec::new() };
    for (case, factors) in cases.iter().zip(&found) {
        for (wavelength, factors) in wavelengths.iter().zip(factors) {
            let row = |(view, factor): (&View, &Estimate)| row(case, *wavelength, *view, *factor);
            table.rows.extend(views.iter().zip(factors).map(row));
        }
    }
    table.tell(&arguments.search)?;
    if let Some(file) = &arguments.plot {
        let mut azimuths = Series::all(&arguments.azimuth);
        azimuths.sort_by(f64::total_cmp);
        azimuths.dedup();
        if azimuths.len() < FEW_AZIMUTHS {
            plot::write(file, &charts(&table, &azimuths))?;
        } else {
            plot::write(file, &hemispheres(&table))?;
        }
    }
    Ok(0)
}

/// Lines over the zenith angle; in the plane of the light its own side is drawn to the left.
fn charts(table: &Table, azimuths: &[f64]) -> Charts {
    let in_plane = azimuths.iter().all(|azimuth| [0.0, 180.0].contains(azimuth));
    let (mut lines, alike) = lines_of(table, PLOT_KEYS, |cell| {
        let number = |name: &str| cell(name)?.number();
        let (zenith, azimuth) = (number("vza_deg")?, number("azimuth_deg")?);
        let x = if in_plane && azimuth == 180.0 { -zenith } else { zenith };
        let word = if in_plane { String::new() } else { format!("azimuth {azimuth}°") };
        Some((word, [x, number("BRF")?, number("BRF_stderr")?]))
    });
    for (index, line) in lines.iter_mut().enumerate() {
        line.case = index;
        line.points.sort_by(|a, b| a[0].total_cmp(&b[0]));
    }
    let chart = Chart {
        names: if in_plane {
            ["zenith angle / degrees (left: from the side of the sun)", "BRF"]
        } else {
            ["zenith angle / degrees", "BRF"]
        },
        scales: [Scale::Linear; 2],
        y_range: None,
        lines,
    };
    Charts { title: TITLE.into(), subtitle: alike, charts: vec![chart] }
}

fn hemispheres(table: &Table) -> Hemispheres {
    let (lines, alike) = lines_of(table, PLOT_KEYS, |cell| {
        let number = |name: &str| cell(name)?.number();
        // The third number stands where a line has its error.
        Some((String::new(), [number("vza_deg")?, number("azimuth_deg")?, number("BRF")?]))
    });
    let (suns, _) = lines_of(table, PLOT_KEYS, |cell| {
        Some((String::new(), [cell("sza_deg")?.number()?, 0.0, 0.0]))
    });
    let one = |(line, sun): (Line, Line)| Hemisphere {
        label: line.label,
        sun_degrees: sun.points[0][0],
        values: line.points,
    };
    let all = lines.into_iter().zip(suns).map(one).collect();
    Hemispheres { title: TITLE.into(), subtitle: alike, name: "BRF", all }
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
        snow::shapes(&case.stack),
    ]
}
