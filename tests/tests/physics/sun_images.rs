//! Images of the sun in the first two grains that the camera sees, which are solved: against paths that meet it.

use crate::cubes::picture;
use crate::samples;
use crate::sun::{SNOW, scene, scene_of_grains};
use snowgrain_accel::SimdLevel;
use snowgrain_film::PixelRect;
use snowgrain_math::DVec3;
use snowgrain_math::sampler::{PathKey, numbers};
use snowgrain_render::Scene;
use snowgrain_render::measure::Estimate;
use snowgrain_render::transport::{NewPath, PathEnd, PathResult, PathSource, trace};

/// Films of a picture, from which the error of their mean is told.
const FILMS: u64 = 16;

/// The layer of glints: the mean of green over all pixels, and each pixel.
fn glints(scene: &Scene, samples: u64) -> (Estimate, Vec<f64>) {
    let whole = PixelRect::new(0, 0, scene.film.width, scene.film.height);
    let each = samples / FILMS;
    let mut pixels = vec![0.0; (scene.film.width * scene.film.height) as usize];
    let means: Vec<f64> = (0..FILMS)
        .map(|film| {
            let film = picture(scene, film * each..(film + 1) * each, whole).film;
            let layers = film.light_layers().unwrap();
            let layer = layers.layers().position("glints").unwrap();
            let light = |pixel| layers.light(pixel, each).nth(layer).unwrap()[1];
            let light: Vec<f64> = (0..pixels.len()).map(light).collect();
            pixels.iter_mut().zip(&light).for_each(|(sum, light)| *sum += light / FILMS as f64);
            light.iter().sum::<f64>() / light.len() as f64
        })
        .collect();
    let mean = means.iter().sum::<f64>() / FILMS as f64;
    let squares: f64 = means.iter().map(|one| (one - mean) * (one - mean)).sum();
    let standard_error = (squares / (FILMS * (FILMS - 1)) as f64).sqrt();
    (Estimate { mean, standard_error }, pixels)
}

/// Paths all over a picture, and what they meet of its first light by way of at most two grains alone.
struct Met<'a> {
    scene: &'a Scene,
    paths: std::ops::Range<u64>,
    /// Sums of green and of its squares, of one grain and of two.
    sums: [[f64; 2]; 2],
    pixels: Vec<f64>,
}

impl PathSource for Met<'_> {
    type Tag = usize;

    fn next_path(&mut self) -> Option<NewPath<usize>> {
        let film = &self.scene.film;
        let key = PathKey::new(0x911275, self.paths.next()?, 0);
        let [x, y, _] = numbers(key, 0).map(f64::from);
        let [u, v, _] = numbers(key, 1).map(f64::from);
        let (x, y) = (x * f64::from(film.width), y * f64::from(film.height));
        let tag = y as usize * film.width as usize + x as usize;
        Some(NewPath { tag, ray: self.scene.camera.ray(x, y, [u, v]), key, event: 2 })
    }

    fn finish(&mut self, pixel: usize, path: &PathResult) {
        let PathEnd::Escaped(ray) = path.end else { return };
        if path.surface_bounces == 0 && (1..=2).contains(&path.grain_visits) {
            let lights = &self.scene.lights;
            let colour = &self.scene.colours[lights.slot_of(0)];
            let radiance = lights.radiance_at_infinity(0, ray.direction);
            let light = f64::from(colour.apply(radiance, path.ice_length)[1]);
            let [sum, squares] = &mut self.sums[path.grain_visits as usize - 1];
            *sum += light;
            *squares += light * light;
            self.pixels[pixel] += light;
        }
    }
}

/// What paths meet by one grain, and by two; and the light of each pixel by both.
fn met(scene: &Scene, paths: u64) -> ([Estimate; 2], Vec<f64>) {
    let count = (scene.film.width * scene.film.height) as usize;
    let mut source = Met { scene, paths: 0..paths, sums: [[0.0; 2]; 2], pixels: vec![0.0; count] };
    trace(&scene.world, SimdLevel::detect(), &mut source);
    let paths = paths as f64;
    let estimates = source.sums.map(|[sum, squares]| {
        let mean = sum / paths;
        Estimate { mean, standard_error: ((squares / paths - mean * mean) / paths).sqrt() }
    });
    (estimates, source.pixels.iter().map(|light| light * count as f64 / paths).collect())
}

/// Middle of a picture's light, and how far it spreads in root mean square, pixels.
fn extent(pixels: &[f64], width: usize) -> [f64; 3] {
    let mean = |value: &dyn Fn(f64, f64) -> f64| {
        let at = |pixel: usize| value((pixel % width) as f64, (pixel / width) as f64);
        let sum: f64 = pixels.iter().enumerate().map(|(pixel, light)| light * at(pixel)).sum();
        sum / pixels.iter().sum::<f64>()
    };
    let (x, y) = (mean(&|x, _| x), mean(&|_, y| y));
    [x, y, mean(&|a, b| (a - x) * (a - x) + (b - y) * (b - y)).sqrt()]
}

/// Two lone grains under a sun of 5 or 10 degrees: ahead of the camera, so that most light goes through both; aside;
/// through a lens. The layer of glints is as bright as what paths meet by one and two grains, within 3 standard
/// errors of at most 2 % (which one seed in 370 misses for each), and where they meet it.
#[test]
fn images_of_the_sun_in_two_grains_are_those_that_paths_meet() {
    let behind = DVec3::new(0.0, 0.0, -0.0011);
    let aside = DVec3::new(0.00044, 0.0002, -0.001);
    for (name, second, sun, lens) in [
        ("behind", behind, [20.0, 10.0, 5.0], false),
        ("aside", aside, [30.0, 45.0, 10.0], false),
        ("through a lens", behind, [20.0, 10.0, 10.0], true),
    ] {
        let [elevation, azimuth, diameter] = sun;
        let projection = if lens {
            "vertical_fov = 3.0\naperture = 0.002\nfocus = 0.0305"
        } else {
            "kind = \"orthographic\"\nheight = 0.0016"
        };
        let text = format!(
            "version = 1\n[film]\nwidth = 20\nheight = 20\n[camera]\nfrom = [0.0035, 0.0095, 0.029]\n\
             at = [0.0, 0.0, -0.0005]\n{projection}\n[ice]\nabsorption = 0.0\n[integrator]\n\
             calibration_paths = 1024\n[[light]]\nkind = \"sun\"\nangular_diameter = {diameter}\n\
             elevation = {elevation}\nazimuth = {azimuth}\n[[snow]]\nsource = \"file\"\nfile = \"two.ply\"\n"
        );
        let scene = scene_of_grains(&text, &[DVec3::ZERO, second], 0.0005);
        let (solved, solved_pixels) = glints(&scene, samples(4096, 1 << 15));
        let ([one, two], met_pixels) = met(&scene, samples(1 << 21, 1 << 25));
        let [a, b, c] = [solved, one, two].map(|estimate| estimate.standard_error);
        let (expected, error) = (one.mean + two.mean, (a * a + b * b + c * c).sqrt());
        let extents = [&solved_pixels, &met_pixels].map(|pixels| extent(pixels, 20));
        println!(
            "{name}: {:+.2} % +- {:.2} % (+- {:.2} % of the search), by two grains {:.0} %; {extents:.3?}",
            100.0 * (solved.mean / expected - 1.0),
            100.0 * error / expected,
            100.0 * a / expected,
            100.0 * two.mean / expected,
        );
        assert!(error <= 0.02 * expected, "{name}: {solved:?} {one:?} {two:?}");
        assert!(
            (solved.mean - expected).abs() <= 3.0 * error,
            "{name}: {solved:?} {one:?} {two:?}"
        );
        let moved = [0, 1, 2].map(|index: usize| (extents[0][index] - extents[1][index]).abs());
        assert!(moved.iter().all(|&moved| moved < 0.25), "{name}: {extents:?}");
    }
}

/// On snow, where grains overlap (`ray`) and where they do not: the light of a sun by way of one and two grains, within
/// 3 standard errors of at most 8 % (3 % in full).
#[test]
fn glints_on_snow_are_as_bright_as_those_that_paths_meet() {
    for rule in ["stick", "ray"] {
        let rule_is = format!("snow.rule=\"{rule}\"");
        let changes = [
            &rule_is[..],
            "light.azimuth=0.0",
            "light.elevation=20.0",
            "light.angular_diameter=20.0",
            "integrator.calibration_paths=1024",
        ];
        let scene = scene(SNOW, &changes);
        let (solved, _) = glints(&scene, samples(160, 1 << 12));
        let ([one, two], _) = met(&scene, samples(1 << 19, 1 << 23));
        let [a, b, c] = [solved, one, two].map(|estimate| estimate.standard_error);
        let (expected, error) = (one.mean + two.mean, (a * a + b * b + c * c).sqrt());
        println!(
            "{rule}: {:+.2} % +- {:.2} % (+- {:.2} % of the search), by two grains {:.0} %",
            100.0 * (solved.mean / expected - 1.0),
            100.0 * error / expected,
            100.0 * a / expected,
            100.0 * two.mean / expected,
        );
        let most = if crate::is_full() { 0.03 } else { 0.08 };
        assert!(error <= most * expected, "{rule}: {solved:?} {one:?} {two:?}");
        assert!(
            (solved.mean - expected).abs() <= 3.0 * error,
            "{rule}: {solved:?} {one:?} {two:?}"
        );
    }
}
