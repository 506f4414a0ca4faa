//! Grains of salt, sand and substances of one's own; glints; surfaces that are filled.

use crate::Workplace;
use serde_json::Value;
use snowgrain_film::Layer;
use snowgrain_formats::image::read_picture;

const SCENE: &str = "\
version = 1
[film]
width = 24
height = 16
samples_per_pixel = 4
[camera]
from = [0, 0.02, 0.02]
at = [0, 0, 0]
vertical_fov = 20
[material]
kind = \"salt\"
[[light]]
kind = \"sun\"
elevation = 40
[[light]]
kind = \"sky\"
[[object]]
shape = \"plane\"
[[snow]]
source = \"deposit\"
rule = \"stick\"
radius = \"0.5 mm\"
grains = 200
area = [-0.005, -0.005, 0.005, 0.005]
[integrator]
calibration_paths = 8192
";

fn place() -> Workplace {
    let place = Workplace::new();
    place.file("scene.toml", SCENE);
    place
}

/// Green of all pixels.
fn mean(place: &Workplace, name: &str) -> f64 {
    let picture = read_picture(&place.path(name)).unwrap();
    let green = picture.layer(Layer::G).unwrap();
    green.iter().map(|&value| f64::from(value)).sum::<f64>() / green.len() as f64
}

#[test]
fn a_film_of_salt_knows_that_it_is_no_ice() {
    let place = place();
    place.succeed(&["render", "scene.toml", "-o", "salt.film", "-o", "salt.exr", "--quiet"]);
    place.succeed(&["develop", "salt.film", "-o", "again.exr"]);
    assert_eq!(place.bytes("salt.exr"), place.bytes("again.exr"));
    for option in [&["--ice-k", "picard-2016"][..], &["--impurity", "soot=1ppm"], &["--clean"]] {
        let ended = place.run(&[&["develop", "salt.film", "-o", "ice.exr"], option].concat());
        assert_eq!(ended.code, Some(2), "{}", ended.stderr);
        let said = format!("{} is of ice, but its grains are of salt", option[0]);
        assert!(ended.stderr.contains(&said), "{}", ended.stderr);
        assert_eq!(ended.stderr.trim_end().lines().count(), 1, "{}", ended.stderr);
    }
    assert!(!place.names().contains(&"ice.exr".to_owned()));
    // Another substance is another scene.
    let resumed = ["render", "scene.toml", "--set", "material.kind=\"ice\"", "--resume"];
    let ended = place.run(&[&resumed[..], &["-o", "salt.film", "--quiet"]].concat());
    assert_ne!(ended.code, Some(0), "{}", ended.stderr);
}

#[test]
fn a_table_of_ones_own_is_read_from_the_folder_of_the_scene() {
    let place = place();
    place.file("dark.csv", "nm,n,k\n380,1.6,1e-4\n780,1.5,1e-4\n");
    let own = ["--set", "material={kind=\"measured\", file=\"dark.csv\"}", "--quiet"];
    place.succeed(
        &[&["render", "scene.toml", "-o", "dark.exr", "-o", "dark.film"], &own[..]].concat(),
    );
    place.succeed(&["render", "scene.toml", "-o", "salt.exr", "--quiet"]);
    assert!(mean(&place, "dark.exr") < mean(&place, "salt.exr"));
    place.succeed(&["develop", "dark.film", "-o", "again.exr"]);
    assert_eq!(place.bytes("dark.exr"), place.bytes("again.exr"));
    let phase = ["optics", "phase", "--indices", "dark.csv", "--wavelength", "580", "--bins", "2"];
    let text = place.succeed(&phase).stdout;
    assert!(text.contains("# refractive_index 1.55\n"), "{text}");
    let text = place.succeed(&["optics", "phase", "--material", "quartz", "--bins", "2"]).stdout;
    assert!(text.contains("# refractive_index 1.549"), "{text}");

    place.file("dark.csv", "nm,n,k\n380,1.6,1e-4\n400,0.5,0\n780,1.5,1e-4\n");
    let ended = place.run(&[&["render", "scene.toml", "-o", "bad.exr"], &own[..]].concat());
    assert_eq!(ended.code, Some(65), "{}", ended.stderr);
    let said = "dark.csv, line 3: n is 0.5; write an index of refraction of 1 to 4";
    assert!(ended.stderr.contains(said), "{}", ended.stderr);
    assert!(!place.names().contains(&"bad.exr".to_owned()));
}

#[test]
fn a_dispersed_picture_is_the_same_on_any_threads_and_kept_whole() {
    let place = place();
    let glass = ["--set", "material={kind=\"bk7\", dispersion=true}", "--quiet", "--spp", "16"];
    let render = |threads: &str, name: &str| {
        let run = ["render", "scene.toml", "-o", name, "--threads", threads];
        place.succeed(&[&run[..], &glass].concat());
    };
    render("1", "one.film");
    render("3", "three.film");
    assert!(place.bytes("one.film") == place.bytes("three.film"));
    let white = ["render", "scene.toml", "--furnace", "-o", "white.exr"];
    place.succeed(&[&white[..], &glass].concat());
    let picture = read_picture(&place.path("white.exr")).unwrap();
    for layer in Layer::COLOUR {
        let values = picture.layer(layer).unwrap();
        assert!(values.iter().all(|value| (value - 1.0).abs() < 1e-4), "{layer:?}");
    }
    let kept = ["render", "scene.toml", "-o", "kept.film", "--keep", "ice-paths"];
    let ended = place.run(&[&kept[..], &glass].concat());
    assert!(ended.code == Some(65) && ended.stderr.contains("wavelengths"), "{}", ended.stderr);
}

#[test]
fn glints_are_counted_by_their_kind() {
    let place = place();
    let crystals = "snow.shapes=[{shape=\"hexagonal-prism\"}]";
    let low = "light.0.elevation=5";
    let wide = "light.0.angular_diameter=40";
    let sets = ["--set", wide, "--set", low, "--set", crystals];
    let run = [&["measure", "glints", "scene.toml"][..], &sets].concat();
    let text = place.succeed(&[&run[..], &["-q"]].concat()).stdout;
    assert!(text.contains("reflected") && text.contains("expected"), "{text}");
    let json = place.succeed(&[&run[..], &["-q", "--json"]].concat()).stdout;
    let suns: Value = serde_json::from_str(&json).unwrap();
    let sun = &suns[0];
    assert_eq!(sun["faces"].as_u64().unwrap(), 8 * sun["crystals"].as_u64().unwrap());
    let kinds = ["reflected", "refracted", "reflected within"];
    for (glints, kind) in sun["glints"].as_array().unwrap().iter().zip(kinds) {
        assert_eq!(glints["kind"], kind);
        let count = |key: &str| glints[key].as_u64().unwrap();
        assert!(count("made") > 0 && count("seen") <= count("made"), "{glints}");
    }
    let balls = place.run(&["measure", "glints", "scene.toml", "-q"]);
    assert!(balls.code == Some(65) && balls.stderr.contains("spheres"), "{}", balls.stderr);
    let none = place.run(&["measure", "glints", "snowy-teapot", "-q"]);
    assert!(none.code == Some(65) && none.stderr.contains("no sun"), "{}", none.stderr);
}

#[test]
fn an_open_surface_is_filled_down_to_its_base_and_thinned_by_a_map() {
    let place = Workplace::new();
    let heights = "v 0 0.01 0\nv 0.04 0.01 0\nv 0 0.01 0.04\nv 0.04 0.01 0.04\nf 1 3 2\nf 2 3 4\n";
    place.file("drift.obj", heights);
    // White and black.
    let map =
        [&b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 1 +X 2\n"[..], &[128, 128, 128, 129], &[0; 4]];
    place.file("map.hdr", map.concat());
    let head = &SCENE[..SCENE.find("[[snow]]").unwrap()].replace("salt", "ice");
    let fill =
        "[[snow]]\nsource = \"fill\"\nfile = \"drift.obj\"\nradius = \"0.5 mm\"\ndensity = 250\n";
    place.file("scene.toml", format!("{head}{fill}base = 0\n"));
    let grains = |more: &[&str]| {
        let run = ["deposit", "scene.toml", "-o", "grains.ply", "--json-stats", "stats.json", "-q"];
        place.succeed(&[&run[..], more].concat());
        let stats: Value = serde_json::from_slice(&place.bytes("stats.json")).unwrap();
        stats["grains"].as_f64().unwrap()
    };
    let whole = grains(&[]);
    let ball = 4.0 / 3.0 * core::f64::consts::PI * 0.125e-9;
    assert!((whole * ball * 917.0 / 1.6e-5 / 250.0 - 1.0).abs() < 0.05, "{whole}");
    let area = "snow.area=[0, 0, 0.04, 0.04]";
    let half = grains(&["--set", "snow.density_map=map.hdr", "--set", area]);
    assert!((half / whole - 0.5).abs() < 0.03, "{half} of {whole}");
    place.file("scene.toml", format!("{head}{fill}"));
    let ended = place.run(&["deposit", "scene.toml", "-o", "grains.ply"]);
    assert_eq!(ended.code, Some(65), "{}", ended.stderr);
    assert!(
        ended.stderr.contains("the mesh is not closed") && ended.stderr.contains("say the base")
    );
}
