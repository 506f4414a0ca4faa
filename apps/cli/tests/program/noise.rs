//! Noise: renders to a target, and pictures without any.

use crate::Workplace;
use snowgrain_film::{BlockCounts, GLINTS, Layer};
use snowgrain_formats::image::read_picture;
use snowgrain_formats::read_film;

#[test]
fn a_noise_target_gives_blocks_what_they_need_and_says_so() {
    let place = Workplace::new();
    let snow = ["--size", "48x40", "--set", "snow.grains=2000", "--set", "snow.radius=2.5mm"];
    let target = ["--noise-target", "0.15", "--spp", "120", "--json-stats", "a.json"];
    let outputs = ["-o", "a.film", "-o", "a.exr"];
    let arguments = [&["render", "snowy-teapot"], &snow[..], &target, &outputs].concat();
    let said = place.succeed(&arguments).stderr;
    assert!(said.contains("noise target 0.15: 16 to "), "{said}");
    let film = read_film(&place.path("a.film")).unwrap();
    let counts = film.block_counts().unwrap();
    assert_eq!(counts.counts().len() as u64, BlockCounts::blocks(film.crop()));
    assert!(counts.counts().iter().all(|count| (16..=120).contains(count)));
    assert!(counts.greatest() > 60, "{}", counts.greatest());
    let picture = read_picture(&place.path("a.exr")).unwrap();
    let held = picture.layer(Layer::SampleCount).unwrap();
    let total: f64 = held.iter().map(|&count| f64::from(count)).sum();
    assert_eq!(total, counts.total() as f64);
    let stats: serde_json::Value = serde_json::from_slice(&place.bytes("a.json")).unwrap();
    assert_eq!(stats["samples"], counts.total());
    assert_eq!(stats["complete"], true);
    assert_eq!(stats["samples_per_pixel"], counts.greatest());
    let noise = &stats["noise"];
    assert_eq!((&noise["target"], &noise["pilot_samples"]), (&0.15.into(), &(16 * 48 * 40).into()));
    assert_eq!(noise["samples_per_pixel_mean"], total / (48.0 * 40.0));
    assert!(noise["largest_relative_error"].as_f64().unwrap() > 0.0, "{noise}");
}

#[test]
fn a_denoiser_that_is_not_there_is_69_before_any_work() {
    let place = Workplace::new();
    place.tiny(&["-o", "a.film"]);
    let before = place.names();
    let denoise = ["--denoise", "--denoise-library", "no/library.so", "-o", "b.png"];
    for command in [["render", "snowy-teapot"], ["develop", "a.film"]] {
        let ended = place.run(&[&command[..], &denoise].concat());
        assert_eq!(ended.code, Some(69), "{}", ended.stderr);
        assert_eq!(ended.stderr.lines().count(), 1, "{}", ended.stderr);
        for part in ["snowgrain: error:", "no/library.so", "SNOWGRAIN_OIDN"] {
            assert!(ended.stderr.contains(part), "{}", ended.stderr);
        }
    }
    assert_eq!(place.names(), before);
}

/// Where `SNOWGRAIN_OIDN` names the library.
#[test]
fn glints_come_through_the_denoiser() {
    if std::env::var_os("SNOWGRAIN_OIDN").is_none() {
        println!("skipped: SNOWGRAIN_OIDN names no library of Open Image Denoise");
        return;
    }
    let place = Workplace::new();
    let sun = ["--set", "light+={kind=\"sun\", elevation=40}"];
    let calibration = ["--set", "integrator.calibration_paths=16384"];
    place.tiny(&[&sun[..], &calibration, &["-o", "plain.exr", "-o", "a.film"]].concat());
    place.succeed(&["develop", "a.film", "--denoise", "-o", "clean.exr"]);
    let read = |name: &str| read_picture(&place.path(name)).unwrap();
    let (plain, clean) = (read("plain.exr"), read("clean.exr"));
    assert_eq!(clean.light_layers, plain.light_layers);
    let glints = plain.light_layers.iter().find(|layer| layer.name == GLINTS).unwrap();
    let green = clean.layer(Layer::G).unwrap();
    let (at, brightest) =
        glints.values[1].iter().enumerate().max_by(|a, b| a.1.total_cmp(b.1)).unwrap();
    assert!(*brightest > 5.0 && green[at] >= *brightest, "{} of {brightest}", green[at]);
}

/// Where `SNOWGRAIN_OIDN` names the library.
#[test]
fn a_denoised_picture_is_marked_and_its_film_is_not_changed() {
    if std::env::var_os("SNOWGRAIN_OIDN").is_none() {
        println!("skipped: SNOWGRAIN_OIDN names no library of Open Image Denoise");
        return;
    }
    let place = Workplace::new();
    place.tiny(&["-o", "plain.film", "-o", "plain.exr"]);
    place.tiny(&["--denoise", "-o", "a.film", "-o", "a.exr"]);
    assert_eq!(place.bytes("a.film"), place.bytes("plain.film"));
    place.succeed(&["develop", "plain.film", "--denoise", "-o", "b.exr", "-o", "b.png"]);
    let (plain, denoised) = (place.path("plain.exr"), place.path("a.exr"));
    let (plain, denoised) = (read_picture(&plain).unwrap(), read_picture(&denoised).unwrap());
    assert!(denoised.denoised && !plain.denoised && denoised.variance().is_none());
    assert_ne!(denoised.layer(Layer::G), plain.layer(Layer::G));
    assert!(read_picture(&place.path("b.exr")).unwrap().denoised);
    let said = place.succeed(&["compare", "a.exr", "plain.exr"]).stderr;
    assert!(said.contains("a.exr") && said.contains("denoiser"), "{said}");
}
