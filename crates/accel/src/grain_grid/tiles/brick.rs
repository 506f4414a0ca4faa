//! Bricks of cells, and the grains that reach into those of a tile.

use super::Layout;
use crate::grain_grid::build::{PAD, overlaps, reaches_cell};
use crate::grain_grid::packed_cells::{BRICK, CELLS_PER_BRICK};
use crate::grain_grid::{Block, CellEntry, GRAINS_PER_BLOCK, GridError, OVERLAPS};
use snowgrain_geometry::QuantisedGrain;

/// A grain that reaches into a brick.
#[derive(Clone, Copy, Debug)]
pub(super) struct Reaching {
    /// From the brick's low corner.
    pub(super) center: [i32; 3],
    /// Flags and radius, as blocks hold them.
    pub(super) radius: u16,
    /// Whether its centre lies in the brick.
    pub(super) is_own: bool,
}

/// The cells of a brick and their blocks, numbered from some number on.
#[derive(Clone, Debug)]
pub(super) struct Contents {
    pub(super) entries: Vec<CellEntry>,
    pub(super) blocks: Vec<Block>,
    /// Grains whose centres lie in it.
    pub(super) grains: u64,
}

/// The bricks of one variant of a tile.
pub(super) struct TileBricks {
    /// Of each brick the grains that reach into it, in their order.
    pub(super) reaching: Vec<Vec<Reaching>>,
}

impl TileBricks {
    pub(super) fn new(layout: &Layout<'_>, grains: &[QuantisedGrain]) -> Self {
        let mut bricks: Vec<Vec<(u32, Reaching)>> = vec![Vec::new(); layout.bricks_of_tile()];
        for (index, grain) in (0u32..).zip(grains) {
            for_bricks(layout, grain, |brick, reaching| {
                bricks[layout.number_in_tile(brick)].push((index, reaching));
            });
        }
        let overlapping = overlapping(layout, &bricks, grains.len());
        let flagged = |(index, mut reaching): (u32, Reaching)| {
            reaching.radius |= if overlapping[index as usize] { OVERLAPS } else { 0 };
            reaching
        };
        let reaching =
            bricks.into_iter().map(|brick| brick.into_iter().map(flagged).collect()).collect();
        Self { reaching }
    }

    /// What a brick shows of which all grains are there, and no surface.
    pub(super) fn contents(
        &self,
        layout: &Layout<'_>,
        number: usize,
    ) -> Result<Contents, GridError> {
        contents(layout, &self.reaching[number], 1, |_| false)
    }
}

/// Shows each brick that a grain reaches, some of them beyond the tile.
fn for_bricks(
    layout: &Layout<'_>,
    grain: &QuantisedGrain,
    mut show: impl FnMut([i64; 3], Reaching),
) {
    let reach = i64::from(grain.radius) + i64::from(PAD);
    let range = |axis: usize| {
        let at = i64::from(grain.center[axis]);
        let brick = |at: i64| at.div_euclid(layout.edge(axis));
        brick(at - reach)..=brick(at + reach)
    };
    let edges: [i32; 3] = std::array::from_fn(|axis| BRICK * layout.side[axis]);
    for z in range(2) {
        for y in range(1) {
            for x in range(0) {
                let brick = [x, y, z];
                let center: [i32; 3] = std::array::from_fn(|axis| {
                    (i64::from(grain.center[axis]) - brick[axis] * layout.edge(axis)) as i32
                });
                if reaches_cell(center, grain.radius, edges) {
                    let is_own = (0..3).all(|axis| (0..edges[axis]).contains(&center[axis]));
                    show(brick, Reaching { center, radius: grain.radius, is_own });
                }
            }
        }
    }
}

/// Which grains of a tile overlap others: two that do reach into one cell together.
fn overlapping(layout: &Layout<'_>, bricks: &[Vec<(u32, Reaching)>], grains: usize) -> Vec<bool> {
    let mut overlapping = vec![false; grains];
    let mut cells: Vec<Vec<usize>> = vec![Vec::new(); CELLS_PER_BRICK];
    for brick in bricks {
        cells.iter_mut().for_each(Vec::clear);
        for (at, (_, grain)) in brick.iter().enumerate() {
            for_cells(layout, grain, |cell, _| cells[cell].push(at));
        }
        for cell in &cells {
            for (second, &b) in cell.iter().enumerate() {
                for &a in &cell[..second] {
                    let ((i, a), (j, b)) = (&brick[a], &brick[b]);
                    if overlaps(a.center, a.radius, b.center, b.radius) {
                        overlapping[*i as usize] = true;
                        overlapping[*j as usize] = true;
                    }
                }
            }
        }
    }
    overlapping
}

/// The cells of a brick that a grain reaches, with the cell's low corner from that of the brick.
fn for_cells(layout: &Layout<'_>, grain: &Reaching, mut show: impl FnMut(usize, [i32; 3])) {
    let radius = grain.radius & crate::grain_grid::RADIUS_MASK;
    let reach = i32::from(radius) + PAD;
    let range = |axis: usize| {
        let cell = |at: i32| at.div_euclid(layout.side[axis]).clamp(0, BRICK - 1);
        cell(grain.center[axis] - reach)..=cell(grain.center[axis] + reach)
    };
    for z in range(2) {
        for y in range(1) {
            for x in range(0) {
                let cell = [x, y, z];
                let corner: [i32; 3] = std::array::from_fn(|a| cell[a] * layout.side[a]);
                let center = std::array::from_fn(|a| grain.center[a] - corner[a]);
                if reaches_cell(center, radius, layout.side) {
                    show(((z * BRICK + y) * BRICK + x) as usize, corner);
                }
            }
        }
    }
}

/// Lists grains in the cells of a brick, in their order, in blocks that are numbered from `first` on.
///
/// # Errors
/// More grains in a cell than it can list.
pub(super) fn contents(
    layout: &Layout<'_>,
    grains: &[Reaching],
    first: usize,
    has_surface: impl Fn([i32; 3]) -> bool,
) -> Result<Contents, GridError> {
    let mut counts = [0usize; CELLS_PER_BRICK];
    grains.iter().for_each(|grain| for_cells(layout, grain, |cell, _| counts[cell] += 1));
    let most = CellEntry::MAX_BLOCKS_PER_CELL * GRAINS_PER_BLOCK;
    if let Some(&count) = counts.iter().find(|&&count| count > most) {
        let side = f64::from(layout.side[1]) * layout.quantisation.quantum();
        return Err(GridError::CrowdedCell { count, most, side });
    }
    let mut next = first;
    let entry = |(cell, &count): (usize, &usize)| {
        let at = [cell & 7, cell >> 3 & 7, cell >> 6].map(|c| (c as u32).cast_signed());
        let blocks = count.div_ceil(GRAINS_PER_BLOCK);
        let number = if blocks == 0 { 0 } else { next };
        next += blocks;
        CellEntry::new(number, blocks, has_surface(at))
    };
    let entries: Vec<CellEntry> = counts.iter().enumerate().map(entry).collect();
    let mut blocks = vec![Block::EMPTY; next - first];
    let mut slots = [0usize; CELLS_PER_BRICK];
    for grain in grains {
        for_cells(layout, grain, |cell, corner| {
            let slot = slots[cell];
            slots[cell] += 1;
            let block = entries[cell].first_block() - first + slot / GRAINS_PER_BLOCK;
            let local =
                std::array::from_fn(|a| (grain.center[a] - corner[a] + layout.margin) as u16);
            blocks[block].set(slot % GRAINS_PER_BLOCK, local, grain.radius);
        });
    }
    let own = grains.iter().filter(|grain| grain.is_own).count();
    Ok(Contents { entries, blocks, grains: own as u64 })
}
