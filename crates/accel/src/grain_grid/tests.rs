//! What packing must keep: every grain in every cell that it reaches, flags as distances say, and one
//! result for all threads.

use super::block::{MEETS_SURFACE, OVERLAPS, RADIUS_MASK};
use super::build::{overlaps, reaches_cell};
use super::hull::{Hull, Placed};
use super::{Block, GRAINS_PER_BLOCK, GrainGrid, GrainParts, Packing};
use super::{Placement, Prototype, ShapeWord, ShapedGrains};
use crate::Surfaces;
use snowgrain_geometry::shape::Face;
use snowgrain_geometry::{GrainShape, Quantisation, QuantisedGrain, Shape, ShapeKind};
use snowgrain_math::DVec3;
use snowgrain_math::sampler::{PathKey, numbers};

fn squared(x: f32) -> f32 {
    x * x
}

/// Grains with centres in a cube, radii between two bounds, quanta.
fn strewn(count: u64, edge: f32, [least, most]: [f32; 2]) -> Vec<QuantisedGrain> {
    let random = |index, event| numbers(PathKey::new(3, index, 0), event);
    (0..count)
        .map(|index| QuantisedGrain {
            center: random(index, 0).map(|u| (u * edge - 0.4 * edge) as i32),
            radius: (least + (most - least) * squared(squared(random(index, 1)[0]))) as u16,
        })
        .collect()
}

fn pack(grains: &[QuantisedGrain], period: Option<[i64; 2]>, packing: Packing) -> GrainGrid {
    let quantisation = Quantisation::for_grains(DVec3::ZERO, 1.0);
    match period {
        None => GrainGrid::build(quantisation, grains, &Surfaces::default(), packing),
        Some(period) => GrainGrid::build_periodic(quantisation, grains, period, packing),
    }
    .unwrap()
}

/// What every cell should list, in order: centre in cell quanta, radius.
fn check_cells(grid: &GrainGrid, grains: &[QuantisedGrain]) {
    let overlap = |index: usize| {
        let QuantisedGrain { center, radius } = grains[index];
        grains
            .iter()
            .enumerate()
            .any(|(i, g)| i != index && overlaps(center, radius, g.center, g.radius))
    };
    let flags: Vec<u16> =
        (0..grains.len()).map(|index| if overlap(index) { OVERLAPS } else { 0 }).collect();
    let [nx, ny, nz] = grid.cells;
    for (x, y, z) in
        (0..nz).flat_map(|z| (0..ny).flat_map(move |y| (0..nx).map(move |x| (x, y, z))))
    {
        let cell = [x, y, z];
        let mut wanted = Vec::new();
        for (grain, flags) in grains.iter().zip(&flags) {
            let center: [i32; 3] = std::array::from_fn(|axis| {
                (i64::from(grain.center[axis])
                    - grid.first[axis]
                    - i64::from(cell[axis]) * i64::from(grid.side[axis])) as i32
            });
            if reaches_cell(center, grain.radius, grid.side) {
                wanted.push((center.map(|c| (c + grid.margin) as u16), grain.radius | flags));
            }
        }
        let entry = grid.entry(cell);
        let blocks: &[Block] = &grid.blocks[entry.blocks()];
        let listed: Vec<_> = blocks
            .iter()
            .flat_map(|b| (0..GRAINS_PER_BLOCK).map(|s| ([b.x[s], b.y[s], b.z[s]], b.radius[s])))
            .filter(|(_, radius)| radius & RADIUS_MASK > 0)
            .collect();
        assert_eq!(listed, wanted, "cell {cell:?}");
    }
}

#[test]
fn every_cell_lists_what_reaches_it_and_flags_tell_overlaps() {
    for (count, edge, radii) in [
        (1, 10.0, [5000.0, 5000.0]),
        (700, 60_000.0, [500.0, 5450.0]),
        (900, 20_000.0, [54.0, 5450.0]),
    ] {
        let grains = strewn(count, edge, radii);
        for packing in [Packing::Fast, Packing::Compact] {
            check_cells(&pack(&grains, None, packing), &grains);
        }
    }
}

/// A grain of a shape overlaps another one that no plane parts from it, whichever cells list the two.
#[test]
fn flags_of_shaped_grains_tell_which_others_no_plane_parts_them_from() {
    let kinds = [
        ShapeKind::HexagonalPrism { aspect: 0.2, rounding: 0.0 },
        ShapeKind::HexagonalPrism { aspect: 2.0, rounding: 0.3 },
        ShapeKind::RandomPolyhedron { faces: 9, seed: 2, rounding: 0.0 },
    ];
    let prototypes = kinds.map(|kind| Shape::new(kind).unwrap());
    let hulls = prototypes.each_ref().map(Hull::new);
    let grains = strewn(300, 24_000.0, [300.0, 2500.0]);
    let turned = |index: usize| {
        let [a, b, c] = numbers(PathKey::new(4, index as u64, 0), 0).map(|u| f64::from(u) - 0.5);
        GrainShape::new(index % kinds.len(), [a, b, c, 0.3])
    };
    let shapes: Vec<GrainShape> = (0..grains.len()).map(turned).collect();
    let shaped = ShapedGrains { prototypes: &prototypes, of_grains: &shapes };
    let grid = GrainGrid::build_shaped(
        Quantisation::for_grains(DVec3::ZERO, 1.0),
        (&grains, shaped),
        (&Surfaces::default(), &[]),
        None,
        Packing::Fast,
    )
    .unwrap();
    let placed = |index: usize| {
        let (shape, radius) = (shapes[index], f64::from(grains[index].radius));
        let prototype = shape.prototype();
        Placed { hull: &hulls[prototype], placement: Placement::new(shape, radius) }
    };
    let center = |index: usize| DVec3::from_array(grains[index].center.map(f64::from));
    let overlaps =
        |i: usize, j: usize| i != j && !placed(i).is_apart_from(&placed(j), center(j) - center(i));
    let wanted: Vec<bool> =
        (0..grains.len()).map(|i| (0..grains.len()).any(|j| overlaps(i, j))).collect();
    let words = &grid.shapes().unwrap().blocks;
    let mut seen = 0;
    for (block, words) in grid.blocks().iter().zip(words) {
        for slot in (0..GRAINS_PER_BLOCK).filter(|&slot| block.radius[slot] & RADIUS_MASK > 0) {
            let word = ShapeWord::of_slot(words[slot]);
            let radius = grid.shapes().unwrap().placement(words[slot], block.radius[slot]).radius;
            let is_this =
                |i: &usize| shapes[*i] == word.shape() && f64::from(grains[*i].radius) == radius;
            let index = (0..grains.len()).find(is_this).unwrap();
            assert_eq!(block.radius[slot] & OVERLAPS != 0, wanted[index], "grain {index}");
            seen += 1;
        }
    }
    let overlapping = wanted.iter().filter(|&&overlaps| overlaps).count();
    assert!(seen >= 300 && (60..240).contains(&overlapping), "{seen} {overlapping}");
}

/// Where a point of a face lies in another grain, the face is one that other ice reaches; most that no such point is found
/// on are not.
#[test]
fn faces_that_other_grains_hold_points_of_are_reached() {
    let kinds = [
        ShapeKind::HexagonalPrism { aspect: 0.2, rounding: 0.0 },
        ShapeKind::HexagonalPrism { aspect: 2.0, rounding: 0.3 },
        ShapeKind::Cube { rounding: 0.0 },
        ShapeKind::RandomPolyhedron { faces: 9, seed: 2, rounding: 0.0 },
        ShapeKind::Spheroid { aspect: 2.0 },
    ];
    let prototypes = kinds.map(|kind| Shape::new(kind).unwrap());
    let hulls = prototypes.each_ref().map(Hull::new);
    let kernel = prototypes.each_ref().map(Prototype::new);
    let vector = |index: u64, event: u32| {
        DVec3::from_array(numbers(PathKey::new(5, index, 0), event).map(f64::from)) - 0.5
    };
    let placed = |index: u64, event: u32| {
        let [q, w] = [vector(index, event), vector(index, event + 1)];
        let shape = GrainShape::new(index as usize % kinds.len(), [q.x, q.y, q.z, w.x]);
        Placement::new(shape, 1000.0)
    };
    let (mut held, mut free, mut told_free) = (0, 0, 0);
    for index in 0..1500 {
        let (a, b) = (placed(index, 0), placed(index / 5, 2));
        let between = vector(index, 4).normalize() * (300.0 + index as f64);
        let Some(slabs) = &kernel[a.prototype].slabs else { continue };
        let reached = Placed { hull: &hulls[a.prototype], placement: a }
            .faces_reached_by(&Placed { hull: &hulls[b.prototype], placement: b }, between);
        let faces = &prototypes[a.prototype].parts()[0].faces;
        for (number, plane) in slabs.numbered() {
            let is_held = (0..300).any(|i| {
                let along = vector(i, 5).normalize();
                let far = |face: &Face| match face.normal.dot(along) {
                    slope if slope > 0.0 => face.distance / slope,
                    _ => f64::INFINITY,
                };
                let point = along * far(&faces[plane]);
                let is_on = faces.iter().all(|face| far(face) >= far(&faces[plane]));
                let to_b = a.rotation * point * 1000.0 - between;
                is_on && kernel[b.prototype].contains(b.to_prototype(to_b))
            });
            assert!(!is_held || reached.has(number), "{index} {number}");
            held += u32::from(is_held);
            free += u32::from(!is_held);
            told_free += u32::from(!reached.has(number));
        }
    }
    assert!(held > 500 && 10 * told_free > 7 * free, "{held} {free} {told_free}");
}

#[test]
fn the_structure_does_not_depend_on_threads_or_parts() {
    let grains = strewn(40_000, 200_000.0, [1000.0, 5450.0]);
    let period = 4096 * 60;
    let within: Vec<_> = strewn(5000, 100_000.0, [1000.0, 5450.0])
        .into_iter()
        .map(|g| QuantisedGrain { center: g.center.map(|c| c + 100_000), ..g })
        .collect();
    let on = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| {
            let read = |part: usize, out: &mut Vec<QuantisedGrain>| {
                out.extend_from_slice(grains.chunks(777).nth(part).unwrap());
            };
            let parts = GrainParts::Parts { count: grains.len().div_ceil(777), read: &read };
            let quantisation = Quantisation::for_grains(DVec3::ZERO, 1.0);
            [
                pack(&grains, None, Packing::Fast),
                pack(&within, Some([period; 2]), Packing::Compact),
                GrainGrid::build(quantisation, parts, &Surfaces::default(), Packing::Fast).unwrap(),
            ]
        })
    };
    let reference = on(1);
    assert_eq!(reference[0].blocks, reference[2].blocks);
    assert!(reference[0].blocks.iter().all(|b| b.radius.iter().all(|r| r & MEETS_SURFACE == 0)));
    for threads in [2, 7] {
        for (grid, reference) in on(threads).iter().zip(&reference) {
            assert_eq!(grid.blocks, reference.blocks);
            assert_eq!(format!("{:?}", grid.storage), format!("{:?}", reference.storage));
        }
    }
}

/// Half of the volume in grains of a hundredth of the radius.
#[test]
fn cells_smaller_than_the_largest_grain_hold_heaps_of_the_smallest() {
    let mut grains = strewn(30_000, 4000.0, [54.0, 55.0]);
    grains.push(QuantisedGrain { center: [0, -6000, 0], radius: 5450 });
    let grid = pack(&grains, None, Packing::Fast);
    assert!(grid.side[0] < 5450);
    assert_eq!(grid.grains(), 30_001);
}
