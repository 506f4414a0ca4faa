//! Falling spheres and nearest points.

use super::*;

/// The height below which contacts do not count, where all count.
const ON_AND_ON: f64 = f64::NEG_INFINITY;

/// Distance from `p` to the nearest surface.
fn distance(surfaces: &Surfaces, p: DVec3, out: &mut Vec<SphereContact>) -> f64 {
    surfaces.near(p, f64::INFINITY, out);
    out.iter().map(|contact| contact.center_y).fold(f64::INFINITY, f64::min)
}

#[test]
fn a_falling_sphere_stops_where_a_numeric_search_says() {
    let (mut contacts, mut misses, mut overlaps) = (0, 0, 0);
    let mut out = Vec::new();
    for scene in 0..12 {
        let mut random = Random::new(scene);
        let mut surfaces = everything(&mut random, DVec3::ZERO);
        if scene % 2 == 1 {
            surfaces = mesh(soup(&mut random, 60), DAffine3::IDENTITY);
        }
        for _ in 0..60 {
            let p = random.cube() * 1.2;
            let radius = [0.003, 0.05, 0.4][scene as usize % 3];
            let start_y = p.y * 2.0 + 1.0;
            let contact = surfaces.drop_sphere(p.x, p.z, radius, [start_y, ON_AND_ON]);
            let end = contact.map_or(-6.0, |c| c.center_y);
            let at = |y: f64| DVec3::new(p.x, y, p.z);
            if let Some(c) = contact {
                let gap = distance(&surfaces, at(end), &mut out);
                if end == start_y {
                    assert!(gap <= radius);
                    overlaps += 1;
                    continue;
                }
                contacts += 1;
                assert!((gap - radius).abs() < 1e-9, "{c:?}: gap {gap}, radius {radius}");
                assert!((c.point + c.normal * radius - at(end)).length() < 1e-7, "{c:?}");
                assert!((c.normal.length() - 1.0).abs() < 1e-12 && c.normal.y > -1e-9);
            } else {
                misses += 1;
            }
            for i in 0..100 {
                let y = end + (start_y - end) * f64::from(i) / 100.0;
                let gap = distance(&surfaces, at(y), &mut out);
                assert!(gap > radius - 1e-9, "{gap} at {y}, radius {radius}");
            }
        }
    }
    assert!(contacts > 200 && misses > 20 && overlaps > 20, "{contacts} {misses} {overlaps}");
}

#[test]
fn a_falling_point_is_a_ray() {
    let mut random = Random::new(5);
    let surfaces = everything(&mut random, DVec3::ZERO);
    for _ in 0..100 {
        let p = random.cube();
        let ray = Ray::new(DVec3::new(p.x, 2.0, p.z), DVec3::NEG_Y);
        let hit = surfaces.intersect(&ray, f64::INFINITY, None);
        let contact = surfaces.drop_sphere(p.x, p.z, 0.0, [2.0, ON_AND_ON]);
        assert_eq!(contact.map(|c| (c.center_y, c.id)), hit.map(|h| (2.0 - h.t, h.id)));
    }
}

#[test]
fn contacts_have_their_closed_forms() {
    let sphere =
        |scale: DVec3| Surfaces::new(&[(SurfaceShape::Sphere, DAffine3::from_scale(scale))]);
    let unit = sphere(DVec3::ONE);
    for x in [0.0, 0.3, 0.9, 1.2, 1.249] {
        let y = unit.drop_sphere(x, 0.0, 0.25, [4.0, ON_AND_ON]).unwrap().center_y;
        assert!((y * y + x * x - 1.25 * 1.25).abs() < 1e-13, "{x}: {y}");
    }
    assert_eq!(unit.drop_sphere(1.2501, 0.0, 0.25, [4.0, ON_AND_ON]), None);
    assert_eq!(unit.drop_sphere(0.3, 0.0, 0.25, [-4.0, ON_AND_ON]), None);
    let inside = unit.drop_sphere(0.3, 0.0, 0.25, [0.0, ON_AND_ON]).unwrap();
    assert!((inside.center_y + (0.75f64 * 0.75 - 0.09).sqrt()).abs() < 1e-13);
    assert!(inside.normal.y > 0.0);
    let flat =
        sphere(DVec3::new(3.0, 0.5, 2.0)).drop_sphere(0.0, 0.0, 0.1, [9.0, ON_AND_ON]).unwrap();
    assert!((flat.center_y - 0.6).abs() < 1e-14 && (flat.normal - DVec3::Y).length() < 1e-14);
    // The foot of the radius lies on x^2/9 + y^2/0.25 = 1, along the gradient.
    let side =
        sphere(DVec3::new(3.0, 0.5, 2.0)).drop_sphere(2.5, 0.0, 0.1, [9.0, ON_AND_ON]).unwrap();
    let p = side.point;
    assert!((p.x * p.x / 9.0 + p.y * p.y / 0.25 - 1.0).abs() < 1e-13);
    let gradient = DVec3::new(p.x / 9.0, p.y / 0.25, 0.0).normalize();
    assert!((gradient - side.normal).length() < 1e-12);

    let cube = Surfaces::new(&[(SurfaceShape::Box, DAffine3::IDENTITY)]);
    assert_eq!(cube.drop_sphere(0.2, 0.4, 0.5, [9.0, ON_AND_ON]).unwrap().center_y, 1.5);
    let edge = cube.drop_sphere(1.3, 0.4, 0.5, [9.0, ON_AND_ON]).unwrap();
    assert!((edge.center_y - 1.4).abs() < 1e-14);
    let corner = cube.drop_sphere(1.2, 1.2, 0.3, [9.0, ON_AND_ON]).unwrap();
    assert!((corner.center_y - 1.1).abs() < 1e-14);
    assert_eq!(corner.point, DVec3::ONE);
    let overlapping = cube.drop_sphere(0.0, 0.0, 0.5, [1.2, ON_AND_ON]).unwrap();
    assert_eq!((overlapping.center_y, overlapping.point), (1.2, DVec3::Y));

    let slope = DAffine3 {
        matrix3: DMat3::from_cols(DVec3::new(1.0, 0.75, 0.0), DVec3::Y, DVec3::Z),
        translation: DVec3::new(0.0, 1.0, 0.0),
    };
    let plane = Surfaces::new(&[(SurfaceShape::Plane, slope)]);
    let contact = plane.drop_sphere(0.0, 5.0, 0.8, [9.0, ON_AND_ON]).unwrap();
    assert!((contact.center_y - 2.0).abs() < 1e-14);
    assert!((contact.normal - DVec3::new(-0.6, 0.8, 0.0)).length() < 1e-15);
    assert_eq!(plane.drop_sphere(0.0, 5.0, 0.8, [-3.0, ON_AND_ON]), None);
}

#[test]
fn near_finds_the_closest_points_in_order() {
    let mut out = Vec::new();
    for scene in 0..6 {
        let mut random = Random::new(scene);
        let objects = one_of_each(&mut random, DVec3::ZERO);
        let surfaces = Surfaces::new(&objects);
        let triangles = BruteForce::new(&objects).triangles.len();
        for _ in 0..30 {
            let p = random.cube();
            surfaces.near(p, f64::INFINITY, &mut out);
            assert!(out.windows(2).all(|pair| pair[0].id < pair[1].id));
            assert_eq!(out.len(), 2 + 12 + 1 + triangles);
            let all = out.clone();
            for contact in &all {
                let offset = contact.point + contact.normal * contact.center_y - p;
                assert!(offset.length() < 1e-12, "{contact:?}");
            }
            // No point that a ray finds on a piece is nearer than the piece's closest one.
            for _ in 0..40 {
                let ray = Ray::new(p, random.direction());
                let Some(hit) = surfaces.intersect(&ray, f64::INFINITY, None) else { continue };
                let contact = all.iter().find(|contact| contact.id == hit.id).unwrap();
                assert!(hit.t >= contact.center_y - 1e-12, "{hit:?} {contact:?}");
            }
            surfaces.near(p, 0.2, &mut out);
            let expected: Vec<_> = all.into_iter().filter(|c| c.center_y < 0.2).collect();
            assert_eq!(out, expected);
        }
    }
}
