//! `snowgrain optics wet`.

use super::cases::{Share, find_all};
use super::plot::{self, Chart, Charts, Keys, Line, Scale, lines_of};
use super::snow::zenith;
use super::table::{Cell, Table, check_rows};
use crate::arguments::WetArguments;
use crate::failure::Failure;
use crate::progress::Progress;
use crate::threads::pool;
use snowgrain_accel::SimdLevel;
use snowgrain_optics::ice::{self, ICE_DENSITY};
use snowgrain_optics::sphere::{self, Polarisation};
use snowgrain_optics::theory::{self, SingleScattering};
use snowgrain_optics::{Dielectric, water};
use snowgrain_render::laboratory::{
    AlbedoSettings, Incidence, Scatterers, SnowLayer, SnowStack, Tell, WetLayer, WetSettings,
    homogeneous_albedo,
};

const COLUMNS: [&str; 14] = [
    "model",
    "wavelength_nm",
    "radius_um",
    "density_kg_m3",
    "depth_m",
    "sza_deg",
    "saturation",
    "liquid_water_percent",
    "wetness",
    "R",
    "R_stderr",
    "T",
    "T_stderr",
    "A",
];

/// Standard error of the model of larger grains.
const STANDARD_ERROR: f64 = 0.002;
/// Most solid that the model of larger grains takes.
const MOST_FILLED: f64 = 1.0;

pub(super) fn run(arguments: &WetArguments) -> Result<u8, Failure> {
    let progress = Progress::new(arguments.quiet, false);
    let pool = pool(&arguments.machine)?;
    progress.stage("packing grains");
    let make =
        || WetLayer::new(arguments.radius, arguments.density, arguments.depth, arguments.seed);
    let layer = pool.install(make)?;
    let saturations = saturations(arguments, &layer)?;
    check_rows(&[3, saturations.len(), arguments.wavelengths.0.len()])?;
    let find = |&saturation: &f64, tell: Tell<'_>| Ok(rows(arguments, &layer, saturation, tell));
    let share = |_: &f64| Share::Together;
    let found = find_all((&progress, &pool, "wet snow"), &saturations, share, find)?;
    progress.finish();
    let rows = found.into_iter().flatten().collect();
    let table = Table { names: COLUMNS.to_vec(), rows };
    table.tell_with(&[], arguments.format, arguments.output.as_deref())?;
    if let Some(file) = &arguments.plot {
        plot::write(file, &charts(&table))?;
    }
    Ok(0)
}

fn charts(table: &Table) -> Charts {
    const KEYS: Keys = &[
        ("model", "", ""),
        ("wavelength_nm", "", " nm"),
        ("radius_um", "r ", " µm"),
        ("density_kg_m3", "", " kg/m³"),
        ("depth_m", "depth ", " m"),
        ("sza_deg", "sun ", "°"),
    ];
    let lines = |part: &'static str, error: &'static str| {
        lines_of(table, KEYS, move |cell| {
            let number = |name: &str| cell(name)?.number();
            Some((part.to_owned(), [number("saturation")?, number(part)?, number(error)?]))
        })
    };
    let ((mut all, alike), (transmitted, _)) = (lines("R", "R_stderr"), lines("T", "T_stderr"));
    all.extend(transmitted.into_iter().map(|line| Line { dashed: true, ..line }));
    let chart = Chart {
        names: ["part of the pores filled with water", "part of the light"],
        scales: [Scale::Linear, Scale::Linear],
        y_range: Some([0.0, 1.0]),
        lines: all,
    };
    Charts { title: "Wet snow".into(), subtitle: alike, charts: vec![chart] }
}

/// The saturations that were asked for, one way or another.
fn saturations(arguments: &WetArguments, layer: &WetLayer) -> Result<Vec<f64>, Failure> {
    let (option, values, full) = match arguments {
        WetArguments { saturation: Some(range), .. } => ("--saturation", &range.0, 1.0),
        WetArguments { liquid_water: Some(range), .. } => {
            ("--liquid-water", &range.0, 100.0 * layer.liquid_water_content(1.0))
        }
        WetArguments { wetness: Some(range), .. } => ("--wetness", &range.0, layer.wetness(1.0)),
        _ => return Ok((0..=10).map(|tenth| f64::from(tenth) / 10.0).collect()),
    };
    match values.iter().find(|&&value| !(0.0..=full * (1.0 + 1e-9)).contains(&value)) {
        Some(value) => Err(Failure::usage(format!(
            "{option}: {value} is out of range: the pores of this snow hold 0 to {full:.4}"
        ))),
        None => Ok(values.iter().map(|value| (value / full).min(1.0)).collect()),
    }
}

fn incidence(arguments: &WetArguments) -> Incidence {
    arguments.sza.map_or(Incidence::Diffuse, |zenith_degrees| Incidence::Sun { zenith_degrees })
}

/// The lines of one amount of water.
fn rows(
    arguments: &WetArguments,
    layer: &WetLayer,
    saturation: f64,
    tell: Tell<'_>,
) -> Vec<Vec<Cell>> {
    let mut rows = Vec::new();
    let settings = WetSettings {
        wavelengths_nm: arguments.wavelengths.0.clone(),
        incidence: incidence(arguments),
        ice: arguments.ice_k,
        paths: arguments.paths,
        seed: arguments.seed,
    };
    let mut row = |model: &str, wavelength: f64, [r, r_error, t, t_error]: [f64; 4]| {
        let number = Cell::Number;
        rows.push(vec![
            Cell::Word(model.into()),
            number(wavelength),
            number(arguments.radius * 1e6),
            number(arguments.density),
            number(arguments.depth),
            zenith(incidence(arguments)),
            number(saturation),
            number(100.0 * layer.liquid_water_content(saturation)),
            number(layer.wetness(saturation)),
            number(r),
            number(r_error),
            number(t),
            number(t_error),
            number((1.0 - r - t).max(0.0)),
        ]);
    };
    for albedo in layer.albedo(saturation, &settings) {
        let (r, t) = (albedo.reflectance, albedo.transmittance);
        let values = [r.mean, r.standard_error, t.mean, t.standard_error];
        row("films", albedo.wavelength_nm, values);
    }
    tell(0.9);
    for (wavelength, values) in larger_grains(arguments, layer, saturation) {
        row("larger-grains", wavelength, values);
    }
    for &wavelength in &arguments.wavelengths.0 {
        let fluxes = submerged(arguments, saturation, wavelength);
        row("submerged", wavelength, [fluxes.reflectance, 0.0, fluxes.transmittance, 0.0]);
    }
    rows
}

/// The layer of spheres with the surface and volume of what borders on air; nothing where no air is left.
fn larger_grains(
    arguments: &WetArguments,
    layer: &WetLayer,
    saturation: f64,
) -> Vec<(f64, [f64; 4])> {
    let (radius, filled) = (layer.effective_radius(saturation), layer.filled(saturation));
    if !(radius < arguments.depth && filled < MOST_FILLED) {
        return Vec::new();
    }
    let stack = SnowStack {
        layers: vec![SnowLayer {
            scatterers: Scatterers::Spheres,
            radius,
            density: filled * ICE_DENSITY,
            depth: arguments.depth,
            impurities: Vec::new(),
        }],
        ground_albedo: 0.0,
        ice: arguments.ice_k,
    };
    let settings = AlbedoSettings {
        wavelengths_nm: arguments.wavelengths.0.clone(),
        incidence: incidence(arguments),
        polarisation: Polarisation::Redrawn,
        standard_error: STANDARD_ERROR,
        relative_error_of_transmittance: f64::INFINITY,
        most_paths: 10_000_000,
        seed: arguments.seed,
        level: arguments.machine.simd.unwrap_or_else(SimdLevel::detect),
    };
    homogeneous_albedo(&stack, &settings, &|_| ())
        .into_iter()
        .map(|albedo| {
            let (r, t) = (albedo.reflectance, albedo.transmittance);
            (albedo.wavelength_nm, [r.mean, r.standard_error, t.mean, t.standard_error])
        })
        .collect()
}

/// The layer of grains as large as dry ones, a part of them in water (Kokhanovsky and Zege 2004).
fn submerged(arguments: &WetArguments, saturation: f64, wavelength_nm: f64) -> theory::Fluxes {
    let indices = [ice::refractive_index(wavelength_nm), water::refractive_index(wavelength_nm)];
    let absorption = arguments.ice_k.per_metre(wavelength_nm) * arguments.radius;
    let [dry, wet] = [indices[0], indices[0] / indices[1]].map(|eta| {
        let medium = Dielectric { eta };
        [sphere::co_albedo(medium, absorption), sphere::asymmetry(medium)]
    });
    let [co_albedo, asymmetry] =
        [0, 1].map(|i: usize| (1.0 - saturation) * dry[i] + saturation * wet[i]);
    let depth = 0.75 * arguments.density / ICE_DENSITY * arguments.depth / arguments.radius;
    let incidence = match incidence(arguments) {
        Incidence::Diffuse => theory::Incidence::Diffuse,
        Incidence::Sun { zenith_degrees } => theory::Incidence::Parallel(
            snowgrain_math::trig::sin_cos(zenith_degrees.to_radians()).1,
        ),
    };
    theory::kokhanovsky_zege(SingleScattering { co_albedo, asymmetry }, depth, incidence)
}
