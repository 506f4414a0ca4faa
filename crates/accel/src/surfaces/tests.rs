use super::*;
use snowgrain_geometry::teapot;
use snowgrain_math::DMat3;
use snowgrain_math::frame::cosine_hemisphere;
use snowgrain_math::sampler::{PathKey, numbers};

/// A stream of uniform numbers.
struct Random {
    key: PathKey,
    event: u32,
}

impl Random {
    fn new(stream: u64) -> Self {
        Self { key: PathKey::new(2, stream, 0), event: 0 }
    }

    fn unit(&mut self) -> DVec3 {
        self.event += 1;
        let [x, y, z] = numbers(self.key, self.event).map(f64::from);
        DVec3::new(x, y, z)
    }

    /// In [-1, 1]^3.
    fn cube(&mut self) -> DVec3 {
        self.unit() * 2.0 - 1.0
    }

    fn direction(&mut self) -> DVec3 {
        loop {
            let d = self.cube();
            if (0.01..=1.0).contains(&d.length_squared()) {
                return d.normalize();
            }
        }
    }

    fn rotation(&mut self) -> DMat3 {
        let x = self.direction();
        let y = x.cross(self.direction()).normalize();
        DMat3::from_cols(x, y, x.cross(y))
    }
}

fn soup(random: &mut Random, count: u32) -> TriangleMesh {
    let mut positions = Vec::new();
    for _ in 0..count {
        let (center, size) = (random.cube(), random.unit().x * 0.5);
        positions.extend((0..3).map(|_| center + random.cube() * size));
    }
    let triangles = (0..count).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect();
    TriangleMesh::new(positions, triangles).unwrap()
}

/// A closed, bumpy ball: an octahedron whose faces are cut `n` times along each edge.
fn bumpy_ball(n: u32, bump: f64) -> TriangleMesh {
    let mut positions: Vec<DVec3> = Vec::new();
    let mut triangles = Vec::new();
    for face in 0..8u32 {
        let sign = |bit: u32| if face >> bit & 1 == 0 { 1.0 } else { -1.0 };
        let mut vertex = |i: u32, j: u32| {
            let p = DVec3::new(
                sign(0) * f64::from(i),
                sign(1) * f64::from(j),
                sign(2) * f64::from(n - i - j),
            ) + DVec3::ZERO;
            let wave = 1.0 + bump * f64::from((i * 7 + j * 13 + (n - i - j) * 29) % 11) / 11.0;
            let p = p.normalize() * wave;
            positions.iter().position(|&q| q == p).unwrap_or_else(|| {
                positions.push(p);
                positions.len() - 1
            }) as u32
        };
        for i in 0..n {
            for j in 0..n - i {
                triangles.push([vertex(i, j), vertex(i + 1, j), vertex(i, j + 1)]);
                if i + j + 2 <= n {
                    triangles.push([vertex(i + 1, j), vertex(i + 1, j + 1), vertex(i, j + 1)]);
                }
            }
        }
    }
    TriangleMesh::new(positions, triangles).unwrap()
}

fn mesh(mesh: TriangleMesh, transform: DAffine3) -> Surfaces {
    Surfaces::new(&[(SurfaceShape::Mesh(Arc::new(mesh)), transform)])
}

/// One of everything, tilted and stretched, around `origin`.
fn everything(random: &mut Random, origin: DVec3) -> Surfaces {
    let mut place = |size: DVec3| {
        let matrix = random.rotation() * DMat3::from_diagonal(size) * random.rotation();
        DAffine3 { matrix3: matrix, translation: origin + random.cube() }
    };
    let transforms = [
        place(DVec3::splat(0.4)),
        place(DVec3::new(0.8, 0.3, 0.1)),
        place(DVec3::new(0.5, 0.2, 0.3)),
        place(DVec3::splat(0.3)),
        DAffine3 {
            matrix3: DMat3::from_cols(
                DVec3::new(1.0, 0.2, 0.0),
                DVec3::Y,
                DVec3::new(0.0, 0.3, 1.0),
            ),
            translation: origin - DVec3::Y,
        },
        DAffine3::from_translation(origin),
    ];
    let shapes = [
        SurfaceShape::Sphere,
        SurfaceShape::Sphere,
        SurfaceShape::Box,
        SurfaceShape::Box,
        SurfaceShape::Plane,
        SurfaceShape::Mesh(Arc::new(soup(random, 40))),
    ];
    Surfaces::new(&shapes.into_iter().zip(transforms).collect::<Vec<_>>())
}

fn brute_force(
    surfaces: &Surfaces,
    ray: &Ray,
    exclude: Option<SurfaceId>,
) -> Option<(f64, SurfaceId)> {
    let sheared = (
        triangle::ShearedRay::<0>::new(ray),
        triangle::ShearedRay::<1>::new(ray),
        triangle::ShearedRay::<2>::new(ray),
    );
    let main = triangle::main_axis(ray.direction);
    let meet = |t: &Triangle| match main {
        0 => t.intersect(&sheared.0),
        1 => t.intersect(&sheared.1),
        _ => t.intersect(&sheared.2),
    };
    let triangles = surfaces
        .bvh
        .triangles
        .iter()
        .filter(|t| Some(t.id) != exclude)
        .filter_map(|t| Some((meet(t)?, t.id)));
    let solids = surfaces.solids.iter().filter_map(|s| s.intersect(ray, exclude));
    triangles.chain(solids.map(|hit| (hit.t, hit.id))).min_by(|a, b| a.partial_cmp(b).unwrap())
}

#[test]
fn rays_find_what_brute_force_finds_at_every_simd_level() {
    let best = Level::new();
    #[cfg(target_arch = "x86_64")]
    let levels = {
        let baseline = best.as_sse2().map(Level::Sse2);
        let avx2 = best.as_avx2().map(Level::Avx2);
        [Some(best), baseline, avx2]
    };
    #[cfg(not(target_arch = "x86_64"))]
    let levels = [Some(best)];
    let mut hits = 0;
    for scene in 0..12 {
        let mut random = Random::new(scene);
        let origin = [DVec3::ZERO, DVec3::new(1e4, -1e4, 3e3)][scene as usize % 2];
        let mut surfaces = if scene < 6 {
            mesh(soup(&mut random, 400), DAffine3::from_translation(origin))
        } else {
            everything(&mut random, origin)
        };
        for level in levels.into_iter().flatten() {
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
                assert_eq!(hit.map(|h| (h.t, h.id)), brute_force(&surfaces, &ray, exclude));
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
            let contact = surfaces.drop_sphere(p.x, p.z, radius, start_y);
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
        let contact = surfaces.drop_sphere(p.x, p.z, 0.0, 2.0);
        assert_eq!(contact.map(|c| (c.center_y, c.id)), hit.map(|h| (2.0 - h.t, h.id)));
    }
}

#[test]
fn contacts_have_their_closed_forms() {
    let sphere =
        |scale: DVec3| Surfaces::new(&[(SurfaceShape::Sphere, DAffine3::from_scale(scale))]);
    let unit = sphere(DVec3::ONE);
    for x in [0.0, 0.3, 0.9, 1.2, 1.249] {
        let y = unit.drop_sphere(x, 0.0, 0.25, 4.0).unwrap().center_y;
        assert!((y * y + x * x - 1.25 * 1.25).abs() < 1e-13, "{x}: {y}");
    }
    assert_eq!(unit.drop_sphere(1.2501, 0.0, 0.25, 4.0), None);
    assert_eq!(unit.drop_sphere(0.3, 0.0, 0.25, -4.0), None);
    let inside = unit.drop_sphere(0.3, 0.0, 0.25, 0.0).unwrap();
    assert!((inside.center_y + (0.75f64 * 0.75 - 0.09).sqrt()).abs() < 1e-13);
    assert!(inside.normal.y > 0.0);
    let flat = sphere(DVec3::new(3.0, 0.5, 2.0)).drop_sphere(0.0, 0.0, 0.1, 9.0).unwrap();
    assert!((flat.center_y - 0.6).abs() < 1e-14 && (flat.normal - DVec3::Y).length() < 1e-14);
    // The foot of the radius lies on x^2/9 + y^2/0.25 = 1, along the gradient.
    let side = sphere(DVec3::new(3.0, 0.5, 2.0)).drop_sphere(2.5, 0.0, 0.1, 9.0).unwrap();
    let p = side.point;
    assert!((p.x * p.x / 9.0 + p.y * p.y / 0.25 - 1.0).abs() < 1e-13);
    let gradient = DVec3::new(p.x / 9.0, p.y / 0.25, 0.0).normalize();
    assert!((gradient - side.normal).length() < 1e-12);

    let cube = Surfaces::new(&[(SurfaceShape::Box, DAffine3::IDENTITY)]);
    assert_eq!(cube.drop_sphere(0.2, 0.4, 0.5, 9.0).unwrap().center_y, 1.5);
    let edge = cube.drop_sphere(1.3, 0.4, 0.5, 9.0).unwrap();
    assert!((edge.center_y - 1.4).abs() < 1e-14);
    let corner = cube.drop_sphere(1.2, 1.2, 0.3, 9.0).unwrap();
    assert!((corner.center_y - 1.1).abs() < 1e-14);
    assert_eq!(corner.point, DVec3::ONE);
    let overlapping = cube.drop_sphere(0.0, 0.0, 0.5, 1.2).unwrap();
    assert_eq!((overlapping.center_y, overlapping.point), (1.2, DVec3::Y));

    let slope = DAffine3 {
        matrix3: DMat3::from_cols(DVec3::new(1.0, 0.75, 0.0), DVec3::Y, DVec3::Z),
        translation: DVec3::new(0.0, 1.0, 0.0),
    };
    let plane = Surfaces::new(&[(SurfaceShape::Plane, slope)]);
    let contact = plane.drop_sphere(0.0, 5.0, 0.8, 9.0).unwrap();
    assert!((contact.center_y - 2.0).abs() < 1e-14);
    assert!((contact.normal - DVec3::new(-0.6, 0.8, 0.0)).length() < 1e-15);
    assert_eq!(plane.drop_sphere(0.0, 5.0, 0.8, -3.0), None);
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
fn no_box_that_holds_a_surface_point_is_called_free() {
    let mut yes = 0;
    for scene in 0..10 {
        let mut random = Random::new(scene);
        let origin = [DVec3::ZERO, DVec3::new(-1e4, 2e3, 1e4)][scene as usize % 2];
        let surfaces = everything(&mut random, origin);
        for _ in 0..400 {
            let ray = Ray::new(origin + random.cube() * 3.0, random.direction());
            let Some(hit) = surfaces.intersect(&ray, 8.0, None) else { continue };
            let (corner, size) = (random.unit(), random.unit().x * 0.2);
            let min = ray.at(hit.t) - corner * size;
            assert!(surfaces.may_cross(&Aabb::new(min, min + size)), "{hit:?}");
            yes += 1;
        }
    }
    assert!(yes > 1000, "{yes}");
}

#[test]
fn free_boxes_are_mostly_called_free() {
    let mut random = Random::new(77);
    let (mut wrong, mut free) = (0, 0);
    let mut near = Vec::new();
    for scene in 0..10 {
        let surfaces = everything(&mut Random::new(scene), DVec3::ZERO);
        for _ in 0..300 {
            let (center, half) = (random.cube(), 0.02);
            surfaces.near(center, half * 3.0f64.sqrt(), &mut near);
            if near.is_empty() {
                free += 1;
                let bounds = Aabb::new(center - half, center + half);
                wrong += i32::from(surfaces.may_cross(&bounds));
            }
        }
    }
    assert!(free > 1000 && wrong * 100 < free, "{wrong} of {free}");
}

#[test]
fn near_finds_the_closest_points_in_order() {
    let mut out = Vec::new();
    for scene in 0..6 {
        let mut random = Random::new(scene);
        let surfaces = everything(&mut random, DVec3::ZERO);
        for _ in 0..30 {
            let p = random.cube();
            surfaces.near(p, f64::INFINITY, &mut out);
            assert!(out.windows(2).all(|pair| pair[0].id < pair[1].id));
            assert_eq!(out.len(), 2 + 12 + 1 + surfaces.bvh.triangles.len());
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

#[test]
fn a_scene_without_surfaces_answers_nothing() {
    let surfaces = Surfaces::default();
    let mut out = vec![];
    assert!(surfaces.is_empty() && !surfaces.has_infinite() && surfaces.bounds().is_empty());
    assert_eq!(surfaces.intersect(&Ray::new(DVec3::ZERO, DVec3::Y), 9.0, None), None);
    assert_eq!(surfaces.drop_sphere(0.0, 0.0, 1.0, 5.0), None);
    assert!(!surfaces.may_cross(&Aabb::new(-DVec3::ONE, DVec3::ONE)));
    surfaces.near(DVec3::ZERO, 5.0, &mut out);
    assert!(out.is_empty());
    let plane = Surfaces::new(&[(SurfaceShape::Plane, DAffine3::IDENTITY)]);
    assert!(!plane.is_empty() && plane.has_infinite() && plane.bounds().is_empty());
}

#[test]
fn flattened_objects_are_harmless() {
    let flat = DAffine3::from_scale(DVec3::new(1.0, 0.0, 1.0));
    let shapes = [
        SurfaceShape::Sphere,
        SurfaceShape::Box,
        SurfaceShape::Plane,
        SurfaceShape::Mesh(Arc::new(bumpy_ball(2, 0.0))),
        SurfaceShape::Mesh(Arc::default()),
    ];
    for transform in [flat, DAffine3::from_scale(DVec3::ZERO)] {
        let surfaces = Surfaces::new(&shapes.clone().map(|shape| (shape, transform)));
        let mut random = Random::new(3);
        let mut out = Vec::new();
        for _ in 0..100 {
            let ray = Ray::new(random.cube(), random.direction());
            let _ = surfaces.intersect(&ray, f64::INFINITY, None);
            let _ = surfaces.drop_sphere(ray.origin.x, ray.origin.z, 0.1, 2.0);
            surfaces.near(ray.origin, 0.5, &mut out);
        }
    }
}

/// `cargo test --release -p snowgrain-accel -- --ignored --nocapture rate`
#[test]
#[ignore = "measures speed, asserts nothing"]
fn rate_of_rays_on_the_teapot() {
    for divisions in [32, 128] {
        let start = std::time::Instant::now();
        let surfaces = mesh(teapot(divisions), DAffine3::IDENTITY);
        let build = start.elapsed().as_secs_f64();
        let mut random = Random::new(0);
        let bounds = surfaces.bounds();
        let point = |random: &mut Random| bounds.min + random.unit() * bounds.size();
        let rays: Vec<Ray> = (0..1_000_000)
            .map(|_| {
                let (from, to) = (point(&mut random), point(&mut random));
                Ray::new(from, (to - from).normalize())
            })
            .collect();
        let start = std::time::Instant::now();
        let hits =
            rays.iter().filter(|r| surfaces.intersect(r, f64::INFINITY, None).is_some()).count();
        let trace = start.elapsed().as_secs_f64();
        let start = std::time::Instant::now();
        let crossed = rays
            .iter()
            .filter(|r| surfaces.may_cross(&Aabb::new(r.origin - 0.01, r.origin + 0.01)))
            .count();
        let cross = start.elapsed().as_secs_f64();
        let start = std::time::Instant::now();
        let landed = rays
            .iter()
            .filter(|r| surfaces.drop_sphere(r.origin.x, r.origin.z, 0.01, 4.0).is_some())
            .count();
        let drop = start.elapsed().as_secs_f64();
        println!(
            "{} triangles, {} bytes, built in {build:.3} s: {:.2} M rays/s ({hits} hit), \
             {:.2} M boxes/s ({crossed} crossed), {:.2} M drops/s ({landed} land)",
            surfaces.bvh.triangles.len(),
            surfaces.memory_bytes(),
            1.0 / trace,
            1.0 / cross,
            1.0 / drop,
        );
    }
}
