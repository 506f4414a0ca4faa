//! A square of cells with the blocks of their stacks: what one thread owns while grains fall.

use super::block::{Block, GRAINS_PER_BLOCK, NO_BLOCK};
use super::plan::{TILE_BITS, TILE_EDGE};
use super::{GrainSlot, GrainStacksError};

/// Blocks are allocated in chunks of this many, so that growing never copies nor doubles.
const BLOCKS_PER_CHUNK: usize = 32;
/// Most blocks that a grain's name can tell apart.
const MOST_BLOCKS: u32 = 1 << 28;

/// The head of a stack.
#[derive(Clone, Copy, Debug)]
pub(super) struct Cell {
    /// Newest block, or [`NO_BLOCK`].
    pub(super) newest: u32,
    /// Highest top of its grains.
    pub(super) top: i32,
}

const EMPTY_CELL: Cell = Cell { newest: NO_BLOCK, top: i32::MIN };

/// `TILE_EDGE` x `TILE_EDGE` cells.
#[derive(Clone, Debug)]
pub(super) struct Tile {
    name: u32,
    pub(super) grains: u32,
    blocks: u32,
    pub(super) cells: Vec<Cell>,
    chunks: Vec<Vec<Block>>,
}

impl Tile {
    /// An empty tile; no other of the store has its name.
    pub(super) fn new(name: u32) -> Self {
        let cells = vec![EMPTY_CELL; (TILE_EDGE * TILE_EDGE) as usize];
        Self { name, grains: 0, blocks: 0, cells, chunks: Vec::new() }
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

    #[inline(always)]
    pub(super) fn block(&self, index: u32) -> &Block {
        let index = index as usize;
        &self.chunks[index / BLOCKS_PER_CHUNK][index % BLOCKS_PER_CHUNK]
    }

    #[inline(always)]
    fn block_mut(&mut self, index: u32) -> &mut Block {
        let index = index as usize;
        &mut self.chunks[index / BLOCKS_PER_CHUNK][index % BLOCKS_PER_CHUNK]
    }

    pub(super) fn slot(&self, block: u32, lane: usize) -> GrainSlot {
        GrainSlot(u64::from(self.name) << 32 | u64::from(block << 4 | lane as u32))
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
        let cell = self.cells[cell_index];
        let mut head = cell.newest;
        if head == NO_BLOCK || self.block(head).count() == GRAINS_PER_BLOCK {
            head = self.append(Block::new(cell.newest, cell.top))?;
        }
        let lane = self.block_mut(head).push(local, y, radius);
        let top = cell.top.max(y + i32::from(radius));
        self.cells[cell_index] = Cell { newest: head, top };
        self.grains += 1;
        Ok(self.slot(head, lane))
    }

    /// Takes the newest grain off the stack of a cell that has one.
    pub(super) fn pop(&mut self, cell_index: usize) {
        let cell = self.cells[cell_index];
        let block = self.block_mut(cell.newest);
        block.pop();
        let top = block.top();
        let (count, older) = (block.count(), block.older());
        // An empty block is left behind, unreachable: pops are rare.
        let newest = if count == 0 { older } else { cell.newest };
        self.cells[cell_index] = Cell { newest, top };
        self.grains -= 1;
    }

    fn append(&mut self, block: Block) -> Result<u32, GrainStacksError> {
        if self.blocks >= MOST_BLOCKS {
            return Err(GrainStacksError::TooManyGrains);
        }
        if (self.blocks as usize).is_multiple_of(BLOCKS_PER_CHUNK) {
            self.chunks.push(Vec::with_capacity(BLOCKS_PER_CHUNK));
        }
        if let Some(chunk) = self.chunks.last_mut() {
            chunk.push(block);
        }
        self.blocks += 1;
        Ok(self.blocks - 1)
    }

    /// Blocks of the stack from `newest` down.
    #[inline(always)]
    pub(super) fn blocks_from(&self, newest: u32) -> impl Iterator<Item = (u32, &Block)> {
        let mut next = newest;
        std::iter::from_fn(move || {
            if next == NO_BLOCK {
                return None;
            }
            let (index, block) = (next, self.block(next));
            next = block.older();
            Some((index, block))
        })
    }

    pub(super) fn bytes(&self) -> usize {
        size_of::<Self>()
            + self.cells.capacity() * size_of::<Cell>()
            + self.chunks.len() * BLOCKS_PER_CHUNK * size_of::<Block>()
            + self.chunks.capacity() * size_of::<Vec<Block>>()
    }
}
