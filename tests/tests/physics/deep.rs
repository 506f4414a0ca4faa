//! Light that ends deep in the snow with what other light brought from there, against light that is followed
//! to its end.

use crate::SIGMAS;
use crate::cubes::picture;
use crate::sun::scene;
use snowgrain_film::{Film, PixelRect};
use snowgrain_render::Scene;
use snowgrain_render::measure::Estimate;
use snowgrain_render::transport::deep::DeepSettings;

/// A block of snow of which most is deep, of grains that touch and some that overlap.
const SNOW: &str = r#"
version = 1
[film]
width = 32
height = 32
[camera]
from = [0.02, 0.12, 0.12]
at = [0.02, 0.038, 0.02]
vertical_fov = 10.0
[[light]]
kind = "overcast"
group = "sky"
[[object]]
shape = "plane"
albedo = [0.6, 0.3, 0.1]
[[snow]]
source = "pack"
box = [0, 0, 0, 0.04, 0.04, 0.04]
radius = "0.4 mm"
variation = "0.1 mm"
density = 350
"#;

const LEARNT: [&str; 2] = ["integrator.deep=learnt", "integrator.learning_paths=65536"];

fn with<'a>(changes: &[&'a str], more: &[&'a str]) -> Vec<&'a str> {
    changes.iter().chain(more).copied().collect()
}

fn film(scene: &Scene, samples: u64) -> Film {
    let whole = PixelRect::new(0, 0, scene.film.width, scene.film.height);
    picture(scene, 0..samples, whole).film
}

/// The mean of a channel over all pixels.
fn channel(film: &Film, channel: usize) -> Estimate {
    let count = film.pixels().len() as f64;
    let sum = |value: &dyn Fn(usize) -> f64| (0..film.pixels().len()).map(value).sum::<f64>();
    Estimate {
        mean: sum(&|pixel| film.pixels()[pixel].mean_radiance()[channel]) / count,
        standard_error: sum(&|pixel| film.pixels()[pixel].variance_of_mean()[channel]).sqrt()
            / count,
    }
}

/// Each channel within the error that is asked for (and 4 sigma of chance) of light that is followed to its end, with the
/// noise of a path cut to less than half: salt, whose light turns sooner; white and blue ice, which
/// needs lengths; ice with soot in a stratum of its own; a sun that is looked for.
#[test]
fn learnt_light_is_as_bright_and_as_blue_as_exact_light() {
    let soot = "snow.impurities={ black-carbon = \"2 ppm\" }";
    let sun = [
        "light.kind=\"sun\"",
        "light.elevation=50",
        "light.azimuth=120",
        "light.angular_diameter=30",
        "integrator.light=\"sampled\"",
        "integrator.calibration_paths=65536",
    ];
    let plates = "snow.shapes=[{ shape = \"hexagonal-plate\", aspect = 0.3 }]";
    let cases: [(&str, Vec<&str>, u64, u64); 5] = [
        ("plates", vec![plates], 128, 64),
        ("salt", vec!["material={ kind = \"salt\" }", "snow.density=826"], 512, 256),
        ("overcast", vec![], 1024, 512),
        ("soot", vec![soot], 512, 256),
        ("sun", sun.to_vec(), 192, 128),
    ];
    for (name, changes, exact_samples, learnt_samples) in cases {
        let exact = film(&scene(SNOW, &changes), exact_samples);
        let learnt_scene = scene(SNOW, &with(&changes, &LEARNT));
        assert!(learnt_scene.outcomes.is_some(), "{name}: something is deep");
        let learnt = film(&learnt_scene, learnt_samples);
        for colour in 0..3 {
            let [a, b] = [channel(&exact, colour), channel(&learnt, colour)];
            let error =
                (a.standard_error * a.standard_error + b.standard_error * b.standard_error).sqrt();
            println!("{name} {colour}: {a:?} {b:?} {:+.2} %", 100.0 * (b.mean / a.mean - 1.0));
            let allowed = 0.01 * a.mean + SIGMAS * error;
            assert!((b.mean - a.mean).abs() <= allowed, "{name} {colour}: {a:?} {b:?}");
        }
        if name == "overcast" {
            let of = |film: &Film, samples: u64| {
                let error = channel(film, 1).standard_error;
                error * error * samples as f64
            };
            let ratio = of(&exact, exact_samples) / of(&learnt, learnt_samples);
            println!("{name}: variance of a path over that of a learnt one {ratio}");
            assert!(ratio > 2.0, "{ratio}");
        }
    }
}

/// In uniform light from everywhere nothing is lost: every path brings 1, and so does what was learnt from them.
#[test]
fn a_furnace_stays_uniform() {
    let changes = [
        "light.kind=\"uniform\"",
        "object.albedo=1",
        "ice.absorption=0",
        "integrator.deep_after_grains=1",
        "integrator.deep_depth=0",
    ];
    let film = film(&scene(SNOW, &with(&changes, &LEARNT)), 16);
    for pixel in film.pixels() {
        for radiance in pixel.mean_radiance() {
            assert!((radiance - 1.0).abs() < 1e-6, "{radiance}");
        }
    }
}

/// Snow that is nowhere deep is followed to its end: the same film but for its name.
#[test]
fn a_thin_dusting_is_exact() {
    let thin = SNOW.replace(
        "source = \"pack\"\nbox = [0, 0, 0, 0.04, 0.04, 0.04]",
        "source = \"deposit\"\ndepth = \"4 mm\"\narea = [0, 0, 0.04, 0.04]",
    );
    let exact = film(&scene(&thin, &[]), 8);
    let learnt_scene = scene(&thin, &LEARNT);
    assert!(learnt_scene.outcomes.is_none());
    assert!(film(&learnt_scene, 8).pixels() == exact.pixels());
}

/// Snow of ten grains' diameters on red ground, where light ends a quarter of a transport length from either: within 1 % and 4 sigma
/// in each channel.
#[test]
fn a_dusting_on_red_ground_keeps_its_colour() {
    let dusting = SNOW
        .replace(
            "source = \"pack\"\nbox = [0, 0, 0, 0.04, 0.04, 0.04]",
            "source = \"deposit\"\ndepth = \"8 mm\"\narea = [0, 0, 0.04, 0.04]",
        )
        .replace("albedo = [0.6, 0.3, 0.1]", "albedo = [0.7, 0.05, 0.05]")
        .replace("at = [0.02, 0.038, 0.02]", "at = [0.02, 0.006, 0.02]");
    let exact = film(&scene(&dusting, &[]), 512);
    let learnt_scene = scene(&dusting, &LEARNT);
    println!("deep: {}", learnt_scene.outcomes.is_some());
    let learnt = film(&learnt_scene, 512);
    for colour in 0..3 {
        let [a, b] = [channel(&exact, colour), channel(&learnt, colour)];
        let error =
            (a.standard_error * a.standard_error + b.standard_error * b.standard_error).sqrt();
        println!("dusting {colour}: {a:?} {b:?} {:+.2} %", 100.0 * (b.mean / a.mean - 1.0));
        assert!((b.mean - a.mean).abs() <= 0.01 * a.mean + SIGMAS * error, "{a:?} {b:?}");
    }
}

/// What is learnt and rendered does not depend on threads or instructions.
#[test]
fn learnt_light_is_the_same_on_any_thread() {
    let scene_by = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| film(&scene(SNOW, &with(&["film.width=16"], &LEARNT)), 4))
    };
    assert!(scene_by(1).pixels() == scene_by(5).pixels());
}

/// Smaller errors than any settings are known for are refused, others take what is known.
#[test]
fn settings_follow_the_error() {
    assert!(DeepSettings::for_error(1e-4).is_none());
    assert_eq!(DeepSettings::for_error(0.005), DeepSettings::for_error(0.003));
    let coarse = DeepSettings::for_error(0.05).unwrap();
    assert!(coarse.after_grains < DeepSettings::for_error(0.001).unwrap().after_grains);
}
