//! Meshes that are placed many times, meshes that are hard on a hierarchy, and how it is built.

use super::*;
use crate::surfaces::build::{Item, Plan};
use crate::surfaces::cuboid::Bounds;
use crate::surfaces::mesh::MeshTree;

/// Asks everything of `objects`, at every SIMD level, and compares with going through the list.
fn check(objects: &Objects, random: &mut Random, origin: DVec3, size: f64) {
    let mut surfaces = Surfaces::new(objects);
    let all = BruteForce::new(objects);
    assert_eq!(surfaces.bounds(), all.bounds());
    let mut out = Vec::new();
    let mut exclude = None;
    for i in 0..60 {
        let levels = SimdLevel::available();
        surfaces = surfaces.with_level(levels[i % levels.len()]);
        let target = origin + random.cube() * size;
        let straight = [DVec3::NEG_Y, DVec3::X, -DVec3::Z][i % 3];
        let direction = if i % 4 == 0 { straight } else { random.direction() };
        let ray = Ray::new(target - direction * size * random.unit().x * 3.0, direction);
        let hit = surfaces.intersect(&ray, f64::INFINITY, exclude);
        assert_eq!(hit.map(|h| (h.t, h.id)), all.intersect(&ray, exclude), "{ray:?}");
        if let Some(hit) = hit {
            // From here on the ray is short, as in the cells of a grid.
            assert!(surfaces.intersect(&ray, hit.t, exclude) == Some(hit));
            assert_eq!(surfaces.intersect(&ray, hit.t * (1.0 - 1e-12), exclude), None);
            exclude = Some(hit.id);
        }
        let radius = size * [0.003, 0.05, 0.4][i % 3];
        let (x, z, start_y) = (target.x, target.z, origin.y + size * 2.0);
        let drop = Drop { x, z, radius, start_y, down_to: f64::NEG_INFINITY };
        for drop in [drop, Drop { start_y: target.y, ..drop }] {
            let contact = all.drop_sphere(&drop);
            let near_it = contact.map_or(target.y, |contact| contact.center_y);
            for down_to in [drop.down_to, near_it, near_it - radius * 1e-9, target.y] {
                let counts = contact.filter(|contact| contact.center_y > down_to);
                let heights = [drop.start_y, down_to];
                let found = surfaces.drop_sphere(x, z, radius, heights);
                assert_eq!(found, counts, "{drop:?} down to {down_to}");
            }
        }
        surfaces.near(target, radius, &mut out);
        assert_eq!(out, all.near(target, radius));
        let bounds = Aabb::new(target - radius * 0.1, target + radius * 0.1);
        assert_eq!(surfaces.may_cross(&bounds), all.may_cross(&bounds), "{bounds:?}");
    }
}

/// Placements of all kinds: turned, stretched, skewed, mirrored, swapped axes, nearly flat, flat.
fn placement(random: &mut Random, kind: usize, origin: DVec3) -> DAffine3 {
    let turn = random.rotation() * DMat3::from_diagonal(random.unit() + 0.1) * random.rotation();
    let swapped = DMat3::from_cols(DVec3::Y * 0.5, DVec3::NEG_Z, DVec3::X * 0.7);
    let flat = DMat3::from_diagonal(DVec3::new(1.0, [1e-9, 0.0][kind / 6 % 2], 1.0));
    let matrix3 = match kind % 6 {
        0 => DMat3::IDENTITY,
        1 => DMat3::from_diagonal(random.cube()),
        2 => swapped,
        3 => random.rotation() * flat,
        _ => turn,
    };
    DAffine3 { matrix3, translation: origin + random.cube() * 2.0 }
}

#[test]
fn instances_are_what_copies_of_their_triangles_are() {
    for scene in 0..16u64 {
        let mut random = Random::new(900 + scene);
        let origin = [DVec3::ZERO, DVec3::new(2e4, -1e4, 3e3)][scene as usize % 2];
        let (soup, ball) = (Arc::new(soup(&mut random, 60)), Arc::new(bumpy_ball(3, 0.3)));
        let mut objects = one_of_each(&mut random, origin);
        if scene % 4 < 2 {
            objects.clear();
        }
        for i in 0..20 {
            let place = placement(&mut random, i, origin);
            let shape = match i % 5 {
                0 | 1 => SurfaceShape::Mesh(Arc::clone(&soup)),
                2 | 3 => SurfaceShape::Mesh(Arc::clone(&ball)),
                _ => SurfaceShape::Sphere,
            };
            // What is flat has no inverse, and solids lose themselves then.
            if i % 5 != 4 || i % 6 != 3 {
                objects.push((shape, place));
            }
        }
        check(&objects, &mut random, origin, 3.0);
    }
}

#[test]
fn turned_surfaces_are_those_placed_turned() {
    let mut random = Random::new(77);
    let mut objects = one_of_each(&mut random, DVec3::ONE);
    let ball = Arc::new(bumpy_ball(3, 0.3));
    for _ in 0..5 {
        let place = placement(&mut random, 4, DVec3::ONE);
        objects.push((SurfaceShape::Mesh(Arc::clone(&ball)), place));
    }
    let turn = random.rotation();
    let turned = Surfaces::new(&objects).turned(&turn);
    let rotation = DAffine3 { matrix3: turn, translation: DVec3::ZERO };
    let placed: Objects = objects.into_iter().map(|(s, place)| (s, rotation * place)).collect();
    let expected = Surfaces::new(&placed);
    assert_eq!(turned.bounds(), expected.bounds());
    for _ in 0..200 {
        let target = turn * (DVec3::ONE + random.cube() * 3.0);
        let direction = random.direction();
        let ray = Ray::new(target - direction * 3.0, direction);
        let hits = [&turned, &expected].map(|s| s.intersect(&ray, f64::INFINITY, None));
        assert_eq!(hits[0], hits[1]);
    }
}

#[test]
fn meshes_may_be_tiny_and_large_and_uneven() {
    for (scene, scale) in [1e-7, 1e-3, 1e6].into_iter().enumerate() {
        let mut random = Random::new(1700 + scene as u64);
        let mut uneven = soup(&mut random, 120);
        for (i, corners) in uneven.triangles.iter().enumerate() {
            let shrink = [1.0, 1e-3, 1e-6][i % 3];
            let first = uneven.positions[corners[0] as usize];
            for v in &corners[1..] {
                let p = &mut uneven.positions[*v as usize];
                *p = first + (*p - first) * shrink;
            }
        }
        let matrix3 = random.rotation() * scale;
        let place = DAffine3 { matrix3, translation: random.cube() * scale };
        let objects = vec![(SurfaceShape::Mesh(Arc::new(uneven)), place)];
        check(&objects, &mut random, place.translation, scale);
    }
}

#[test]
fn meshes_that_cannot_be_split_well_are_searched_rightly() {
    let mut random = Random::new(31);
    let mut positions = Vec::new();
    // Triangles around one middle, and ever smaller ones towards a corner.
    for i in 0..600 {
        let size = if i < 300 { 1.0 } else { trig::pow(0.93, f64::from(i - 300)) };
        let [a, b] = [random.cube() * size, random.cube() * size];
        let shift = if i < 300 { DVec3::ZERO } else { DVec3::splat(size) };
        positions.extend([a, b, -a - b].map(|p| p + shift));
    }
    let triangles = (0..600).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect();
    let mesh = TriangleMesh::new(positions, triangles).unwrap();
    let objects = vec![(SurfaceShape::Mesh(Arc::new(mesh)), DAffine3::IDENTITY)];
    check(&objects, &mut random, DVec3::ZERO, 1.0);
}

#[test]
fn vertices_far_apart_in_a_mesh_are_found() {
    let mut random = Random::new(32);
    let small = soup(&mut random, 50);
    let mut positions = vec![DVec3::ZERO; 200_000];
    let stride = positions.len() / small.positions.len();
    for (i, &p) in small.positions.iter().enumerate() {
        positions[i * stride] = p;
    }
    let triangles = small.triangles.iter().map(|t| t.map(|v| v * stride as u32)).collect();
    let mesh = TriangleMesh::new(positions, triangles).unwrap();
    let objects = vec![(SurfaceShape::Mesh(Arc::new(mesh)), DAffine3::IDENTITY)];
    check(&objects, &mut random, DVec3::ZERO, 1.0);
}

#[test]
fn coincident_boxes_do_not_make_a_deep_tree() {
    let bounds = Bounds { min: [0.0; 4], max: [1.0; 4] };
    let items: Vec<Item> = (0..100_000).map(|i| Item::new(bounds, i)).collect();
    let built = Plan { leaf_size: 8, same: None }.build(items);
    assert_eq!(built.leaves.iter().map(ExactSizeIterator::len).sum::<usize>(), 100_000);
    // All leaves are at least half full.
    assert!(built.leaves.len() <= 25_000, "{}", built.leaves.len());
}

#[test]
fn any_number_of_threads_builds_the_same() {
    let mesh = Arc::new(teapot(24));
    let build = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        let tree = pool.install(|| MeshTree::new(Arc::clone(&mesh)));
        (tree.tree.nodes, tree.blocks)
    };
    let one = build(1);
    assert!(one.1.len() * 8 < mesh.triangles.len() * 3 / 2, "blocks are mostly full");
    assert!(build(2) == one && build(3) == one);
}

#[test]
fn a_mesh_costs_its_triangles_once() {
    let shape = SurfaceShape::Mesh(Arc::new(teapot(8)));
    let place = |i: u32| DAffine3::from_translation(DVec3::X * f64::from(i));
    let bytes = |count: u32| {
        let objects: Objects = (0..count).map(|i| (shape.clone(), place(i))).collect();
        Surfaces::new(&objects).memory_bytes()
    };
    assert!(bytes(1001) - bytes(1) < 1000 * 512);
}
