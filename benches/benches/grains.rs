//! `cargo bench -p snowgrain-benches --bench grains [-- FILTER]`: how fast grains fall, how much
//! memory they take, and how fast light travels among them, per CPU second of one core.

use snowgrain_accel::{GrainGrid, Packing, SimdLevel, Surfaces};
use snowgrain_benches::{best_of, cpu_seconds, pile, world};
use snowgrain_geometry::Quantisation;
use snowgrain_grains::{DepositRule, GrainField, LatticeCell, LatticeKind, LatticeSettings};
use snowgrain_math::{Aabb, DVec3};
use snowgrain_render::World;
use snowgrain_render::measure::{BodyMeasure, measure_body};

const GRAINS: u64 = 1_000_000;
const PATHS: u64 = 100_000;

fn main() {
    let filter = std::env::args().skip(1).find(|argument| !argument.starts_with('-'));
    let wanted = |name: &str| filter.as_ref().is_none_or(|filter| name.contains(filter.as_str()));
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build().expect("one thread starts");
    pool.install(|| {
        if wanted("lattice") {
            lattice();
        }
        for (name, rule, depth) in [
            ("ray", DepositRule::Ray, 80.0),
            ("stick", DepositRule::Stick, 200.0),
            ("roll", DepositRule::Roll, 60.0),
        ] {
            if wanted(name) {
                deposit(name, rule, depth);
            }
        }
    });
}

/// The simple cubic cube of 120 grains an edge, which needs no memory.
fn lattice() {
    let settings = LatticeSettings {
        kind: LatticeKind::Sc,
        counts: [120; 3],
        radius: 0.5,
        spacing: None,
        density: None,
    };
    let quantisation = Quantisation::for_grains(DVec3::ZERO, 0.5);
    let cell = LatticeCell::new(&settings, &quantisation).expect("the lattice is legal");
    let packed = snowgrain_accel::LatticeCell {
        side_quanta: cell.side_quanta,
        basis: cell.basis,
        radius_quanta: cell.radius,
    };
    let grid = GrainGrid::lattice(quantisation, &packed, cell.counts, [0; 3], [false; 3])
        .expect("the lattice is legal");
    let world = World { grid, surfaces: Surfaces::default(), albedos: Vec::new(), eta: 1.31 };
    let hull = Aabb::new(DVec3::ZERO, DVec3::splat(120.0));
    light("sc cube 120^3, implicit", &world, &hull);
}

/// A pile of the rule: its fall, its packing, its memory, the light in it.
fn deposit(name: &str, rule: DepositRule, depth: f64) {
    let runs = if rule == DepositRule::Roll { 1 } else { 3 };
    let (seconds, (field, _)) = best_of(runs, || pile(rule, GRAINS, depth));
    println!(
        "{name:<28} fall          {:8.2} M grains/CPU-s  ({seconds:.2} CPU-s for {} grains)",
        field.len() as f64 / seconds / 1e6,
        field.len(),
    );
    let (seconds, world) = best_of(2, || world(&field, 1.31, Packing::Fast));
    println!(
        "{name:<28} packing       {:8.2} M grains/CPU-s  {:.1} bytes a grain",
        field.len() as f64 / seconds / 1e6,
        world.grid.memory_bytes() as f64 / field.len() as f64,
    );
    light(name, &world, &hull(&field));
}

fn hull(field: &GrainField) -> Aabb {
    field.bounds()
}

/// Light from all around a body, at every SIMD level of this machine.
fn light(name: &str, world: &World, hull: &Aabb) {
    for level in SimdLevel::available() {
        let (seconds, measure) =
            cpu_seconds(|| -> BodyMeasure { measure_body(world, hull, PATHS, 0, level) });
        let visits = measure.grain_visits.mean * PATHS as f64;
        let events = measure.interface_events.mean * PATHS as f64;
        println!(
            "{name:<28} light {level:<7} {:8.2} M visits/CPU-s  {:.2} M interfaces/CPU-s  {} let out",
            visits / seconds / 1e6,
            events / seconds / 1e6,
            measure.trapped_paths,
        );
    }
}
