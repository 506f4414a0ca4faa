//! `snowgrain deposit`.

use crate::arguments::DepositArguments;
use crate::budget::Budget;
use crate::failure::Failure;
use crate::load;
use crate::output;
use crate::process::{self, Stopwatch};
use crate::progress::Progress;
use crate::signals::Interrupts;
use crate::summary::{SnowfallFigures, density_lines, grouped, snowfalls};
use crate::threads;
use serde::Serialize;
use snowgrain_accel::SimdLevel;
use snowgrain_formats::{atomic, write_grains};
use snowgrain_geometry::{Grain, QuantisedGrain};
use snowgrain_grains::measures::Extent;
use snowgrain_grains::{FieldShapes, GrainField, ICE_DENSITY, PackReport};
use snowgrain_render::description::{SceneDescription, SnowDescription};
use snowgrain_render::{CostEstimate, deposit_at, surfaces_of};
use std::sync::Arc;

pub(super) fn run(arguments: &DepositArguments) -> Result<u8, Failure> {
    atomic::check_writable_target(&arguments.output)?;
    if let Some(path) = &arguments.report.json_stats {
        atomic::check_writable_target(path)?;
    }
    let progress = Progress::new(arguments.report.quiet, arguments.report.verbose);
    let interrupts = Interrupts::watch();
    let loaded = load::load(&arguments.scene, Vec::new())?;
    loaded.assumptions.iter().for_each(|line| progress.note(line));
    let description = &loaded.description;
    if description.snow.is_empty() {
        return Err(Failure::bad_input("no [[snow]] in the scene; add one").of(&loaded.name));
    }
    let cost = CostEstimate::of_fall(description);
    if let Some(budget) = Budget::of_this_machine(arguments.machine.max_memory) {
        budget.check(&cost).map_err(|failure| failure.of(&loaded.name))?;
    }
    let pool = threads::pool(&arguments.machine)?;
    let level = arguments.machine.simd.unwrap_or_else(SimdLevel::detect);
    let watch = Stopwatch::start();
    let mut stage = |stage| progress.build_stage(stage, &description.snow);
    let (field, reports) = pool
        .install(|| deposit_at(description, level, &mut stage))
        .map_err(|error| Failure::from(error).of(&loaded.name))?;
    let spent = watch.spent();
    interrupts.while_writing(|| write_grains(&arguments.output, &field))?;
    progress.stage("measuring");
    let lies = lies_on_surface(description, field.quantisation.quantum());
    let (grains, stacks_bytes) = (field.len() as u64, field.bytes() as u64);
    let measured = middle_of(field);
    let pack = PackReport::of(&measured, extent_of(description), &lies);
    let ratio = description.ice.absorption.density_ratio();
    let fallen = snowfalls(&reports, ratio);
    let figures = Figures::new([grains, stacks_bytes], (&pack, ratio), fallen, spent);
    progress.finish();
    figures.lines().iter().for_each(|line| progress.note(line));
    if let Some(path) = &arguments.report.json_stats {
        let text = output::json(&figures)?;
        interrupts.while_writing(|| output::write_text(path, &text))?;
    }
    Ok(0)
}

/// All grains, or, of more than can be measured in little memory and time, those of a rectangle in
/// the middle of the plan.
fn middle_of(field: GrainField) -> GrainField {
    const MOST: f64 = 5e6;
    let part = (MOST / field.len() as f64).sqrt();
    if part >= 1.0 {
        return field;
    }
    let bounds = field.bounds();
    let (center, half) = (bounds.center(), bounds.size() * (0.5 * part));
    let within = |grain: &QuantisedGrain| {
        let offset = (field.quantisation.grain(*grain).center - center).abs();
        offset.x <= half.x && offset.z <= half.z
    };
    let Some(FieldShapes { prototypes, of_grains }) = field.shapes() else {
        return GrainField::new(field.quantisation, field.quantised().filter(within).collect());
    };
    let inside = field.quantised().zip(of_grains).filter(|(grain, _)| within(grain));
    let (grains, of_grains) = inside.map(|(grain, shape)| (grain, *shape)).unzip();
    let shapes = FieldShapes { prototypes: Arc::clone(prototypes), of_grains };
    GrainField::new(field.quantisation, grains).with_shapes(shapes)
}

/// Where the solid fraction of a scene's snow is measured.
fn extent_of(description: &SceneDescription) -> Extent {
    if description.snow.iter().all(|snow| matches!(snow, SnowDescription::Lattice(_))) {
        Extent::Block
    } else {
        Extent::Draped
    }
}

/// Whether a grain touches an object: to a few quanta, since it is rounded to them.
pub(super) fn lies_on_surface(
    description: &SceneDescription,
    quantum: f64,
) -> impl Fn(&Grain) -> bool {
    let surfaces = surfaces_of(description);
    move |grain| {
        let mut touched = Vec::new();
        surfaces.near(grain.center, grain.radius + 3.0 * quantum, &mut touched);
        !touched.is_empty()
    }
}

/// The figures that `--json-stats` holds.
#[derive(Debug, Serialize)]
struct Figures {
    grains: u64,
    /// Memory of the grains after their fall, bytes.
    grain_bytes: u64,
    /// Grains that the figures below were measured on: those in the middle of large packs.
    measured_grains: u64,
    snowfalls: Vec<Option<SnowfallFigures>>,
    accepted: u64,
    discarded: u64,
    missed: u64,
    /// Between 20 and 80 % of the depth that the snow has at each place.
    union_solid_fraction: f64,
    union_solid_fraction_standard_error: f64,
    union_density: f64,
    nominal_solid_fraction: f64,
    contacts_per_grain: f64,
    overlaps_per_grain: f64,
    connected_fraction: f64,
    deposit_seconds: f64,
    deposit_cpu_seconds: f64,
    peak_rss_bytes: Option<u64>,
    version: &'static str,
}

impl Figures {
    fn new(
        [grains, grain_bytes]: [u64; 2],
        (pack, density_ratio): (&PackReport, f64),
        snowfalls: Vec<Option<SnowfallFigures>>,
        spent: process::Spent,
    ) -> Self {
        let sum = |part: fn(&SnowfallFigures) -> u64| snowfalls.iter().flatten().map(part).sum();
        Self {
            grains,
            grain_bytes,
            measured_grains: pack.grains,
            accepted: sum(|fall| fall.accepted),
            discarded: sum(|fall| fall.discarded),
            missed: sum(|fall| fall.missed),
            snowfalls,
            union_solid_fraction: pack.union_solid_fraction.mean,
            union_solid_fraction_standard_error: pack.union_solid_fraction.standard_error,
            union_density: density_ratio * ICE_DENSITY * pack.union_solid_fraction.mean,
            nominal_solid_fraction: pack.nominal_solid_fraction,
            contacts_per_grain: pack.contacts_per_grain,
            overlaps_per_grain: pack.overlaps_per_grain,
            connected_fraction: pack.connected_fraction,
            deposit_seconds: spent.wall,
            deposit_cpu_seconds: spent.cpu,
            peak_rss_bytes: process::peak_memory(),
            version: env!("CARGO_PKG_VERSION"),
        }
    }

    fn lines(&self) -> Vec<String> {
        let mut lines = vec![
            format!(
                "{} grains: {} accepted, {} discarded as too steep, {} fell past everything",
                grouped(self.grains),
                grouped(self.accepted),
                grouped(self.discarded),
                grouped(self.missed),
            ),
            format!(
                "solid fraction {:.4} +- {:.4} (union: {:.1} kg/m3), {:.4} (nominal), between 20 and \
                 80 % of the depth{}",
                self.union_solid_fraction,
                self.union_solid_fraction_standard_error,
                self.union_density,
                self.nominal_solid_fraction,
                if self.measured_grains == self.grains {
                    String::new()
                } else {
                    format!(", of the {} grains in the middle", grouped(self.measured_grains))
                },
            ),
            format!(
                "{:.2} contacts and {:.2} overlaps a grain, {:.2} % hang together with the ground",
                self.contacts_per_grain,
                self.overlaps_per_grain,
                100.0 * self.connected_fraction,
            ),
            format!("{:.2} s ({:.2} s CPU)", self.deposit_seconds, self.deposit_cpu_seconds),
        ];
        lines.extend(density_lines(&self.snowfalls));
        lines
    }
}
