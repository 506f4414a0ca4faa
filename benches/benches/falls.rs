//! `cargo bench -p snowgrain-benches --bench falls [-- FILTER...]`: how fast grains fall, per CPU
//! second, and the memory that they take while they do.
//!
//! Lines are named by rule, ground and number of grains; those that hold every FILTER are run. Falls
//! of 10^8 grains take two gigabytes and a minute each, so they run only where a filter says `1e8`.

use snowgrain_accel::{SurfaceShape, Surfaces};
use snowgrain_benches::{RADIUS, cpu_seconds};
use snowgrain_geometry::{Quantisation, teapot};
use snowgrain_grains::{Amount, DepositRule, DepositSettings, Radii, Snowfall};
use snowgrain_math::{DAffine3, DVec3};
use std::sync::Arc;
use std::time::Instant;

const RULES: [(&str, DepositRule, f64); 3] = [
    ("ray", DepositRule::Ray, 0.5 * 80.0),
    ("stick", DepositRule::Stick, 0.15 * 200.0),
    ("roll", DepositRule::Roll, 0.58 * 60.0),
];
const SIZES: [(&str, u64); 4] =
    [("1e5", 100_000), ("1e6", 1_000_000), ("1e7", 10_000_000), ("1e8", 100_000_000)];

/// What grains fall on.
#[derive(Clone, Copy)]
enum Ground {
    Floor,
    Sphere,
    Teapot,
}

struct Filters(Vec<String>);

impl Filters {
    fn want(&self, name: &str) -> bool {
        self.0.iter().all(|filter| name.contains(filter.as_str()))
    }
}

fn main() {
    let filters = Filters(std::env::args().skip(1).filter(|a| !a.starts_with('-')).collect());
    for (rule_name, rule, filled) in RULES {
        for (ground_name, ground) in
            [("floor", Ground::Floor), ("sphere", Ground::Sphere), ("teapot", Ground::Teapot)]
        {
            for (size_name, grains) in SIZES {
                let name = format!("{rule_name} {ground_name} {size_name}");
                let large = size_name == "1e8" || (rule_name, size_name) == ("roll", "1e7");
                let asked = filters.0.iter().any(|filter| filter == size_name);
                if filters.want(&name) && (!large || asked) {
                    for threads in [1, 2] {
                        let fall = Falls { rule, ground, filled, wind: false, radii: EQUAL };
                        fall.report(&name, grains, threads);
                    }
                }
            }
        }
    }
    variants(&filters);
}

const EQUAL: Radii = Radii::Uniform { mean: RADIUS, variation: 0.0 };
const WIDE: Radii = Radii::Uniform { mean: RADIUS, variation: RADIUS };

/// Wind, wide radii, and fine snow on coarse.
fn variants(filters: &Filters) {
    for (name, rule, filled) in &RULES {
        let wanted = |variant: &str| filters.want(&format!("{name} {variant}"));
        let fall = |wind, radii| Falls {
            rule: *rule,
            ground: Ground::Floor,
            filled: *filled,
            wind,
            radii,
        };
        if *rule != DepositRule::Roll && wanted("wind") {
            fall(true, EQUAL).report(&format!("{name} wind 1e6"), 1_000_000, 1);
        }
        if wanted("wide radii") {
            fall(false, WIDE).report(&format!("{name} wide radii 1e6"), 1_000_000, 1);
        }
        if wanted("100:1") {
            hundred_to_one(name, *rule);
        }
    }
}

/// Falls of one rule on one ground.
struct Falls {
    rule: DepositRule,
    ground: Ground,
    /// Solid fraction times depth in radii.
    filled: f64,
    wind: bool,
    radii: Radii,
}

impl Falls {
    fn report(&self, name: &str, grains: u64, threads: usize) {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
        let runs = (3_000_000 / grains).clamp(1, 3);
        let mut best = (f64::INFINITY, 0.0, 0.0);
        for _ in 0..runs {
            let run = pool.as_ref().expect("threads start").install(|| self.run(grains));
            if run.0 < best.0 {
                best = run;
            }
        }
        let (cpu, wall, bytes) = best;
        println!(
            "{name:<24} {threads} threads  {:7.3} M grains/CPU-s  {:7.3} M grains/s  {bytes:5.1} bytes a grain",
            grains as f64 / cpu / 1e6,
            grains as f64 / wall / 1e6,
        );
    }

    /// CPU seconds, seconds, bytes a grain.
    fn run(&self, grains: u64) -> (f64, f64, f64) {
        let volume = 4.0 / 3.0 * std::f64::consts::PI * self.radii.mean_cube();
        let width = (grains as f64 * volume / (self.filled * RADIUS)).sqrt();
        let quantisation = Quantisation::for_grains(DVec3::ZERO, self.radii.largest());
        let surfaces = surfaces(self.ground, width);
        let settings = DepositSettings {
            amount: Amount::Grains(grains),
            radii: self.radii.clone(),
            density: None,
            rule: Some(self.rule),
            max_slope_degrees: 90.0,
            direction: if self.wind { [0.5, -1.0, 0.2] } else { DepositSettings::DOWN },
            area: Some([-0.5 * width, -0.5 * width, 0.5 * width, 0.5 * width]),
            seed: 0,
        };
        let mut snow = match &surfaces {
            Some(surfaces) => Snowfall::on_surfaces(quantisation, surfaces),
            None => Snowfall::on_level_floor(quantisation, [width; 2]).expect("it is wide"),
        };
        let start = Instant::now();
        let (cpu, _) = cpu_seconds(|| snow.deposit(&settings).expect("grains come to rest"));
        (cpu, start.elapsed().as_secs_f64(), snow.bytes() as f64 / grains as f64)
    }
}

/// A plane with something that stands on half of the width; `None` for a floor that repeats.
fn surfaces(ground: Ground, width: f64) -> Option<Surfaces> {
    let (shape, scale) = match ground {
        Ground::Floor => return None,
        Ground::Sphere => (SurfaceShape::Sphere, 0.25 * width),
        Ground::Teapot => (SurfaceShape::Mesh(Arc::new(teapot(32))), 0.1 * width),
    };
    let object = (shape, DAffine3::from_scale(DVec3::splat(scale)));
    Some(Surfaces::new(&[object, (SurfaceShape::Plane, DAffine3::IDENTITY)]))
}

/// A layer of grains a hundred times larger, snow on them, and large ones on that snow.
fn hundred_to_one(name: &str, rule: DepositRule) {
    let coarse = Radii::Uniform { mean: 100.0 * RADIUS, variation: 0.0 };
    let width = 1000.0 * RADIUS;
    let quantisation = Quantisation::for_grains(DVec3::ZERO, coarse.mean());
    let mut snow = Snowfall::on_level_floor(quantisation, [width; 2]).expect("it is wide");
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build().expect("a thread starts");
    for (part, radii, grains) in [
        ("coarse", coarse.clone(), 50),
        ("fine on coarse", EQUAL, 1_000_000),
        ("coarse on fine", coarse, 50),
    ] {
        let settings = DepositSettings {
            amount: Amount::Grains(grains),
            radii,
            density: None,
            rule: Some(rule),
            max_slope_degrees: 90.0,
            direction: DepositSettings::DOWN,
            area: None,
            seed: 0,
        };
        let (cpu, _) =
            pool.install(|| cpu_seconds(|| snow.deposit(&settings).expect("grains come to rest")));
        println!(
            "{:<24} {grains} grains in {:.3} CPU-s, {:.2} us a grain",
            format!("{name} 100:1 {part}"),
            cpu,
            cpu / grains as f64 * 1e6
        );
    }
}
