use super::*;
use crate::measures::{Slab, connections, union_solid_fraction};
use crate::{DepositRule, Radii};
use snowgrain_math::DVec3;

const R: f64 = 0.5e-3;

fn settings(rule: DepositRule, amount: Amount) -> DepositSettings {
    DepositSettings {
        amount,
        radii: Radii { mean: R, variation: 0.0 },
        density: None,
        rule,
        max_slope_degrees: 90.0,
        area: None,
        seed: 3,
    }
}

fn quantisation(largest: f64) -> Quantisation {
    Quantisation::for_grains(DVec3::ZERO, largest)
}

/// A pile of equal grains on a level periodic floor `width` radii wide.
fn pile(rule: DepositRule, width: f64, grains: u64) -> (GrainField, [f64; 2], DepositReport) {
    let mut snow = Snowfall::on_level_floor(quantisation(R), [width * R, width * R]).unwrap();
    let report = snow.deposit(&settings(rule, Amount::Grains(grains))).unwrap();
    let period = snow.period().unwrap();
    (snow.into_field(), period, report)
}

/// Depth in radii and union solid fraction between 20 and 80 % of it.
fn fill((field, period, _): &(GrainField, [f64; 2], DepositReport)) -> (f64, f64) {
    let slab = Slab::between_parts_of_depth(field, Some(*period), [0.2, 0.8]);
    (field.bounds().max.y / R, union_solid_fraction(field, &slab, 300_000, 1).mean)
}

#[test]
fn the_paper_s_rule_fills_as_measured_independently() {
    // PHYSICS: .447 at 39 r, .431 at 82 r, each within .006; sampling error below .001.
    for (grains, depth, expected) in [(61_000, 39.0, 0.447), (128_000, 82.0, 0.431)] {
        let (deep, fraction) = fill(&pile(DepositRule::Ray, 120.0, grains));
        assert!((deep - depth).abs() < 0.05 * depth, "{deep} r deep");
        assert!((fraction - expected).abs() < 0.006, "{fraction} at {deep} r");
    }
}
