//! Files good and bad, made here.

mod textures;

use super::*;
use proptest::prelude::*;
use serde_json::{Value, json};
use textures::grey_jpeg;

/// A square of two triangles as five accessors: floats, indices of each size.
const SQUARE: [[f32; 3]; 4] = [[0.0, 0.0, 0.0], [1.0, 0.0, 0.0], [1.0, 1.0, 0.0], [0.0, 1.0, 0.0]];

/// The bytes of the square: positions (48), u16 indices (12), u8 indices of a strip (4), u32 indices of
/// a fan (16), interleaved i16 positions with 2 bytes between (32).
fn binary() -> Vec<u8> {
    let mut bytes: Vec<u8> = SQUARE.iter().flatten().flat_map(|x| x.to_le_bytes()).collect();
    bytes.extend([0u16, 1, 2, 0, 2, 3].iter().flat_map(|i| i.to_le_bytes()));
    bytes.extend([0u8, 1, 3, 2]);
    bytes.extend([0u32, 1, 2, 3].iter().flat_map(|i| i.to_le_bytes()));
    for corner in SQUARE {
        let scaled = corner.map(|x| (x * 32_767.0) as i16);
        bytes.extend(scaled.iter().flat_map(|i| i.to_le_bytes()));
        bytes.extend([7, 7]);
    }
    bytes
}

/// A document whose node 0 holds the square; tests change it.
fn square() -> Value {
    json!({
        "asset": { "version": "2.0" },
        "scene": 0,
        "scenes": [{ "nodes": [0] }],
        "nodes": [{ "name": "board", "mesh": 0 }],
        "meshes": [{ "primitives": [{ "attributes": { "POSITION": 0 }, "indices": 1 }] }],
        "accessors": [
            { "bufferView": 0, "componentType": 5126, "count": 4, "type": "VEC3" },
            { "bufferView": 1, "componentType": 5123, "count": 6, "type": "SCALAR" },
            { "bufferView": 1, "byteOffset": 12, "componentType": 5121, "count": 4, "type": "SCALAR" },
            { "bufferView": 2, "componentType": 5125, "count": 4, "type": "SCALAR" },
            { "bufferView": 3, "componentType": 5122, "count": 4, "type": "VEC3",
              "normalized": true },
        ],
        "bufferViews": [
            { "buffer": 0, "byteLength": 48 },
            { "buffer": 0, "byteOffset": 48, "byteLength": 16 },
            { "buffer": 0, "byteOffset": 64, "byteLength": 16 },
            { "buffer": 0, "byteOffset": 80, "byteLength": 32, "byteStride": 8 },
        ],
        "buffers": [{ "byteLength": 112 }],
    })
}

/// The document with a value at a JSON pointer replaced.
fn with(pointer: &str, value: Value) -> Value {
    let mut document = square();
    *document.pointer_mut(pointer).unwrap_or_else(|| panic!("{pointer}")) = value;
    document
}

/// The document with a key added to the object at a JSON pointer.
fn adding(pointer: &str, key: &str, value: Value) -> Value {
    let mut document = square();
    document.pointer_mut(pointer).unwrap()[key] = value;
    document
}

fn glb(document: &Value) -> Vec<u8> {
    let mut json = serde_json::to_vec(document).unwrap();
    json.resize(json.len().next_multiple_of(4), b' ');
    let binary = binary();
    let mut bytes = b"glTF\x02\0\0\0".to_vec();
    bytes.extend((28 + json.len() as u32 + binary.len() as u32).to_le_bytes());
    for (kind, chunk) in [(b"JSON", &json), (b"BIN\0", &binary)] {
        bytes.extend((chunk.len() as u32).to_le_bytes());
        bytes.extend(kind);
        bytes.extend(chunk);
    }
    bytes
}

fn read(document: &Value) -> Result<ImportedScene, String> {
    let folder = Path::new("nowhere");
    import(&glb(document), folder).map_err(|fault| fault.of(Path::new("a.glb")).to_string())
}

fn corners(mesh: &TriangleMesh) -> Vec<[DVec3; 3]> {
    (0..mesh.triangles.len()).map(|i| mesh.corners(i)).collect()
}

#[test]
fn a_glb_gives_its_triangles_and_names() {
    let scene = read(&square()).unwrap();
    let [board] = &scene.objects[..] else { panic!("{scene:?}") };
    assert_eq!(board.name, "board");
    assert_eq!(board.transform, DAffine3::IDENTITY);
    assert_eq!(board.material, ImportedMaterial::NONE);
    assert_eq!(board.mesh.positions, SQUARE.map(|p| DVec3::from(p.map(f64::from))));
    assert_eq!(board.mesh.triangles, [[0, 1, 2], [0, 2, 3]]);
    assert_eq!((scene.ignored, scene.cameras.len(), scene.lights.len()), (None, 0, 0));
}

#[test]
fn a_document_with_its_data_beside_or_within_it_is_the_same() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("data 1.bin"), binary()).unwrap();
    let within = format!(
        "data:application/gltf-buffer;base64,{}",
        base64::Engine::encode(&base64::engine::general_purpose::STANDARD, binary())
    );
    let expected = read(&square()).unwrap();
    for uri in ["data%201.bin", &within] {
        let path = folder.path().join("shot.gltf");
        let document = adding("/buffers/0", "uri", uri.into());
        std::fs::write(&path, document.to_string()).unwrap();
        assert_eq!(read_gltf(&path).unwrap(), expected);
        assert_eq!(crate::load_mesh(&path).unwrap(), *expected.objects[0].mesh);
    }
}

#[test]
fn strips_fans_and_lists_without_indices_are_read() {
    let primitive = |mode: u32, indices: Option<u32>| {
        let mut document = square();
        let primitive = document.pointer_mut("/meshes/0/primitives/0").unwrap();
        primitive["mode"] = mode.into();
        match indices {
            Some(accessor) => primitive["indices"] = accessor.into(),
            None => drop(primitive.as_object_mut().unwrap().remove("indices")),
        }
        read(&document).map(|scene| scene.objects[0].mesh.triangles.clone())
    };
    assert_eq!(primitive(5, Some(2)).unwrap(), [[0, 1, 3], [1, 2, 3]], "a strip of bytes");
    assert_eq!(primitive(6, Some(3)).unwrap(), [[0, 1, 2], [0, 2, 3]], "a fan of words");
    assert_eq!(primitive(6, None).unwrap(), [[0, 1, 2], [0, 2, 3]]);
    assert_eq!(primitive(4, None).unwrap(), [[0, 1, 2]], "one corner is left over");
    for mode in 0..4 {
        assert!(primitive(mode, None).unwrap_err().contains("no triangle"), "points and lines");
    }
    assert!(primitive(7, None).unwrap_err().contains("unknown mode 7"));
}

#[test]
fn normalised_interleaved_and_sparse_positions_are_read() {
    let quantised = read(&with("/meshes/0/primitives/0/attributes/POSITION", 4.into())).unwrap();
    assert_eq!(
        corners(&quantised.objects[0].mesh),
        corners(&read(&square()).unwrap().objects[0].mesh)
    );
    // Corner 3 moves to where corner 1 is; the byte 3 stands at 12 + 2 of view 1.
    let sparse = json!({
        "count": 1,
        "indices": { "bufferView": 1, "byteOffset": 14, "componentType": 5121 },
        "values": { "bufferView": 0, "byteOffset": 24 },
    });
    let moved = read(&adding("/accessors/0", "sparse", sparse.clone())).unwrap();
    let mesh = &moved.objects[0].mesh;
    assert_eq!(mesh.positions[3], DVec3::new(1.0, 1.0, 0.0));
    // Without a view all others are 0: no triangle is left.
    let mut alone = adding("/accessors/0", "sparse", sparse);
    alone["accessors"][0].as_object_mut().unwrap().remove("bufferView");
    assert!(read(&alone).unwrap_err().contains("no triangle with an area"));
}

#[test]
fn nodes_move_their_children_and_share_meshes() {
    let mut document = square();
    let half = 0.5f64.sqrt();
    document["nodes"] = json!([
        { "children": [1, 2], "translation": [10, 0, 0], "scale": [2, 2, 2] },
        { "mesh": 0, "rotation": [0, half, 0, half] },
        { "mesh": 0, "matrix": [1,0,0,0, 0,1,0,0, 0,0,1,0, 0,3,0,1] },
    ]);
    let scene = read(&document).unwrap();
    let [turned, raised] = &scene.objects[..] else { panic!("{scene:?}") };
    assert!(Arc::ptr_eq(&turned.mesh, &raised.mesh), "a mesh is held once");
    // A quarter turn about y takes x to -z.
    let tip = turned.transform.transform_point3(DVec3::X);
    assert!((tip - DVec3::new(10.0, 0.0, -2.0)).length() < 1e-12, "{tip}");
    assert_eq!(raised.transform.transform_point3(DVec3::X), DVec3::new(12.0, 6.0, 0.0));
    assert_eq!(turned.name, "nodes[1]");
    let joined = joined_mesh(&glb(&document), Path::new("a.glb")).unwrap();
    assert_eq!((joined.positions.len(), joined.triangles.len()), (8, 4));
    assert_eq!(joined.corners(2)[1], DVec3::new(12.0, 6.0, 0.0));
}

#[test]
fn materials_cameras_and_lights_are_read() {
    let mut document = square();
    document["materials"] = json!([{
        "pbrMetallicRoughness": {
            "baseColorFactor": [0.8, 0.4, 0.2, 1.0], "metallicFactor": 0.25, "roughnessFactor": 0.5,
        },
        "normalTexture": { "index": 0 },
        "alphaMode": "BLEND",
    }]);
    document["meshes"][0]["primitives"][0]["material"] = 0.into();
    document["scenes"][0]["nodes"] = json!([0, 1, 2, 3, 4, 5]);
    document["cameras"] = json!([
        { "type": "perspective",
          "perspective": { "yfov": 0.5, "aspectRatio": 1.5, "znear": 0.01 } },
        { "type": "orthographic",
          "orthographic": { "xmag": 2, "ymag": 1, "znear": 0.01, "zfar": 10 } },
    ]);
    document["extensions"] = json!({ "KHR_lights_punctual": { "lights": [
        { "type": "directional", "intensity": 50_000, "color": [1, 0.9, 0.8] },
        { "type": "point", "intensity": 100 },
        { "type": "spot", "name": "torch", "spot": { "outerConeAngle": 0.5 } },
    ] } });
    let light = |index: u32| json!({ "KHR_lights_punctual": { "light": index } });
    document["nodes"] = json!([
        { "mesh": 0 },
        { "camera": 0, "name": "eye", "translation": [0, 1, 5] },
        { "camera": 1, "rotation": [-1, 0, 0, 1] },
        { "extensions": light(0), "rotation": [-1, 0, 0, 1] },
        { "extensions": light(1), "translation": [1, 2, 3] },
        { "extensions": light(2) },
    ]);
    document["extensionsRequired"] = json!(["KHR_lights_punctual", "KHR_materials_ior"]);
    let scene = read(&document).unwrap();
    let material = ImportedMaterial {
        base_colour: [0.8, 0.4, 0.2],
        texture: None,
        metallic: 0.25,
        roughness: 0.5,
    };
    assert_eq!(scene.objects[0].material, material);
    let said = scene.ignored.unwrap();
    for part in ["1 glossy materials", "1 normal maps", "1 transparent"] {
        assert!(said.contains(part), "{said}");
    }
    let [eye, plan] = &scene.cameras[..] else { panic!() };
    assert_eq!(
        (eye.name.as_str(), eye.from, eye.aspect),
        ("eye", DVec3::new(0.0, 1.0, 5.0), Some(1.5))
    );
    assert_eq!((eye.gaze, eye.up), (DVec3::NEG_Z, DVec3::Y));
    let vertical_fov_degrees = 0.5f64.to_degrees();
    assert_eq!(eye.projection, ImportedProjection::Perspective { vertical_fov_degrees });
    // Turned to look straight down, with -z up.
    assert!(
        (plan.gaze - DVec3::NEG_Y).length() < 1e-12 && (plan.up - DVec3::NEG_Z).length() < 1e-12
    );
    assert_eq!(plan.aspect, Some(2.0));
    assert!(matches!(plan.projection, ImportedProjection::Orthographic { height }
        if (height - 2.0).abs() < 1e-12));
    let [sun, bulb, torch] = &scene.lights[..] else { panic!() };
    assert_eq!(sun.colour, [1.0, 0.9, 0.8]);
    assert!(matches!(sun.kind, ImportedLightKind::Directional { direction, lux }
        if lux == 5e4 && (direction - DVec3::NEG_Y).length() < 1e-12));
    let position = DVec3::new(1.0, 2.0, 3.0);
    assert_eq!(bulb.kind, ImportedLightKind::Point { position, candela: 100.0 });
    assert_eq!(torch.name, "torch");
    let ImportedLightKind::Spot { candela, inner_radians, outer_radians, .. } = torch.kind else {
        panic!()
    };
    assert_eq!((candela, inner_radians, outer_radians), (1.0, 0.0, 0.5));
}

#[test]
fn what_contradicts_itself_is_refused_by_element() {
    let refusals = [
        (with("/asset/version", "1.0".into()), "version \"1.0\" is not known"),
        (with("/scenes/0/nodes/0", 7.into()), "scenes[0] names nodes[7], but there are 1"),
        (with("/scene", 3.into()), "names scenes[3]"),
        (with("/scenes", json!([])), "holds no scene"),
        (with("/nodes/0/mesh", 1.into()), "nodes[0] names meshes[1]"),
        (
            with("/meshes/0/primitives/0/attributes/POSITION", 9.into()),
            "meshes[0].primitives[0] names accessors[9]",
        ),
        (with("/meshes/0/primitives/0/attributes", json!({})), "has no POSITION"),
        (with("/meshes/0/primitives/0/indices", 0.into()), "holds \"VEC3\", not \"SCALAR\""),
        (with("/accessors/0/bufferView", 9.into()), "names bufferViews[9]"),
        (with("/accessors/0/componentType", 1.into()), "unknown componentType 1"),
        (with("/accessors/0/count", 5.into()), "claims 5 elements"),
        (with("/accessors/0/count", u64::MAX.into()), "claims 18446744073709551615 elements"),
        (with("/accessors/1/count", u64::MAX.into()), "more than its bufferView of 16 bytes"),
        (with("/accessors/1/componentType", 5126.into()), "not unsigned integers"),
        (with("/bufferViews/0/byteLength", 113.into()), "bufferViews[0] is 113 bytes"),
        (adding("/bufferViews/0", "byteOffset", u64::MAX.into()), "bufferViews[0] is 48 bytes"),
        (adding("/bufferViews/1", "byteStride", 0.into()), "every 0 bytes"),
        (with("/buffers/0/byteLength", 1000.into()), "claims 1000 bytes, but has 112"),
        (adding("/buffers/0", "uri", "../a.bin".into()), "leaves its folder"),
        (adding("/nodes/0", "children", json!([0])), "nodes[0] is reached twice"),
        (adding("/nodes/0", "scale", json!([1, 0, 1])), "flattens its mesh"),
        (adding("/nodes/0", "rotation", json!([0, 0, 0, 0])), "a rotation of no length"),
        (
            adding("/nodes/0", "matrix", json!([1, 0, 0, 1, 0, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1])),
            "not affine",
        ),
        (adding("/nodes/0", "camera", 0.into()), "names cameras[0]"),
        (
            adding("/nodes/0", "extensions", json!({ "KHR_lights_punctual": { "light": 0 } })),
            "names lights[0]",
        ),
        (adding("/meshes/0/primitives/0", "material", 0.into()), "names materials[0]"),
        (
            adding("", "extensionsRequired", json!(["KHR_draco_mesh_compression"])),
            "without the extension \"KHR_draco_mesh_compression\"",
        ),
        (
            adding(
                "/accessors/0",
                "sparse",
                json!({
                    "count": 1, "values": { "bufferView": 0 },
                    "indices": { "bufferView": 0, "byteOffset": 14, "componentType": 5121 },
                }),
            ),
            "replaces element 128 of 4",
        ),
    ];
    for (document, why) in &refusals {
        let error = read(document).map(|_| why).unwrap_err();
        assert!(error.starts_with("a.glb") && error.contains(why), "{error}");
    }
}

#[test]
fn vertices_that_are_no_numbers_and_indices_of_none_are_refused() {
    let change = |at: usize, bytes: &[u8]| {
        let mut glb = glb(&square());
        let start = glb.len() - binary().len() + at;
        glb[start..start + bytes.len()].copy_from_slice(bytes);
        import(&glb, Path::new("")).unwrap_err().of(Path::new("a.glb")).to_string()
    };
    let nan = change(12, &f32::NAN.to_le_bytes());
    assert!(nan.contains("meshes[0].primitives[0]: vertex 1"), "{nan}");
    let beyond = change(48, &4u16.to_le_bytes());
    assert!(beyond.contains("meshes[0].primitives[0]") && beyond.contains('4'), "{beyond}");
}

#[test]
fn containers_that_are_cut_off_are_refused() {
    let whole = glb(&square());
    for length in 0..whole.len() {
        assert!(import(&whole[..length], Path::new("")).is_err(), "{length}");
    }
    let mut version = whole.clone();
    version[4] = 1;
    assert!(import(&version, Path::new("")).is_err());
    let mut kind = whole;
    kind[16] = b'X';
    assert!(import(&kind, Path::new("")).is_err());
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 400, failure_persistence: None, ..Default::default() })]

    #[test]
    fn damaged_files_are_read_or_refused(
        changes in prop::collection::vec((any::<prop::sample::Index>(), any::<u8>()), 1..6),
    ) {
        let mut bytes = glb(&square());
        for (at, value) in &changes {
            let at = at.index(bytes.len());
            bytes[at] = *value;
        }
        let _ = import(&bytes, Path::new("nowhere"));
    }

    #[test]
    fn damaged_images_have_a_mean_or_none(
        changes in prop::collection::vec((any::<prop::sample::Index>(), any::<u8>()), 1..6),
    ) {
        let mut bytes = grey_jpeg();
        for (at, value) in &changes {
            let at = at.index(bytes.len());
            bytes[at] = *value;
        }
        let _ = crate::texture::decode(&bytes);
    }

    #[test]
    fn any_bytes_are_read_or_refused(bytes in prop::collection::vec(any::<u8>(), 0..200)) {
        let _ = import(&bytes, Path::new("nowhere"));
        let _ = import(&[b"glTF\x02\0\0\0", &bytes[..]].concat(), Path::new("nowhere"));
    }

    #[test]
    fn numbers_of_any_size_are_read_or_refused(
        pointer in prop::sample::select(vec![
            "/scene", "/scenes/0/nodes/0", "/nodes/0/mesh", "/meshes/0/primitives/0/indices",
            "/meshes/0/primitives/0/attributes/POSITION", "/accessors/0/bufferView",
            "/accessors/0/componentType", "/accessors/0/count", "/accessors/1/count",
            "/accessors/2/byteOffset", "/bufferViews/0/buffer", "/bufferViews/0/byteLength",
            "/bufferViews/1/byteOffset", "/bufferViews/3/byteStride", "/buffers/0/byteLength",
        ]),
        number in prop_oneof![any::<u64>(), 0u64..300, Just(u64::from(u32::MAX)), Just(u64::MAX)],
    ) {
        let _ = read(&with(pointer, number.into()));
    }
}
