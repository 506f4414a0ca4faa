//! What light does in a medium, against what it must do.

use super::*;
use crate::measure::{
    Estimate, PackedSlab, SlabMeasure, SlabSettings, calibrate_proxy, measure_slab,
    measure_slab_in_depth, measure_slab_in_medium,
};
use snowgrain_geometry::ShapeKind;
use snowgrain_grains::{MixedShape, Orientation, PackSettings, Radii};
use snowgrain_optics::{Dielectric, sphere};
use std::sync::Arc;

/// Radius of the grains, metres.
const RADIUS: f64 = 0.5e-3;
const ETA: f64 = 1.31;

fn slab(density: f64, depth_radii: f64, paths: u64) -> PackedSlab {
    slab_of((Radii::equal(RADIUS), None), ETA, (density, depth_radii, paths))
}

fn slab_of(
    (radii, mix): (Radii, Option<&ShapeMix>),
    eta: f64,
    (density, depth_radii, paths): (f64, f64, u64),
) -> PackedSlab {
    let pack = PackSettings { radii, density, seed: 3 };
    PackedSlab::new((&pack, mix), (depth_radii * RADIUS, eta), (paths, 5)).unwrap()
}

fn mix_of(kinds: &[ShapeKind]) -> ShapeMix {
    mix_that_lies(kinds, Orientation::Random)
}

fn mix_that_lies(kinds: &[ShapeKind], orientation: Orientation) -> ShapeMix {
    let mixed = |kind: &ShapeKind| MixedShape {
        shape: Arc::new(Shape::new(*kind).unwrap()),
        orientation,
        fraction: 1.0,
    };
    ShapeMix::new(kinds.iter().map(mixed).collect(), 4).unwrap()
}

/// A medium of the grains of a slab, with the calibration that they need.
fn medium_of(slab: &PackedSlab, kind: MediumKind) -> Medium {
    let medium = Medium::in_the_dark(kind, (&slab.world, &slab.prototypes)).unwrap();
    match medium.inner_snow(None).unwrap().filter(|snow| !snow.is_known()) {
        None => medium,
        Some(snow) => {
            let measured = calibrate_proxy(&snow, 1 << 15).unwrap();
            medium.calibrated(&Calibration::table_through(measured))
        }
    }
}

fn in_medium(slab: &PackedSlab, kind: MediumKind, settings: &SlabSettings) -> SlabMeasure {
    measure_slab_in_medium(&slab.world, &medium_of(slab, kind), settings)
}

/// By chance once in 16 000, where the systematic part is nothing.
fn assert_within(what: &str, found: Estimate, expected: f64, part: f64) {
    let off = (found.mean - expected).abs();
    let allowed = part * expected + 4.0 * found.standard_error;
    assert!(off <= allowed, "{what}: {found:?} instead of {expected}");
}

/// Grains visited are 2 tau, and the ice of each 4/3 B r on average (exact for any packing): within 1 %.
fn assert_visits(what: &str, slab: &PackedSlab, found: &SlabMeasure) {
    let ice_of_visit = 4.0 / 3.0 * sphere::absorption_enhancement(Dielectric { eta: ETA }) * RADIUS;
    assert_within(what, found.grain_visits, 2.0 * slab.tau, 0.01);
    assert_within(what, found.ice_path, 2.0 * slab.tau * ice_of_visit, 0.01);
}

#[test]
fn the_proxy_visits_as_many_grains_and_travels_as_far_in_ice() {
    for density in [150.0, 275.0, 400.0, 500.0] {
        let slab = slab(density, 50.0, 1 << 16);
        let found = in_medium(&slab, MediumKind::Proxy, &slab.settings);
        assert_visits(&format!("{density} kg/m^3"), &slab, &found);
    }
}

/// So does light that is followed exactly but where it is deep, grain by grain or over spheres; none is lost.
#[test]
fn light_that_is_deep_visits_as_many_grains_and_travels_as_far_in_ice() {
    let slab = slab(400.0, 110.0, 1 << 16);
    let exact = measure_slab(&slab.world, &slab.settings);
    let [by_grain, over_spheres] = [false, true].map(|jumps| {
        let start = ProxyStart { after_grains: 4, depth: 0.5, jumps };
        let world = (&slab.world, &*slab.prototypes);
        let proxy = ProxyInDepth::in_the_dark(world, &start, &CALIBRATION).unwrap();
        let found = measure_slab_in_depth(&slab.world, &proxy, &slab.settings);
        assert_visits(&format!("jumps: {jumps}"), &slab, &found);
        assert_through(&exact, &found);
        found
    });
    assert_ne!(by_grain, over_spheres, "no sphere had room");
}

fn variance(of: Estimate) -> f64 {
    of.standard_error * of.standard_error
}

/// As much light comes through as through the grains, within 1 % of all light; nothing is lost.
fn assert_through(exact: &SlabMeasure, found: &SlabMeasure) {
    let all = found.reflectance.mean + found.transmittance.mean;
    assert!((all - 1.0).abs() < 1e-12, "{all}");
    let [a, b] = [exact.transmittance, found.transmittance];
    let error = (variance(a) + variance(b)).sqrt();
    assert!((a.mean - b.mean).abs() < 0.01 + 4.0 * error, "{a:?} {b:?}");
}

#[test]
fn the_proxy_lets_as_much_light_through() {
    for density in [275.0, 500.0] {
        let slab = slab(density, 50.0, 1 << 15);
        let exact = measure_slab(&slab.world, &slab.settings);
        let found = in_medium(&slab, MediumKind::Proxy, &slab.settings);
        assert_through(&exact, &found);
    }
}

/// The medium of a floor of snow holds the area of its grains, and half of a ball that lies in the floor is given back.
#[test]
fn the_density_holds_all_grains() {
    let slab = slab(275.0, 30.0, 1);
    let composition = Composition::new(&slab.world.grid, &[]);
    let surfaces = (&slab.world.surfaces, &[][..]);
    let density = Density::new(&slab.world.grid, &composition, surfaces).unwrap();
    let volume = density.nodes().map(|matter| matter.area).sum::<f64>() * density.volume_of_cell();
    let period = slab.settings.period;
    let area = volume / (period[0] * period[1]);
    assert!((area / slab.tau - 1.0).abs() < 5e-4, "{area} {}", slab.tau);
    let radius = density.nodes().map(|matter| matter.radius).fold(0.0, f64::max);
    assert!((radius / RADIUS - 1.0).abs() < 1e-3, "{radius}");
}

/// Paths are functions of their numbers: the same by any number of threads.
#[test]
fn threads_do_not_show() {
    let slab = slab(275.0, 20.0, 1 << 15);
    let on = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| in_medium(&slab, MediumKind::Proxy, &slab.settings))
    };
    assert_eq!(on(1), on(3));
}

/// Other grains than equal spheres of ice: shapes that reach into each other, mixed sizes, other indices. They visit as many grains and
/// travel as far in ice as exact light, within 1 %, and with the calibration that is measured before a picture as much comes through.
#[test]
fn other_grains_visit_travel_and_let_through_as_much() {
    let plate = ShapeKind::HexagonalPrism { aspect: 0.3, rounding: 0.2 };
    let column = ShapeKind::HexagonalPrism { aspect: 2.5, rounding: 0.0 };
    let cube = ShapeKind::Cube { rounding: 0.5 };
    let level = mix_that_lies(&[plate], Orientation::Horizontal { spread_degrees: 5.0 });
    let spread = Radii::Uniform { mean: RADIUS, variation: 0.6 * RADIUS };
    let cases = [
        ("plates and columns", Radii::equal(RADIUS), Some(mix_of(&[plate, column])), ETA),
        ("plates that lie level", Radii::equal(RADIUS), Some(level), ETA),
        ("mixed spheres", spread.clone(), None, ETA),
        ("salt", spread, Some(mix_of(&[cube])), 1.544),
    ];
    for (what, radii, mix, eta) in cases {
        let slab = slab_of((radii, mix.as_ref()), eta, (250.0, 40.0, 1 << 15));
        let exact = measure_slab(&slab.world, &slab.settings);
        let found = in_medium(&slab, MediumKind::Proxy, &slab.settings);
        assert_like(&format!("{what}: visits"), found.grain_visits, exact.grain_visits);
        assert_like(&format!("{what}: ice"), found.ice_path, exact.ice_path);
        assert_through(&exact, &found);
    }
}

/// Within 1 % and four standard errors of both.
fn assert_like(what: &str, found: Estimate, exact: Estimate) {
    let error = (variance(found) + variance(exact)).sqrt();
    let both = Estimate { standard_error: error, ..found };
    assert_within(what, both, exact.mean, 0.01);
}
