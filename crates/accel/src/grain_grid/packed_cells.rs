//! Where the blocks of arbitrary snow are found.

use super::{CellEntry, GridError};
use crate::pages;
use crate::prefetch::prefetch;

/// Cells along an edge of a brick.
pub(crate) const BRICK: i32 = 8;
/// Cells of a brick.
pub(crate) const CELLS_PER_BRICK: usize = 512;
/// Most bricks that the table may number: it takes 1 GiB then.
const MOST_BRICKS: u128 = 1 << 28;

/// A dense table of bricks, and the entries of the cells of those that hold anything. Brick 0 stands
/// for all that hold nothing.
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
        Ok(Self {
            bricks,
            table: vec![0; count as usize],
            entries: vec![CellEntry::EMPTY_BRICK; CELLS_PER_BRICK],
        })
    }

    pub(crate) fn memory_bytes(&self) -> usize {
        size_of_val(self.table.as_slice()) + size_of_val(self.entries.as_slice())
    }

    /// The number of the brick of a cell.
    #[inline(always)]
    pub(crate) fn brick_of(&self, cell: [i32; 3]) -> usize {
        let [x, y, z] = cell.map(|c| (c >> 3) as usize);
        (z * self.bricks[1] as usize + y) * self.bricks[0] as usize + x
    }

    /// What a step of one brick along each axis adds to its number.
    pub(crate) fn brick_steps(&self) -> [u32; 3] {
        let [x, y, _] = self.bricks.map(i32::cast_unsigned);
        [1, x, x * y]
    }

    /// The entry of the cell at `within` of the brick of number `brick`.
    #[inline(always)]
    pub(crate) fn entry_at(&self, brick: u32, within: u32) -> CellEntry {
        self.entries[self.index_at(brick, within)]
    }

    /// Asks for that entry ahead of its use.
    #[inline(always)]
    pub(crate) fn prefetch_at(&self, brick: u32, within: u32) {
        prefetch(&self.entries[self.index_at(brick, within)]);
    }

    #[inline(always)]
    fn index_at(&self, brick: u32, within: u32) -> usize {
        self.table[brick as usize] as usize * CELLS_PER_BRICK + within as usize
    }

    #[inline(always)]
    pub(crate) fn entry(&self, cell: [i32; 3]) -> CellEntry {
        self.entries[self.index(cell)]
    }

    /// Gives a cell's brick its entries, in the order of [`Self::seal_bricks`].
    pub(crate) fn touch(&mut self, cell: [i32; 3]) {
        let brick = self.brick_of(cell);
        self.table[brick] = 1;
    }

    /// Numbers the touched bricks in the order of the table, so that neighbours in space lie
    /// together in memory whatever the order of the grains. `crossed_at_once` tells whether light may
    /// cross a brick without contents in one step.
    pub(crate) fn seal_bricks(&mut self, crossed_at_once: bool) {
        let mut bricks = 1;
        for brick in self.table.iter_mut().filter(|brick| **brick != 0) {
            *brick = bricks;
            bricks += 1;
        }
        let empty = if crossed_at_once { CellEntry::EMPTY_BRICK } else { CellEntry::EMPTY };
        self.entries = pages::filled(bricks as usize * CELLS_PER_BRICK, CellEntry::EMPTY);
        self.entries[..CELLS_PER_BRICK].fill(empty);
    }

    /// The index of a cell's entry.
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

/// The place of a cell in its brick.
#[inline(always)]
pub(crate) fn within_brick(cell: [i32; 3]) -> usize {
    let [x, y, z] = cell.map(|c| (c & (BRICK - 1)) as usize);
    (z * 8 + y) * 8 + x
}
