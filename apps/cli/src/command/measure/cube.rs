//! `snowgrain measure cube`.

use super::Figure;
use super::snow::{self, MeasuredSnow, USUAL_RADIUS};
use crate::arguments::CubeArguments;
use crate::budget::Budget;
use crate::failure::Failure;
use crate::output;
use crate::progress::Progress;
use crate::summary::grouped;
use crate::threads::pool;
use serde::Serialize;
use snowgrain_accel::SimdLevel;
use snowgrain_formats::read_grains;
use snowgrain_render::CostEstimate;
use snowgrain_render::measure::{BodyMeasure, measure_body};

pub(super) fn run(arguments: &CubeArguments) -> Result<u8, Failure> {
    let tracing = &arguments.tracing;
    let progress = Progress::new(tracing.quiet, false);
    let level = tracing.machine.simd.unwrap_or_else(SimdLevel::detect);
    let pool = pool(&tracing.machine)?;
    let snow = snow(arguments)?;
    progress.stage("measuring");
    let measure =
        pool.install(|| measure_body(&snow.world, &snow.hull, tracing.paths, tracing.seed, level));
    progress.finish();
    let figures = Figures::new(&snow, &measure);
    output::print(&if tracing.json { output::json(&figures)? } else { figures.text() })?;
    Ok(0)
}

fn snow(arguments: &CubeArguments) -> Result<MeasuredSnow, Failure> {
    let tracing = &arguments.tracing;
    let radius = tracing.radius.unwrap_or(USUAL_RADIUS);
    match (arguments.lattice, arguments.counts, &arguments.file) {
        (Some(kind), Some(counts), None) => snow::crystal(kind, counts, radius, false, tracing.ior),
        (None, None, Some(path)) => {
            let field = read_grains(path)?;
            if let Some(budget) = Budget::of_this_machine(tracing.machine.max_memory) {
                budget.check(&CostEstimate::of_grains(field.len() as u64))?;
            }
            snow::body(&field, tracing.ior)
                .map_err(|failure| failure.of(&path.display().to_string()))
        }
        _ => Err(Failure::usage("give --lattice with --counts, or --file")),
    }
}

/// What the measure found.
#[derive(Debug, Serialize)]
struct Figures {
    grains: u64,
    grain_surface: f64,
    hull_surface: f64,
    paths: u64,
    missed_paths: u64,
    trapped_paths: u64,
    grain_visits: Figure,
    interface_events: Figure,
    ice_path: Figure,
    upward: Figure,
}

impl Figures {
    fn new(snow: &MeasuredSnow, measure: &BodyMeasure) -> Self {
        let size = snow.hull.size();
        // A convex body's mean projected area is a quarter of its surface.
        let hull_surface = 2.0 * (size.x * size.y + size.y * size.z + size.z * size.x);
        let grain_surface = snow.sums.surface();
        Self {
            grains: snow.sums.grains,
            grain_surface,
            hull_surface,
            paths: measure.paths,
            missed_paths: measure.missed,
            trapped_paths: measure.trapped_paths,
            grain_visits: Figure::of(measure.grain_visits).expecting(grain_surface / hull_surface),
            interface_events: Figure::of(measure.interface_events),
            ice_path: Figure::of(measure.ice_path),
            upward: Figure::of(measure.upward),
        }
    }

    fn text(&self) -> String {
        format!(
            "snow        {} grains, surface {:.6e} m2 in a box of surface {:.6e} m2\n\
             light       from all around, {} paths, {} of them missed every grain, {} trapped\n\
             visits      {}\n\
             events      {}\n\
             ice path    {} m\n\
             upward      {}\n",
            grouped(self.grains),
            self.grain_surface,
            self.hull_surface,
            grouped(self.paths),
            grouped(self.missed_paths),
            self.trapped_paths,
            self.grain_visits.text("grain surface / (4 x mean projected area)"),
            self.interface_events.text(""),
            self.ice_path.text(""),
            self.upward.text(""),
        )
    }
}
