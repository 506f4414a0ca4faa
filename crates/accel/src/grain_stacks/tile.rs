//! A square of cells with the blocks of their stacks: what one thread owns while grains fall.

use super::block::{Block, GRAINS_PER_BLOCK, NO_BLOCK};
use super::plan::{TILE_BITS, TILE_EDGE};
use super::{GrainSlot, GrainStacksError};

const CELLS: usize = (TILE_EDGE * TILE_EDGE) as usize;
/// Full blocks are allocated in chunks of this many, so that growing never copies nor doubles.
const BLOCKS_PER_CHUNK: usize = 32;
const EMPTY_BLOCK: Block = Block::new(NO_BLOCK, i32::MIN);
/// Most full blocks that a grain's name can tell apart; the names after them are those of the newest.
const MOST_BLOCKS: u32 = (1 << 28) - CELLS as u32;

/// `TILE_EDGE` x `TILE_EDGE` cells.
///
/// The newest blocks lie side by side, one a cell, so that a fall finds them from the cell alone: no
/// link stands between the look at one and the next. A block that is full moves to the older ones.
#[derive(Clone, Debug)]
pub(super) struct Tile {
    name: u32,
    pub(super) grains: u32,
    /// Highest top of the grains of each cell.
    pub(super) tops: [i32; CELLS],
    /// Newest block of each cell; none before the first grain of the tile.
    newest: Box<[Block]>,
    full: u32,
    chunks: Vec<Box<[Block; BLOCKS_PER_CHUNK]>>,
}

impl Tile {
    /// An empty tile; no other of the store has its name.
    pub(super) fn new(name: u32) -> Self {
        let tops = [i32::MIN; CELLS];
        Self { name, grains: 0, tops, newest: Box::default(), full: 0, chunks: Vec::new() }
    }

    /// Gives it another name; grains that lie in it get other names too.
    pub(super) fn rename(&mut self, name: u32) {
        self.name = name;
    }

    /// Index of the cell in this column and row of the plan, of those that belong to this tile.
    #[inline(always)]
    pub(super) fn cell_index([column, row]: [i32; 2]) -> usize {
        let last = TILE_EDGE - 1;
        ((row & last) << TILE_BITS | (column & last)) as usize
    }

    /// The newest block of a cell, which may be empty; `None` where the tile has no grain.
    #[inline(always)]
    pub(super) fn newest(&self, cell_index: usize) -> Option<&Block> {
        self.newest.get(cell_index)
    }

    /// A block that was full.
    #[inline(always)]
    pub(super) fn older(&self, index: u32) -> &Block {
        let index = index as usize;
        &self.chunks[index / BLOCKS_PER_CHUNK][index % BLOCKS_PER_CHUNK]
    }

    /// The block that lies below a block of the same stack.
    #[inline(always)]
    pub(super) fn below(&self, block: &Block) -> Option<&Block> {
        let older = block.older();
        (older != NO_BLOCK).then(|| self.older(older))
    }

    /// Name of the grain in a lane of an older block.
    pub(super) fn slot(&self, block: u32, lane: usize) -> GrainSlot {
        GrainSlot(u64::from(self.name) << 32 | u64::from(block << 4 | lane as u32))
    }

    /// What stands for the newest block of a cell in the names of its grains.
    pub(super) fn newest_name(cell_index: usize) -> u32 {
        MOST_BLOCKS + cell_index as u32
    }

    /// Puts a grain on the stack of a cell.
    #[inline]
    pub(super) fn push(
        &mut self,
        cell_index: usize,
        local: [u16; 2],
        y: i32,
        radius: u16,
    ) -> Result<GrainSlot, GrainStacksError> {
        if self.newest.is_empty() {
            self.newest = vec![EMPTY_BLOCK; CELLS].into_boxed_slice();
        }
        if self.newest[cell_index].count() == GRAINS_PER_BLOCK {
            self.lay_down(cell_index)?;
        }
        let lane = self.newest[cell_index].push(local, y, radius);
        let top = &mut self.tops[cell_index];
        *top = (*top).max(y + i32::from(radius));
        self.grains += 1;
        Ok(self.slot(Self::newest_name(cell_index), lane))
    }

    /// Moves the newest block of a cell, which is full, to the older ones.
    fn lay_down(&mut self, cell_index: usize) -> Result<(), GrainStacksError> {
        if self.full >= MOST_BLOCKS {
            return Err(GrainStacksError::TooManyGrains);
        }
        let (chunk, at) =
            (self.full as usize / BLOCKS_PER_CHUNK, self.full as usize % BLOCKS_PER_CHUNK);
        if at == 0 {
            self.chunks.push(Box::new([EMPTY_BLOCK; BLOCKS_PER_CHUNK]));
        }
        let next = Block::new(self.full, self.tops[cell_index]);
        self.chunks[chunk][at] = std::mem::replace(&mut self.newest[cell_index], next);
        self.full += 1;
        Ok(())
    }

    /// Takes the newest grain off the stack of a cell that has one.
    pub(super) fn pop(&mut self, cell_index: usize) {
        let mut block = self.newest[cell_index].clone();
        if block.count() == 0 {
            // The place of the older block is left behind, unreachable: pops are rare.
            block = self.older(block.older()).clone();
        }
        block.pop();
        self.tops[cell_index] = block.top();
        self.newest[cell_index] = block;
        self.grains -= 1;
    }

    /// Blocks of the stack of a cell, the newest first, each with what stands for it in names.
    #[inline(always)]
    pub(super) fn blocks(&self, cell_index: usize) -> impl Iterator<Item = (u32, &Block)> {
        let newest = self.newest(cell_index).map(|block| (Self::newest_name(cell_index), block));
        std::iter::successors(newest, |(_, block)| {
            let older = block.older();
            (older != NO_BLOCK).then(|| (older, self.older(older)))
        })
    }

    pub(super) fn bytes(&self) -> usize {
        size_of::<Self>()
            + self.newest.len() * size_of::<Block>()
            + self.chunks.len() * size_of::<[Block; BLOCKS_PER_CHUNK]>()
            + self.chunks.capacity() * size_of::<Box<[Block; BLOCKS_PER_CHUNK]>>()
    }
}
