//! The layers of snow that were asked for, and how they are told in tables.

use super::table::{Cell, number};
use crate::arguments::{SearchArguments, SnowArguments};
use crate::failure::Failure;
use snowgrain_accel::SimdLevel;
use snowgrain_formats::laboratory::read_layers;
use snowgrain_optics::ice::radius_of_specific_surface_area;
use snowgrain_optics::{Impurity, Load};
use snowgrain_render::laboratory::{AlbedoSettings, Incidence, SnowLayer, SnowStack};

/// Every combination of what was asked for, or the layers of the file.
pub(super) fn stacks(arguments: &SnowArguments) -> Result<Vec<SnowStack>, Failure> {
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
