//! Where the blocks of arbitrary snow are found.

use super::{CellEntry, GridError};
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
        let table = vec![0; Self::count_bricks(bricks)?];
        Ok(Self::of(bricks, table, vec![CellEntry::EMPTY_BRICK; CELLS_PER_BRICK]))
    }

    /// How many bricks the table must number.
    ///
    /// # Errors
    /// More than it can.
    pub(crate) fn count_bricks(bricks: [i32; 3]) -> Result<usize, GridError> {
        let count = bricks.iter().map(|&n| n as u128).product::<u128>();
        if count >= MOST_BRICKS {
            return Err(GridError::TooSparse { bricks: count });
        }
        Ok(count as usize)
    }

    /// The table of all bricks and the entries that it numbers, those of brick 0 first.
    pub(crate) fn of(bricks: [i32; 3], table: Vec<u32>, entries: Vec<CellEntry>) -> Self {
        Self { bricks, table, entries }
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

    /// The entries of all bricks that differ, 512 each; the first hold nothing.
    pub(crate) fn entries(&self) -> &[CellEntry] {
        &self.entries
    }

    /// Shows each brick that holds anything, with its number among [`Self::entries`].
    pub(crate) fn for_each_brick(&self, mut show: impl FnMut([i32; 3], usize)) {
        let [x, y] = [self.bricks[0], self.bricks[1]].map(|n| n as usize);
        for (at, &number) in self.table.iter().enumerate().filter(|(_, number)| **number != 0) {
            show(
                [at % x, at / x % y, at / (x * y)].map(|c| (c as u32).cast_signed()),
                number as usize,
            );
        }
    }

    /// The index of a cell's entry.
    #[inline(always)]
    pub(crate) fn index(&self, cell: [i32; 3]) -> usize {
        self.table[self.brick_of(cell)] as usize * CELLS_PER_BRICK + within_brick(cell)
    }
}

/// The place of a cell in its brick.
#[inline(always)]
pub(crate) fn within_brick(cell: [i32; 3]) -> usize {
    let [x, y, z] = cell.map(|c| (c & (BRICK - 1)) as usize);
    (z * 8 + y) * 8 + x
}
