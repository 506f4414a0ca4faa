//! Light that is learnt: kept from one run to the next, and how well it is known.

use crate::Workplace;
use snowgrain_film::LearntLight;
use snowgrain_formats::read_film;
use std::fs;

const SCENE: &str = "\
version = 1
[film]
width = 12
height = 12
samples_per_pixel = 8
[camera]
from = [0.02, 0.12, 0.12]
at = [0.02, 0.038, 0.02]
vertical_fov = 10
[[light]]
kind = \"overcast\"
[[object]]
shape = \"plane\"
albedo = 0.3
[[snow]]
source = \"pack\"
box = [0, 0, 0, 0.04, 0.04, 0.04]
radius = \"0.5 mm\"
density = 350
[integrator]
learning_paths = 16384
deep = \"learnt\"
";

/// The same picture with and without a store, where it is full, and where what lies in it is damaged.
#[test]
fn what_was_learnt_is_taken_up_again() {
    let place = Workplace::new();
    place.file("scene.toml", SCENE);
    let render = |film: &str, more: &[&str]| {
        place.succeed(&[&["render", "scene.toml", "--quiet", "-o", film], more].concat());
        fs::read(place.path(film)).unwrap()
    };
    let cache = ["--learnt-cache", "learnt"];
    let plain = render("plain.film", &[]);
    assert!(render("first.film", &cache) == plain);
    let files: Vec<_> = fs::read_dir(place.path("learnt")).unwrap().collect();
    let [Ok(file)] = &files[..] else { panic!("one file: {files:?}") };
    let learnt = fs::read(file.path()).unwrap();
    assert!(render("second.film", &cache) == plain);
    fs::write(file.path(), &learnt[..learnt.len() - 7]).unwrap();
    assert!(render("third.film", &cache) == plain);
    assert!(fs::read(file.path()).unwrap() == learnt, "it is learnt and kept anew");
    render("other.film", &["--seed", "5", "--learnt-cache", "learnt"]);
    assert_eq!(fs::read_dir(place.path("learnt")).unwrap().count(), 2);
}

/// Each pixel tells how much of it was learnt, and its standard error.
#[test]
fn a_film_tells_what_was_learnt() {
    let place = Workplace::new();
    place.file("scene.toml", SCENE);
    place.succeed(&["render", "scene.toml", "--quiet", "-o", "picture.film"]);
    let film = read_film(&place.path("picture.film")).unwrap();
    let learnt = film.learnt_sums().unwrap();
    let (mut light, mut error, mut radiance) = (0.0, 0.0, 0.0);
    for (sums, pixel) in learnt.iter().zip(film.pixels()) {
        let of_pixel = LearntLight::of(sums, pixel.samples());
        let mean = pixel.mean_radiance().iter().sum::<f64>() / 3.0;
        assert!(of_pixel.light <= mean * (1.0 + 1e-6), "{of_pixel:?} {mean}");
        light += of_pixel.light;
        error += of_pixel.error;
        radiance += mean;
    }
    let (part, error) = (light / radiance, error / light);
    assert!((0.05..0.95).contains(&part), "{part} of the light is learnt");
    assert!((0.001..0.05).contains(&error), "{error}");
    place.succeed(&[
        "render",
        "scene.toml",
        "--quiet",
        "--set",
        "integrator={}",
        "-o",
        "exact.film",
    ]);
    assert!(read_film(&place.path("exact.film")).unwrap().learnt_sums().is_none());
}

#[test]
fn a_store_that_is_no_folder_is_refused() {
    let place = Workplace::new();
    place.file("scene.toml", SCENE);
    place.file("learnt", "no folder");
    let ended = place.run(&["render", "scene.toml", "-o", "p.film", "--learnt-cache", "learnt"]);
    assert_eq!(ended.code, Some(73), "{}", ended.stderr);
    assert!(ended.stderr.contains("--learnt-cache learnt"), "{}", ended.stderr);
    assert!(!place.path("p.film").exists());
    let exact = ["render", "scene.toml", "--set", "integrator={}", "-o", "p.film"];
    let ended = place.run(&[&exact[..], &["--learnt-cache", "folder"]].concat());
    assert_eq!(ended.code, Some(2), "{}", ended.stderr);
    assert!(ended.stderr.contains("add --lod-error"), "{}", ended.stderr);
}
