//! `snowgrain measure glints`.

use crate::arguments::GlintsArguments;
use crate::budget::Budget;
use crate::failure::Failure;
use crate::load;
use crate::output;
use crate::progress::Progress;
use crate::threads::pool;
use serde::Serialize;
use snowgrain_accel::SimdLevel;
use snowgrain_film::PixelRect;
use snowgrain_render::camera::Camera;
use snowgrain_render::description::{LightKind, SceneDescription};
use snowgrain_render::measure::{GlintKind, GlintMeasure, GlintSun, measure_glints};
use snowgrain_render::{CostEstimate, World, deposit_at, surfaces_of};

pub(super) fn run(arguments: &GlintsArguments) -> Result<u8, Failure> {
    let progress = Progress::new(arguments.quiet, false);
    let loaded = load::load(&arguments.scene, Vec::new())?;
    loaded.assumptions.iter().for_each(|line| progress.note(line));
    let description = &loaded.description;
    let suns = suns_of(description);
    if suns.is_empty() {
        let mend = "there is no sun in this scene to glint: add [[light]] with kind = \"sun\"";
        return Err(Failure::bad_input(mend).of(&loaded.name));
    }
    if !description.has_shapes() {
        let mend = "its grains are spheres, which do not glint: give them [[snow.shapes]]";
        return Err(Failure::bad_input(mend).of(&loaded.name));
    }
    let whole = PixelRect::new(0, 0, description.film.width, description.film.height);
    if let Some(budget) = Budget::of_this_machine(arguments.machine.max_memory) {
        let fits = budget.check(&CostEstimate::of(description, whole));
        fits.map_err(|failure| failure.of(&loaded.name))?;
    }
    let level = arguments.machine.simd.unwrap_or_else(SimdLevel::detect);
    let pool = pool(&arguments.machine)?;
    let measures = pool.install(|| {
        let mut stage = |stage| progress.build_stage(stage, &description.snow);
        let failed = |error| Failure::from(error).of(&loaded.name);
        let (field, _) = deposit_at(description, level, &mut stage).map_err(failed)?;
        let surfaces = surfaces_of(description).with_level(level);
        let packing = description.packing.unwrap_or_default();
        let grid = field.pack(&surfaces, packing).map_err(|error| failed(error.into()))?;
        let eta = description.ice.eta();
        let (materials, emitters) = (Vec::new(), Vec::new());
        let world = World { grid, surfaces, materials, emitters, eta };
        let camera = Camera::new(&description.camera, &description.film);
        progress.stage("measuring");
        let rays = (arguments.rays, description.film.seed);
        let measure = |sun: &GlintSun| {
            Row::new(sun, &measure_glints((&world, &field), &camera, *sun, rays, level))
        };
        Ok::<_, Failure>(suns.iter().map(measure).collect::<Vec<Row>>())
    })?;
    progress.finish();
    let text = if arguments.json { output::json(&measures)? } else { table(&measures) };
    output::print(&text)?;
    Ok(0)
}

fn suns_of(description: &SceneDescription) -> Vec<GlintSun> {
    let suns = description.lights.iter().filter_map(|light| match light.kind {
        LightKind::Sun { direction, diameter_degrees } => {
            Some(GlintSun { direction: direction.normalize(), diameter_degrees })
        }
        _ => None,
    });
    suns.collect()
}

/// The glints of one sun.
#[derive(Debug, Serialize)]
struct Row {
    /// Towards the sun.
    sun: [f64; 3],
    crystals: u64,
    grains_passed_over: u64,
    faces: u64,
    /// Reflected glints of as many faces in all directions alike, and their standard deviation.
    expected: f64,
    expected_deviation: f64,
    glints: Vec<Glints>,
}

/// The glints of one kind.
#[derive(Debug, Serialize)]
struct Glints {
    kind: &'static str,
    made: u64,
    seen: u64,
    /// Mean part of the sun's radiance that a glint shows.
    mean_weight: f64,
}

impl Row {
    fn new(sun: &GlintSun, measure: &GlintMeasure) -> Self {
        let glints = GlintKind::ALL.iter().zip(&measure.counts).map(|(kind, count)| Glints {
            kind: match kind {
                GlintKind::Reflected => "reflected",
                GlintKind::Refracted => "refracted",
                GlintKind::ReflectedWithin => "reflected within",
            },
            made: count.made,
            seen: count.seen,
            mean_weight: count.weight / count.made.max(1) as f64,
        });
        Self {
            sun: sun.direction.to_array(),
            crystals: measure.crystals,
            grains_passed_over: measure.passed_over,
            faces: measure.faces,
            expected: measure.expected,
            expected_deviation: measure.expected.sqrt(),
            glints: glints.collect(),
        }
    }
}

fn table(rows: &[Row]) -> String {
    let mut text = String::new();
    for row in rows {
        let [x, y, z] = row.sun;
        text += &format!(
            "sun towards ({x:.3}, {y:.3}, {z:.3}): {} crystals with {} faces, {} other grains\n",
            row.crystals, row.faces, row.grains_passed_over
        );
        for Glints { kind, made, seen, mean_weight } in &row.glints {
            let expected = match *kind {
                "reflected" => {
                    format!(", {:.1} +- {:.1} expected", row.expected, row.expected_deviation)
                }
                _ => String::new(),
            };
            text += &format!(
                "  {kind:16}  {made} made{expected}, {seen} seen, each {mean_weight:.4} of the sun\n"
            );
        }
    }
    text
}
