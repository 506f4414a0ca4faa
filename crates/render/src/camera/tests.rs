//! What cameras must do: closed forms and identities.

use super::*;
use crate::description::{Focus, Lens};
use snowgrain_math::sampler::{PathKey, numbers};

const SIZE: (u32, u32) = (120, 80);

fn camera(projection: Projection) -> Camera {
    let description = CameraDescription {
        from: DVec3::new(0.3, 0.4, 0.5),
        at: DVec3::new(-0.2, 0.1, -0.3),
        up: DVec3::Y,
        projection,
        backdrop: [0.0; 3],
    };
    Camera::new(&description, &FilmDescription::new(SIZE.0, SIZE.1, 1, 0))
}

fn lens(diameter: f64, focus_distance: f64, blades: u32) -> Projection {
    let focus = Focus::Distance(focus_distance);
    let lens = Lens { diameter, focus, blades, blade_rotation_degrees: 10.0 };
    Projection::Perspective { vertical_fov_degrees: 35.0, lens: Some(lens) }
}

fn all() -> [Camera; 4] {
    [
        camera(Projection::pinhole(35.0)),
        camera(lens(0.02, 0.6, 0)),
        camera(lens(0.005, 0.1, 5)),
        camera(Projection::Orthographic { height: 0.2 }),
    ]
}

/// Image places and places of the lens, at random.
fn places() -> impl Iterator<Item = ([f64; 2], [f64; 2])> {
    (0..200).map(|index| {
        let key = PathKey::new(2, index, 0);
        let [x, y, _] = numbers(key, 0).map(f64::from);
        let [u, v, _] = numbers(key, 1).map(f64::from);
        ([x * f64::from(SIZE.0), y * f64::from(SIZE.1)], [u, v])
    })
}

#[test]
fn a_point_of_a_ray_is_projected_to_where_the_ray_came_from() {
    for camera in all() {
        for ([x, y], lens) in places() {
            let ray = camera.ray(x, y, lens);
            assert!((ray.direction.length() - 1.0).abs() < 1e-15);
            for distance in [0.01, 0.3, 7.0] {
                let (px, py) = camera.project(ray.at(distance), lens).unwrap();
                assert!((px - x).abs() < 1e-9 && (py - y).abs() < 1e-9, "{camera:?}");
            }
            assert_eq!(camera.project(ray.at(-0.3), lens), None, "behind the camera");
        }
    }
}

#[test]
fn rays_of_one_place_of_the_lens_are_one_bundle() {
    for camera in all() {
        for ([x, y], lens) in places() {
            let ray = camera.ray(x, y, lens);
            match camera.bundle(lens) {
                Bundle::Through(point) => assert_eq!(ray.origin, point),
                Bundle::Along(direction) => assert_eq!(ray.direction, direction),
            }
        }
    }
}

#[test]
fn a_small_lens_is_a_pinhole_and_every_lens_is_one_in_focus() {
    let pinhole = camera(Projection::pinhole(35.0));
    let focus = 0.6;
    let wide = camera(lens(0.02, focus, 7));
    for ([x, y], place) in places() {
        let ray = pinhole.ray(x, y, place);
        let at = ray.at(focus / ray.direction.dot(pinhole.forward));
        let through = wide.ray(x, y, place);
        let distance = (at - through.origin).length();
        assert!((through.at(distance) - at).length() < 1e-15, "the rays meet in focus");
        assert!(wide.depth(through.origin).abs() < 1e-15, "the lens is across the view");
    }
    let tiny = camera(lens(1e-9, focus, 0));
    for ([x, y], place) in places() {
        let apart = tiny.ray(x, y, place).direction - pinhole.ray(x, y, place).direction;
        assert!(apart.length() < 1e-8);
    }
}

/// Similar triangles: a point at the distance z spreads over a disc of diameter D |z - f| / z in the
/// plane at the distance z' = f in focus.
#[test]
fn a_point_out_of_focus_spreads_over_its_circle_of_confusion() {
    let (diameter, focus) = (0.03, 0.5);
    let camera = camera(lens(diameter, focus, 0));
    for z in [0.2, 0.45, 0.8, 5.0] {
        let point = camera.origin + camera.forward * z + camera.right * (0.3 * z);
        let places = places().map(|(_, lens)| camera.project(point, lens).unwrap());
        let (center_x, center_y) = camera.project(point, [0.5, 0.5]).unwrap();
        let radius = places
            .map(|(x, y)| (DVec3::new(x - center_x, y - center_y, 0.0)).length())
            .fold(0.0, f64::max);
        let expected = 0.5 * diameter * (z - focus).abs() / z / camera.pixel_footprint(focus);
        assert!(radius <= expected * (1.0 + 1e-9), "{z}: {radius} > {expected} pixels");
        assert!(radius > 0.97 * expected, "{z}: {radius} < {expected} pixels");
        // Its rim, exactly.
        let (x, y) = camera.project(point, [0.5, 0.0]).unwrap();
        let rim = DVec3::new(x - center_x, y - center_y, 0.0).length();
        assert!((rim - expected).abs() < 1e-9 * expected, "{z}: {rim} {expected}");
    }
}

/// A little square of the picture against the solid angle, or the area, that its rays span.
#[test]
fn pixels_are_as_dense_as_the_rays_of_their_corners() {
    for camera in all() {
        for ([x, y], lens) in places().take(20) {
            const EDGE: f64 = 1e-3;
            let middle = camera.ray(x, y, lens);
            let right = camera.ray(x + EDGE, y, lens);
            let down = camera.ray(x, y + EDGE, lens);
            let span = match camera.bundle(lens) {
                Bundle::Through(_) => {
                    (right.direction - middle.direction).cross(down.direction - middle.direction)
                }
                Bundle::Along(_) => {
                    (right.origin - middle.origin).cross(down.origin - middle.origin)
                }
            };
            let density = EDGE * EDGE / span.length();
            let ratio = camera.pixel_density(middle.direction) / density;
            assert!((ratio - 1.0).abs() < 1e-4, "{camera:?}: {ratio}");
        }
    }
}

#[test]
fn a_footprint_is_the_distance_of_neighbouring_rays() {
    for camera in all() {
        let distance = 0.37;
        let at = |x: f64| {
            let ray = camera.ray(x, 40.0, [0.5, 0.5]);
            ray.at(distance / ray.direction.dot(camera.forward))
        };
        let apart = (at(61.0) - at(60.0)).length();
        // In other planes rays from beside the middle of a lens are as far apart, too.
        assert!((apart - camera.pixel_footprint(distance)).abs() < 1e-12, "{camera:?}");
    }
    let orthographic = camera(Projection::Orthographic { height: 0.2 });
    assert!((orthographic.pixel_footprint(1.0) - 0.2 / 80.0).abs() < 1e-15);
}

/// Blades show upright behind the focus and upside down before it.
#[test]
fn blur_behind_the_focus_stands_as_the_opening_does() {
    let camera = camera(lens(0.02, 0.5, 3));
    let corner = [0.0, 0.0];
    for (z, upright) in [(2.0, true), (0.2, false)] {
        let point = camera.origin + camera.forward * z;
        let highest = (1..400)
            .map(|i| [f64::from(i) / 400.0, 0.0])
            .map(|lens| camera.project(point, lens).unwrap().1)
            .fold(f64::INFINITY, f64::min);
        let height = camera.project(point, corner).unwrap().1;
        assert!((height - 40.0).abs() < 1e-9, "the middle of the lens");
        let lowest = 80.0
            - (1..400)
                .map(|i| camera.project(point, [f64::from(i) / 400.0, 0.0]).unwrap().1)
                .fold(0.0, f64::max);
        assert_eq!(highest < lowest, upright, "{z}: {highest} {lowest}");
    }
}

#[test]
fn the_pencil_of_a_place_of_the_lens_has_the_rays_of_the_camera() {
    for camera in all() {
        for ([x, y], lens) in places() {
            let ray = camera.ray(x, y, lens);
            let (origin, direction) = camera.pencil(lens).ray([x, y]);
            assert!((origin - ray.origin).length() < 1e-14, "{camera:?}");
            assert!((direction - ray.direction).length() < 1e-14, "{camera:?}");
        }
    }
}
