//! Colours after the render, and wet snow, on the command line.

use crate::Workplace;
use snowgrain_formats::image::read_picture;
use snowgrain_formats::read_film;

/// A small scene whose film keeps ice paths.
const RENDER: [&str; 9] = [
    "render",
    "snowy-sphere-thin",
    "--size",
    "40x30",
    "--spp",
    "4",
    "--set",
    "snow.grains=30000",
    "-q",
];

#[test]
fn one_film_becomes_clean_sooty_and_spectral_pictures() {
    let place = Workplace::new();
    let kept = ["--keep", "ice-paths", "-o", "a.film", "-o", "a.exr"];
    let rendered = place.run(&[&RENDER[..], &kept].concat());
    assert_eq!(rendered.code, Some(0), "{}", rendered.stderr);
    let developed = |more: &[&str]| {
        let run = place.run(&[&["develop", "a.film"], more].concat());
        assert_eq!((run.code, run.stdout.as_str()), (Some(0), ""), "{}", run.stderr);
    };
    developed(&["-o", "same.exr", "-o", "same.png"]);
    assert_eq!(place.bytes("same.exr"), place.bytes("a.exr"));
    developed(&["--impurity", "soot=2ppm", "-o", "sooty.exr"]);
    developed(&["--impurity", "black-carbon=2ppm", "-o", "named.exr"]);
    assert_eq!(place.bytes("sooty.exr"), place.bytes("named.exr"));
    let mean = |name: &str| read_picture(&place.path(name)).unwrap().mean_radiance().unwrap();
    let (clean, sooty) = (mean("a.exr"), mean("sooty.exr"));
    assert!((0..3).all(|c| sooty[c] < clean[c]), "{clean:?} {sooty:?}");
    let fresh = [&RENDER[..], &["--set", "ice.impurities={black-carbon=\"2ppm\"}", "-o", "b.exr"]];
    assert_eq!(place.run(&fresh.concat()).code, Some(0));
    let fresh = mean("b.exr");
    assert!((0..3).all(|c| (sooty[c] - fresh[c]).abs() < 5e-4), "{sooty:?} {fresh:?}");

    developed(&["--wavelengths", "450:650:100", "--primaries", "acescg", "-o", "s.exr"]);
    let spectral = read_picture(&place.path("s.exr")).unwrap();
    let wavelengths: Vec<f64> = spectral.spectrum.iter().map(|layer| layer.wavelength_nm).collect();
    assert_eq!(wavelengths, [450.0, 550.0, 650.0]);
    assert_eq!(spectral.primaries.name(), "acescg");
    let compared = place.run(&["compare", "s.exr", "a.exr"]);
    assert_eq!(compared.code, Some(65), "{}", compared.stderr);
    assert!(compared.stderr.contains("primaries (acescg and srgb)"), "{}", compared.stderr);
}

#[test]
fn light_is_kept_by_group() {
    let place = Workplace::new();
    let kept = ["--keep", "light-groups", "-o", "a.film", "-o", "a.exr"];
    assert_eq!(place.run(&[&RENDER[..], &kept].concat()).code, Some(0));
    for name in ["a.exr", "a.film"] {
        let picture = read_picture(&place.path(name)).unwrap();
        let colour = picture.colour().unwrap().map(<[f32]>::to_vec);
        let mut layers = picture.light_layers;
        layers.sort_by(|a, b| a.name.cmp(&b.name));
        let [backdrop, sky] = layers.as_slice() else { panic!("{name}") };
        assert_eq!((&*sky.name, &*backdrop.name), ("sky", "backdrop"));
        for (channel, whole) in colour.iter().enumerate() {
            let parts = sky.values[channel].iter().zip(&backdrop.values[channel]);
            assert!(parts.zip(whole).all(|((a, b), sum)| (a + b - sum).abs() <= 1e-6 * sum));
        }
        assert_eq!(picture.vertical_fov_degrees.map(f64::round), Some(28.0));
    }
}

#[test]
fn what_is_kept_is_kept_beside_what_the_scene_keeps() {
    let place = Workplace::new();
    let scene = ["--set", "film.keep=[\"light-groups\"]"];
    let wavelengths = ["--wavelengths", "450,550", "-o", "a.film", "-o", "a.exr"];
    place.succeed(&[&RENDER[..], &scene, &wavelengths].concat());
    let film = read_film(&place.path("a.film")).unwrap();
    assert!(film.ice_paths().is_some() && film.light_layers().is_some());
    place.succeed(&[&RENDER[..], &scene, &["--keep", "ice-paths", "-o", "b.film"]].concat());
    assert_eq!(place.bytes("a.film"), place.bytes("b.film"));
}

#[test]
fn a_film_that_cannot_be_changed_says_how_to_make_one_that_can() {
    let place = Workplace::new();
    assert_eq!(place.run(&[&RENDER[..], &["-o", "a.film"]].concat()).code, Some(0));
    let refused = |arguments: &[&str], code: i32, said: &str| {
        let run = place.run(arguments);
        assert_eq!(run.code, Some(code), "{}", run.stderr);
        assert!(run.stderr.contains(said), "{}", run.stderr);
    };
    let soot = ["develop", "a.film", "--impurity", "soot=1ppm", "-o", "a.png"];
    refused(&soot, 65, "a.film: the film keeps no ice paths");
    refused(&soot, 65, "--keep ice-paths");
    refused(&["develop", "a.film", "-o", "b.film"], 2, ".png or .exr");
    refused(&["develop", "b.film", "-o", "b.png"], 66, "b.film");
    refused(&["develop", "a.film", "--wavelengths", "500", "-o", "a.png"], 2, ".exr");
    refused(&["develop", "a.film", "--primaries", "acescg", "-o", "a.png"], 2, ".exr");
    let render = |more: &[&'static str]| [&RENDER[..], more].concat();
    refused(&render(&["--keep", "ice-paths", "-o", "a.png"]), 2, ".film");
    refused(&render(&["--keep", "light-groups", "-o", "a.png"]), 2, ".exr");
    refused(&render(&["--wavelengths", "500", "-o", "a.png"]), 2, ".exr");
    refused(&["develop", "a.film", "--impurity", "coal=1ppm", "-o", "a.png"], 2, "black-carbon");
    refused(&["develop", "a.film", "--ice-k", "-3", "-o", "a.png"], 2, "1/m");
    refused(&["develop", "a.film", "--wavelengths", "900", "-o", "a.exr"], 2, "not visible");
    assert!(!place.path("a.png").exists());
}

#[test]
fn pores_fill_with_water() {
    let place = Workplace::new();
    let snow = ["optics", "wet", "--radius", "0.5mm", "--density", "250", "--depth", "5mm"];
    let with = |more: &[&str]| place.run(&[&snow[..], &["--paths", "400"], more].concat());
    let run = with(&["--saturation", "0,0.5,1", "--threads", "1"]);
    assert_eq!(run.code, Some(0), "{}", run.stderr);
    let rows: Vec<Vec<&str>> =
        run.stdout.lines().skip(1).map(|line| line.split(',').collect()).collect();
    let of = |model: &str| rows.iter().filter(|row| row[0] == model).count();
    // Where no air is left no sphere has its surface.
    assert_eq!([of("films"), of("larger-grains"), of("submerged")], [3, 2, 3]);
    for row in rows.iter().filter(|row| row[0] == "films") {
        let number = |column: usize| row[column].parse::<f64>().unwrap();
        let (water, wetness) = (number(7), number(8));
        let ice = 100.0 * 250.0 / 917.0;
        assert!((water - number(6) * (100.0 - ice)).abs() < 0.01, "{row:?}");
        assert!((wetness - water / ice).abs() < 1e-4, "{row:?}");
        assert!((number(9) + number(11) + number(13) - 1.0).abs() < 1e-5, "{row:?}");
    }
    assert_eq!(with(&["--saturation", "0:1:0.5", "--threads", "3"]).stdout, run.stdout);
    let refused = with(&["--liquid-water", "90"]);
    assert_eq!(refused.code, Some(2));
    assert!(refused.stderr.contains("--liquid-water: 90 is out of range"), "{}", refused.stderr);
    let dense =
        place.run(&["optics", "wet", "--radius", "0.5mm", "--density", "500", "--depth", "5mm"]);
    assert!(dense.code == Some(65) && dense.stderr.contains("at most 321"), "{}", dense.stderr);
}
