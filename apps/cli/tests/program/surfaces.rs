//! Pictures on objects, and objects of metal and glass.

use crate::Workplace;
use snowgrain_film::Layer;
use snowgrain_formats::image::read_picture;

/// A square that faces the camera, with a picture on it.
const BOARD: &str = r#"{
    "asset": { "version": "2.0" }, "scene": 0, "scenes": [{ "nodes": [0] }],
    "nodes": [{ "mesh": 0, "name": "board" }],
    "images": [{ "uri": "board.png" }], "textures": [{ "source": 0 }],
    "materials": [{ "pbrMetallicRoughness": {
        "baseColorTexture": { "index": 0 }, "metallicFactor": 0 } }],
    "meshes": [{ "primitives": [{ "attributes": { "POSITION": 0, "TEXCOORD_0": 1 },
                                  "indices": 2, "material": 0 }] }],
    "accessors": [
        { "bufferView": 0, "componentType": 5126, "count": 4, "type": "VEC3" },
        { "bufferView": 1, "componentType": 5126, "count": 4, "type": "VEC2" },
        { "bufferView": 2, "componentType": 5121, "count": 6, "type": "SCALAR" }],
    "bufferViews": [{ "buffer": 0, "byteLength": 48 },
                    { "buffer": 0, "byteOffset": 48, "byteLength": 32 },
                    { "buffer": 0, "byteOffset": 80, "byteLength": 6 }],
    "buffers": [{ "byteLength": 86, "uri": "board.bin" }]
}"#;

const SCENE: &str = "version = 1
[film]
width = 8
height = 8
samples_per_pixel = 4
[import]
file = \"board.gltf\"
[camera]
kind = \"orthographic\"
from = [0, 0, 1]
at = [0, 0, 0]
height = 1
[[light]]
kind = \"uniform\"
";

/// The board: its picture is red above and blue below.
fn board() -> Workplace {
    let place = Workplace::new();
    let corners: [[f32; 3]; 4] =
        [[-1.0, -1.0, 0.0], [1.0, -1.0, 0.0], [1.0, 1.0, 0.0], [-1.0, 1.0, 0.0]];
    let places: [[f32; 2]; 4] = [[0.0, 1.0], [1.0, 1.0], [1.0, 0.0], [0.0, 0.0]];
    let numbers = corners.iter().flatten().chain(places.iter().flatten());
    let mut bytes: Vec<u8> = numbers.flat_map(|x| x.to_le_bytes()).collect();
    bytes.extend([0, 1, 2, 0, 2, 3]);
    place.file("board.bin", bytes);
    place.file("board.gltf", BOARD);
    place.file("board.png", PICTURE);
    place.file("scene.toml", SCENE);
    place
}

/// 1 x 16 pixels of PNG: eight of red, eight of blue.
const PICTURE: &[u8] = &[
    137, 80, 78, 71, 13, 10, 26, 10, 0, 0, 0, 13, 73, 72, 68, 82, 0, 0, 0, 1, 0, 0, 0, 16, 8, 2, 0,
    0, 0, 88, 253, 130, 224, 0, 0, 0, 18, 73, 68, 65, 84, 120, 218, 99, 248, 207, 192, 192, 128,
    15, 227, 151, 253, 15, 0, 254, 79, 15, 241, 155, 87, 231, 217, 0, 0, 0, 0, 73, 69, 78, 68, 174,
    66, 96, 130,
];

#[test]
fn a_shot_shows_the_pictures_on_its_objects() {
    let place = board();
    place.succeed(&["render", "scene.toml", "-q", "-o", "board.exr"]);
    let picture = read_picture(&place.path("board.exr")).unwrap();
    let at = |layer, row: usize| picture.layer(layer).unwrap()[row * 8 + 4];
    assert_eq!([at(Layer::R, 1), at(Layer::G, 1), at(Layer::B, 1)], [1.0, 0.0, 0.0]);
    assert_eq!([at(Layer::R, 6), at(Layer::G, 6), at(Layer::B, 6)], [0.0, 0.0, 1.0]);
    assert_eq!(at(Layer::AlbedoB, 6), 1.0);
}

#[test]
fn a_picture_that_is_none_is_refused_by_its_key() {
    let place = board();
    place.file("wall.png", b"\x89PNG\r\n\x1a\nrubbish");
    let scene = "version = 1\n[camera]\nfrom = [0, 1, 1]\nat = [0, 0, 0]\n[[light]]\nkind = \"sky\"\n\
        [[object]]\nshape = \"plane\"\nalbedo_texture = \"wall.png\"\n";
    place.file("wall.toml", scene);
    let ended = place.run(&["render", "wall.toml", "-o", "wall.png.exr"]);
    assert_eq!(ended.code, Some(65), "{}", ended.stderr);
    assert!(ended.stderr.contains("object.0.albedo_texture"), "{}", ended.stderr);
    place.file("wall.toml", scene.replace("wall.png", "missing.png"));
    assert_eq!(place.run(&["render", "wall.toml", "-o", "wall.exr"]).code, Some(66));
}
