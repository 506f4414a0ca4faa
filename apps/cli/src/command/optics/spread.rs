//! `snowgrain optics spread`.

use super::cases::{Share, find_all};
use super::plot::{self, Chart, Charts, Keys, Line, Scale, lines_of};
use super::snow;
use super::table::{Cell, Table, check_rows};
use crate::arguments::{PolarisationName, SpreadArguments, SpreadMethod};
use crate::failure::Failure;
use crate::progress::Progress;
use crate::threads::pool;
use snowgrain_render::laboratory::{
    FaceSpread, GrainLayer, Incidence, Scatterers, SnowStack, Spread, SpreadBin, SpreadSettings,
    Tell, grain_spread, homogeneous_spread,
};
use snowgrain_render::measure::Estimate;

const COLUMNS: [&str; 13] = [
    "method",
    "wavelength_nm",
    "radius_um",
    "sza_deg",
    "depth_m",
    "quantity",
    "from",
    "to",
    "value",
    "value_stderr",
    "density_kg_m3",
    "impurities",
    "shapes",
];

/// Most lines of a case at one wavelength.
const MOST_BINS: usize = 1200;
/// Speed of light, m/ps.
const LIGHT_METRES_PER_PICOSECOND: f64 = 2.997_924_58e-4;

struct Case {
    name: &'static str,
    stack: SnowStack,
    incidence: Incidence,
    method: SpreadMethod,
}

pub(super) fn run(arguments: &SpreadArguments) -> Result<u8, Failure> {
    let progress = Progress::new(arguments.search.quiet, false);
    let pool = pool(&arguments.search.machine)?;
    let cases = cases(arguments)?;
    check_rows(&[cases.len(), arguments.wavelengths.0.len(), MOST_BINS])?;
    // A pack of grains takes much memory.
    let share = |case: &Case| match case.method {
        SpreadMethod::Grains => Share::Alone,
        SpreadMethod::Homogeneous => Share::Together,
    };
    let find = |case: &Case, tell: Tell<'_>| find(arguments, case, tell);
    let found = find_all((&progress, &pool, "spread"), &cases, share, find)?;
    progress.finish();
    let mut table = Table { names: COLUMNS.to_vec(), rows: Vec::new() };
    for (case, spreads) in cases.iter().zip(&found) {
        for spread in spreads {
            table.rows.extend(rows(case, spread));
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
        ("method", "", ""),
        ("radius_um", "r ", " µm"),
        ("sza_deg", "light ", "°"),
        ("density_kg_m3", "", " kg/m³"),
        ("depth_m", "depth ", " m"),
        ("impurities", "", ""),
        ("shapes", "", ""),
    ];
    let lines = |what: &'static str, unit: f64| {
        lines_of(table, KEYS, move |cell| {
            let number = |name: &str| cell(name)?.number();
            let quantity = cell("quantity")?.text();
            let face = quantity.strip_suffix(what)?.to_owned();
            let (from, to) = (number("from")?, number("to")?);
            // The middle of a bin as it is drawn; the first one and the last have none.
            let middle = unit * (from * to).sqrt();
            let inner = middle > 0.0 && middle.is_finite();
            let point = [middle, number("value")?, number("value_stderr")?];
            inner.then_some((face, point))
        })
    };
    let ((places, alike), (times, _)) = (lines("_per_area", 1e3), lines("_per_time", 1.0));
    let chart = |x: &'static str, y: &'static str, lines: Vec<Line>| {
        let dashed = |line: Line| Line { dashed: line.label.starts_with('T'), ..line };
        Chart {
            names: [x, y],
            scales: [Scale::Logarithmic; 2],
            y_range: None,
            lines: lines.into_iter().map(dashed).collect(),
        }
    };
    Charts {
        title: "Light that enters at a point: reflected (R) and let through (T)".into(),
        subtitle: alike,
        charts: vec![
            chart("distance / mm", "light per area / m⁻²", places),
            chart("time / ps", "light per time / ps⁻¹", times),
        ],
    }
}

fn cases(arguments: &SpreadArguments) -> Result<Vec<Case>, Failure> {
    let incidences = if arguments.diffuse || !arguments.sza.is_empty() {
        snow::incidences(arguments.diffuse, &arguments.sza)
    } else {
        vec![Incidence::Sun { zenith_degrees: 0.0 }]
    };
    let mut cases = Vec::new();
    for stack in snow::stacks((&arguments.snow, &arguments.search))? {
        for &incidence in &incidences {
            for &method in &arguments.method {
                check(arguments, &stack, method)?;
                let stack = match method {
                    SpreadMethod::Grains => GrainLayer::packed(&stack, arguments.pack.into())?,
                    SpreadMethod::Homogeneous => stack.clone(),
                };
                let name = match method {
                    SpreadMethod::Grains => snow::packed_name(arguments.pack),
                    SpreadMethod::Homogeneous => "homogeneous",
                };
                cases.push(Case { name, stack, incidence, method });
            }
        }
    }
    Ok(cases)
}

/// Refuses what is not covered, before others take their time.
fn check(
    arguments: &SpreadArguments,
    stack: &SnowStack,
    method: SpreadMethod,
) -> Result<(), Failure> {
    let tracked = arguments.search.polarisation == PolarisationName::Tracked;
    if method == SpreadMethod::Grains && tracked {
        return Err(snow::grains_are_unpolarised());
    }
    if stack.layers.len() != 1 || stack.ground_albedo > 0.0 {
        return Err(not_one_layer());
    }
    if stack.layers[0].scatterers != Scatterers::Spheres {
        return Err(Failure::usage("spreads are of spheres, which take room; leave --shapes out"));
    }
    Ok(())
}

fn not_one_layer() -> Failure {
    Failure::usage(
        "spreads are of one layer over a black ground; leave --ground out and ask for one layer",
    )
}

fn find(arguments: &SpreadArguments, case: &Case, tell: Tell<'_>) -> Result<Vec<Spread>, Failure> {
    let search = snow::search(&arguments.search);
    let settings = SpreadSettings {
        wavelengths_nm: arguments.wavelengths.0.clone(),
        incidence: case.incidence,
        polarisation: search.polarisation,
        standard_error: arguments.stderr,
        most_paths: search.most_paths,
        seed: search.seed,
        level: search.level,
    };
    let found = match case.method {
        SpreadMethod::Homogeneous => homogeneous_spread(&case.stack, &settings, tell),
        SpreadMethod::Grains => {
            let mut grains = snow::grain_layer(&case.stack, arguments.pack, &arguments.search)?;
            grain_spread(&case.stack, &mut grains, &settings, tell)
        }
    };
    found.ok_or_else(not_one_layer)
}

/// A figure: what it is called, between which bounds it holds, and what it is.
type Figure = (String, [f64; 2], Estimate);

/// No bounds.
const EVERYWHERE: [f64; 2] = [f64::NAN; 2];

fn rows(case: &Case, spread: &Spread) -> Vec<Vec<Cell>> {
    let length = Estimate { mean: spread.transport_length, standard_error: 0.0 };
    let mut figures = vec![("transport_length_m".to_owned(), EVERYWHERE, length)];
    figures.extend(of_face("R", &spread.reflected));
    if !case.stack.is_deep() {
        figures.extend(of_face("T", &spread.transmitted));
    }
    let row = |(quantity, [from, to], value): Figure| {
        vec![
            Cell::Word(case.name.into()),
            Cell::Number(spread.wavelength_nm),
            snow::radius_um(&case.stack),
            snow::zenith(case.incidence),
            snow::depth_m(&case.stack),
            Cell::Word(quantity),
            Cell::Number(from),
            Cell::Number(to),
            Cell::Number(value.mean),
            Cell::Number(value.standard_error),
            snow::density(&case.stack),
            snow::impurities(&case.stack),
            snow::shapes(&case.stack),
        ]
    };
    figures.into_iter().map(row).collect()
}

fn of_face(face: &str, spread: &FaceSpread) -> Vec<Figure> {
    let one = |what: &str, value: Estimate| (format!("{face}{what}"), EVERYWHERE, value);
    let time = |path: f64| path / LIGHT_METRES_PER_PICOSECOND;
    let scaled = |value: Estimate, by: f64| Estimate {
        mean: value.mean * by,
        standard_error: value.standard_error * by,
    };
    let mut figures = vec![
        one("", spread.total),
        one("_median_radius_m", spread.median_radius),
        one("_radius_90_m", spread.radius_of_90_percent),
        one("_mean_path_m", spread.mean_path),
        one("_mean_time_ps", scaled(spread.mean_path, time(1.0))),
    ];
    let mut add = |what: &str, bins: Vec<(f64, f64, Estimate)>| {
        let figure = |(from, to, value)| (format!("{face}{what}"), [from, to], value);
        figures.extend(bins.into_iter().map(figure));
    };
    let lit = |bin: &&SpreadBin| bin.value.mean > 0.0;
    let plain = |bins: &[SpreadBin]| {
        bins.iter().filter(lit).map(|bin| (bin.from, bin.to, bin.value)).collect::<Vec<_>>()
    };
    add("_per_area", plain(&spread.per_area));
    let rings = spread.within.iter().zip(&spread.per_area).filter(|(_, ring)| lit(ring));
    add("_within", rings.map(|(within, _)| (0.0, within.to, within.value)).collect());
    add("_per_width", plain(&spread.per_width));
    add("_per_path", plain(&spread.per_path));
    let in_time = |bin: &SpreadBin| {
        (time(bin.from), time(bin.to), scaled(bin.value, LIGHT_METRES_PER_PICOSECOND))
    };
    add("_per_time", spread.per_path.iter().filter(lit).map(in_time).collect());
    figures
}
