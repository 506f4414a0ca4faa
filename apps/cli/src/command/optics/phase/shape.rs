//! `snowgrain optics phase --shape` and `--shapes`.

use super::super::plot;
use super::super::table::{Cell, Table};
use super::charts;
use crate::arguments::PhaseArguments;
use crate::failure::Failure;
use crate::threads;
use snowgrain_accel::SimdLevel;
use snowgrain_formats::laboratory::read_scatterers;
use snowgrain_formats::scene::document::{ShapeName, ShapeTable};
use snowgrain_geometry::{Shape, ShapeKind};
use snowgrain_math::trig;
use snowgrain_render::laboratory::{Scatterers, Scattering, scattering_of_mix};

pub(super) fn run(arguments: &PhaseArguments) -> Result<u8, Failure> {
    let (eta, _) = super::index(arguments)?;
    let typed = &arguments.shape;
    let (name, shapes) = shapes(arguments)?;
    let level = typed.machine.simd.unwrap_or_else(SimdLevel::detect);
    let bins = usize::from(arguments.bins);
    let pool = threads::pool(&typed.machine)?;
    let paths = (typed.paths, typed.seed);
    let found = pool.install(|| scattering_of_mix(&shapes, eta, bins, paths, level));
    let surface = mean(&shapes, Shape::surface_area);
    let figures = [
        ("refractive_index", eta),
        ("g", found.asymmetry.mean),
        ("g_standard_error", found.asymmetry.standard_error),
        ("B", found.enhancement.mean),
        ("B_standard_error", found.enhancement.standard_error),
        ("interfaces_per_visit", found.interface_events.mean),
        ("projected_area_r2", found.projected_area.mean),
        ("projected_area_standard_error", found.projected_area.standard_error),
        ("surface_area_r2", surface),
    ];
    let table = table(&found);
    table.tell_with(&figures, arguments.format, arguments.output.as_deref())?;
    if let Some(file) = &arguments.plot {
        let title = format!("Scattering by {name}, without diffraction");
        plot::write(file, &charts(&title, &table, [eta, found.asymmetry.mean]))?;
    }
    Ok(0)
}

/// What is asked for: how it is called, and each shape with its part of the grains.
fn shapes(arguments: &PhaseArguments) -> Result<(String, Vec<(Shape, f64)>), Failure> {
    if let Some(name) = &arguments.shape.shapes {
        let Scatterers::Shapes(mix) = read_scatterers(name, arguments.shape.seed)? else {
            return Ok((name.clone(), vec![(sphere()?, 1.0)]));
        };
        let shapes = mix.mix().shapes().iter();
        let shapes = shapes.map(|mixed| (Shape::clone(&mixed.shape), mixed.fraction));
        return Ok((name.clone(), shapes.collect()));
    }
    let kind = match arguments.shape.shape {
        Some(name) => kind(arguments, name)?,
        None => ShapeKind::Sphere,
    };
    let shape = Shape::new(kind).map_err(|error| Failure::usage(format!("--{error}")))?;
    Ok((shape.name().to_owned(), vec![(shape, 1.0)]))
}

fn sphere() -> Result<Shape, Failure> {
    Shape::new(ShapeKind::Sphere).map_err(|error| Failure::usage(error.to_string()))
}

/// Mean over the grains.
fn mean(shapes: &[(Shape, f64)], of: impl Fn(&Shape) -> f64) -> f64 {
    let all: f64 = shapes.iter().map(|(_, fraction)| fraction).sum();
    shapes.iter().map(|(shape, fraction)| fraction * of(shape)).sum::<f64>() / all
}

fn kind(arguments: &PhaseArguments, name: ShapeName) -> Result<ShapeKind, Failure> {
    let typed = &arguments.shape;
    let table = ShapeTable {
        aspect: typed.aspect,
        rounding: Some(typed.rounding),
        faces: Some(typed.faces),
        seed: Some(typed.seed),
        arms: Some(typed.arms),
        ..ShapeTable::of(name)
    };
    let kind = table.kind().map_err(|(key, mend)| Failure::usage(format!("--{key}: {mend}")))?;
    kind.ok_or_else(|| Failure::usage("--shape: a mesh is not a shape of numbers"))
}

fn table(found: &Scattering) -> Table {
    let bins = found.energy_by_angle.len();
    let edge = |bin: usize| 180.0 * bin as f64 / bins as f64;
    let cosine = |degrees: f64| trig::sin_cos(degrees.to_radians()).1;
    let row = |(bin, energy): (usize, &snowgrain_render::measure::Estimate)| {
        let [from, to] = [edge(bin), edge(bin + 1)];
        let per_energy = 2.0 / (cosine(from) - cosine(to));
        [from, to, energy.mean, per_energy * energy.mean, per_energy * energy.standard_error]
            .map(Cell::Number)
            .to_vec()
    };
    Table {
        names: vec!["from_deg", "to_deg", "energy", "phase_function", "standard_error"],
        rows: found.energy_by_angle.iter().enumerate().map(row).collect(),
    }
}
