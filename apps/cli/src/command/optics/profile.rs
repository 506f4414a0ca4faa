//! `snowgrain optics profile`.

use super::cases::find_all;
use super::plot::{self, Chart, Charts, Keys, Line, Scale, lines_of};
use super::snow;
use super::table::{Cell, Table, check_rows};
use crate::arguments::{ProfileArguments, Series};
use crate::failure::Failure;
use crate::progress::Progress;
use crate::threads::pool;
use snowgrain_render::laboratory::{
    AlbedoSettings, Flux, Incidence, SnowStack, Tell, flux_profile,
};

/// Standard error of a downward flux, as a part of it.
const RELATIVE_ERROR: f64 = 0.01;

const COLUMNS: [&str; 13] = [
    "wavelength_nm",
    "radius_um",
    "sza_deg",
    "z_m",
    "down",
    "down_stderr",
    "up",
    "up_stderr",
    "efold_m",
    "depth_m",
    "density_kg_m3",
    "impurities",
    "shapes",
];

pub(super) fn run(arguments: &ProfileArguments) -> Result<u8, Failure> {
    let progress = Progress::new(arguments.search.quiet, false);
    let pool = pool(&arguments.search.machine)?;
    let depths = Series::all(&arguments.at);
    if !depths.is_sorted_by(|a, b| a < b) {
        return Err(Failure::usage("--at: write depths from the top down, each once"));
    }
    let incidences = snow::incidences(false, &arguments.sza);
    let cases: Vec<(SnowStack, Incidence)> = snow::stacks((&arguments.snow, &arguments.search))?
        .into_iter()
        .flat_map(|stack| incidences.iter().map(move |&incidence| (stack.clone(), incidence)))
        .collect();
    check_rows(&[cases.len(), arguments.wavelengths.0.len(), depths.len()])?;
    for (stack, _) in &cases {
        check(stack, &depths)?;
    }
    let find =
        |case: &(SnowStack, Incidence), tell: Tell<'_>| fluxes(arguments, &depths, case, tell);
    let found =
        find_all((&progress, &pool, "profile"), &cases, |(stack, _)| snow::share(stack), find)?;
    progress.finish();
    let mut table = Table { names: COLUMNS.to_vec(), rows: Vec::new() };
    for ((stack, incidence), profiles) in cases.iter().zip(&found) {
        for (wavelength, fluxes) in arguments.wavelengths.0.iter().zip(profiles) {
            let rows = rows(stack, *incidence, &depths, fluxes);
            table.rows.extend(rows.map(|row| [vec![Cell::Number(*wavelength)], row].concat()));
        }
    }
    table.tell(&arguments.search)?;
    if let Some(file) = &arguments.plot {
        plot::write(file, &charts(&table))?;
    }
    Ok(0)
}

fn charts(table: &Table) -> Charts {
    const KEYS: Keys = &[
        ("wavelength_nm", "", " nm"),
        ("radius_um", "r ", " µm"),
        ("sza_deg", "sun ", "°"),
        ("density_kg_m3", "", " kg/m³"),
        ("depth_m", "depth ", " m"),
        ("impurities", "", ""),
        ("shapes", "", ""),
    ];
    let lines = |part: &'static str, error: &'static str| {
        lines_of(table, KEYS, move |cell| {
            let number = |name: &str| cell(name)?.number();
            let point = [100.0 * number("z_m")?, number(part)?, number(error)?];
            Some((part.to_owned(), point))
        })
    };
    let ((mut all, alike), (up, _)) = (lines("down", "down_stderr"), lines("up", "up_stderr"));
    all.extend(up.into_iter().map(|line| Line { dashed: true, ..line }));
    let chart = Chart {
        names: ["depth below the surface / cm", "flux / that of the light on the snow"],
        scales: [Scale::Linear, Scale::Logarithmic],
        y_range: None,
        lines: all,
    };
    Charts { title: "Light inside snow".into(), subtitle: alike, charts: vec![chart] }
}

/// Refuses what is not covered, before others take their time.
fn check(stack: &SnowStack, depths: &[f64]) -> Result<(), Failure> {
    if stack.layers.len() != 1 || stack.ground_albedo > 0.0 {
        return Err(not_one_layer());
    }
    let within = stack.layers.first().map_or(0.0, |layer| layer.depth);
    if let Some(depth) = depths.iter().find(|&&depth| depth > within) {
        let reason = format!("--at: {depth} m lies below the snow, which is {within} m deep");
        return Err(Failure::usage(reason));
    }
    Ok(())
}

fn not_one_layer() -> Failure {
    Failure::usage("profiles are of one layer over a black ground; leave --ground out")
}

/// Of each wavelength the fluxes at all depths.
fn fluxes(
    arguments: &ProfileArguments,
    depths: &[f64],
    (stack, incidence): &(SnowStack, Incidence),
    tell: Tell<'_>,
) -> Result<Vec<Vec<Flux>>, Failure> {
    let settings = AlbedoSettings {
        wavelengths_nm: arguments.wavelengths.0.clone(),
        incidence: *incidence,
        standard_error: arguments.stderr,
        relative_error_of_transmittance: RELATIVE_ERROR,
        ..snow::search(&arguments.search)
    };
    flux_profile(stack, depths, &settings, tell).ok_or_else(not_one_layer)
}

/// A line for each depth, without its wavelength.
fn rows<'a>(
    stack: &'a SnowStack,
    incidence: Incidence,
    depths: &'a [f64],
    fluxes: &'a [Flux],
) -> impl Iterator<Item = Vec<Cell>> + 'a {
    let fold = |index: usize| {
        let (Some(next), Some(flux)) = (depths.get(index + 1), fluxes.get(index + 1)) else {
            return f64::NAN;
        };
        let fall = fluxes[index].down.mean / flux.down.mean;
        (next - depths[index]) / snowgrain_math::trig::ln(fall)
    };
    depths.iter().zip(fluxes).enumerate().map(move |(index, (depth, flux))| {
        vec![
            snow::radius_um(stack),
            snow::zenith(incidence),
            Cell::Number(*depth),
            Cell::Number(flux.down.mean),
            Cell::Number(flux.down.standard_error),
            Cell::Number(flux.up.mean),
            Cell::Number(flux.up.standard_error),
            Cell::Number(fold(index)),
            snow::depth_m(stack),
            snow::density(stack),
            snow::impurities(stack),
            snow::shapes(stack),
        ]
    })
}
