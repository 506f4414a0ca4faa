//! `snowgrain optics albedo`.

use super::snow;
use super::table::{Cell, Table};
use crate::arguments::{AlbedoArguments, Method, PolarisationName};
use crate::budget::Budget;
use crate::failure::Failure;
use crate::progress::Progress;
use crate::summary::grouped;
use crate::threads::pool;
use snowgrain_render::CostEstimate;
use snowgrain_render::laboratory::{
    Albedo, AlbedoSettings, Band, GrainLayer, Incidence, SnowStack, Theory, broadband,
    broadband_wavelengths_nm, grain_albedo, homogeneous_albedo, theoretical_albedo,
};
use snowgrain_render::measure::Estimate;

/// Most lines of a table.
const MOST_ROWS: usize = 10_000_000;

const COLUMNS: [&str; 13] = [
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
];

pub(super) fn run(arguments: &AlbedoArguments) -> Result<u8, Failure> {
    let progress = Progress::new(arguments.search.quiet, false);
    let pool = pool(&arguments.search.machine)?;
    let stacks = snow::stacks(&arguments.snow)?;
    let incidences = incidences(arguments);
    let wavelengths_nm = if arguments.broadband {
        broadband_wavelengths_nm()
    } else {
        arguments.wavelengths.0.clone()
    };
    let wavelengths = wavelengths_nm.len();
    let cases = stacks.len() * incidences.len() * arguments.method.len();
    if cases.saturating_mul(wavelengths) > MOST_ROWS {
        return Err(Failure::refused(format!(
            "{cases} cases of {wavelengths} wavelengths make more than {MOST_ROWS} lines; ask for \
             fewer at a time"
        )));
    }
    let mut table =
        Table { names: COLUMNS.to_vec(), rows: Vec::with_capacity(cases * wavelengths) };
    for (index, stack) in stacks.iter().enumerate() {
        for &incidence in &incidences {
            for &method in &arguments.method {
                let case = format!("{}, case {} of {}", name(method), index + 1, stacks.len());
                progress.stage(&case);
                let find = |incidence: Incidence| {
                    let search = Search { arguments, progress: &progress, stack, method };
                    pool.install(|| search.find(incidence, &wavelengths_nm))
                };
                let albedos = find(incidence)?;
                if !arguments.broadband {
                    let row = |albedo: &Albedo| row(stack, incidence, method, &Part::of(albedo));
                    table.rows.extend(albedos.iter().map(row));
                    continue;
                }
                let diffuse = if incidence == Incidence::Diffuse {
                    albedos.clone()
                } else {
                    find(Incidence::Diffuse)?
                };
                for band in Band::ALL {
                    let Some(fluxes) = broadband(band, incidence, &albedos, &diffuse) else {
                        continue;
                    };
                    let part = Part::of_band(band, fluxes, stack);
                    table.rows.push(row(stack, incidence, method, &part));
                }
            }
        }
    }
    progress.finish();
    table.tell(&arguments.search)?;
    Ok(0)
}

fn incidences(arguments: &AlbedoArguments) -> Vec<Incidence> {
    let suns = arguments.sza.iter().map(|&zenith_degrees| Incidence::Sun { zenith_degrees });
    let diffuse = arguments.diffuse || arguments.sza.is_empty();
    diffuse.then_some(Incidence::Diffuse).into_iter().chain(suns).collect()
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
    progress: &'a Progress,
    stack: &'a SnowStack,
    method: Method,
}

impl Search<'_> {
    fn find(&self, incidence: Incidence, wavelengths_nm: &[f64]) -> Result<Vec<Albedo>, Failure> {
        let Self { arguments, progress, stack, method } = *self;
        let theory = match method {
            Method::Homogeneous | Method::Grains => {
                let settings = AlbedoSettings {
                    wavelengths_nm: wavelengths_nm.to_vec(),
                    incidence,
                    standard_error: arguments.stderr,
                    ..snow::search(&arguments.search)
                };
                let mut tell = |paths: u64, done: f64| {
                    progress.detail(&format!("{} paths, {:.0} %", grouped(paths), 100.0 * done));
                };
                if method == Method::Homogeneous {
                    return Ok(homogeneous_albedo(stack, &settings, &mut tell));
                }
                if arguments.search.polarisation == PolarisationName::Tracked {
                    return Err(Failure::usage(
                        "grains are traced with unpolarised light; leave --polarisation out, or use \
                     --method homogeneous",
                    ));
                }
                let budget = Budget::of_this_machine(arguments.search.machine.max_memory);
                let needs = CostEstimate::of_grains(GrainLayer::grains(stack));
                budget.map_or(Ok(()), |budget| budget.check(&needs))?;
                let mut layer = GrainLayer::new(stack, settings.seed)?;
                return Ok(grain_albedo(stack, &mut layer, &settings, &mut tell));
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
                Theory::BohrenBarkstrom => "one layer of infinite depth under diffuse light",
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

fn row(stack: &SnowStack, incidence: Incidence, method: Method, part: &Part) -> Vec<Cell> {
    let [reflectance, transmittance] = part.fluxes;
    vec![
        Cell::Word(name(method).into()),
        part.of.clone(),
        snow::radius_um(stack),
        snow::zenith(incidence),
        snow::depth_m(stack),
        Cell::Number(reflectance.mean),
        Cell::Number(reflectance.standard_error),
        Cell::Number(transmittance.mean),
        Cell::Number(transmittance.standard_error),
        Cell::Number(part.absorptance),
        snow::density(stack),
        Cell::Number(stack.ground_albedo),
        snow::impurities(stack),
    ]
}
