//! What the benchmarks share: time in CPU seconds, and the snow that they measure.
//!
//! Machines are noisy: rates are per CPU second of this process, each the best of a few runs, and
//! figures are compared within one run only.

use snowgrain_accel::{Packing, Surfaces};
use snowgrain_geometry::Quantisation;
use snowgrain_grains::{Amount, DepositRule, DepositSettings, GrainField, Radii, Snowfall};
use snowgrain_math::DVec3;
use snowgrain_render::World;
use std::time::Duration;

/// Seconds that all threads of this process have computed.
fn cpu_now() -> Duration {
    let time = rustix::time::clock_gettime(rustix::time::ClockId::ProcessCPUTime);
    Duration::new(time.tv_sec.unsigned_abs(), u32::try_from(time.tv_nsec).unwrap_or(0))
}

/// CPU seconds that `work` takes, and what it gives.
pub fn cpu_seconds<T>(work: impl FnOnce() -> T) -> (f64, T) {
    let start = cpu_now();
    let result = work();
    ((cpu_now() - start).as_secs_f64(), result)
}

/// Least CPU seconds of `runs` runs of `work`, and what the last gave.
pub fn best_of<T>(runs: u32, mut work: impl FnMut() -> T) -> (f64, T) {
    let (mut best, mut result) = cpu_seconds(&mut work);
    for _ in 1..runs {
        let (seconds, next) = cpu_seconds(&mut work);
        best = best.min(seconds);
        result = next;
    }
    (best, result)
}

/// Radius of the grains of the benchmarks, metres.
pub const RADIUS: f64 = 0.5e-3;

/// A snowfall of equal grains on a level floor that repeats, wide enough that `grains` of them lie
/// `layers` radii deep at the solid fraction of the rule.
///
/// # Panics
/// If the snowfall is refused, which its settings do not allow.
#[must_use]
pub fn pile(rule: DepositRule, grains: u64, layers: f64) -> (GrainField, [f64; 2]) {
    let solid_fraction = match rule {
        DepositRule::Ray => 0.5,
        DepositRule::Stick => 0.15,
        DepositRule::Roll => 0.58,
    };
    let ball = 4.0 / 3.0 * std::f64::consts::PI;
    let width = (grains as f64 * ball / (solid_fraction * layers)).sqrt() * RADIUS;
    let quantisation = Quantisation::for_grains(DVec3::ZERO, RADIUS);
    let mut snowfall =
        Snowfall::on_level_floor(quantisation, [width; 2]).expect("the floor is wide enough");
    let settings = DepositSettings {
        amount: Amount::Grains(grains),
        radii: Radii::Uniform { mean: RADIUS, variation: 0.0 },
        density: None,
        rule: Some(rule),
        max_slope_degrees: 90.0,
        direction: DepositSettings::DOWN,
        area: None,
        seed: 0,
    };
    snowfall.deposit(&settings).expect("grains come to rest on a floor");
    let period = snowfall.period().expect("the floor repeats");
    (snowfall.into_field(), period)
}

/// The grains packed for light, alone.
///
/// # Panics
/// If they cannot be packed.
#[must_use]
pub fn world(field: &GrainField, eta: f64, packing: Packing) -> World {
    let surfaces = Surfaces::default();
    let grid = field.pack(&surfaces, packing).expect("equal grains can be packed");
    World { grid, surfaces, materials: Vec::new(), emitters: Vec::new(), eta }
}
