//! Pictures on meshes.

use super::{read, square};
use crate::gltf::ImportedScene;
use serde_json::{Value, json};

/// A JPEG image of one pixel of grey: steps of 1 in all frequencies, one code of one bit each for "the
/// same brightness" and "no more frequencies", and these two as its data.
pub(super) fn grey_jpeg() -> Vec<u8> {
    let mut bytes = vec![0xff, 0xd8, 0xff, 0xdb, 0, 67, 0];
    bytes.extend([1; 64]);
    bytes.extend([0xff, 0xc0, 0, 11, 8, 0, 1, 0, 1, 1, 1, 0x11, 0]);
    for table in [0x00, 0x10] {
        bytes.extend([0xff, 0xc4, 0, 20, table, 1]);
        bytes.extend([0; 16]);
    }
    bytes.extend([0xff, 0xda, 0, 8, 1, 1, 0, 0, 63, 0, 0x3f, 0xff, 0xd9]);
    bytes
}

/// White above, black below.
fn half_white() -> Vec<u8> {
    let mut png = Vec::new();
    let encoder = image::codecs::png::PngEncoder::new(&mut png);
    let pixels = [255, 255, 255, 255, 255, 255, 0, 0, 0, 0, 0, 0];
    let colour = image::ExtendedColorType::Rgb8;
    image::ImageEncoder::write_image(encoder, &pixels, 2, 2, colour).unwrap();
    png
}

/// The square with a picture on it, placed by coordinates if wanted.
fn textured(bytes: &[u8], placed: bool) -> ImportedScene {
    read(&textured_square(bytes, placed)).unwrap()
}

fn textured_square(bytes: &[u8], placed: bool) -> Value {
    let data =
        |bytes: &[u8]| base64::Engine::encode(&base64::engine::general_purpose::STANDARD, bytes);
    let mut document = square();
    document["images"] = json!([{ "uri": format!("data:image/png;base64,{}", data(bytes)) }]);
    document["textures"] = json!([{ "source": 0 }]);
    document["materials"] = json!([{ "pbrMetallicRoughness": {
        "baseColorFactor": [1, 0.5, 0, 1], "metallicFactor": 0, "baseColorTexture": { "index": 0 },
    } }]);
    document["meshes"][0]["primitives"][0]["material"] = 0.into();
    if placed {
        let places: [[f32; 2]; 4] = [[0.0, 1.0], [1.0, 1.0], [1.0, 0.0], [0.0, 0.0]];
        let bytes: Vec<u8> =
            places.as_flattened().iter().flat_map(|value| value.to_le_bytes()).collect();
        let (buffers, views, accessors) = ("buffers", "bufferViews", "accessors");
        let push = |document: &mut Value, list: &str, item: Value| {
            let items = document[list].as_array_mut().unwrap();
            items.push(item);
            items.len() - 1
        };
        let uri = format!("data:application/octet-stream;base64,{}", data(&bytes));
        let buffer = push(&mut document, buffers, json!({ "byteLength": 32, "uri": uri }));
        let view = push(&mut document, views, json!({ "buffer": buffer, "byteLength": 32 }));
        let accessor = push(
            &mut document,
            accessors,
            json!({ "bufferView": view, "componentType": 5126, "type": "VEC2", "count": 4 }),
        );
        document["meshes"][0]["primitives"][0]["attributes"]["TEXCOORD_0"] = accessor.into();
    }
    document
}

/// A quarter turn counter-clockwise in the picture takes what lay to the right up; offsets go to the right
/// and down.
#[test]
fn textures_are_scaled_then_turned_then_moved() {
    let read_moved = |transform: Value| {
        let mut document = textured_square(&half_white(), true);
        let texture = &mut document["materials"][0]["pbrMetallicRoughness"]["baseColorTexture"];
        texture["extensions"]["KHR_texture_transform"] = transform;
        read(&document)
    };
    let moved = |transform: Value| {
        let scene = read_moved(transform).unwrap();
        assert_eq!(scene.ignored, None);
        // Of the vertex whose coordinates are (1, 0): the right upper corner of the picture.
        scene.objects[0].mesh.coordinates[0][2].map(|x| (f64::from(x) * 1e6).round() / 1e6)
    };
    assert_eq!(moved(json!({})), [1.0, 1.0]);
    assert_eq!(moved(json!({ "offset": [0.25, 0.5] })), [1.25, 0.5]);
    assert_eq!(moved(json!({ "scale": [0.5, 3] })), [0.5, 1.0]);
    let turned =
        json!({ "rotation": std::f64::consts::FRAC_PI_2, "scale": [0.5, 3], "offset": [0.1, 0] });
    assert_eq!(moved(turned), [0.1, 1.5]);
    let far = read_moved(json!({ "offset": [1e300, 0] })).unwrap_err().to_string();
    assert!(far.contains("not a finite number"), "{far}");
}

#[test]
fn textures_lie_where_the_mesh_places_them() {
    let scene = textured(&half_white(), true);
    let object = &scene.objects[0];
    assert_eq!(object.mesh.coordinates[0], [[0.0, 0.0], [1.0, 0.0], [1.0, 1.0]], "v goes up");
    let texture = object.material.texture.as_ref().unwrap();
    assert_eq!(texture.at([0.5, 0.75]), [1.0; 3]);
    assert_eq!(texture.at([0.5, 0.25]), [0.0; 3]);
    assert_eq!((object.material.base_colour, scene.ignored), ([1.0, 0.5, 0.0], None));
}

#[test]
fn textures_without_a_place_give_their_mean_colour() {
    let mean = |bytes: &[u8]| {
        let scene = textured(bytes, false);
        assert!(scene.objects[0].mesh.coordinates.is_empty());
        assert_eq!(scene.objects[0].material.texture, None);
        (scene.objects[0].material.base_colour, scene.ignored.unwrap())
    };
    let (half, said) = mean(&half_white());
    assert!(half == [0.5, 0.25, 0.0] && said.contains("without coordinates"), "{half:?} {said}");
    // Grey 128 of 255: linear .21586.
    let (grey, _) = mean(&grey_jpeg());
    assert!((grey[0] - 0.215_86).abs() < 1e-5, "{grey:?}");
    let mut huge = grey_jpeg();
    huge[76..80].copy_from_slice(&[0x3f, 0xff, 0x3f, 0xff]);
    for unread in [b"GIF89a", &huge[..], &half_white()[..40]] {
        let (half, said) = mean(unread);
        assert!(half == [0.5, 0.25, 0.0] && said.contains("not read"), "{said}");
    }
}
