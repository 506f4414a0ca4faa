//! The layers of snow that were asked for, and how they are told in tables.

use super::cases::Share;
use super::plot::Keys;
use super::table::{Cell, number};
use crate::arguments::{PackName, PolarisationName, SearchArguments, Series, SnowArguments};
use crate::budget::Budget;
use crate::failure::Failure;
use snowgrain_accel::SimdLevel;
use snowgrain_formats::laboratory::{check_radius, read_layers, read_scatterers};
use snowgrain_optics::ice::radius_of_specific_surface_area;
use snowgrain_optics::{Impurity, Load};
use snowgrain_render::CostEstimate;
use snowgrain_render::laboratory::{
    AlbedoSettings, GrainLayer, Incidence, Scatterers, SnowLayer, SnowStack,
};

/// Every combination of what was asked for, or the layers of the file.
///
/// # Errors
/// A file of layers or shapes that cannot be used; shapes with polarisation that is tracked.
pub(super) fn stacks(
    (arguments, search): (&SnowArguments, &SearchArguments),
) -> Result<Vec<SnowStack>, Failure> {
    let mut stacks = Vec::new();
    for name in &arguments.shapes {
        let scatterers = read_scatterers(name.trim(), search.seed)?;
        match &arguments.layers {
            Some(path) => stacks.push(read_layers(path, &scatterers, search.seed)?),
            None => stacks.extend(layers(arguments, &scatterers)?),
        }
    }
    let tracked = search.polarisation == PolarisationName::Tracked;
    if tracked && stacks.iter().flatten().any(|layer| layer.scatterers != Scatterers::Spheres) {
        return Err(Failure::usage(
            "shapes are traced with unpolarised light; leave --polarisation out, or --shapes",
        ));
    }
    let grounds = Series::all(&arguments.ground);
    let over = |layers: Vec<SnowLayer>| {
        let stack = |&ground_albedo: &f64| SnowStack {
            layers: layers.clone(),
            ground_albedo,
            ice: arguments.ice_k,
        };
        grounds.iter().map(stack).collect::<Vec<_>>()
    };
    Ok(stacks.into_iter().flat_map(over).collect())
}

/// Every combination of one layer.
fn layers(
    arguments: &SnowArguments,
    scatterers: &Scatterers,
) -> Result<Vec<Vec<SnowLayer>>, Failure> {
    let mut mixtures: Vec<Vec<Impurity>> = vec![Vec::new()];
    for loads in &arguments.impurity {
        let with = |mixture: &Vec<Impurity>| {
            let one = |&impurity: &Impurity| [mixture.as_slice(), &[impurity]].concat();
            loads.0.iter().map(one).collect::<Vec<_>>()
        };
        mixtures = mixtures.iter().flat_map(with).collect();
    }
    let (densities, depths) = (Series::all(&arguments.density), Series::all(&arguments.depth));
    let mut layers = Vec::new();
    for radius in radii(arguments, scatterers)? {
        for &density in &densities {
            for &depth in &depths {
                for impurities in &mixtures {
                    let (scatterers, impurities) = (scatterers.clone(), impurities.clone());
                    layers.push(vec![SnowLayer { scatterers, radius, density, depth, impurities }]);
                }
            }
        }
    }
    Ok(layers)
}

/// Radii, and those of grains of the areas: shapes of more surface are larger than spheres of the same area.
fn radii(arguments: &SnowArguments, scatterers: &Scatterers) -> Result<Vec<f64>, Failure> {
    let mut radii = Series::all(&arguments.radius);
    for area in Series::all(&arguments.ssa) {
        let radius = radius_of_specific_surface_area(area) * scatterers.surface();
        radii.push(
            check_radius(radius).map_err(|reason| Failure::usage(format!("--ssa: {reason}")))?,
        );
    }
    Ok(radii)
}

/// Parallel light at each zenith angle; light from all of the sky, first, where it is asked for or
/// nothing else is.
pub(super) fn incidences(diffuse: bool, zeniths: &[Series]) -> Vec<Incidence> {
    let zeniths = Series::all(zeniths);
    let diffuse = (diffuse || zeniths.is_empty()).then_some(Incidence::Diffuse);
    let suns = zeniths.into_iter().map(|zenith_degrees| Incidence::Sun { zenith_degrees });
    diffuse.into_iter().chain(suns).collect()
}

/// Settings of a search by Monte Carlo, without what it searches for.
pub(super) fn search(arguments: &SearchArguments) -> AlbedoSettings {
    AlbedoSettings {
        wavelengths_nm: Vec::new(),
        incidence: Incidence::Diffuse,
        polarisation: arguments.polarisation.into(),
        standard_error: 1.0,
        relative_error_of_transmittance: f64::INFINITY,
        most_paths: arguments.max_paths,
        seed: arguments.seed,
        level: arguments.machine.simd.unwrap_or_else(SimdLevel::detect),
    }
}

/// The only layer of `stack` as a pack of grains.
///
/// # Errors
/// Snow of which no pack can be made, or for which there is no room.
pub(super) fn grain_layer(
    stack: &SnowStack,
    pack: PackName,
    arguments: &SearchArguments,
) -> Result<GrainLayer, Failure> {
    let budget = Budget::of_this_machine(arguments.machine.max_memory);
    let needs = CostEstimate::of_grains(GrainLayer::grains(stack, pack.into()));
    budget.map_or(Ok(()), |budget| budget.check(&needs))?;
    Ok(GrainLayer::new(stack, pack.into(), arguments.seed)?)
}

/// The method, with the lattice in which its grains are packed.
pub(super) fn packed_name(pack: PackName) -> &'static str {
    match pack {
        PackName::Random => "grains",
        PackName::Sc => "grains-sc",
        PackName::Fcc => "grains-fcc",
    }
}

/// What is said where grains should be traced with light whose polarisation is tracked.
pub(super) fn grains_are_unpolarised() -> Failure {
    Failure::usage(
        "grains are traced with unpolarised light; leave --polarisation out, or use --method \
         homogeneous",
    )
}

/// What tells cases apart in a plot.
pub(super) const PLOT_KEYS: Keys = &[
    ("method", "", ""),
    ("radius_um", "r ", " µm"),
    ("sza_deg", "sun ", "°"),
    ("density_kg_m3", "", " kg/m³"),
    ("depth_m", "depth ", " m"),
    ("ground_albedo", "ground ", ""),
    ("impurities", "", ""),
    ("shapes", "", ""),
];

/// A value of the only layer; what differs between layers is not one number.
fn of_layer(stack: &SnowStack, value: impl Fn(&SnowLayer) -> Cell) -> Cell {
    match stack.layers.as_slice() {
        [layer] => value(layer),
        _ => Cell::Word("layers".into()),
    }
}

pub(super) fn radius_um(stack: &SnowStack) -> Cell {
    of_layer(stack, |layer| Cell::Number(layer.radius * 1e6))
}

pub(super) fn zenith(incidence: Incidence) -> Cell {
    match incidence {
        Incidence::Diffuse => Cell::Word("diffuse".into()),
        Incidence::Sun { zenith_degrees } => Cell::Number(zenith_degrees),
    }
}

pub(super) fn density(stack: &SnowStack) -> Cell {
    of_layer(stack, |layer| Cell::Number(layer.density))
}

pub(super) fn depth_m(stack: &SnowStack) -> Cell {
    Cell::Number(stack.layers.iter().map(|layer| layer.depth).sum())
}

pub(super) fn impurities(stack: &SnowStack) -> Cell {
    of_layer(stack, |layer| {
        Cell::Word(layer.impurities.iter().map(impurity).collect::<Vec<_>>().join(";"))
    })
}

/// What the grains are.
pub(super) fn shapes(stack: &SnowStack) -> Cell {
    of_layer(stack, |layer| {
        Cell::Word(match &layer.scatterers {
            Scatterers::Spheres => "spheres".into(),
            Scatterers::Shapes(mix) => mix.name().to_owned(),
        })
    })
}

/// Sampling shapes takes all threads, and what is sampled serves the cases that follow.
pub(super) fn share(stack: &SnowStack) -> Share {
    let spheres = stack.layers.iter().all(|layer| layer.scatterers == Scatterers::Spheres);
    if spheres { Share::Together } else { Share::Alone }
}

fn impurity(impurity: &Impurity) -> String {
    let name = impurity.kind.name();
    match impurity.load {
        Load::MassFraction(fraction) => {
            format!("{name}={}ppb", number(fraction * 1e9))
        }
        Load::CellsPerKilogram(cells) => {
            format!("{name}={}cells/mL", number(cells / 1000.0))
        }
    }
}
