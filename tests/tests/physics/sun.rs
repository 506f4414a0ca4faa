//! Light that is looked for against light that is met: suns, lamps, uniform light.
//!
//! `SNOWGRAIN_FULL=1` compares suns of 5 and 2 degrees; the default a wider one, of which chance finds more.

use crate::cubes::picture;
use crate::{SIGMAS, samples};
use snowgrain_film::{Film, PixelRect};
use snowgrain_formats::scene::{Loader, ReadGrains, SceneFile, resolve};
use snowgrain_geometry::Quantisation;
use snowgrain_grains::GrainField;
use snowgrain_math::DVec3;
use snowgrain_render::Scene;
use snowgrain_render::measure::Estimate;

/// Snow of a rule on a grey floor, seen from the side so that each pixel covers many grains.
pub(crate) const SNOW: &str = r#"
version = 1
[film]
width = 32
height = 32
[camera]
from = [0.0, 0.14, 0.14]
at = [0.0, 0.002, 0.0]
vertical_fov = 12.0
[ice]
absorption = 0.0
[[light]]
kind = "sun"
elevation = 40.0
azimuth = 60.0
[[object]]
shape = "plane"
albedo = 0.5
[[snow]]
source = "deposit"
radius = "0.5 mm"
depth = "5 mm"
area = [-0.03, -0.03, 0.03, 0.03]
"#;

pub(crate) fn scene(text: &str, changes: &[&str]) -> Scene {
    scene_with(text, changes, &mut |_| Err("no grains".into()))
}

/// The scene whose grains have these centres and one radius, metres.
pub(crate) fn scene_of_grains(text: &str, centers: &[DVec3], radius: f64) -> Scene {
    let quantisation = Quantisation::for_grains(DVec3::ZERO, radius);
    let grain = |&center: &DVec3| quantisation.round(center, radius).unwrap();
    let grains = centers.iter().map(grain).collect::<Vec<_>>();
    scene_with(text, &[], &mut |_| Ok(GrainField::new(quantisation, grains.clone())))
}

fn scene_with(text: &str, changes: &[&str], grains: &mut ReadGrains<'_>) -> Scene {
    let changes: Vec<String> = changes.iter().map(|&change| change.to_owned()).collect();
    let file = SceneFile::parse(text, "test.toml".as_ref(), &changes).unwrap();
    let loader = Loader {
        mesh: &mut |_| Err("no mesh".into()),
        grains,
        import: &mut |_| Err("no shot".into()),
        environment: &mut |_| Err("no map".into()),
        texture: &mut |_| Err("no texture".into()),
        sizes: &mut |_| Err("no texture".into()),
        plan_image: &mut |_| Err("no texture".into()),
        optical_constants: &mut |_| Err("no indices".into()),
    };
    Scene::build(&resolve(&file, loader).unwrap(), &mut |_| ()).unwrap()
}

fn film(scene: &Scene, samples: u64) -> Film {
    let whole = PixelRect::new(0, 0, scene.film.width, scene.film.height);
    picture(scene, 0..samples, whole).film
}

/// The mean of green over all pixels.
fn mean(film: &Film) -> Estimate {
    let count = film.pixels().len() as f64;
    let sum = |value: &dyn Fn(usize) -> f64| (0..film.pixels().len()).map(value).sum::<f64>();
    Estimate {
        mean: sum(&|pixel| film.pixels()[pixel].mean_radiance()[1]) / count,
        standard_error: sum(&|pixel| film.pixels()[pixel].variance_of_mean()[1]).sqrt() / count,
    }
}

/// All light is 1 where nothing is lost: found by search and by chance together.
#[test]
fn uniform_light_that_is_looked_for_is_as_uniform_as_that_which_is_met() {
    for rule in ["stick", "ray", "roll"] {
        let rule_is = format!("snow.rule=\"{rule}\"");
        let changes = [
            rule_is.as_str(),
            "integrator.calibration_paths=262144",
            "light.0.kind=\"uniform\"",
            "object.albedo=1.0",
            "integrator.light=\"all-sampled\"",
        ];
        let text = SNOW.replace("elevation = 40.0\nazimuth = 60.0\n", "");
        let found = mean(&film(&scene(&text, &changes), samples(512, 4096)));
        println!("{rule}: {found:?}");
        assert!(found.standard_error <= 1e-3, "{rule}: {found:?}");
        let off = (found.mean - 1.0).abs();
        assert!(off <= SIGMAS * found.standard_error, "{rule}: {found:?}");
    }
}

/// On snow of a rule, under a high and a low sun: within 1 % or three standard errors of both.
fn assert_as_bright_over(rule: &str) {
    let diameter = if crate::is_full() { 5.0 } else { 30.0 };
    for elevation in [20.0, 50.0] {
        assert_as_bright_as_met(rule, elevation, diameter, samples(512, 1 << 16));
    }
}

#[test]
fn a_sun_that_is_looked_for_is_as_bright_as_one_that_is_met_over_stick() {
    assert_as_bright_over("stick");
}

#[test]
fn a_sun_that_is_looked_for_is_as_bright_as_one_that_is_met_over_ray() {
    assert_as_bright_over("ray");
}

#[test]
fn a_sun_that_is_looked_for_is_as_bright_as_one_that_is_met_over_roll() {
    assert_as_bright_over("roll");
}

/// A sun of 2 degrees, the full profile's alone: it takes hundreds of millions of paths until chance has met it often enough.
#[test]
fn a_small_sun_that_is_looked_for_is_as_bright_as_one_that_is_met() {
    if crate::is_full() {
        assert_as_bright_as_met("stick", 50.0, 2.0, 1 << 18);
    }
}

/// A sun of so many degrees across, so high over snow of a rule, by search and by `exact_samples` a pixel that meet it.
fn assert_as_bright_as_met(rule: &str, elevation: f64, diameter: f64, exact_samples: u64) {
    let changes = [
        format!("snow.rule=\"{rule}\""),
        format!("light.elevation={elevation}"),
        format!("light.angular_diameter={diameter}"),
    ];
    let paths = format!("integrator.calibration_paths={}", samples(1 << 18, 1 << 22));
    let by = |finding: &str, samples: u64| {
        let mut changes: Vec<&str> = changes.iter().map(String::as_str).collect();
        let finding_is = format!("integrator.light=\"{finding}\"");
        changes.push(&finding_is);
        if finding != "exact" {
            changes.push(&paths);
        }
        mean(&film(&scene(SNOW, &changes), samples))
    };
    let exact = by("exact", exact_samples);
    let sampled = by("sampled", samples(128, 1 << 13));
    let [a, b] = [exact.standard_error, sampled.standard_error];
    let error = (a * a + b * b).sqrt();
    let off = sampled.mean - exact.mean;
    println!(
        "{rule}, {elevation} degrees high, {diameter} across: {:+.2} % +- {:.2} %",
        100.0 * off / exact.mean,
        100.0 * error / exact.mean
    );
    let allowed = (0.01 * exact.mean).max(3.0 * error);
    assert!(off.abs() <= allowed, "{rule}, {elevation}, {diameter}: {exact:?} {sampled:?}");
}

/// The images of the sun in a lone grain, which are solved, against those that are met: means of the whole
/// picture, in which the grain fills a few pixels or a part of one.
#[test]
fn the_sun_in_a_lone_grain_is_solved_as_it_is_met() {
    for height in ["0.0015", "0.006"] {
        let text = SNOW
            .replace("source = \"deposit\"\nradius = \"0.5 mm\"\ndepth = \"5 mm\"\narea = [-0.03, -0.03, 0.03, 0.03]", "source = \"lattice\"\nlattice = \"sc\"\nradius = \"0.5 mm\"\ncounts = [1, 1, 1]")
            .replace("[[object]]\nshape = \"plane\"\nalbedo = 0.5\n", "")
            .replace("width = 32\nheight = 32", "width = 12\nheight = 12")
            .replace("at = [0.0, 0.002, 0.0]\nvertical_fov = 12.0", &format!("at = [0.0005, 0.0005, 0.0005]\nkind = \"orthographic\"\nheight = {height}"));
        let by = |finding: &str, samples: u64| {
            let finding = format!("integrator.light=\"{finding}\"");
            let changes = [finding.as_str(), "light.angular_diameter=20.0"];
            mean(&film(&scene(&text, &changes), samples))
        };
        let exact = by("exact", samples(1 << 15, 1 << 18));
        let sampled = by("sampled", samples(1 << 9, 1 << 14));
        let [a, b] = [exact.standard_error, sampled.standard_error];
        let error = (a * a + b * b).sqrt();
        println!("{height} m: {exact:?} {sampled:?}");
        assert!((sampled.mean - exact.mean).abs() <= SIGMAS * error, "{exact:?} {sampled:?}");
    }
}

/// The same in a lone grain with faces, which mirrors a sun into the camera or does not: the chain of its
/// interfaces against light that is met.
#[test]
fn the_sun_in_a_lone_crystal_is_solved_as_it_is_met() {
    let lone = "source = \"lattice\"\nlattice = \"sc\"\nradius = \"0.5 mm\"\ncounts = [1, 1, 1]\n[[snow.shapes]]\n";
    for (shape, elevation) in [
        ("shape = \"hexagonal-column\"\naspect = 2.0\norientation = \"horizontal\"", 45),
        ("shape = \"cube\"\nrounding = 0.3", 70),
        ("shape = \"random-polyhedron\"\nfaces = 14\nrounding = 0.3", 70),
    ] {
        let text = SNOW
            .replace("source = \"deposit\"\nradius = \"0.5 mm\"\ndepth = \"5 mm\"\narea = [-0.03, -0.03, 0.03, 0.03]", &format!("{lone}{shape}"))
            .replace("[[object]]\nshape = \"plane\"\nalbedo = 0.5\n", "")
            .replace("width = 32\nheight = 32", "width = 12\nheight = 12")
            .replace("at = [0.0, 0.002, 0.0]\nvertical_fov = 12.0", "at = [0.0005, 0.0005, 0.0005]\nkind = \"orthographic\"\nheight = 0.0015");
        let by = |finding: &str, samples: u64| {
            let finding_is = format!("integrator.light=\"{finding}\"");
            let height = format!("light.elevation={elevation}");
            let mut changes = vec![finding_is.as_str(), "light.angular_diameter=20.0", &height];
            if finding == "sampled" {
                changes.push("integrator.calibration_paths=16384");
            }
            mean(&film(&scene(&text, &changes), samples))
        };
        let exact = by("exact", samples(1 << 14, 1 << 18));
        let sampled = by("sampled", samples(1 << 11, 1 << 14));
        let [a, b] = [exact.standard_error, sampled.standard_error];
        let error = (a * a + b * b).sqrt();
        println!("{shape}: {exact:?} {sampled:?}");
        assert!(exact.mean > 3.0 * exact.standard_error, "{shape} shines: {exact:?}");
        assert!((sampled.mean - exact.mean).abs() <= SIGMAS * error, "{exact:?} {sampled:?}");
    }
}

/// Of plates and rounded polyhedra, as of spheres: within 2 % or three standard errors of both.
#[test]
fn a_sun_on_crystals_is_as_bright_as_one_that_is_met() {
    let shapes = "area = [-0.03, -0.03, 0.03, 0.03]\n[[snow.shapes]]\nshape = \"hexagonal-plate\"\naspect = 0.3\n[[snow.shapes]]\nshape = \"random-polyhedron\"\nfaces = 14\nrounding = 0.3\n";
    let text = SNOW.replace("area = [-0.03, -0.03, 0.03, 0.03]\n", shapes);
    let by = |finding: &str, samples: u64| {
        let finding_is = format!("integrator.light=\"{finding}\"");
        let diameter = if crate::is_full() { 5.0 } else { 20.0 };
        let diameter = format!("light.angular_diameter={diameter}");
        let mut changes = vec![finding_is.as_str(), &diameter, "snow.rule=\"stick\""];
        if finding == "sampled" {
            changes.push("integrator.calibration_paths=262144");
        }
        mean(&film(&scene(&text, &changes), samples))
    };
    let exact = by("exact", samples(256, 1 << 16));
    let sampled = by("sampled", samples(64, 1 << 12));
    let [a, b] = [exact.standard_error, sampled.standard_error];
    let error = (a * a + b * b).sqrt();
    let off = sampled.mean - exact.mean;
    println!("crystals: {:+.2} % +- {:.2} %", 100.0 * off / exact.mean, 100.0 * error / exact.mean);
    assert!(off.abs() <= (0.02 * exact.mean).max(3.0 * error), "{exact:?} {sampled:?}");
}

/// What half a degree of sun gains: the variance of a sample against that of chance, which finds a disc of
/// radiance L with a mean of m once in L/m samples.
///
/// The brightest images in two grains, of which one path in 10^6 finds one, make the variance that so few samples have scatter:
/// of those of 64 samples a pixel by other seeds one in nine is below 10^4, of those of 1024 (`docs/lights.md`) none of eight.
#[test]
fn a_sun_that_is_looked_for_has_a_ten_thousandth_of_the_variance() {
    let changes = ["snow.rule=\"stick\"", "integrator.calibration_paths=262144"];
    let scene = scene(SNOW, &changes);
    let count = samples(64, 1024);
    let film = film(&scene, count);
    let found = mean(&film);
    let pixels = film.pixels().len() as f64;
    let variance = found.standard_error * found.standard_error * count as f64 * pixels;
    let sun = f64::from(scene.lights.radiance_at_infinity(0, sun_direction())[1]);
    let by_chance = (sun - found.mean) * found.mean;
    println!("{:.0} times less variance, mean {}", by_chance / variance, found.mean);
    let least = if crate::is_full() { 1e4 } else { 3e3 };
    assert!(by_chance / variance > least, "{by_chance} {variance}");
}

fn sun_direction() -> DVec3 {
    snowgrain_render::light::direction_of(40.0, 60.0)
}
