//! What is rendered, and that it depends on nothing but the scene.

use crate::Workplace;
use snowgrain_film::{Layer, Picture, PixelRect};
use snowgrain_formats::image::read_picture;
use snowgrain_formats::read_film;

#[test]
fn a_scene_is_rendered_to_every_format_with_its_figures() {
    let place = Workplace::new();
    let outputs = ["-o", "a.png", "-o", "a.exr", "-o", "a.film", "--json-stats", "a.json"];
    let ended = place.tiny(&outputs);
    assert_eq!(ended.stderr, "", "quiet says nothing");
    assert_eq!(ended.stdout, "");
    assert_eq!(place.names(), ["a.exr", "a.film", "a.json", "a.png"]);
    let film = read_film(&place.path("a.film")).unwrap();
    assert_eq!((film.width(), film.height(), film.samples().total()), (48, 48, 2));
    let exr = read_picture(&place.path("a.exr")).unwrap();
    let mut expected = Picture::from_film(&film).unwrap();
    // EXR files hold it in single precision.
    expected.vertical_fov_degrees = film.vertical_fov_degrees.map(|x| f64::from(x as f32));
    assert_eq!(exr, expected);
    let png = read_picture(&place.path("a.png")).unwrap();
    assert_eq!(png.window(), PixelRect::new(0, 0, 48, 48));

    let stats: serde_json::Value = serde_json::from_slice(&place.bytes("a.json")).unwrap();
    for key in [
        "grains",
        "grain_bytes",
        "peak_rss_bytes",
        "deposit_seconds",
        "deposit_cpu_seconds",
        "build_seconds",
        "learning_seconds",
        "render_seconds",
        "render_cpu_seconds",
        "samples",
        "paths_in_snow",
        "interface_events",
        "grain_visits",
        "trapped_paths",
        "rays",
        "threads",
    ] {
        assert!(stats[key].is_number(), "{key}: {stats}");
    }
    assert_eq!(stats["grains"], 2000);
    assert_eq!(stats["samples"], 2 * 48 * 48);
    assert_eq!(stats["trapped_paths"], 0);
    assert_eq!(stats["snowfalls"][0]["accepted"], 2000);
    assert!(stats["snowfalls"][0]["discarded"].is_number());
    assert_eq!(stats["version"], env!("CARGO_PKG_VERSION"));
    assert_eq!(stats["scene_hash"].as_str().unwrap().len(), 64);
    let mean = Picture::from_film(&film).unwrap().mean_radiance().unwrap();
    assert_eq!(stats["mean_radiance"].as_array().unwrap()[0].as_f64(), Some(mean[0]));
}

#[test]
fn threads_and_instructions_do_not_change_a_byte() {
    let place = Workplace::new();
    place.tiny(&["--threads", "1", "-o", "1.exr", "-o", "1.film"]);
    place.tiny(&["--threads", "7", "-o", "7.exr", "-o", "7.film"]);
    assert_eq!(place.bytes("1.exr"), place.bytes("7.exr"));
    assert_eq!(place.bytes("1.film"), place.bytes("7.film"));
    for level in snowgrain_accel::SimdLevel::available() {
        place.tiny(&["--simd", &level.to_string(), "-o", "level.film"]);
        assert_eq!(place.bytes("level.film"), place.bytes("1.film"), "{level}");
    }
}

#[test]
fn a_crop_is_a_part_of_the_picture() {
    let place = Workplace::new();
    place.tiny(&["-o", "whole.film"]);
    place.tiny(&["--crop", "11,5,40,33", "-o", "crop.film"]);
    let whole = read_film(&place.path("whole.film")).unwrap();
    let crop = read_film(&place.path("crop.film")).unwrap();
    assert_eq!(crop.crop(), PixelRect::new(11, 5, 40, 33));
    for index in 0..crop.pixels().len() {
        let (x, y) = crop.crop().pixel(index);
        let there = whole.crop().index(x, y).unwrap();
        assert_eq!(crop.pixels()[index], whole.pixels()[there], "({x}, {y})");
    }
}

#[test]
fn grains_that_are_written_and_read_back_give_the_same_film() {
    let place = Workplace::new();
    let snow = ["--set", "snow.grains=2000", "--set", "snow.radius=2.5mm"];
    let deposit = ["deposit", "snowy-teapot", "-o", "grains.ply", "--json-stats", "d.json"];
    let said = place.succeed(&[&deposit[..], &snow].concat()).stderr;
    assert!(said.contains("2 000 accepted") && said.contains("kg/m3"), "{said}");
    let stats: serde_json::Value = serde_json::from_slice(&place.bytes("d.json")).unwrap();
    assert_eq!(stats["accepted"], 2000);
    for key in ["union_solid_fraction", "nominal_solid_fraction", "contacts_per_grain"] {
        assert!(stats[key].as_f64().unwrap() > 0.0, "{key}: {stats}");
    }
    let scene = place.succeed(&["scenes", "snowy-teapot", "--print"]).stdout;
    let (head, tail) = scene.split_once("[[snow]]").unwrap();
    let (_, integrator) = tail.split_once("[integrator]").unwrap();
    place.file(
        "read.toml",
        format!("{head}[[snow]]\nsource=\"file\"\nfile=\"grains.ply\"\n[integrator]{integrator}"),
    );
    place.tiny(&["-o", "fallen.film"]);
    place.succeed(&[
        "render",
        "read.toml",
        "--quiet",
        "--size",
        "48x48",
        "--spp",
        "2",
        "-o",
        "read.film",
    ]);
    let [mut fallen, read] =
        ["fallen.film", "read.film"].map(|name| read_film(&place.path(name)).unwrap());
    assert_ne!(fallen.recipe, read.recipe, "other things were asked for");
    fallen.recipe = read.recipe;
    assert!(fallen == read, "the films differ");
}

#[test]
fn in_a_furnace_every_pixel_is_exactly_1() {
    let place = Workplace::new();
    let small = ["--furnace", "--quiet", "--size", "24x24", "--spp", "2", "-o", "a.exr"];
    let snow = ["--set", "snow.grains=2000", "--set", "snow.radius=2.5mm"];
    place.file(
        "pyramid.obj",
        "v 0 0 0\nv 1 0 0\nv 0 0 1\nv 0 1 0\nf 1 2 3\nf 1 2 4\nf 2 3 4\nf 1 4 3\n",
    );
    let scenes = [
        ("snowy-teapot", &snow[..]),
        ("snowy-sphere-thick", &snow),
        ("pyramid.obj", &snow),
        ("snow-cube", &["--set", "snow.counts=[4,4,4]"]),
        ("snow-cube-sc", &["--set", "snow.counts=[5,5,5]"]),
    ];
    for (scene, changes) in scenes {
        place.succeed(&[&["render", scene], &small[..], changes].concat());
        let picture = read_picture(&place.path("a.exr")).unwrap();
        for layer in Layer::COLOUR {
            let values = picture.layer(layer).unwrap();
            assert!(values.iter().all(|&value| value == 1.0), "{scene} {layer:?}");
        }
    }
}

#[test]
fn a_mesh_alone_is_put_into_the_snow() {
    let place = Workplace::new();
    place.file(
        "tetra.obj",
        "v 0 0 0\nv 1 0 0\nv 0 0 1\nv 0 1 0\nf 1 2 3\nf 1 2 4\nf 2 3 4\nf 1 4 3\n",
    );
    let tiny = ["--size", "32x32", "--spp", "1", "--set", "snow.grains=3000"];
    let options = ["render", "tetra.obj", "--object-size", "20cm", "--up", "z", "-o", "a.png"];
    let said = place.succeed(&[&options[..], &tiny].concat()).stderr;
    assert!(said.contains("0.2") && said.contains("z is up"), "{said}");
    let picture = read_picture(&place.path("a.png")).unwrap();
    let red = picture.layer(Layer::R).unwrap();
    assert!(red.iter().any(|&r| r > 0.3) && red.iter().any(|&r| r < 0.1), "snow on dark");
    assert!(place.bytes("tetra.obj").starts_with(b"v 0"));
}

#[test]
fn a_dry_run_tells_and_makes_nothing() {
    let place = Workplace::new();
    let said = place.succeed(&["render", "snowy-teapot", "--dry-run", "-o", "a.png"]).stdout;
    for part in ["1 000 000", "MiB", "512x512", "time"] {
        assert!(said.contains(part), "{said}");
    }
    place.succeed(&["render", "snowy-teapot", "--dry-run"]);
    assert_eq!(place.names(), [""; 0]);
    let ended = place.run(&["render", "snowy-teapot", "--dry-run", "--max-memory", "10MB"]);
    assert_eq!(ended.code, Some(69));
    assert!(ended.stdout.contains("1 000 000"));
}

#[test]
fn a_time_limit_ends_a_render_after_few_passes() {
    let place = Workplace::new();
    let outputs = ["-o", "a.film", "-o", "a.exr", "--json-stats", "a.json"];
    let limit = ["--time-limit", "1ms", "--spp", "1000000"];
    let limit = [&limit[..], &outputs].concat();
    let grains = ["--set", "snow.grains=500", "--size", "16x16"];
    let said = place.succeed(&[&["render", "snowy-teapot"], &limit[..], &grains].concat()).stderr;
    // The pass that is seen to be late is the first, but the next ones may be nearly done by then.
    assert!(said.contains("--time-limit") && said.contains(" of 1000000"), "{said}");
    let held = read_film(&place.path("a.film")).unwrap().samples().total();
    assert!((1..10_000).contains(&held), "{held}");
    // The picture is whole, and every file says of how many samples.
    let picture = read_picture(&place.path("a.exr")).unwrap();
    assert_eq!(picture.provenance.unwrap().samples_per_pixel, held);
    let counts = picture.layer(Layer::SampleCount).unwrap();
    assert!(counts.iter().all(|&count| count == held as f32));
    let stats: serde_json::Value = serde_json::from_slice(&place.bytes("a.json")).unwrap();
    assert_eq!(stats["samples_per_pixel"], held);
    assert_eq!(stats["complete"], false);
}

#[test]
fn scenes_and_schema_are_printed() {
    let place = Workplace::new();
    let list = place.succeed(&["scenes"]).stdout;
    for scene in snowgrain_formats::scene::builtin_scenes() {
        assert!(list.contains(scene.name));
        assert_eq!(place.succeed(&["scenes", scene.name, "--print"]).stdout, scene.toml);
    }
    assert_eq!(place.succeed(&["schema"]).stdout, snowgrain_formats::scene::schema());
    assert!(place.succeed(&["--version"]).stdout.starts_with("snowgrain "));
    for command in ["render", "deposit", "scenes", "schema", "compare", "measure"] {
        let help = place.succeed(&[command, "--help"]).stdout;
        assert!(help.contains("Example"), "{command}");
    }
}
