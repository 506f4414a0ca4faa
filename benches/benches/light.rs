//! `cargo bench -p snowgrain-benches --bench light [-- SCENE...] [LEVEL...]`: how fast light travels
//! among grains, per CPU second of one core.
//!
//! Scenes: `sc`, `bcc`, `fcc` (lattices without memory), and `ray`, `stick`, `roll` (1 M grains, or as
//! many as `ray:10000000` says; `compact-ray` packs them compactly; `plate-stick`, `column-stick`, `ball-stick`
//! give them these shapes, the last a sphere that is traced as the shapes are). Levels: `avx512`, `avx2`, `sse4.2`, `sse2`, `neon`; all of this machine
//! where none is named.

use snowgrain_accel::{GrainGrid, Packing, SimdLevel, Surfaces};
use snowgrain_benches::{RADIUS, best_of, cpu_seconds, pile, world};
use snowgrain_geometry::{GrainShape, Quantisation, Shape, ShapeKind};
use snowgrain_grains::{
    DepositRule, FieldShapes, GrainField, LatticeCell, LatticeKind, LatticeSettings, MixedShape,
    Orientation, ShapeMix,
};
use snowgrain_math::sampler::{PathKey, numbers};
use snowgrain_math::{Aabb, DVec3, Ray};
use snowgrain_render::World;
use snowgrain_render::measure::measure_body;
use snowgrain_render::transport::{NewPath, PathResult, PathSource, trace};
use std::sync::Arc;
use std::time::Instant;

/// Paths from all around.
const PATHS: u64 = 200_000;
/// Pixels along an edge of the picture of a deposit, and samples of each.
const PIXELS: u32 = 256;
const SAMPLES: u32 = 4;
/// Pixels along an edge of its tiles.
const TILE: u32 = 32;

/// What is measured where nothing is named.
const SCENES: [&str; 9] =
    ["sc", "bcc", "fcc", "ray", "stick", "roll", "ball-stick", "plate-stick", "column-stick"];

fn main() {
    let named: Vec<String> =
        std::env::args().skip(1).filter(|argument| !argument.starts_with('-')).collect();
    let levels: Vec<SimdLevel> = named.iter().filter_map(|name| name.parse().ok()).collect();
    let levels = if levels.is_empty() { SimdLevel::available() } else { levels };
    let scenes: Vec<&str> = named
        .iter()
        .map(String::as_str)
        .filter(|name| name.parse::<SimdLevel>().is_err())
        .collect();
    let scenes = if scenes.is_empty() { SCENES.to_vec() } else { scenes };
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build().expect("one thread starts");
    pool.install(|| {
        for name in scenes {
            let (world, hull) = scene(name);
            println!(
                "{name:<10} {} grains, {:.1} bytes a grain",
                world.grid.grains(),
                world.grid.memory_bytes() as f64 / world.grid.grains() as f64
            );
            for &level in &levels {
                light_all_around(name, &world, &hull, level);
                light_to_a_picture(name, &world, &hull, level);
            }
        }
    });
}

fn scene(name: &str) -> (World, Aabb) {
    let (name, packing) = match name.strip_prefix("compact-") {
        Some(name) => (name, Packing::Compact),
        None => (name, Packing::Fast),
    };
    let (shape, name) = match name.split_once('-') {
        Some((shape, name)) => (Some(shape), name),
        None => (None, name),
    };
    let (kind, grains) = name.split_once(':').unwrap_or((name, "1000000"));
    let grains = grains.parse().expect("the number of grains is a whole number");
    match kind {
        "sc" => lattice(LatticeKind::Sc, 120),
        "bcc" => lattice(LatticeKind::Bcc, 100),
        "fcc" => lattice(LatticeKind::Fcc, 76),
        "ray" => deposit(DepositRule::Ray, grains, 80.0, (packing, shape)),
        "stick" => deposit(DepositRule::Stick, grains, 200.0, (packing, shape)),
        "roll" => deposit(DepositRule::Roll, grains, 60.0, (packing, shape)),
        other => panic!("no scene is called '{other}'"),
    }
}

fn lattice(kind: LatticeKind, cells: u32) -> (World, Aabb) {
    let settings =
        LatticeSettings { kind, counts: [cells; 3], radius: 0.5, spacing: None, density: None };
    let quantisation = Quantisation::for_grains(DVec3::ZERO, 0.5);
    let cell = LatticeCell::new(&settings, &quantisation).expect("the lattice is legal");
    let packed = snowgrain_accel::LatticeCell {
        side_quanta: cell.side_quanta,
        basis: cell.basis,
        radius_quanta: cell.radius,
    };
    let grid = GrainGrid::lattice(quantisation, &packed, cell.counts, [0; 3], [false; 3])
        .expect("the lattice is legal");
    let hull = grid.bounds();
    (
        World {
            grid,
            surfaces: Surfaces::default(),
            materials: Vec::new(),
            emitters: Vec::new(),
            eta: 1.31,
        },
        hull,
    )
}

/// The grains with a shape, turned at random.
fn shaped(field: GrainField, name: &str) -> GrainField {
    let kind = match name {
        "plate" => ShapeKind::HexagonalPrism { aspect: 0.2, rounding: 0.0 },
        "column" => ShapeKind::HexagonalPrism { aspect: 2.0, rounding: 0.0 },
        "ball" => ShapeKind::Spheroid { aspect: 1.0 },
        other => panic!("no shape is called '{other}'"),
    };
    let shape = Arc::new(Shape::new(kind).expect("the shape is legal"));
    // Blocks hold bounding spheres, for which the quanta must be coarse enough.
    let coarser = shape.bounding_radius();
    let lattice = Quantisation::for_grains(DVec3::ZERO, RADIUS * coarser);
    let grains = field.iter().map(|grain| {
        lattice.round(grain.center, grain.radius).expect("coarser quanta reach farther")
    });
    let field = GrainField::new(lattice, grains.collect());
    let mixed =
        MixedShape { shape: Arc::clone(&shape), orientation: Orientation::Random, fraction: 1.0 };
    let mix = ShapeMix::new(vec![mixed], 0).expect("one shape is a mixture");
    let turned = |grain| GrainShape::new(0, mix.draw(grain).1);
    let of_grains = field.quantised().map(turned).collect();
    field.with_shapes(FieldShapes { prototypes: [Shape::clone(&shape)].into(), of_grains })
}

fn deposit(
    rule: DepositRule,
    grains: u64,
    depth: f64,
    (packing, shape): (Packing, Option<&str>),
) -> (World, Aabb) {
    let (field, _) = pile(rule, grains, depth);
    let field = match shape {
        Some(name) => shaped(field, name),
        None => field,
    };
    for threads in [1, 2] {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
        let pool = pool.expect("threads start");
        let mut wall = f64::INFINITY;
        let (seconds, _) = best_of(3, || {
            let start = Instant::now();
            let world = pool.install(|| world(&field, 1.31, packing));
            wall = wall.min(start.elapsed().as_secs_f64());
            world
        });
        println!(
            "packing    {:8.2} M grains/CPU-s, {:.3} s wall with {threads} threads",
            field.len() as f64 / seconds / 1e6,
            wall
        );
    }
    (world(&field, 1.31, packing), field.bounds())
}

/// Light from all around, each path far from the last: the caches help least.
fn light_all_around(name: &str, world: &World, hull: &Aabb, level: SimdLevel) {
    let (seconds, measure) = cpu_seconds(|| measure_body(world, hull, PATHS, 0, level));
    let counts = [measure.grain_visits.mean, measure.interface_events.mean];
    report(name, "all around", level, PATHS, counts, seconds, measure.trapped_paths);
}

/// Light as a picture asks for it, tile by tile: what is seen obliquely from above through a square
/// of pixels over the middle half of the snow.
fn light_to_a_picture(name: &str, world: &World, hull: &Aabb, level: SimdLevel) {
    let mut source = Tiles { hull, next: 0, visits: 0, events: 0, let_out: 0 };
    let (seconds, ()) = cpu_seconds(|| trace(world, level, &mut source));
    let paths = u64::from(PIXELS * PIXELS * SAMPLES);
    let counts = [source.visits, source.events].map(|count| count as f64 / paths as f64);
    report(name, "picture", level, paths, counts, seconds, source.let_out);
}

fn report(
    name: &str,
    lit: &str,
    level: SimdLevel,
    paths: u64,
    [visits, events]: [f64; 2],
    seconds: f64,
    let_out: u64,
) {
    let rate = paths as f64 / seconds / 1e6;
    println!(
        "{name:<10} {lit:<10} {level:<7} {:7.2} M visits/CPU-s {:7.2} M interfaces/CPU-s {:7.1} visits/path {:7.3} us/path {let_out} let out",
        visits * rate,
        events * rate,
        visits,
        1.0 / rate,
    );
}

struct Tiles<'a> {
    hull: &'a Aabb,
    next: u32,
    visits: u64,
    events: u64,
    let_out: u64,
}

impl PathSource for Tiles<'_> {
    type Tag = ();

    fn next_path(&mut self) -> Option<NewPath<()>> {
        if self.next == PIXELS * PIXELS * SAMPLES {
            return None;
        }
        let (pixel, sample) = (self.next / SAMPLES, self.next % SAMPLES);
        self.next += 1;
        let (tile, within) = (pixel / (TILE * TILE), pixel % (TILE * TILE));
        let tiles = PIXELS / TILE;
        let x = tile % tiles * TILE + within % TILE;
        let z = tile / tiles * TILE + within / TILE;
        let key = PathKey::new(0, u64::from(z * PIXELS + x), u64::from(sample));
        let [u, v, _] = numbers(key, 0).map(f64::from);
        let part =
            |index: u32, jitter: f64| 0.25 + 0.5 * (f64::from(index) + jitter) / f64::from(PIXELS);
        let size = self.hull.size();
        let seen = DVec3::new(
            self.hull.min.x + size.x * part(x, u),
            self.hull.max.y,
            self.hull.min.z + size.z * part(z, v),
        );
        let direction = DVec3::new(-0.48, -0.8, -0.36);
        let ray = Ray::new(seen - direction * size.y, direction);
        Some(NewPath { tag: (), ray, key, event: 1 })
    }

    fn finish(&mut self, (): (), path: &PathResult) {
        self.visits += u64::from(path.grain_visits);
        self.events += u64::from(path.interface_events);
        self.let_out += u64::from(path.releases > 0);
    }
}
