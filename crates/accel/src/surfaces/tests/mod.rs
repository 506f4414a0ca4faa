mod contacts;
mod instances;
mod rays;

use super::solid::Solid;
use super::triangle::{ShearedRay, Triangle};
use super::*;
use snowgrain_geometry::teapot;
use snowgrain_math::sampler::{PathKey, numbers};
use snowgrain_math::trig;

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

/// Objects as a list that is gone through from end to end.
struct BruteForce {
    solids: Vec<Solid>,
    triangles: Vec<Triangle>,
}

type Objects = Vec<(SurfaceShape, DAffine3)>;

impl BruteForce {
    fn new(objects: &Objects) -> Self {
        let (mut solids, mut triangles) = (Vec::new(), Vec::new());
        for ((shape, transform), object) in objects.iter().zip(0u32..) {
            match shape {
                SurfaceShape::Sphere => solids.push(Solid::sphere(object, transform)),
                SurfaceShape::Box => solids.push(Solid::cuboid(object, transform)),
                SurfaceShape::Plane => solids.push(Solid::plane(object, transform)),
                SurfaceShape::Mesh(mesh) => triangles.extend((0..mesh.triangles.len()).map(|i| {
                    let corners = mesh.corners(i).map(|p| transform.transform_point3(p));
                    Triangle { corners, id: SurfaceId { object, piece: i as u32 } }
                })),
            }
        }
        triangles.retain(Triangle::has_area);
        Self { solids, triangles }
    }

    fn intersect(&self, ray: &Ray, exclude: Option<SurfaceId>) -> Option<(f64, SurfaceId)> {
        let sheared = ShearedRay::new(ray);
        let triangles = self.triangles.iter().filter(|t| Some(t.id) != exclude);
        let triangles = triangles.filter_map(|t| Some((t.intersect(&sheared)?, t.id)));
        let solids = self.solids.iter().filter_map(|s| s.intersect(ray, exclude));
        triangles.chain(solids.map(|hit| (hit.t, hit.id))).min_by(|a, b| a.partial_cmp(b).unwrap())
    }

    fn drop_sphere(&self, drop: &Drop) -> Option<SphereContact> {
        let mut first = None;
        for solid in &self.solids {
            solid.drop_sphere(drop, |y, touch, id| {
                keep_higher(&mut first, SphereContact::new(y, touch, id));
            });
        }
        for triangle in &self.triangles {
            if let Some((y, touch)) = triangle.drop_sphere(drop) {
                keep_higher(&mut first, SphereContact::new(y, touch, triangle.id));
            }
        }
        first
    }

    fn near(&self, center: DVec3, reach: f64) -> Vec<SphereContact> {
        let mut out = Vec::new();
        let mut found = |distance: f64, touch, id| {
            if distance < reach {
                out.push(SphereContact::new(distance, touch, id));
            }
        };
        for solid in &self.solids {
            solid.near(center, &mut found);
        }
        for triangle in &self.triangles {
            let (touch, distance) = triangle.touch(center);
            found(distance, touch, triangle.id);
        }
        out.sort_unstable_by_key(|contact| contact.id);
        out
    }

    fn may_cross(&self, bounds: &Aabb) -> bool {
        self.solids.iter().any(|solid| solid.may_cross(bounds))
            || self.triangles.iter().any(|triangle| triangle.overlaps(bounds))
    }

    fn bounds(&self) -> Aabb {
        let solids = self.solids.iter().fold(Aabb::EMPTY, |all, s| all.union(&s.bounds()));
        let corners = self.triangles.iter().flat_map(|t| t.corners);
        corners.fold(solids, |all, p| all.including(p))
    }
}

/// One of everything, tilted and stretched, around `origin`.
fn everything(random: &mut Random, origin: DVec3) -> Surfaces {
    Surfaces::new(&one_of_each(random, origin))
}

fn one_of_each(random: &mut Random, origin: DVec3) -> Objects {
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
    shapes.into_iter().zip(transforms).collect()
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
fn a_scene_without_surfaces_answers_nothing() {
    let surfaces = Surfaces::default();
    let mut out = vec![];
    assert!(surfaces.is_empty() && !surfaces.has_infinite() && surfaces.bounds().is_empty());
    assert_eq!(surfaces.intersect(&Ray::new(DVec3::ZERO, DVec3::Y), 9.0, None), None);
    assert_eq!(surfaces.drop_sphere(0.0, 0.0, 1.0, [5.0, -5.0]), None);
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
            let _ = surfaces.drop_sphere(ray.origin.x, ray.origin.z, 0.1, [2.0, -2.0]);
            surfaces.near(ray.origin, 0.5, &mut out);
        }
    }
}
