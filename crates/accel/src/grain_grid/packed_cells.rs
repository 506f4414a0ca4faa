//! Where the blocks of arbitrary snow are found.

use super::{CellEntry, GridError};
use crate::pages;
use crate::prefetch::prefetch;

/// Cells along an edge of a brick.
pub(crate) const BRICK: i32 = 8;
const CELLS_PER_BRICK: usize = 512;
const NO_BRICK: u32 = u32::MAX;
/// Most bricks that the table may number: it takes 1 GiB then.
const MOST_BRICKS: u128 = 1 << 28;

/// A dense table of bricks, and the entries of the cells of those that hold anything.
#[derive(Debug)]
pub struct PackedCells {
    bricks: [i32; 3],
    table: Vec<u32>,
    entries: Vec<CellEntry>,
}

impl PackedCells {
    /// Cells for a grid of `cells`, all empty.
    pub(crate) fn new(cells: [i32; 3]) -> Result<Self, GridError> {
        let bricks = cells.map(|n| (n + BRICK - 1) / BRICK);
        let count = bricks.iter().map(|&n| n as u128).product::<u128>();
        if count >= MOST_BRICKS {
            return Err(GridError::TooSparse { bricks: count });
        }
        Ok(Self { bricks, table: vec![NO_BRICK; count as usize], entries: Vec::new() })
    }

    pub(crate) fn memory_bytes(&self) -> usize {
        size_of_val(self.table.as_slice()) + size_of_val(self.entries.as_slice())
    }

    #[inline(always)]
    fn brick_of(&self, cell: [i32; 3]) -> usize {
        let [x, y, z] = cell.map(|c| (c >> 3) as usize);
        (z * self.bricks[1] as usize + y) * self.bricks[0] as usize + x
    }

    #[inline(always)]
    pub(crate) fn entry(&self, cell: [i32; 3]) -> CellEntry {
        match self.table[self.brick_of(cell)] {
            NO_BRICK => CellEntry::EMPTY_BRICK,
            brick => self.entries[brick as usize * CELLS_PER_BRICK + within_brick(cell)],
        }
    }

    /// Asks for a cell's entry ahead of its use.
    #[inline(always)]
    pub(crate) fn prefetch(&self, cell: [i32; 3]) {
        let brick = self.table[self.brick_of(cell)];
        if brick != NO_BRICK {
            prefetch(&self.entries[brick as usize * CELLS_PER_BRICK + within_brick(cell)]);
        }
    }

    /// Gives a cell's brick its entries, in the order of [`Self::seal_bricks`].
    pub(crate) fn touch(&mut self, cell: [i32; 3]) {
        let brick = self.brick_of(cell);
        self.table[brick] = 0;
    }

    /// Numbers the touched bricks in the order of the table, so that neighbours in space lie
    /// together in memory whatever the order of the grains.
    pub(crate) fn seal_bricks(&mut self) {
        let mut next = 0;
        for brick in self.table.iter_mut().filter(|brick| **brick != NO_BRICK) {
            *brick = next;
            next += 1;
        }
        self.entries = pages::filled(next as usize * CELLS_PER_BRICK, CellEntry::EMPTY);
    }

    /// The index of a cell's entry; its brick must have been touched.
    #[inline(always)]
    pub(crate) fn index(&self, cell: [i32; 3]) -> usize {
        self.table[self.brick_of(cell)] as usize * CELLS_PER_BRICK + within_brick(cell)
    }

    pub(crate) fn entries(&self) -> &[CellEntry] {
        &self.entries
    }

    pub(crate) fn entries_mut(&mut self) -> &mut [CellEntry] {
        &mut self.entries
    }

    /// All bricks along each axis.
    pub(crate) fn bricks(&self) -> [i32; 3] {
        self.bricks
    }
}

#[inline(always)]
fn within_brick(cell: [i32; 3]) -> usize {
    let [x, y, z] = cell.map(|c| (c & (BRICK - 1)) as usize);
    (z * 8 + y) * 8 + x
}
