//! What tiled snow must keep: every grain in every cell that it reaches and no other, flags that are set where they must
//! be, and cells that are kept once.

use super::*;
use crate::SurfaceShape;
use crate::grain_grid::build::{overlaps, reaches_cell};
use crate::grain_grid::{GRAINS_PER_BLOCK, MEETS_SURFACE, OVERLAPS, RADIUS_MASK};
use snowgrain_math::sampler::{PathKey, numbers};
use snowgrain_math::{Aabb, DAffine3, DVec3};

const RADIUS: f64 = 2000.0;
const TILES: [i64; 3] = [3, 2, 3];

/// Grains at random in a tile; those far from its faces differ between variants.
fn variants(period: [i64; 3], count: u64) -> [Vec<QuantisedGrain>; 2] {
    let strewn = |seed: u64| {
        (0..count).map(move |index| {
            let unit = numbers(PathKey::new(seed, index, 0), 0).map(f64::from);
            let size = f64::from(numbers(PathKey::new(seed, index, 0), 1)[0]);
            let center = [0, 1, 2].map(|a| (unit[a] * period[a] as f64) as i32);
            QuantisedGrain { center, radius: (RADIUS * (0.6 + 0.4 * size)) as u16 }
        })
    };
    let frame = (4.0 * RADIUS) as i64;
    let is_inner = |grain: &QuantisedGrain| {
        (0..3).all(|a| (frame..period[a] - frame).contains(&i64::from(grain.center[a])))
    };
    let outer: Vec<_> = strewn(1).filter(|grain| !is_inner(grain)).collect();
    [1, 2].map(|seed| outer.iter().copied().chain(strewn(seed).filter(is_inner)).collect())
}

struct Snow {
    grid: GrainGrid,
    grains: Vec<QuantisedGrain>,
}

/// Tiles cut by a ball, over a plane or in empty space.
fn snow(surfaces: &Surfaces, packing: Packing) -> Snow {
    let quantisation = Quantisation::for_grains(DVec3::ZERO, 1.0);
    let count = 900;
    let divisor = tile_divisor(48_000.0, 0.8 * RADIUS, count as f64, 1.1e14);
    let period = [48_000 / divisor * divisor; 3];
    let variants = variants(period, count);
    let corner = [-period[0], 700, 5000 - period[2]];
    let variant_of = |[x, y, z]: [i64; 3]| (x + y + z).rem_euclid(2) as usize;
    let bounds: [[i64; 2]; 3] =
        [0, 1, 2].map(|a| [corner[a], corner[a] + TILES[a] * period[a] - 1]);
    let middle = bounds.map(|[low, high]| (low + high) / 2);
    let holds = |at: [i64; 3]| {
        let inside = (0..3).all(|a| (bounds[a][0]..=bounds[a][1]).contains(&at[a]));
        let square: i64 = (0..3).map(|a| (at[a] - middle[a]) * (at[a] - middle[a])).sum();
        inside && square < 60_000 * 60_000
    };
    let extent = |around: [[i64; 2]; 3]| {
        let corners = (0..8).map(|c| [0, 1, 2].map(|a: usize| around[a][c >> a & 1]));
        let apart = (0..3).any(|a| around[a][1] < bounds[a][0] || around[a][0] > bounds[a][1]);
        match (apart, corners.into_iter().all(holds)) {
            (true, _) => Extent::Empty,
            (_, true) => Extent::Whole,
            _ => Extent::Part,
        }
    };
    let tiled = TiledGrains {
        variants: &[&variants[0], &variants[1]],
        period,
        corner,
        variant_of: &variant_of,
        bounds,
        extent: &extent,
        holds: &holds,
    };
    let grid = GrainGrid::build_tiled(quantisation, &tiled, surfaces, packing).unwrap();
    let mut grains = Vec::new();
    for (z, y, x) in (0..TILES[2])
        .flat_map(|z| (0..TILES[1]).flat_map(move |y| (0..TILES[0]).map(move |x| (z, y, x))))
    {
        let tile = [x, y, z];
        for grain in &variants[variant_of(tile)] {
            let at: [i64; 3] = std::array::from_fn(|a| {
                corner[a] + tile[a] * period[a] + i64::from(grain.center[a])
            });
            if holds(at) {
                grains.push(QuantisedGrain { center: at.map(|c| c as i32), ..*grain });
            }
        }
    }
    Snow { grid, grains }
}

/// Checks what all cells list; gives the flags of all copies of each grain together.
fn check(Snow { grid, grains }: &Snow) -> Vec<Vec<u16>> {
    let mut flags = vec![Vec::new(); grains.len()];
    let [nx, ny, nz] = grid.cells;
    let local = |grain: &QuantisedGrain, cell: [i32; 3]| -> [i32; 3] {
        std::array::from_fn(|a| {
            let low = grid.first[a] + i64::from(cell[a]) * i64::from(grid.side[a]);
            (i64::from(grain.center[a]) - low) as i32
        })
    };
    let mut listed = 0;
    for cell in (0..nz).flat_map(|z| (0..ny).flat_map(move |y| (0..nx).map(move |x| [x, y, z]))) {
        let entry = grid.entry(cell);
        let range = if entry.first_block() == 0 { 0..0 } else { entry.blocks() };
        let mut found: Vec<([u16; 3], u16)> = Vec::new();
        for block in &grid.blocks[range] {
            let slots = (0..GRAINS_PER_BLOCK).filter(|&slot| block.radius[slot] != 0);
            found.extend(slots.map(|s| ([block.x[s], block.y[s], block.z[s]], block.radius[s])));
        }
        listed += found.len();
        for (index, grain) in grains.iter().enumerate() {
            let center = local(grain, cell);
            if reaches_cell(center, grain.radius, grid.side) {
                let stored = center.map(|c| (c + grid.margin) as u16);
                let at = found
                    .iter()
                    .position(|&(center, r)| center == stored && r & RADIUS_MASK == grain.radius);
                let (_, radius) = found.swap_remove(at.expect("a grain that reaches is listed"));
                flags[index].push(radius & !RADIUS_MASK);
            }
        }
        assert!(found.is_empty(), "nothing else is listed in {cell:?}: {found:?}");
    }
    assert!(listed > grains.len());
    flags
}

#[test]
fn cells_list_the_grains_that_reach_them_and_nothing_else() {
    for packing in [Packing::Fast, Packing::Compact] {
        let snow = snow(&Surfaces::default(), packing);
        assert_eq!(snow.grid.grains(), snow.grains.len() as u64);
        let flags = check(&snow);
        for (grain, flags) in snow.grains.iter().zip(&flags) {
            let overlaps = snow.grains.iter().any(|other| {
                other != grain && overlaps(grain.center, grain.radius, other.center, other.radius)
            });
            assert!(!overlaps || flags.iter().all(|flags| flags & OVERLAPS != 0));
            assert!(flags.iter().all(|flags| flags & MEETS_SURFACE == 0));
        }
    }
}

#[test]
fn surfaces_are_told_to_cells_and_grains() {
    let quantum = Quantisation::for_grains(DVec3::ZERO, 1.0).quantum();
    let height = 30_000.0 * quantum;
    let plane = (SurfaceShape::Plane, DAffine3::from_translation(DVec3::Y * height));
    let surfaces = Surfaces::new(&[plane]);
    let snow = snow(&surfaces, Packing::Fast);
    let flags = check(&snow);
    for (grain, flags) in snow.grains.iter().zip(&flags) {
        let gap = (f64::from(grain.center[1]) - 30_000.0).abs();
        let met = flags.iter().filter(|&&flags| flags & MEETS_SURFACE != 0).count();
        assert!(gap > f64::from(grain.radius) || met == flags.len(), "all copies know the plane");
        assert!(gap < f64::from(grain.radius) + 4.0 || met == 0, "none that is far from it");
    }
    let [nx, ny, nz] = snow.grid.cells;
    for cell in (0..nz).flat_map(|z| (0..ny).flat_map(move |y| (0..nx).map(move |x| [x, y, z]))) {
        let Aabb { min, max } = snow.grid.cell_box(cell, cell.map(|c| c + 1));
        let crossed = min.y <= height && height <= max.y;
        assert!(!crossed || snow.grid.entry(cell).has_surface(), "{cell:?}");
    }
}

/// Within a tile's repetitions no block is kept twice.
#[test]
fn what_repeats_is_kept_once() {
    let snow = snow(&Surfaces::default(), Packing::Fast);
    let alone: usize = snow.grid.blocks.len();
    let listed = snow.grains.len();
    println!("{alone} blocks for {listed} grains, {} bytes", snow.grid.memory_bytes());
    let mut seen = std::collections::HashSet::new();
    let doubles = snow.grid.blocks.iter().filter(|block| {
        let bytes: [u16; 64] = bytemuck::cast(**block);
        !seen.insert(bytes)
    });
    // The frames of the two variants are listed by each.
    assert!(doubles.count() * 2 < alone, "{alone} blocks");
}

#[test]
fn threads_do_not_show() {
    let on = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| snow(&Surfaces::default(), Packing::Fast).grid)
    };
    let (one, many) = (on(1), on(5));
    assert!(one.blocks == many.blocks);
    let [nx, ny, nz] = one.cells;
    for cell in (0..nz).flat_map(|z| (0..ny).flat_map(move |y| (0..nx).map(move |x| [x, y, z]))) {
        assert_eq!(one.entry(cell), many.entry(cell));
    }
}
