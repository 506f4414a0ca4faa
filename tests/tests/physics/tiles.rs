//! Light in snow whose tiles are kept once, against the identities of packed grains and against snow that is listed.

use crate::cubes::picture;
use crate::sun::scene;
use crate::{SIGMAS, samples};
use snowgrain_accel::SimdLevel;
use snowgrain_film::{Film, PixelRect};
use snowgrain_math::DVec3;
use snowgrain_render::Scene;
use snowgrain_render::measure::{Estimate, measure_body};

/// More than one tile along x and z, cut across on all sides, over ground.
const SNOW: &str = r#"
version = 1
[film]
width = 24
height = 24
[camera]
from = [0.03, 0.12, 0.14]
at = [0.03, 0.02, 0.03]
vertical_fov = 30.0
[[light]]
kind = "overcast"
[[object]]
shape = "plane"
translate = [0, 0.004, 0]
albedo = 0.5
[[snow]]
source = "pack"
box = [0, 0, 0, 0.061, 0.023, 0.055]
radius = "0.4 mm"
density = 275
"#;

fn film(scene: &Scene, samples: u64) -> Film {
    let whole = PixelRect::new(0, 0, scene.film.width, scene.film.height);
    picture(scene, 0..samples, whole).film
}

fn green(film: &Film) -> Estimate {
    let count = film.pixels().len() as f64;
    let variance: f64 = film.pixels().iter().map(|pixel| pixel.variance_of_mean()[1]).sum();
    Estimate {
        mean: film.pixels().iter().map(|pixel| pixel.mean_radiance()[1]).sum::<f64>() / count,
        standard_error: variance.sqrt() / count,
    }
}

/// Two packs of one recipe differ by less than half a percent here.
#[test]
fn tiled_snow_is_as_bright_as_listed_snow() {
    let [tiled, listed] = ["true", "false"].map(|tiled| {
        let scene = scene(SNOW, &[&format!("integrator.tiled={tiled}")]);
        let grains = scene.world.grid.grains();
        (green(&film(&scene, samples(96, 1024))), grains)
    });
    println!("{tiled:?} {listed:?}");
    // A box this small cuts through parts of a pack that are a little denser or looser than all of it.
    let ball = 4.0 / 3.0 * core::f64::consts::PI * 0.4e-3 * 0.4e-3 * 0.4e-3;
    let asked = 275.0 / 917.0 * 0.061 * 0.023 * 0.055 / ball;
    for grains in [tiled.1, listed.1] {
        assert!((grains as f64 / asked - 1.0).abs() < 0.02, "{grains} grains of {asked}");
    }
    let [a, b] = [tiled.0.standard_error, listed.0.standard_error];
    let error = (a * a + b * b).sqrt();
    let allowed = 0.005 * listed.0.mean + SIGMAS * error;
    assert!((tiled.0.mean - listed.0.mean).abs() < allowed, "{tiled:?} {listed:?}");
}

/// In uniform light every path brings 1, whatever it meets.
#[test]
fn a_furnace_of_tiles_stays_uniform() {
    let changes =
        ["integrator.tiled=true", "light.kind=\"uniform\"", "object.albedo=1", "ice.absorption=0"];
    for pixel in film(&scene(SNOW, &changes), 8).pixels() {
        for radiance in pixel.mean_radiance() {
            assert!((radiance - 1.0).abs() < 1e-6, "{radiance}");
        }
    }
}

/// The mean of visits in a body lit from all around is the surface of its grains by that of a box around them, whatever their
/// places: so none is missing and none is met twice.
#[test]
fn every_grain_of_tiles_is_met_as_often_as_its_surface_asks() {
    let scene = scene(SNOW, &["integrator.tiled=true", "object.translate=[0,-1,0]"]);
    let grid = &scene.world.grid;
    let hull = snowgrain_math::Aabb::new(DVec3::splat(-5e-4), DVec3::new(0.0615, 0.0235, 0.0555));
    let size = hull.size();
    let around = 2.0 * (size.x * size.y + size.y * size.z + size.z * size.x);
    let grains = 4.0 * core::f64::consts::PI * 0.4e-3 * 0.4e-3 * grid.grains() as f64;
    let measure =
        measure_body(&scene.world, &hull, samples(150_000, 2_000_000), 3, SimdLevel::detect());
    let Estimate { mean, standard_error } = measure.grain_visits;
    println!("{mean} ({standard_error}) visits, {} expected", grains / around);
    assert!((mean - grains / around).abs() < SIGMAS * standard_error + 1e-3 * mean);
    assert_eq!(measure.trapped_paths, 0);
}

/// Tiles are chosen and packed alike on any number of threads: the same hash and picture.
#[test]
fn tiled_snow_is_the_same_on_any_thread() {
    let on = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| {
            let scene = scene(SNOW, &["integrator.tiled=true", "film.width=8", "film.height=8"]);
            (scene.hash, film(&scene, 2))
        })
    };
    let [one, many] = [1, 3].map(on);
    assert!(one.0 == many.0 && one.1.pixels() == many.1.pixels());
}
