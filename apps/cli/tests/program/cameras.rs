//! Shots made elsewhere, cameras with lenses, and quick looks.

use crate::{TINY, Workplace};
use snowgrain_film::Picture;
use snowgrain_formats::image::read_picture;

/// A pyramid with a camera before it; its buffer is `pyramid.bin`.
const SHOT: &str = r#"{
    "asset": { "version": "2.0" }, "scene": 0, "scenes": [{ "nodes": [0, 1, 2] }],
    "nodes": [
        { "mesh": 0, "name": "pyramid" },
        { "camera": 0, "name": "eye", "translation": [0, 0.05, 0.5] },
        { "translation": [0, 1, 1], "extensions": { "KHR_lights_punctual": { "light": 0 } } }
    ],
    "extensions": { "KHR_lights_punctual": { "lights": [{ "type": "point" }] } },
    "cameras": [{ "type": "perspective",
                  "perspective": { "yfov": 0.4, "aspectRatio": 1.5, "znear": 0.01 } }],
    "materials": [{ "pbrMetallicRoughness": {
        "baseColorFactor": [0.8, 0.1, 0.1, 1], "metallicFactor": 0 } }],
    "meshes": [{ "primitives": [
        { "attributes": { "POSITION": 0 }, "indices": 1, "material": 0 }] }],
    "accessors": [
        { "bufferView": 0, "componentType": 5126, "count": 5, "type": "VEC3" },
        { "bufferView": 1, "componentType": 5121, "count": 12, "type": "SCALAR" }],
    "bufferViews": [{ "buffer": 0, "byteLength": 60 },
                    { "buffer": 0, "byteOffset": 60, "byteLength": 12 }],
    "buffers": [{ "byteLength": 72, "uri": "pyramid.bin" }]
}"#;

const FEW: [&str; 8] = [
    "--set",
    "snow.grains=1000",
    "--set",
    "snow.radius=1mm",
    "--spp",
    "2",
    "--set",
    "film.height=32",
];

/// A folder with the shot and its buffer.
fn studio() -> Workplace {
    let place = Workplace::new();
    let corners: [[f32; 3]; 5] = [
        [-0.06, 0.0, -0.06],
        [0.06, 0.0, -0.06],
        [0.06, 0.0, 0.06],
        [-0.06, 0.0, 0.06],
        [0.0, 0.1, 0.0],
    ];
    let mut bytes: Vec<u8> = corners.iter().flatten().flat_map(|x| x.to_le_bytes()).collect();
    bytes.extend([0, 1, 4, 1, 2, 4, 2, 3, 4, 3, 0, 4]);
    place.file("pyramid.bin", bytes);
    place.file("shot.gltf", SHOT);
    place
}

fn picture(place: &Workplace, name: &str) -> Picture {
    read_picture(&place.path(name)).unwrap()
}

#[test]
fn a_shot_is_rendered_through_its_own_camera_under_snow() {
    let place = studio();
    let ended = place.succeed(&[&["render", "shot.gltf", "-o", "a.exr"], &FEW[..]].concat());
    for part in ["camera \"eye\" of the file", "1 lights of the file"] {
        assert!(ended.stderr.contains(part), "{}", ended.stderr);
    }
    let shot = picture(&place, "a.exr");
    let [red, ..] = shot.colour().unwrap();
    assert!(red.iter().any(|&x| x > 0.3), "its light shines");
    assert_eq!((shot.width(), shot.height()), (768, 32), "the width is that of the file");
    // The same shot, taken over by a scene.
    place.file(
        "a.toml",
        "version = 1\n[film]\nwidth = 48\nheight = 32\n[import]\nfile = \"shot.gltf\"\n\
         [[light]]\nkind = \"sky\"\n[[snow]]\nsource = \"deposit\"\ngrains = 1\nradius = \"1 mm\"\n",
    );
    place.succeed(&[&["render", "a.toml", "-q", "-o", "b.exr"], &FEW[..]].concat());
    let [red, green, _] = picture(&place, "b.exr").mean_radiance().unwrap();
    assert!(red > green, "a red pyramid: {red} {green}");
}

#[test]
fn a_shot_that_reaches_for_other_files_is_refused() {
    let place = studio();
    for (name, why) in [
        ("../pyramid.bin", "leaves its folder"),
        ("/etc/hostname", "leaves its folder"),
        ("none.bin", "is not there"),
    ] {
        place.file("bad.gltf", SHOT.replace("pyramid.bin", name));
        let before = place.names();
        let ended = place.run(&["render", "bad.gltf", "-o", "a.png"]);
        assert_eq!(ended.code, Some(65), "{}", ended.stderr);
        assert!(
            ended.stderr.contains("bad.gltf") && ended.stderr.contains("buffers[0]"),
            "{}",
            ended.stderr
        );
        assert!(ended.stderr.contains(why), "{}", ended.stderr);
        assert_eq!(place.names(), before);
    }
    let ended = place.run(&["render", "shot.gltf", "-o", "a.png", "--up", "z"]);
    assert_eq!(ended.code, Some(2));
    assert!(ended.stderr.contains("metres with y up"), "{}", ended.stderr);
}

#[test]
fn quick_looks_show_the_scene_from_other_sides() {
    let place = Workplace::new();
    let mut seen = Vec::new();
    for view in ["front", "three-quarter", "top", "close"] {
        let name = format!("{view}.png");
        place.tiny(&["--view", view, "-o", &name]);
        seen.push(place.bytes(&name));
    }
    seen.sort();
    seen.dedup();
    assert_eq!(seen.len(), 4);
    let ended = place.run(&["render", "snowy-teapot", "-o", "a.png", "--view", "below"]);
    assert_eq!(ended.code, Some(2));
    assert!(ended.stderr.contains("front, three-quarter, top, close"), "{}", ended.stderr);
}

#[test]
fn a_lens_changes_the_picture_and_threads_do_not() {
    let place = Workplace::new();
    let lens = ["--set", "camera.aperture=5mm", "--set", "camera.focus=surface"];
    place.tiny(&["-o", "sharp.film"]);
    place.tiny(&[&lens[..], &["-o", "1.film", "--threads", "1"]].concat());
    place.tiny(&[&lens[..], &["-o", "7.film", "--threads", "7"]].concat());
    assert_eq!(place.bytes("1.film"), place.bytes("7.film"));
    assert_ne!(place.bytes("1.film"), place.bytes("sharp.film"));
}

#[test]
fn an_exposure_value_darkens_the_png_and_not_the_light() {
    let place = Workplace::new();
    place.tiny(&["-o", "a.exr", "-o", "a.png"]);
    place.tiny(&[
        "--set",
        "camera.ev100=3",
        "-o",
        "b.exr",
        "-o",
        "b.png",
        "--exposure",
        "3.2630344058337938",
    ]);
    assert_eq!(
        place.bytes("a.png"),
        place.bytes("b.png"),
        "1.2 * 2^3 cd/m^2, and as much brighter"
    );
    let (plain, exposed) = (picture(&place, "a.exr"), picture(&place, "b.exr"));
    assert_eq!(plain.mean_radiance().unwrap(), exposed.mean_radiance().unwrap());
    assert!((exposed.exposure_stops + 3.263).abs() < 1e-3);
}

#[test]
fn parallel_rays_that_start_in_snow_are_refused() {
    let place = Workplace::new();
    place.file(
        "a.toml",
        "version = 1\n[film]\nwidth = 16\nheight = 16\nsamples_per_pixel = 2\n\
         [camera]\nkind = \"orthographic\"\nfrom = [4, 4, 4.3]\nat = [4, 4, 0]\nheight = 4\n\
         [[light]]\nkind = \"sky\"\n\
         [[snow]]\nsource = \"lattice\"\nlattice = \"sc\"\ncounts = [8, 8, 8]\nradius = 0.5\n",
    );
    let ended = place.run(&["render", "a.toml", "-o", "a.exr"]);
    assert_eq!(ended.code, Some(65), "{}", ended.stderr);
    assert!(ended.stderr.contains("its rays start within grains"), "{}", ended.stderr);
    assert_eq!(place.names(), ["a.toml"]);
    place.succeed(&["render", "a.toml", "-q", "-o", "a.exr", "--set", "camera.from=[4,4,9]"]);
    let teapot = [&["render", "snowy-teapot", "-q", "-o", "b.png"], &TINY[..]].concat();
    place.succeed(&[&teapot[..], &["--set", "camera.f_number=2.8"]].concat());
}
