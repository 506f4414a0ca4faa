//! What a cell of a grid holds.

/// What a cell holds: bit 31 tells that a surface passes through it, bits 28..31 hold the number of
/// blocks less one, bits 0..28 the index of the first block. Block 0 is empty.
#[derive(Clone, Copy, Debug, PartialEq, Eq, bytemuck::Zeroable)]
#[repr(transparent)]
pub struct CellEntry(pub(crate) u32);

impl CellEntry {
    pub(crate) const EMPTY: Self = Self(0);
    /// A whole brick without grains or surfaces; light may cross it in one step. Its block is block 0.
    pub(crate) const EMPTY_BRICK: Self = Self(7 << 28);
    pub(crate) const SURFACE: u32 = 1 << 31;
    pub(crate) const MAX_BLOCKS_PER_CELL: usize = 7;
    pub(crate) const MAX_BLOCKS: usize = 1 << 28;

    pub(crate) fn new(first_block: usize, blocks: usize, surface: bool) -> Self {
        debug_assert!(first_block < Self::MAX_BLOCKS && blocks <= Self::MAX_BLOCKS_PER_CELL);
        let count = (blocks.max(1) - 1) as u32;
        Self(first_block as u32 | count << 28 | if surface { Self::SURFACE } else { 0 })
    }

    pub(crate) fn has_surface(self) -> bool {
        self.0 & Self::SURFACE != 0
    }

    /// The cell's first block; block 0 where it holds nothing.
    #[inline(always)]
    pub(crate) fn first_block(self) -> usize {
        (self.0 & (Self::MAX_BLOCKS as u32 - 1)) as usize
    }

    /// The cell's other blocks.
    #[inline(always)]
    pub(crate) fn further_blocks(self) -> std::ops::Range<usize> {
        let first = self.first_block() + 1;
        let further = if self == Self::EMPTY_BRICK { 0 } else { (self.0 >> 28) & 7 };
        first..first + further as usize
    }

    /// All blocks of the cell.
    pub(crate) fn blocks(self) -> std::ops::Range<usize> {
        self.first_block()..self.further_blocks().end
    }
}
