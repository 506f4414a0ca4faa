use super::*;
use crate::TriangleMesh;
use core::f64::consts::PI;
use snowgrain_math::sampler::{PathKey, numbers};
use snowgrain_math::{DVec3, trig};

fn kinds() -> Vec<ShapeKind> {
    let mut kinds = vec![ShapeKind::Sphere];
    for rounding in [0.0, 0.3, 1.0] {
        kinds.extend([
            ShapeKind::Spheroid { aspect: 0.4 + rounding },
            ShapeKind::Cube { rounding },
            ShapeKind::HexagonalPrism { aspect: 0.2, rounding },
            ShapeKind::HexagonalPrism { aspect: 2.5, rounding },
            ShapeKind::TruncatedOctahedron { rounding },
            ShapeKind::RandomPolyhedron { faces: 14, seed: 3, rounding },
        ]);
    }
    kinds
}

/// A line of all that meet the ball of this radius, and the radius's disc.
fn line(index: u64, radius: f64) -> (DVec3, DVec3) {
    let [a, b, c] = numbers(PathKey::new(8, index, 0), 0).map(f64::from);
    let d = f64::from(numbers(PathKey::new(8, index, 0), 1)[0]);
    let y = 1.0 - 2.0 * a;
    let (sin, cos) = trig::sin_cos(2.0 * PI * b);
    let ring = (1.0 - y * y).max(0.0).sqrt();
    let direction = DVec3::new(ring * cos, y, ring * sin).normalize();
    let (s, t) = snowgrain_math::frame::tangents(direction);
    let (sin, cos) = trig::sin_cos(2.0 * PI * d);
    ((s * cos + t * sin) * (radius * c.sqrt()) - direction * 9.0, direction)
}

/// Volume, mean shadow and farthest point by 40 000 random lines: true to 4 sigma but once in 16 000 seeds.
#[test]
fn volume_shadow_and_reach_are_those_that_lines_tell() {
    for kind in kinds() {
        let shape = Shape::new(kind).unwrap();
        let radius = shape.bounding_radius();
        let (lines, disc) = (40_000u32, PI * radius * radius);
        let (mut length, mut squares, mut met) = (0.0, 0.0, 0u32);
        for index in 0..lines {
            let (origin, direction) = line(index.into(), radius);
            let Some(interval) = shape.parts()[0].interval(origin, direction) else { continue };
            for t in [interval.enter, interval.leave] {
                assert!((origin + direction * t).length() < radius + 1e-9, "{kind:?}");
            }
            let chord = interval.leave - interval.enter;
            length += chord;
            squares += chord * chord;
            met += 1;
        }
        let n = f64::from(lines);
        let mean = length / n;
        let sigma = ((squares / n - mean * mean) / n).sqrt();
        assert!(
            (mean * disc - Shape::VOLUME).abs() < 4.0 * sigma * disc,
            "{kind:?} {}",
            mean * disc
        );
        let part = f64::from(met) / n;
        let sigma = (part * (1.0 - part) / n).sqrt();
        let shadow = shape.mean_projected_area();
        assert!(
            (part * disc - shadow).abs() < 4.0 * sigma * disc + 2e-4,
            "{kind:?} {part} {shadow}"
        );
    }
}

#[test]
fn sharp_polyhedra_have_their_textbook_measures() {
    let cube = Shape::new(ShapeKind::Cube { rounding: 0.0 }).unwrap();
    let edge = trig::cbrt(Shape::VOLUME);
    assert!((cube.surface_area() - 6.0 * edge * edge).abs() < 1e-12);
    assert!((cube.bounding_radius() - edge * 0.75f64.sqrt()).abs() < 1e-9);
    for aspect in [0.1, 1.0, 4.0] {
        let shape = Shape::new(ShapeKind::HexagonalPrism { aspect, rounding: 0.0 }).unwrap();
        // Edge a, height 2 a aspect: V = 3 sqrt(3) a^3 aspect, S = (3 sqrt(3) + 12 aspect) a^2.
        let root = 27.0f64.sqrt();
        let a = trig::cbrt(Shape::VOLUME / (root * aspect));
        assert!((shape.surface_area() - (root + 12.0 * aspect) * a * a).abs() < 1e-11);
    }
    let octahedron = Shape::new(ShapeKind::TruncatedOctahedron { rounding: 0.0 }).unwrap();
    // Edge a: V = 8 sqrt(2) a^3, S = (6 + 12 sqrt(3)) a^2.
    let a = trig::cbrt(Shape::VOLUME / 128.0f64.sqrt());
    assert!((octahedron.surface_area() - (6.0 + 432.0f64.sqrt()) * a * a).abs() < 1e-11);
}

#[test]
fn a_spheroid_of_aspect_1_is_the_sphere_and_others_have_their_closed_forms() {
    let [sphere, round] = [ShapeKind::Sphere, ShapeKind::Spheroid { aspect: 1.0 }]
        .map(|kind| Shape::new(kind).unwrap());
    assert_eq!(sphere.parts(), round.parts());
    assert!((sphere.surface_area() - 4.0 * PI).abs() < 4e-4);
    assert!((sphere.bounding_radius() - 1.0).abs() < 1e-9);
    // Prolate of eccentricity e: S = 2 pi a^2 (1 + c / (a e) asin e).
    let (a, c) = (0.5f64, 2.0f64);
    let e = (1.0 - a * a / (c * c)).sqrt();
    let surface = 2.0 * PI * a * a * (1.0 + c / (a * e) * trig::asin(e));
    let scale = trig::cbrt(1.0 / (a * a * c));
    let shape = Shape::new(ShapeKind::Spheroid { aspect: 4.0 }).unwrap();
    assert!((shape.surface_area() / (surface * scale * scale) - 1.0).abs() < 3e-4);
}

#[test]
fn a_fully_rounded_cube_is_the_ball_within() {
    let shape = Shape::new(ShapeKind::Cube { rounding: 1.0 }).unwrap();
    assert!((shape.surface_area() / (4.0 * PI) - 1.0).abs() < 2e-4, "{}", shape.surface_area());
    assert!((shape.bounding_radius() - 1.0).abs() < 1e-4);
}

#[test]
fn points_are_inside_where_lines_are() {
    for kind in kinds() {
        let shape = Shape::new(kind).unwrap();
        for index in 0..300 {
            let (origin, direction) = line(index, shape.bounding_radius());
            let t = 18.0 * f64::from(numbers(PathKey::new(2, index, 0), 0)[0]);
            let inside = shape.contains(origin + direction * t);
            let interval = shape.parts()[0].interval(origin, direction);
            assert_eq!(inside, interval.is_some_and(|i| i.enter < t && t < i.leave), "{kind:?}");
        }
    }
}

#[test]
fn names_tell_all_and_numbers_out_of_range_are_refused() {
    for kind in kinds() {
        let name = kind.name();
        assert_eq!(ShapeKind::parse(&name.split(' ').collect::<Vec<_>>()), Some(kind));
    }
    assert!(Shape::of_name("dodecahedron").is_err());
    assert!(Shape::of_name("polyhedron 1 0 0 1").is_err());
    for kind in [
        ShapeKind::Spheroid { aspect: 0.0 },
        ShapeKind::Spheroid { aspect: f64::NAN },
        ShapeKind::Cube { rounding: 1.1 },
        ShapeKind::HexagonalPrism { aspect: -1.0, rounding: 0.0 },
        ShapeKind::RandomPolyhedron { faces: 4, seed: 0, rounding: 0.0 },
        ShapeKind::Rosette { arms: 1, aspect: 2.0, rounding: 0.0 },
    ] {
        assert!(Shape::new(kind).is_err(), "{kind:?}");
    }
}

#[test]
fn a_rosette_has_the_volume_of_the_union_of_its_arms() {
    let shape = Shape::new(ShapeKind::Rosette { arms: 6, aspect: 2.0, rounding: 0.0 }).unwrap();
    let (mut inside, points) = (0u32, 60_000u32);
    let size = shape.bounding_radius();
    for index in 0..points {
        let [x, y, z] =
            numbers(PathKey::new(3, index.into(), 0), 0).map(|u| 2.0 * f64::from(u) - 1.0);
        inside += u32::from(shape.contains(DVec3::new(x, y, z) * size));
    }
    let part = f64::from(inside) / f64::from(points);
    let box_volume = 8.0 * size * size * size;
    let sigma = (part * (1.0 - part) / f64::from(points)).sqrt() * box_volume;
    assert!((part * box_volume - Shape::VOLUME).abs() < 4.0 * sigma + 0.002);
}

/// The mesh of the box with these half-edges around a point, its triangles facing outwards.
fn box_mesh(half: DVec3, center: DVec3) -> TriangleMesh {
    let corner = |i: u32| {
        let sign = |bit: u32| if i >> bit & 1 == 0 { -1.0 } else { 1.0 };
        center + half * DVec3::new(sign(0), sign(1), sign(2))
    };
    let quads =
        [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]];
    let triangles = quads.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]).collect();
    TriangleMesh::new((0..8).map(corner).collect(), triangles).unwrap()
}

#[test]
fn a_convex_mesh_is_the_body_that_it_encloses_whatever_its_size_and_place() {
    let mesh = box_mesh(DVec3::new(0.002, 0.001, 0.003), DVec3::new(0.1, 3.0, 0.0));
    let shape = Shape::of_convex_mesh(&mesh).unwrap();
    assert_eq!(shape.parts()[0].faces.len(), 6);
    let scale = trig::cbrt(Shape::VOLUME / 48.0);
    let surface = 8.0 * (2.0 + 3.0 + 6.0) * scale * scale;
    assert!((shape.surface_area() / surface - 1.0).abs() < 1e-9);
    assert!((shape.bounding_radius() / (14.0f64.sqrt() * scale) - 1.0).abs() < 1e-9);
    assert!(shape.contains(DVec3::new(0.0, 0.0, 2.9) * scale));
    assert_eq!(Shape::of_name(shape.name()).unwrap(), shape);
}

#[test]
fn meshes_that_are_open_hollow_or_inside_out_are_refused() {
    let good = box_mesh(DVec3::ONE, DVec3::ZERO);
    let with = |positions: Vec<DVec3>, triangles: Vec<[u32; 3]>| {
        Shape::of_convex_mesh(&TriangleMesh::new(positions, triangles).unwrap()).unwrap_err()
    };
    let open = with(good.positions.clone(), good.triangles[1..].to_vec());
    assert_eq!(open, GeometryError::OpenMesh { edges: 3 });
    let inwards = good.triangles.iter().map(|&[a, b, c]| [a, c, b]).collect();
    assert_eq!(with(good.positions.clone(), inwards), GeometryError::NotConvex);
    let mut dented = good.positions.clone();
    dented[0] = DVec3::splat(0.3);
    assert_eq!(with(dented, good.triangles), GeometryError::NotConvex);
}

#[test]
fn flat_faces_add_up_to_the_surface_and_lie_on_their_planes() {
    for kind in [
        ShapeKind::Cube { rounding: 0.0 },
        ShapeKind::HexagonalPrism { aspect: 0.1, rounding: 0.0 },
        ShapeKind::RandomPolyhedron { faces: 14, seed: 1, rounding: 0.0 },
    ] {
        let shape = Shape::new(kind).unwrap();
        let faces = shape.parts()[0].flat_faces();
        let area: f64 = faces.iter().map(|face| face.area).sum();
        assert!((area / shape.surface_area() - 1.0).abs() < 1e-9, "{kind:?} {area}");
        for face in faces {
            assert!(shape.contains(face.centroid - face.normal * 1e-9));
            assert!(!shape.contains(face.centroid + face.normal * 1e-9));
        }
    }
    let rounded = Shape::new(ShapeKind::Cube { rounding: 0.3 }).unwrap();
    assert!(rounded.parts()[0].flat_faces().is_empty());
}

/// A prism whose base is an outline on the plan y = 0, counter-clockwise seen from above; 1 high. Its caps are fans
/// around a point that sees all of the outline.
fn prism(outline: &[[f64; 2]], middle: [f64; 2]) -> TriangleMesh {
    let n = outline.len() as u32;
    let at = |[x, z]: [f64; 2], y: f64| DVec3::new(x, y, -z);
    let mut positions: Vec<DVec3> = outline.iter().map(|&p| at(p, 0.0)).collect();
    positions.extend(outline.iter().map(|&p| at(p, 1.0)));
    positions.extend([at(middle, 0.0), at(middle, 1.0)]);
    let mut triangles = Vec::new();
    for i in 0..n {
        let j = (i + 1) % n;
        triangles.extend([
            [2 * n + 1, n + i, n + j],
            [2 * n, j, i],
            [i, j, n + j],
            [i, n + j, n + i],
        ]);
    }
    TriangleMesh::new(positions, triangles).unwrap()
}

fn star(points: u32) -> TriangleMesh {
    let corner = |i: u32| {
        let (sin, cos) = trig::sin_cos(PI * f64::from(i) / f64::from(points));
        let radius = if i.is_multiple_of(2) { 1.0 } else { 0.4 };
        [radius * cos, radius * sin]
    };
    prism(&(0..2 * points).map(corner).collect::<Vec<_>>(), [0.0, 0.0])
}

fn bracket() -> TriangleMesh {
    let outline = [[0.0, 0.0], [2.0, 0.0], [2.0, 1.0], [1.0, 1.0], [1.0, 2.0], [0.0, 2.0]];
    prism(&outline, [0.7, 0.6])
}

#[test]
fn a_mesh_with_hollows_is_the_union_of_convex_cells_without_seams() {
    // Area of the outline of a star of n points: n sin(pi / n) R r.
    let of_star = |n: f64| n * trig::sin_cos(PI / n).0 * 0.4;
    for (mesh, volume, most) in
        [(bracket(), 3.0, 3), (star(5), of_star(5.0), 16), (star(6), of_star(6.0), 19)]
    {
        let shape = Shape::of_mesh(&mesh).unwrap();
        assert!(shape.parts().len() > 1 && shape.parts().len() <= most, "{}", shape.parts().len());
        let again = Shape::of_name(shape.name()).unwrap();
        assert_eq!(again, shape);
        // Of the mesh at its own size.
        let scale = trig::cbrt(Shape::VOLUME / volume);
        let area: f64 = (0..mesh.triangles.len())
            .map(|index| mesh.corners(index))
            .map(|[a, b, c]| 0.5 * (b - a).cross(c - a).length())
            .sum();
        let ratio = shape.surface_area() / (area * scale * scale);
        assert!((ratio - 1.0).abs() < 1e-9, "{} cells, {ratio}", shape.parts().len());
        let (mut length, lines, radius) = (0.0, 20_000u32, shape.bounding_radius());
        for index in 0..lines {
            let (origin, direction) = line(index.into(), radius);
            let mut stretches: Vec<[f64; 2]> = shape
                .parts()
                .iter()
                .filter_map(|part| part.interval(origin, direction))
                .map(|on| [on.enter, on.leave])
                .collect();
            stretches.sort_by(|a, b| a[0].total_cmp(&b[0]));
            for pair in stretches.windows(2) {
                let gap = pair[1][0] - pair[0][1];
                assert!(gap == 0.0 || gap > 1e-9, "cells overlap or a seam is open: {gap:e}");
            }
            length += stretches.iter().map(|[enter, leave]| leave - enter).sum::<f64>();
        }
        let found = length / f64::from(lines) * PI * radius * radius;
        assert!((found / Shape::VOLUME - 1.0).abs() < 0.03, "{found}");
    }
    let cube =
        Shape::of_mesh(&prism(&[[0.0, 0.0], [1.0, 0.0], [1.0, 1.0], [0.0, 1.0]], [0.5, 0.5]));
    assert_eq!(cube.unwrap().parts().len(), 1);
}

#[test]
fn meshes_that_enclose_no_body_are_refused_by_what_is_wrong() {
    let mut inside_out = bracket();
    inside_out.triangles.iter_mut().for_each(|corners| corners.swap(0, 1));
    assert_eq!(Shape::of_mesh(&inside_out).unwrap_err(), GeometryError::InsideOut);
    let (a, b) = (bracket(), bracket());
    let shift = DVec3::new(0.3, 0.2, -0.4);
    let positions = a.positions.iter().copied().chain(b.positions.iter().map(|&p| p + shift));
    let count = a.positions.len() as u32;
    let moved = b.triangles.iter().map(|corners| corners.map(|v| v + count));
    let triangles = a.triangles.iter().copied().chain(moved).collect();
    let crossing = TriangleMesh::new(positions.collect(), triangles).unwrap();
    assert_eq!(Shape::of_mesh(&crossing).unwrap_err(), GeometryError::CrossingMesh);
    let mut open = bracket();
    open.triangles.pop();
    assert!(matches!(Shape::of_mesh(&open).unwrap_err(), GeometryError::OpenMesh { .. }));
    let many = Shape::of_mesh(&star(80));
    assert!(matches!(many, Err(GeometryError::TooManyCells { most: 64 })));
    for name in ["cells", "cells 1", "cells 1 4 0 0 1", "cells 2.5", "cells 99 0", "cells 0"] {
        assert!(Shape::of_name(name).is_err(), "{name}");
    }
}
