//! Rays against brute force, closed rooms and solids.

use super::*;
use snowgrain_math::frame::cosine_hemisphere;

#[test]
fn rays_find_what_brute_force_finds_at_every_simd_level() {
    let mut hits = 0;
    for scene in 0..12 {
        let mut random = Random::new(scene);
        let origin = [DVec3::ZERO, DVec3::new(1e4, -1e4, 3e3)][scene as usize % 2];
        let objects = if scene < 6 {
            let soup = SurfaceShape::Mesh(Arc::new(soup(&mut random, 400)));
            vec![(soup, DAffine3::from_translation(origin))]
        } else {
            one_of_each(&mut random, origin)
        };
        let (mut surfaces, all) = (Surfaces::new(&objects), BruteForce::new(&objects));
        for level in SimdLevel::available() {
            surfaces = surfaces.with_level(level);
            let mut random = Random::new(100 + scene);
            let mut exclude = None;
            for i in 0..300 {
                let mut direction = random.direction();
                if i % 5 == 0 {
                    direction = [DVec3::NEG_Y, DVec3::X, -DVec3::Z][i / 5 % 3];
                }
                let away = if i % 2 == 0 { 1.0 } else { 40.0 };
                let start = origin + random.cube() - direction * away;
                let ray = Ray::new(start, direction);
                let hit = surfaces.intersect(&ray, f64::INFINITY, exclude);
                assert_eq!(hit.map(|h| (h.t, h.id)), all.intersect(&ray, exclude));
                exclude = hit.map(|h| h.id);
                let Some(hit) = hit else { continue };
                hits += 1;
                assert!(hit.normal.dot(direction) <= 0.0);
                assert!((hit.normal.length() - 1.0).abs() < 1e-12);
                assert_eq!(surfaces.intersect(&ray, hit.t, None).map(|h| h.t <= hit.t), Some(true));
                assert_eq!(surfaces.intersect(&ray, 0.0, None), None);
            }
        }
    }
    assert!(hits > 3000, "{hits}");
}

#[test]
fn hits_lie_on_the_surface() {
    for scene in 0..6 {
        let mut random = Random::new(scene);
        let surfaces = everything(&mut random, DVec3::ZERO);
        let mut near = Vec::new();
        for _ in 0..500 {
            let ray = Ray::new(random.cube() * 3.0, random.direction());
            let Some(hit) = surfaces.intersect(&ray, f64::INFINITY, None) else { continue };
            surfaces.near(ray.at(hit.t), 1e-9 * (1.0 + hit.t), &mut near);
            assert!(near.iter().any(|contact| contact.id == hit.id), "{hit:?}");
        }
    }
}

#[test]
fn nothing_leaks_through_edges_and_vertices() {
    let ball = bumpy_ball(9, 0.3);
    for origin in [DVec3::ZERO, DVec3::new(1e4, 1e4, -1e4)] {
        let surfaces = mesh(ball.clone(), DAffine3::from_translation(origin));
        for corners in &ball.triangles {
            let [a, b, c] = corners.map(|v| ball.positions[v as usize] + origin);
            for target in [a, (a + b) * 0.5, a * 0.25 + b * 0.75, (a + b + c) / 3.0] {
                let from_inside = Ray::new(origin, (target - origin).normalize());
                let hit = surfaces.intersect(&from_inside, f64::INFINITY, None).unwrap();
                assert!((hit.t - (target - origin).length()).abs() < 1e-8);
                let above = DVec3::new(target.x, origin.y + 5.0, target.z);
                let from_axis = DVec3::new(target.x - origin.x, 0.0, target.z - origin.z).length();
                // Only a vertex is exactly where it is; a rounded edge's silhouette may be missed.
                if target == a || from_axis < 0.9 {
                    let hit = surfaces.intersect(&Ray::new(above, DVec3::NEG_Y), 9.0, None);
                    assert!(hit.is_some_and(|hit| hit.t <= above.y - target.y + 1e-8));
                }
                for axis in [DVec3::X, DVec3::Y, DVec3::Z] {
                    let middle = target - axis * axis.dot(target - origin);
                    let inside = Ray::new(middle, axis);
                    if (middle - origin).length() < 0.95 {
                        assert!(surfaces.intersect(&inside, f64::INFINITY, None).is_some());
                    }
                }
            }
        }
    }
}

#[test]
fn light_stays_in_closed_rooms() {
    let room = |shape| Surfaces::new(&[(shape, DAffine3::IDENTITY)]);
    let rooms = [
        room(SurfaceShape::Sphere),
        room(SurfaceShape::Box),
        room(SurfaceShape::Mesh(Arc::new(bumpy_ball(6, 0.4)))),
        room(SurfaceShape::Mesh(Arc::new(bumpy_ball(1, 0.0)))),
    ];
    for (stream, surfaces) in rooms.iter().enumerate() {
        let mut random = Random::new(stream as u64);
        let mut ray = Ray::new(DVec3::ZERO, random.direction());
        let mut exclude = None;
        for bounce in 0..20_000 {
            let hit = surfaces.intersect(&ray, f64::INFINITY, exclude);
            let hit = hit.unwrap_or_else(|| panic!("room {stream} leaks after {bounce}"));
            let u = random.unit();
            ray = Ray::new(ray.at(hit.t), cosine_hemisphere(hit.normal, [u.x, u.y]));
            exclude = Some(hit.id);
        }
    }
}

#[test]
fn rays_inside_and_on_solids() {
    let sphere = Surfaces::new(&[(SurfaceShape::Sphere, DAffine3::from_scale(DVec3::splat(2.0)))]);
    let on = Some(SurfaceId { object: 0, piece: 0 });
    let far = f64::INFINITY;
    let inside = sphere.intersect(&Ray::new(DVec3::X, DVec3::X), far, None).unwrap();
    assert_eq!((inside.t, inside.normal), (1.0, -DVec3::X));
    let through = Ray::new(DVec3::new(2.0, 0.0, 0.0), -DVec3::X);
    assert_eq!(sphere.intersect(&through, far, on).unwrap().t, 4.0);
    assert_eq!(sphere.intersect(&Ray::new(DVec3::X * 2.0, DVec3::X), far, on), None);
    assert_eq!(sphere.intersect(&Ray::new(DVec3::X * 2.0, DVec3::Y), far, on), None);

    let cube = Surfaces::new(&[(SurfaceShape::Box, DAffine3::IDENTITY)]);
    let face = |piece| Some(SurfaceId { object: 0, piece });
    let center = cube.intersect(&Ray::new(DVec3::ZERO, DVec3::Z), far, None).unwrap();
    assert_eq!((center.t, center.normal, center.id.piece), (1.0, -DVec3::Z, 5));
    let through = cube.intersect(&Ray::new(DVec3::Y, DVec3::NEG_Y), far, face(3)).unwrap();
    assert_eq!((through.t, through.id.piece), (2.0, 2));
    assert_eq!(cube.intersect(&Ray::new(DVec3::ONE, DVec3::Y), far, face(3)), None);
}

#[test]
fn a_teapot_far_from_the_origin_is_the_same_teapot() {
    let far = DVec3::new(1e4, -1e4, 1e4);
    let place = |translation| {
        let matrix3 = DMat3::from_diagonal(DVec3::splat(0.05));
        mesh(teapot(8), DAffine3 { matrix3, translation })
    };
    let (here, there) = (place(DVec3::ZERO), place(far));
    let mut random = Random::new(8);
    let mut hits = 0;
    for _ in 0..2000 {
        let ray = Ray::new(random.cube() * 0.2, random.direction());
        let a = here.intersect(&ray, f64::INFINITY, None);
        let b = there.intersect(&Ray::new(ray.origin + far, ray.direction), f64::INFINITY, None);
        assert_eq!(a.is_some(), b.is_some());
        if let (Some(a), Some(b)) = (a, b) {
            hits += 1;
            assert!((a.t - b.t).abs() < 1e-9, "{} {}", a.t, b.t);
        }
    }
    assert!(hits > 200, "{hits}");
    let shift = there.bounds().min - here.bounds().min - far;
    assert!(shift.length() < 1e-11);
}
