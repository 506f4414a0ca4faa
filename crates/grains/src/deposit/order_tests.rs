//! The grains do not tell how they were made to fall: by how many threads, in which regions.

use super::*;
use crate::{DepositRule, Radii};
use snowgrain_accel::SurfaceShape;
use snowgrain_geometry::teapot;
use snowgrain_math::{DAffine3, DVec3};
use std::sync::Arc;

const R: f64 = 0.5e-3;
const RULES: [DepositRule; 3] = [DepositRule::Ray, DepositRule::Stick, DepositRule::Roll];

/// Grounds as in the test of that name; wide enough for several regions of 32 cells.
#[derive(Clone, Copy, Debug)]
enum Under {
    PeriodicFloor,
    Floor,
    Sphere,
    Mesh,
}

fn surfaces(under: Under) -> Surfaces {
    let plane = (SurfaceShape::Plane, DAffine3::IDENTITY);
    let scaled = |r: f64| DAffine3::from_scale(DVec3::splat(r * R));
    match under {
        Under::PeriodicFloor | Under::Floor => Surfaces::new(&[plane]),
        Under::Sphere => Surfaces::new(&[(SurfaceShape::Sphere, scaled(40.0)), plane]),
        Under::Mesh => {
            Surfaces::new(&[(SurfaceShape::Mesh(Arc::new(teapot(8))), scaled(14.0)), plane])
        }
    }
}

fn settings(rule: DepositRule, grains: u64) -> DepositSettings {
    DepositSettings {
        amount: Amount::Grains(grains),
        radii: Radii::Uniform { mean: R, variation: 0.3 * R },
        density: None,
        rule: Some(rule),
        max_slope_degrees: 75.0,
        direction: DepositSettings::DOWN,
        area: Some([-80.0 * R, -80.0 * R, 80.0 * R, 80.0 * R]),
        seed: 11,
    }
}

/// What lies after two snowfalls on `threads` threads, or, with 0, one drop after another.
fn fallen(under: Under, wanted: &DepositSettings, threads: usize) -> (GrainField, DepositReport) {
    let quantisation = Quantisation::for_grains(DVec3::ZERO, 1.3 * R);
    let surfaces = surfaces(under);
    let mut snow = match under {
        Under::PeriodicFloor => Snowfall::on_level_floor(quantisation, [180.0 * R; 2]).unwrap(),
        _ => Snowfall::on_surfaces(quantisation, &surfaces),
    };
    snow.sequential = threads == 0;
    let pool = rayon::ThreadPoolBuilder::new().num_threads(threads.max(1)).build().unwrap();
    let report = pool.install(|| {
        let again = DepositSettings { amount: Amount::Grains(500), ..wanted.clone() };
        snow.deposit(&again).unwrap();
        snow.deposit(wanted).unwrap()
    });
    (snow.into_field(), report)
}

#[test]
fn any_number_of_threads_gives_the_grains_of_one_drop_after_another() {
    for under in [Under::PeriodicFloor, Under::Floor, Under::Sphere, Under::Mesh] {
        for rule in RULES {
            let grains = if rule == DepositRule::Roll { 6_000 } else { 20_000 };
            let wanted = settings(rule, grains);
            let expected = fallen(under, &wanted, 0);
            for threads in [1, 2, 7] {
                let found = fallen(under, &wanted, threads);
                assert_eq!(found.1, expected.1, "{rule:?} on {under:?}, {threads} threads");
                assert!(found.0 == expected.0, "{rule:?} on {under:?}, {threads} threads");
            }
        }
    }
}

#[test]
fn threads_do_not_show_in_snow_that_the_wind_drives() {
    for under in [Under::PeriodicFloor, Under::Sphere, Under::Mesh] {
        for rule in RULES {
            let grains = if rule == DepositRule::Roll { 4_000 } else { 12_000 };
            let wanted = DepositSettings { direction: [0.7, -1.0, -0.4], ..settings(rule, grains) };
            let expected = fallen(under, &wanted, 0);
            assert!(fallen(under, &wanted, 3) == expected, "{rule:?} on {under:?}");
        }
    }
}

#[test]
fn a_depth_is_reached_with_the_same_grains_by_any_number_of_threads() {
    let deep = DepositSettings { amount: Amount::Depth(6.0 * R), ..settings(DepositRule::Ray, 1) };
    let expected = fallen(Under::PeriodicFloor, &deep, 0);
    assert!(fallen(Under::PeriodicFloor, &deep, 2) == expected);
}

#[test]
fn the_parts_of_a_field_are_its_grains_in_order() {
    let (field, _) = fallen(Under::Floor, &settings(DepositRule::Ray, 20_000), 2);
    let mut walked = Vec::new();
    for part in 0..field.parts() {
        field.part(part, &mut walked);
    }
    assert!(field.parts() > 1 && walked.len() == field.len());
    assert_eq!(walked, field.grains().into_owned());
    let listed = GrainField::new(field.quantisation, walked);
    assert!(listed == field && listed.parts() >= 1);
}
