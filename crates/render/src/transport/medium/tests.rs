//! What light does in a medium, against what it must do.

use super::*;
use crate::measure::{
    Estimate, PackedSlab, SlabMeasure, SlabSettings, measure_slab, measure_slab_in_depth,
    measure_slab_in_medium,
};
use snowgrain_grains::{PackSettings, Radii};
use snowgrain_optics::{Dielectric, sphere};

/// Radius of the grains, metres.
const RADIUS: f64 = 0.5e-3;
const ETA: f64 = 1.31;

fn slab(density: f64, depth_radii: f64, paths: u64) -> PackedSlab {
    let radii = Radii::Uniform { mean: RADIUS, variation: 0.0 };
    let pack = PackSettings { radii, density, seed: 3 };
    PackedSlab::new(&pack, (depth_radii * RADIUS, ETA), (paths, 5)).unwrap()
}

fn in_medium(slab: &PackedSlab, kind: MediumKind, settings: &SlabSettings) -> SlabMeasure {
    let medium = Medium::in_the_dark(kind, &slab.world, &CALIBRATION).unwrap();
    measure_slab_in_medium(&slab.world, &medium, settings)
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
        let proxy = ProxyInDepth::in_the_dark(&slab.world, &start).unwrap();
        let found = measure_slab_in_depth(&slab.world, &proxy, &slab.settings);
        assert_visits(&format!("jumps: {jumps}"), &slab, &found);
        assert_through(&exact, &found);
        found
    });
    assert_ne!(by_grain, over_spheres, "no sphere had room");
}

/// As much light comes through as through the grains, within 1 % of all light; nothing is lost.
fn assert_through(exact: &SlabMeasure, found: &SlabMeasure) {
    let all = found.reflectance.mean + found.transmittance.mean;
    assert!((all - 1.0).abs() < 1e-12, "{all}");
    let [a, b] = [exact.transmittance, found.transmittance];
    let variance = |of: Estimate| of.standard_error * of.standard_error;
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
    let density = Density::new(&slab.world.grid, &slab.world.surfaces, &[]).unwrap();
    let volume = density.nodes().map(|matter| matter.area).sum::<f64>() * density.volume_of_cell();
    let period = slab.settings.period;
    let area = volume / (period[0] * period[1]);
    assert!((area / slab.tau - 1.0).abs() < 1e-5, "{area} {}", slab.tau);
    let radius = density.nodes().map(density::Matter::radius).fold(0.0, f64::max);
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
