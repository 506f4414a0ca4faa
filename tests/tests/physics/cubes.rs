//! Cubes of the simple cubic lattice: what independent tracers found for them.

use crate::{assert_agrees, lattice, samples};
use snowgrain_accel::SimdLevel;
use snowgrain_film::{Layer, Picture, PixelRect};
use snowgrain_grains::{LatticeKind, LatticeSettings};
use snowgrain_math::{Aabb, DVec3};
use snowgrain_render::Strata;
use snowgrain_render::camera::Camera;
use snowgrain_render::description::{
    CameraDescription, FilmDescription, IceDescription, IntegratorKind, LightDescription,
    LightFinding, LightKind, Projection, SceneDescription, SnowDescription,
};
use snowgrain_render::measure::{Estimate, measure_body};
use snowgrain_render::{RenderControl, RenderSettings, Rendered, Scene, render};
use snowgrain_tests::reference::CUBE_RADIANCE;
use std::ops::Range;
use std::sync::atomic::{AtomicBool, AtomicU64};

/// The cube of `side`^3 grains of radius 1/2 under a sky of radiance 1, black below, seen from
/// `distance` sides away along `direction`, `pixels`^2.
pub(crate) fn cube(side: u32, direction: DVec3, distance: f64, pixels: u32) -> SceneDescription {
    let center = DVec3::splat(0.5 * f64::from(side));
    SceneDescription {
        film: FilmDescription::new(pixels, pixels, 1, 7),
        camera: CameraDescription {
            from: center + direction.normalize() * (distance * f64::from(side)),
            at: center,
            up: DVec3::Y,
            projection: Projection::pinhole(40.0),
            backdrop: [0.0; 3],
        },
        ice: IceDescription::clear(crate::ETA),
        lights: vec![LightDescription::new(LightKind::Sky, [1.0; 3])],
        objects: Vec::new(),
        snow: vec![SnowDescription::Lattice(LatticeSettings {
            kind: LatticeKind::Sc,
            counts: [side; 3],
            radius: 0.5,
            spacing: None,
            density: None,
        })],
        strata: Strata::default(),
        integrator: IntegratorKind::Grains,
        shapes: Vec::new(),
        light_finding: LightFinding::Exact,
        deep: None,
        packing: None,
        tiled: None,
    }
}

/// The direction of the camera of the benchmark, 35 degrees above the horizon.
pub(crate) const BENCHMARK_VIEW: DVec3 = DVec3::new(1.0, 0.9, 0.8);

/// Renders these samples of a scene.
pub(crate) fn picture(scene: &Scene, samples: Range<u64>, crop: PixelRect) -> Rendered {
    let (stop, samples_done) = (AtomicBool::new(false), AtomicU64::new(0));
    let settings = RenderSettings { samples, crop, level: SimdLevel::detect() };
    let control = RenderControl { stop: &stop, samples_done: &samples_done, after_pass: &|_| () };
    render(scene, &settings, &control).unwrap()
}

/// The pixels whose four corner rays all meet the box.
fn pixels_on(hull: &Aabb, camera: &Camera, pixels: u32) -> Vec<(u32, u32)> {
    let meets = |x: u32, y: u32| {
        hull.intersect(&camera.ray(f64::from(x), f64::from(y), [0.5; 2])).is_some()
    };
    (0..pixels)
        .flat_map(|y| (0..pixels).map(move |x| (x, y)))
        .filter(|&(x, y)| meets(x, y) && meets(x + 1, y) && meets(x, y + 1) && meets(x + 1, y + 1))
        .collect()
}

/// Mean radiance of some pixels whose samples are 0 or 1.
fn mean_of(red: &[f32], crop: PixelRect, pixels: &[(u32, u32)], samples: u64) -> Estimate {
    let value = |&(x, y): &(u32, u32)| f64::from(red[crop.index(x, y).unwrap()]);
    let mean = pixels.iter().map(value).sum::<f64>() / pixels.len() as f64;
    let count = pixels.len() as f64 * samples as f64;
    Estimate { mean, standard_error: (mean * (1.0 - mean) / count).sqrt() }
}

#[test]
fn cubes_under_the_sky_have_the_radiance_that_an_independent_walker_found() {
    const PIXELS: u32 = 256;
    for ((side, interior_mean, hull_mean), spp) in
        CUBE_RADIANCE.into_iter().zip([samples(60, 400), samples(24, 150), samples(8, 60)])
    {
        let scene = Scene::build(&cube(side, BENCHMARK_VIEW, 2.6, PIXELS), &mut |_| ()).unwrap();
        let edge = f64::from(side);
        let core = Aabb::new(DVec3::ONE, DVec3::splat(edge - 1.0));
        let interior = pixels_on(&core, &scene.camera, PIXELS);
        let hull = Aabb::new(DVec3::ZERO, DVec3::splat(edge));
        let hull = pixels_on(&hull, &scene.camera, PIXELS);
        let (columns, rows): (Vec<u32>, Vec<u32>) = hull.iter().copied().unzip();
        let bound = |of: &[u32]| (*of.iter().min().unwrap(), *of.iter().max().unwrap() + 1);
        let ((x0, x1), (y0, y1)) = (bound(&columns), bound(&rows));
        let crop = PixelRect::new(x0, y0, x1, y1);

        let rendered = picture(&scene, 0..spp, crop);
        assert_eq!(rendered.statistics.trapped_paths, 0);
        let developed = Picture::from_film(&rendered.film).unwrap();
        let red = developed.layer(Layer::R).unwrap();
        let inner = mean_of(red, crop, &interior, spp);
        let whole = mean_of(red, crop, &hull, spp);
        println!("cube {side}: interior {inner:?}, hull {whole:?}");
        assert_agrees("interior", inner, interior_mean, 0.0005);
        // Given to three decimals, of which the last is not sure.
        assert_agrees("hull", whole, hull_mean, 0.0015);
    }
}

/// Visits = (total grain surface)/(4 x mean projected area of the hull) = pi N/6.
#[test]
fn a_cube_lit_all_around_is_visited_pi_n_over_six_times() {
    for side in [32, 120] {
        let world = lattice(LatticeKind::Sc, [side; 3], [false; 3]);
        let hull = Aabb::new(DVec3::ZERO, DVec3::splat(f64::from(side)));
        let paths = samples(10_000_000 / u64::from(side), 200_000_000 / u64::from(side));
        let measure = measure_body(&world, &hull, paths, 8, SimdLevel::detect());
        let expected = core::f64::consts::PI / 6.0 * f64::from(side);
        println!("cube {side} lit all around: {:?} visits", measure.grain_visits);
        assert_agrees("visits", measure.grain_visits, expected, 1e-4 * expected);
        assert!((measure.grain_visits.mean / expected - 1.0).abs() < 0.01);
        assert_agrees("events", measure.interface_events, 2.0 * expected, 2e-4 * expected);
        assert_agrees("upward", measure.upward, 0.5, 0.0);
        assert_eq!(measure.trapped_paths, 0);
    }
}
