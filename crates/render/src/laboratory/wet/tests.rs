use super::*;
use crate::World;
use crate::measure::measure_slab;
use snowgrain_accel::{GrainGrid, Packing, Surfaces};
use snowgrain_geometry::Quantisation;

const RADIUS: f64 = 0.5e-3;
const DEPTH: f64 = 20.0 * RADIUS;

fn layer() -> WetLayer {
    WetLayer::new(RADIUS, 250.0, DEPTH, 1).unwrap()
}

fn slab(heights: [f64; 2], layer: &WetLayer, paths: u64) -> SlabSettings {
    SlabSettings {
        top: heights[1],
        bottom: heights[0],
        period: layer.periods,
        incidence: measure::Incidence::Lambertian,
        from_below: false,
        absorption_per_metre: 0.0,
        paths,
        seed: 4,
        level: SimdLevel::detect(),
    }
}

/// Reflectance, transmittance, and mean lengths in ice and water, with water of this index.
fn measured(layer: &WetLayer, film: f64, indices: Indices, paths: u64) -> [Estimate; 4] {
    let pack = Coated::new(&layer.grains, layer.periods, film);
    let slab = slab(pack.heights, layer, paths);
    let results: Vec<WetPath> = (0..paths)
        .into_par_iter()
        .map(|number| {
            let start = slab.path(number);
            follow(&pack, indices, start.ray, start.key, start.event)
        })
        .collect();
    let estimate = |value: &dyn Fn(&WetPath) -> f64| {
        let n = paths as f64;
        let mean = results.iter().map(value).sum::<f64>() / n;
        let squares = results.iter().map(|path| value(path) * value(path)).sum::<f64>() / n;
        Estimate { mean, standard_error: ((squares - mean * mean) / n).sqrt() }
    };
    [
        estimate(&|path| f64::from(u8::from(path.reflected))),
        estimate(&|path| f64::from(u8::from(!path.reflected))),
        estimate(&|path| path.ice_length),
        estimate(&|path| path.water_length),
    ]
}

fn assert_same(what: &str, a: Estimate, b: Estimate) {
    let error = (a.standard_error * a.standard_error + b.standard_error * b.standard_error).sqrt();
    assert!((a.mean - b.mean).abs() < 4.0 * error + 1e-12, "{what}: {a:?} {b:?}");
}

/// Grains of another radius at the same places, as the renderer traces them: overlaps are one body.
fn union(layer: &WetLayer, radius: f64, eta: f64, paths: u64) -> [Estimate; 3] {
    let quantisation = Quantisation::for_grains(DVec3::ZERO, radius);
    let grains: Vec<_> = layer
        .grains
        .iter()
        .map(|grain| quantisation.round(grain.center, radius).unwrap())
        .collect();
    // The period must hold whole cells: it is rounded by 1e-4.
    let quanta =
        layer.periods.map(|period| 32 * (period / quantisation.quantum() / 32.0).round() as i64);
    let grid = GrainGrid::build_periodic(quantisation, &grains, quanta, Packing::Fast).unwrap();
    let world = World {
        grid,
        surfaces: Surfaces::default(),
        materials: Vec::new(),
        emitters: Vec::new(),
        eta,
    };
    let out = radius - RADIUS;
    let slab = measure_slab(&world, &slab([-out, DEPTH + out], layer, paths));
    [slab.reflectance, slab.transmittance, slab.ice_path]
}

#[test]
fn dry_snow_is_what_the_renderer_traces() {
    let layer = layer();
    let dry = measured(&layer, 0.0, Indices { ice: 1.31, water: 1.333 }, 20_000);
    let [reflectance, _, ice] = union(&layer, RADIUS, 1.31, 20_000);
    assert_same("R", dry[0], reflectance);
    assert_same("ice", dry[2], ice);
    assert_eq!(dry[3].mean, 0.0);
}

#[test]
fn water_without_index_is_not_seen() {
    let layer = layer();
    let film = layer.film(0.5);
    let clear = measured(&layer, film, Indices { ice: 1.31, water: 1.0 }, 20_000);
    let [reflectance, _, ice] = union(&layer, RADIUS, 1.31, 20_000);
    assert_same("R", clear[0], reflectance);
    assert_same("ice", clear[2], ice);
}

#[test]
fn water_of_the_index_of_ice_makes_larger_grains_that_overlap() {
    let layer = layer();
    for saturation in [0.1, 0.5, 0.9] {
        let film = layer.film(saturation);
        let paths = 10_000;
        let wet = measured(&layer, film, Indices { ice: 1.31, water: 1.31 }, paths);
        let [reflectance, transmittance, ice] = union(&layer, RADIUS + film, 1.31, paths);
        assert_same("R", wet[0], reflectance);
        assert_same("T", wet[1], transmittance);
        let both = Estimate {
            mean: wet[2].mean + wet[3].mean,
            standard_error: wet[2].standard_error + wet[3].standard_error,
        };
        assert_same("ice and water", both, ice);
    }
}

#[test]
fn films_fill_what_they_are_asked_to() {
    let layer = layer();
    assert_eq!(layer.film(0.0), 0.0);
    let films = [0.05, 0.2, 0.5, 0.8, 1.0].map(|saturation| layer.film(saturation));
    assert!(films.windows(2).all(|pair| pair[0] < pair[1]), "{films:?}");
    // The mean length in water of light that nothing turns is the part of the volume it fills.
    let straight = Indices { ice: 1.0, water: 1.0 };
    let [_, _, ice, water] = measured(&layer, layer.film(0.5), straight, 20_000);
    let expected = layer.wetness(0.5);
    let ratio = water.mean / ice.mean;
    assert!((ratio / expected - 1.0).abs() < 0.06, "{ratio} {expected}");
    assert!((layer.effective_radius(0.0) - RADIUS).abs() < 1e-12);
    let radii = [0.02, 0.3, 0.7, 0.95].map(|saturation| layer.effective_radius(saturation));
    assert!(radii.windows(2).all(|pair| pair[0] < pair[1]) && radii[0] < 1.1 * RADIUS, "{radii:?}");
}

#[test]
fn saturated_snow_lets_far_more_light_through() {
    let layer = layer();
    let settings = WetSettings {
        wavelengths_nm: vec![550.0],
        incidence: Incidence::Diffuse,
        ice: IceAbsorption::default(),
        paths: 10_000,
        seed: 2,
    };
    let [dry, damp, saturated] =
        [0.0, 0.05, 1.0].map(|saturation| layer.albedo(saturation, &settings)[0]);
    assert!(
        dry.transmittance.mean < 0.63 && saturated.transmittance.mean > 0.72,
        "{dry:?} {saturated:?}"
    );
    assert!((dry.reflectance.mean - damp.reflectance.mean).abs() < 0.08);
    assert_eq!(layer.albedo(0.05, &settings)[0], damp, "the same bits again");
}
