//! `snowgrain inspect`.

mod figures;
mod plots;

use super::deposit::lies_on_surface;
use super::optics::plot;
use crate::arguments::InspectArguments;
use crate::budget::Budget;
use crate::failure::Failure;
use crate::load;
use crate::output;
use crate::progress::Progress;
use crate::threads;
use figures::Figures;
use snowgrain_accel::SimdLevel;
use snowgrain_formats::{PlyContent, atomic, ply_content, read_grains};
use snowgrain_grains::GrainField;
use snowgrain_grains::measures::{Extent, Structure};
use snowgrain_render::description::{SceneDescription, SnowDescription};
use snowgrain_render::{CostEstimate, deposit_at};

pub(super) fn run(arguments: &InspectArguments) -> Result<u8, Failure> {
    let files = arguments.report.json_stats.iter().chain(arguments.plot.as_ref().map(|p| &p.path));
    for path in files {
        atomic::check_writable_target(path)?;
    }
    let progress = Progress::new(arguments.report.quiet, arguments.report.verbose);
    let pool = threads::pool(&arguments.machine)?;
    let (field, description) = grains(arguments, &pool, &progress)?;
    if field.is_empty() {
        let name = arguments.scene.scene.display().to_string();
        return Err(Failure::bad_input("it holds no grains").of(&name));
    }
    let extent = match (arguments.period, arguments.block) {
        (Some(period), _) => Extent::Periodic(check_period(period, &field)?),
        (None, true) => Extent::Block,
        (None, false) => description.as_ref().map_or(Extent::Draped, extent_of),
    };
    progress.stage("measuring");
    let structure = pool.install(|| match &description {
        Some(scene) => {
            Structure::of(&field, extent, &lies_on_surface(scene, field.quantisation.quantum()))
        }
        None => Structure::of(&field, extent, &|_| false),
    });
    progress.finish();
    if structure.volume == 0.0 {
        progress.note("the snow is nowhere eight of its largest radii deep: it has no inside");
    }
    let figures = Figures::of(&structure);
    if let Some(file) = &arguments.plot {
        plot::write(file, &plots::charts(&structure))?;
    }
    if let Some(path) = &arguments.report.json_stats {
        output::write_text(path, &output::json(&figures)?)?;
    }
    output::print(&if arguments.json { output::json(&figures)? } else { figures.table() })?;
    Ok(0)
}

/// The grains of a file, or those of a scene with the scene.
fn grains(
    arguments: &InspectArguments,
    pool: &rayon::ThreadPool,
    progress: &Progress,
) -> Result<(GrainField, Option<SceneDescription>), Failure> {
    let path = &arguments.scene.scene;
    let is_ply = path.extension().is_some_and(|e| e.eq_ignore_ascii_case("ply"));
    if is_ply && ply_content(path)? == PlyContent::Grains {
        if !arguments.scene.overrides.is_empty() {
            return Err(Failure::usage("--set is for scenes; a file of grains has no keys"));
        }
        return Ok((read_grains(path)?, None));
    }
    let loaded = load::load(&arguments.scene, Vec::new())?;
    loaded.assumptions.iter().for_each(|line| progress.note(line));
    let description = loaded.description;
    if description.snow.is_empty() {
        return Err(Failure::bad_input("no [[snow]] in the scene; add one").of(&loaded.name));
    }
    if let Some(budget) = Budget::of_this_machine(arguments.machine.max_memory) {
        let cost = CostEstimate::of_fall(&description);
        budget.check(&cost).map_err(|failure| failure.of(&loaded.name))?;
    }
    let level = arguments.machine.simd.unwrap_or_else(SimdLevel::detect);
    let mut stage = |stage| progress.build_stage(stage, &description.snow);
    let (field, _) = pool
        .install(|| deposit_at(&description, level, &mut stage))
        .map_err(|error| Failure::from(error).of(&loaded.name))?;
    Ok((field, Some(description)))
}

/// Where the snow of a scene is measured.
fn extent_of(description: &SceneDescription) -> Extent {
    let is_lattice = |snow: &SnowDescription| matches!(snow, SnowDescription::Lattice(_));
    if description.snow.iter().all(is_lattice) { Extent::Block } else { Extent::Draped }
}

/// # Errors
/// A period that grains cannot have.
fn check_period(period: [f64; 2], field: &GrainField) -> Result<[f64; 2], Failure> {
    let least = 4.0 * f64::from(field.largest_radius_quanta()) * field.quantisation.quantum();
    match period.iter().find(|edge| !(**edge >= least && edge.is_finite())) {
        Some(edge) => Err(Failure::usage(format!(
            "--period: {edge} m is no period for these grains; it must be at least {least} m"
        ))),
        None => Ok(period),
    }
}
