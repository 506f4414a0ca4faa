//! `snowgrain optics albedo`.

use super::table::{Cell, Table};
use crate::arguments::{AlbedoArguments, Method, TableFormat};
use crate::failure::Failure;
use crate::output;
use crate::progress::Progress;
use crate::summary::grouped;
use crate::threads::pool;
use snowgrain_accel::SimdLevel;
use snowgrain_formats::laboratory::read_layers;
use snowgrain_optics::ice::radius_of_specific_surface_area;
use snowgrain_optics::{Impurity, Load};
use snowgrain_render::laboratory::{
    Albedo, AlbedoSettings, Incidence, SnowLayer, SnowStack, Theory, homogeneous_albedo,
    theoretical_albedo,
};

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
    let progress = Progress::new(arguments.quiet, false);
    let pool = pool(&arguments.machine)?;
    let stacks = stacks(arguments)?;
    let incidences = incidences(arguments);
    let wavelengths = arguments.wavelengths.0.len();
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
                let albedos =
                    pool.install(|| find(arguments, &progress, stack, incidence, method))?;
                let row = |albedo: &Albedo| row(stack, incidence, method, albedo);
                table.rows.extend(albedos.iter().map(row));
            }
        }
    }
    progress.finish();
    let text = match arguments.format {
        TableFormat::Csv => table.csv(),
        TableFormat::Json => output::json(&table.objects())?,
    };
    match &arguments.output {
        Some(path) => output::write_text(path, &text)?,
        None => output::print(&text)?,
    }
    Ok(0)
}

/// Every combination of what was asked for, or the layers of the file.
fn stacks(arguments: &AlbedoArguments) -> Result<Vec<SnowStack>, Failure> {
    let stack = |layers: Vec<SnowLayer>| SnowStack {
        layers,
        ground_albedo: arguments.ground,
        ice: arguments.ice_k,
    };
    if let Some(path) = &arguments.layers {
        return Ok(vec![stack(read_layers(path)?)]);
    }
    let from_area = arguments.ssa.iter().map(|&area| radius_of_specific_surface_area(area));
    let radii: Vec<f64> = arguments.radius.iter().copied().chain(from_area).collect();
    let mut mixtures: Vec<Vec<Impurity>> = vec![Vec::new()];
    for loads in &arguments.impurity {
        mixtures = mixtures
            .iter()
            .flat_map(|mixture| {
                loads.0.iter().map(|&impurity| [mixture.as_slice(), &[impurity]].concat())
            })
            .collect();
    }
    let mut stacks = Vec::new();
    for &radius in &radii {
        for &density in &arguments.density {
            for depth in &arguments.depth {
                for impurities in &mixtures {
                    let impurities = impurities.clone();
                    let layer = SnowLayer { radius, density, depth: depth.0, impurities };
                    stacks.push(stack(vec![layer]));
                }
            }
        }
    }
    Ok(stacks)
}

fn incidences(arguments: &AlbedoArguments) -> Vec<Incidence> {
    let suns = arguments.sza.iter().map(|&zenith_degrees| Incidence::Sun { zenith_degrees });
    let diffuse = arguments.diffuse || arguments.sza.is_empty();
    diffuse.then_some(Incidence::Diffuse).into_iter().chain(suns).collect()
}

fn find(
    arguments: &AlbedoArguments,
    progress: &Progress,
    stack: &SnowStack,
    incidence: Incidence,
    method: Method,
) -> Result<Vec<Albedo>, Failure> {
    let theory = match method {
        Method::Homogeneous => {
            let settings = AlbedoSettings {
                wavelengths_nm: arguments.wavelengths.0.clone(),
                incidence,
                polarisation: arguments.polarisation.into(),
                standard_error: arguments.stderr,
                most_paths: arguments.max_paths,
                seed: arguments.seed,
                level: arguments.machine.simd.unwrap_or_else(SimdLevel::detect),
            };
            let mut tell = |paths: u64, done: f64| {
                progress.detail(&format!("{} paths, {:.0} %", grouped(paths), 100.0 * done));
            };
            return Ok(homogeneous_albedo(stack, &settings, &mut tell));
        }
        Method::WiscombeWarren => Theory::WiscombeWarren,
        Method::TwoStream => Theory::TwoStream,
        Method::KokhanovskyZege => Theory::KokhanovskyZege,
        Method::BohrenBarkstrom => Theory::BohrenBarkstrom,
    };
    let polarisation = arguments.polarisation.into();
    let each = arguments.wavelengths.0.iter().map(|&wavelength_nm| {
        theoretical_albedo(theory, stack, incidence, polarisation, wavelength_nm)
    });
    each.collect::<Option<Vec<Albedo>>>().ok_or_else(|| {
        let covers = match theory {
            Theory::BohrenBarkstrom => "one layer of infinite depth under diffuse light",
            Theory::WiscombeWarren | Theory::TwoStream | Theory::KokhanovskyZege => "one layer",
        };
        Failure::usage(format!("{} covers {covers} only; use --method homogeneous", name(method)))
    })
}

fn name(method: Method) -> &'static str {
    match method {
        Method::Homogeneous => "homogeneous",
        Method::WiscombeWarren => "wiscombe-warren",
        Method::TwoStream => "two-stream",
        Method::KokhanovskyZege => "kokhanovsky-zege",
        Method::BohrenBarkstrom => "bohren-barkstrom",
    }
}

fn row(stack: &SnowStack, incidence: Incidence, method: Method, albedo: &Albedo) -> Vec<Cell> {
    // What differs between layers is not one number.
    let one = |value: fn(&SnowLayer) -> f64| match stack.layers.as_slice() {
        [layer] => Cell::Number(value(layer)),
        _ => Cell::Word("layers".into()),
    };
    let impurities = match stack.layers.as_slice() {
        [layer] => layer.impurities.iter().map(impurity).collect::<Vec<_>>().join(";"),
        _ => "layers".into(),
    };
    vec![
        Cell::Word(name(method).into()),
        Cell::Number(albedo.wavelength_nm),
        one(|layer| layer.radius * 1e6),
        match incidence {
            Incidence::Diffuse => Cell::Word("diffuse".into()),
            Incidence::Sun { zenith_degrees } => Cell::Number(zenith_degrees),
        },
        Cell::Number(stack.layers.iter().map(|layer| layer.depth).sum()),
        Cell::Number(albedo.reflectance.mean),
        Cell::Number(albedo.reflectance.standard_error),
        Cell::Number(albedo.transmittance.mean),
        Cell::Number(albedo.transmittance.standard_error),
        Cell::Number(albedo.absorptance),
        one(|layer| layer.density),
        Cell::Number(stack.ground_albedo),
        Cell::Word(impurities),
    ]
}

fn impurity(impurity: &Impurity) -> String {
    let name = impurity.kind.name();
    match impurity.load {
        Load::MassFraction(fraction) => {
            format!("{name}={}ppb", super::table::number(fraction * 1e9))
        }
        Load::CellsPerKilogram(cells) => {
            format!("{name}={}cells/mL", super::table::number(cells / 1000.0))
        }
    }
}
