//! `snowgrain optics albedo`.

use super::cases::{Share, find_all};
use super::plot::{self, Chart, Charts, Line, Scale, lines_of};
use super::snow;
use super::table::{Cell, Table, check_rows};
use crate::arguments::{AlbedoArguments, Method, PolarisationName};
use crate::failure::Failure;
use crate::progress::Progress;
use crate::threads::pool;
use snowgrain_render::laboratory::{
    Albedo, AlbedoSettings, Band, GrainLayer, Incidence, SnowStack, Tell, Theory, broadband,
    broadband_wavelengths_nm, grain_albedo, homogeneous_albedo, theoretical_albedo,
};
use snowgrain_render::measure::Estimate;

const COLUMNS: [&str; 14] = [
    "method",
    "wavelength_nm",
    "radius_um",
    "sza_deg",
    "depth_m",
    "R",
    "R_stderr",
    "T",
    "T_stderr",
    "A",
    "density_kg_m3",
    "ground_albedo",
    "impurities",
    "shapes",
];

/// One search: of all wavelengths.
struct Case {
    stack: SnowStack,
    incidence: Incidence,
    method: Method,
}

pub(super) fn run(arguments: &AlbedoArguments) -> Result<u8, Failure> {
    let progress = Progress::new(arguments.search.quiet, false);
    let pool = pool(&arguments.search.machine)?;
    let wavelengths_nm = if arguments.broadband {
        broadband_wavelengths_nm()
    } else {
        arguments.wavelengths.0.clone()
    };
    let cases = cases(arguments)?;
    check_rows(&[cases.len(), wavelengths_nm.len()])?;
    // A pack of grains takes much memory.
    let share = |case: &Case| match case.method {
        Method::Grains => Share::Alone,
        _ => snow::share(&case.stack),
    };
    let find = |case: &Case, tell: Tell<'_>| parts(arguments, case, &wavelengths_nm, tell);
    let found = find_all((&progress, &pool, "albedo"), &cases, share, find)?;
    progress.finish();
    let mut table = Table { names: COLUMNS.to_vec(), rows: Vec::new() };
    for (case, parts) in cases.iter().zip(&found) {
        let name = match case.method {
            Method::Grains => snow::packed_name(arguments.pack),
            method => name(method),
        };
        table.rows.extend(parts.iter().map(|part| row((name, case), part)));
    }
    table.tell(&arguments.search)?;
    if let Some(file) = &arguments.plot {
        plot::write(file, &charts(&table))?;
    }
    Ok(0)
}

fn charts(table: &Table) -> Charts {
    let lines = |part: &'static str, error: &'static str| {
        lines_of(table, snow::PLOT_KEYS, move |cell| {
            let number = |name: &str| cell(name)?.number();
            let point = [number("wavelength_nm")?, number(part)?, number(error)?];
            (part == "R" || point[1] > 0.0).then(|| (part.to_owned(), point))
        })
    };
    let ((mut all, alike), (through, _)) = (lines("R", "R_stderr"), lines("T", "T_stderr"));
    all.extend(through.into_iter().map(|line| Line { dashed: true, ..line }));
    let chart = Chart {
        names: ["wavelength / nm", "part of the light"],
        scales: [Scale::Linear; 2],
        y_range: Some([0.0, 1.0]),
        lines: all,
    };
    let title = "Light that snow reflects (R) and lets through (T)".into();
    Charts { title, subtitle: alike, charts: vec![chart] }
}

fn cases(arguments: &AlbedoArguments) -> Result<Vec<Case>, Failure> {
    let incidences = snow::incidences(arguments.diffuse, &arguments.sza);
    let mut cases = Vec::new();
    for stack in snow::stacks((&arguments.snow, &arguments.search))? {
        for &incidence in &incidences {
            for &method in &arguments.method {
                let stack = match method {
                    Method::Grains => GrainLayer::packed(&stack, arguments.pack.into())?,
                    _ => stack.clone(),
                };
                let case = Case { stack, incidence, method };
                check(arguments, &case)?;
                cases.push(case);
            }
        }
    }
    Ok(cases)
}

/// Refuses what a method does not cover, before others take their time.
fn check(arguments: &AlbedoArguments, case: &Case) -> Result<(), Failure> {
    /// Any wavelength will do.
    const SOME_NM: [f64; 1] = [550.0];
    let tracked = arguments.search.polarisation == PolarisationName::Tracked;
    match case.method {
        Method::Homogeneous => Ok(()),
        Method::Grains if tracked => Err(snow::grains_are_unpolarised()),
        Method::Grains => Ok(()),
        Method::WiscombeWarren
        | Method::TwoStream
        | Method::KokhanovskyZege
        | Method::BohrenBarkstrom => {
            let search = Search { arguments, stack: &case.stack, method: case.method };
            search.find(case.incidence, &SOME_NM, &|_| ()).map(drop)
        }
    }
}

/// The lines of a case.
fn parts(
    arguments: &AlbedoArguments,
    case: &Case,
    wavelengths_nm: &[f64],
    tell: Tell<'_>,
) -> Result<Vec<Part>, Failure> {
    let search = Search { arguments, stack: &case.stack, method: case.method };
    let albedos = search.find(case.incidence, wavelengths_nm, tell)?;
    if !arguments.broadband {
        return Ok(albedos.iter().map(Part::of).collect());
    }
    let diffuse = if case.incidence == Incidence::Diffuse {
        albedos.clone()
    } else {
        search.find(Incidence::Diffuse, wavelengths_nm, tell)?
    };
    let part = |band: Band| {
        let fluxes = broadband(band, case.incidence, &albedos, &diffuse)?;
        Some(Part::of_band(band, fluxes, &case.stack))
    };
    Ok(Band::ALL.into_iter().filter_map(part).collect())
}

/// One line of the table: a wavelength or a band, and what becomes of its light.
struct Part {
    of: Cell,
    fluxes: [Estimate; 2],
    absorptance: f64,
}

impl Part {
    fn of(albedo: &Albedo) -> Self {
        Self {
            of: Cell::Number(albedo.wavelength_nm),
            fluxes: [albedo.reflectance, albedo.transmittance],
            absorptance: albedo.absorptance,
        }
    }

    fn of_band(band: Band, fluxes: [Estimate; 2], stack: &SnowStack) -> Self {
        let name = match band {
            Band::Solar => "solar",
            Band::Visible => "visible",
            Band::NearInfrared => "near-infrared",
        };
        let [up, down] = fluxes.map(|flux| flux.mean);
        let absorptance = 1.0 - up - (1.0 - stack.ground_albedo) * down;
        Self { of: Cell::Word(name.into()), fluxes, absorptance }
    }
}

/// What albedos are found of, and how.
struct Search<'a> {
    arguments: &'a AlbedoArguments,
    stack: &'a SnowStack,
    method: Method,
}

impl Search<'_> {
    fn find(
        &self,
        incidence: Incidence,
        wavelengths_nm: &[f64],
        tell: Tell<'_>,
    ) -> Result<Vec<Albedo>, Failure> {
        let Self { arguments, stack, method } = *self;
        let theory = match method {
            Method::Homogeneous | Method::Grains => {
                let settings = AlbedoSettings {
                    wavelengths_nm: wavelengths_nm.to_vec(),
                    incidence,
                    standard_error: arguments.stderr,
                    ..snow::search(&arguments.search)
                };
                if method == Method::Homogeneous {
                    return Ok(homogeneous_albedo(stack, &settings, tell));
                }
                let mut layer = snow::grain_layer(stack, arguments.pack, &arguments.search)?;
                return Ok(grain_albedo(stack, &mut layer, &settings, tell));
            }
            Method::WiscombeWarren => Theory::WiscombeWarren,
            Method::TwoStream => Theory::TwoStream,
            Method::KokhanovskyZege => Theory::KokhanovskyZege,
            Method::BohrenBarkstrom => Theory::BohrenBarkstrom,
        };
        let polarisation = arguments.search.polarisation.into();
        let each = wavelengths_nm.iter().map(|&wavelength_nm| {
            theoretical_albedo(theory, stack, incidence, polarisation, wavelength_nm)
        });
        each.collect::<Option<Vec<Albedo>>>().ok_or_else(|| {
            let covers = match theory {
                Theory::BohrenBarkstrom => {
                    "one layer of infinite depth, of spheres, under diffuse light"
                }
                Theory::WiscombeWarren | Theory::TwoStream | Theory::KokhanovskyZege => "one layer",
            };
            Failure::usage(format!(
                "{} covers {covers} only; use --method homogeneous",
                name(method)
            ))
        })
    }
}

fn name(method: Method) -> &'static str {
    match method {
        Method::Homogeneous => "homogeneous",
        Method::Grains => "grains",
        Method::WiscombeWarren => "wiscombe-warren",
        Method::TwoStream => "two-stream",
        Method::KokhanovskyZege => "kokhanovsky-zege",
        Method::BohrenBarkstrom => "bohren-barkstrom",
    }
}

fn row((name, case): (&str, &Case), part: &Part) -> Vec<Cell> {
    let Case { stack, incidence, .. } = case;
    let [reflectance, transmittance] = part.fluxes;
    vec![
        Cell::Word(name.into()),
        part.of.clone(),
        snow::radius_um(stack),
        snow::zenith(*incidence),
        snow::depth_m(stack),
        Cell::Number(reflectance.mean),
        Cell::Number(reflectance.standard_error),
        Cell::Number(transmittance.mean),
        Cell::Number(transmittance.standard_error),
        Cell::Number(part.absorptance),
        snow::density(stack),
        Cell::Number(stack.ground_albedo),
        snow::impurities(stack),
        snow::shapes(stack),
    ]
}
