//! The scenes that are made for a mesh alone.

use super::accepted::deposit;
use super::meaning_of;
use crate::scene::document::SnowKindName;
use crate::scene::{MeshSceneOptions, MeshUnits, SceneError, SceneFile, UpAxis, scene_for_mesh};
use snowgrain_math::{Aabb, DVec3};
use snowgrain_render::description::{Projection, SceneDescription};
use std::path::Path;

/// The description of the scene made for a mesh with these bounds.
fn look(bounds: Aabb, options: &MeshSceneOptions) -> (SceneDescription, Vec<String>) {
    let made = scene_for_mesh("model.obj", &bounds, options).unwrap();
    let file = SceneFile::parse(&made.toml, Path::new("folder/model.toml"), &[]).unwrap();
    (meaning_of(&file).unwrap(), made.assumptions)
}

/// The corners of the mesh's box, where a quick look puts them.
fn placed_corners(scene: &SceneDescription, bounds: &Aabb) -> Vec<DVec3> {
    let pick = |bit: bool, axis: usize| if bit { bounds.max[axis] } else { bounds.min[axis] };
    (0..8)
        .map(|i| DVec3::new(pick(i & 1 > 0, 0), pick(i & 2 > 0, 1), pick(i & 4 > 0, 2)))
        .map(|corner| scene.objects[0].transform.transform_point3(corner))
        .collect()
}

/// Where a point falls in the square picture: within [-1, 1] in x and y.
pub(super) fn in_picture(scene: &SceneDescription, point: DVec3) -> [f64; 2] {
    let camera = &scene.camera;
    let gaze = (camera.at - camera.from).normalize();
    let right = gaze.cross(camera.up).normalize();
    let offset = point - camera.from;
    let Projection::Perspective { vertical_fov_degrees, lens: None } = camera.projection else {
        panic!("a pinhole")
    };
    let half = (vertical_fov_degrees * 0.5).to_radians();
    let reach = gaze.dot(offset) * snowgrain_math::trig::tan(half);
    [right.dot(offset) / reach, right.cross(gaze).dot(offset) / reach]
}

#[test]
fn a_mesh_alone_stands_on_a_slab_in_real_size() {
    let bounds = Aabb::new(DVec3::new(90.0, -7.0, 3.0), DVec3::new(110.0, 33.0, 13.0));
    for (options, longest) in [
        (MeshSceneOptions::default(), 0.2),
        (MeshSceneOptions { units: Some(MeshUnits::Millimetres), ..Default::default() }, 0.04),
        (MeshSceneOptions { object_size: Some(1.5), ..Default::default() }, 1.5),
        (MeshSceneOptions { up: Some(UpAxis::Z), ..Default::default() }, 0.2),
    ] {
        let (scene, assumptions) = look(bounds, &options);
        let corners = placed_corners(&scene, &bounds);
        let stands = corners.iter().fold(Aabb::EMPTY, |b, &corner| b.including(corner));
        let height = if options.up == Some(UpAxis::Z) { 0.25 } else { 1.0 };
        assert!((stands.size().y / longest - height).abs() < 1e-12);
        assert!(stands.min.y.abs() < 1e-12);
        assert!((stands.min.x + stands.max.x).abs() < 1e-12);
        assert!((stands.min.z + stands.max.z).abs() < 1e-12);
        for corner in corners {
            let [x, y] = in_picture(&scene, corner);
            assert!(x.abs() <= 1.0 && y.abs() <= 1.0, "({x}, {y})");
        }
        assert_eq!(assumptions.len(), 3);
        check_ground(&scene, &stands);
    }
}

/// The snow's area is the top of the ground; object and foreground lie inside it, and only its far
/// edge is in the picture.
fn check_ground(scene: &SceneDescription, stands: &Aabb) {
    let ground = scene.objects[1].transform;
    let (low, high) =
        (ground.transform_point3(DVec3::new(-1.0, 1.0, -1.0)), ground.transform_point3(DVec3::ONE));
    assert_eq!((low.y, high.y), (0.0, 0.0));
    let [x0, z0, x1, z1] = deposit(scene).area.unwrap();
    let side = x1 - x0;
    for (edge, corner) in [(x0, low.x), (z0, low.z), (x1, high.x), (z1, high.z)] {
        assert!((edge - corner).abs() < 1e-4 * side, "{edge} {corner}");
    }
    assert!(stands.max.x < x1 && stands.max.z < z1 && stands.min.z > z0);
    assert!(in_picture(scene, DVec3::new(x1, 0.0, z0))[0] > 1.0);
    assert!(in_picture(scene, DVec3::new(0.0, 0.0, z1))[1] < -1.0);
    let far_edge = in_picture(scene, DVec3::new(0.0, 0.0, z0))[1];
    assert!((-0.4..0.9).contains(&far_edge), "{far_edge}");
}

#[test]
fn a_mesh_in_plausible_metres_keeps_its_size() {
    let bounds = Aabb::new(DVec3::ZERO, DVec3::new(0.15, 0.15, 0.12));
    let (scene, assumptions) = look(bounds, &MeshSceneOptions::default());
    let edge = scene.objects[0].transform.transform_vector3(DVec3::Z * 0.12);
    assert!((edge.length() - 0.12).abs() < 1e-12);
    assert!(assumptions[0].starts_with("longest side 0.1500 m (the file taken as metres"));
    let radius = deposit(&scene).radii.mean();
    assert!((0.0003..0.0008).contains(&radius), "{radius}");
}

#[test]
fn snow_of_a_kind_falls_on_a_mesh_of_any_size() {
    let bounds = Aabb::new(DVec3::ZERO, DVec3::splat(0.2));
    for kind in SnowKindName::ALL {
        for size in [0.001, 0.2, 50.0] {
            let (object_size, kind) = (Some(size), Some(kind));
            let options = MeshSceneOptions { object_size, kind, ..Default::default() };
            let made = scene_for_mesh("m.obj", &bounds, &options).unwrap();
            let file = SceneFile::parse(&made.toml, Path::new("x.toml"), &[]).unwrap();
            let snow = &file.document.snow[0];
            assert_eq!((snow.kind, snow.rule), (kind, None));
            assert!((1..=4_000_000).contains(&snow.grains.unwrap()), "{snow:?}");
        }
    }
}

#[test]
fn odd_names_and_sizes_of_meshes_are_safe() {
    let bounds = Aabb::new(DVec3::ZERO, DVec3::splat(1e300));
    let made = scene_for_mesh("a\"b\n'c.obj", &bounds, &MeshSceneOptions::default()).unwrap();
    let file = SceneFile::parse(&made.toml, Path::new("x.toml"), &[]).unwrap();
    assert_eq!(file.document.object[0].file.as_deref(), Some("a\"b\n'c.obj"));
    assert!(meaning_of(&file).is_err());
    for size in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        let options = MeshSceneOptions { object_size: Some(size), ..Default::default() };
        let error = scene_for_mesh("m.obj", &bounds, &options).unwrap_err();
        assert!(matches!(error, SceneError::BadValue { .. }), "{error}");
    }
}
