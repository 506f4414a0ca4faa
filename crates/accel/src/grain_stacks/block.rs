//! Fifteen grains, a link and a bound: 160 bytes.

use crate::prefetch::prefetch;

/// Lanes of a block; the last one holds the link, the bound and the count.
pub(super) const LANES: usize = 16;
/// Grains of a full block.
pub(super) const GRAINS_PER_BLOCK: usize = LANES - 1;
/// The link of the oldest block of a stack.
pub(super) const NO_BLOCK: u32 = u32::MAX;

/// Grains of one cell, positions in quanta: x and z from the cell's corner, y from the origin.
#[derive(Clone, Debug)]
#[repr(align(32))]
pub(super) struct Block {
    pub(super) x: [u16; LANES],
    pub(super) z: [u16; LANES],
    pub(super) radius: [u16; LANES],
    pub(super) y: [i32; LANES],
}

const META: usize = GRAINS_PER_BLOCK;

impl Block {
    /// An empty block on top of block `older`, below whose tops `older_top` is the highest.
    pub(super) const fn new(older: u32, older_top: i32) -> Self {
        let mut block = Self { x: [0; LANES], z: [0; LANES], radius: [0; LANES], y: [0; LANES] };
        block.x[META] = (older & 0xFFFF) as u16;
        block.z[META] = (older >> 16) as u16;
        block.y[META] = older_top;
        block
    }

    #[inline(always)]
    pub(super) fn older(&self) -> u32 {
        u32::from(self.x[META]) | u32::from(self.z[META]) << 16
    }

    /// Highest top of all grains of older blocks.
    #[inline(always)]
    pub(super) fn older_top(&self) -> i32 {
        self.y[META]
    }

    #[inline(always)]
    pub(super) fn count(&self) -> usize {
        usize::from(self.radius[META])
    }

    /// Bit mask of the lanes that hold grains.
    #[inline(always)]
    pub(super) fn lanes(&self) -> u32 {
        (1 << self.count()) - 1
    }

    /// Adds a grain and returns its lane; the block must not be full.
    pub(super) fn push(&mut self, [x, z]: [u16; 2], y: i32, radius: u16) -> usize {
        let lane = self.count();
        self.x[lane] = x;
        self.z[lane] = z;
        self.y[lane] = y;
        self.radius[lane] = radius;
        self.radius[META] += 1;
        lane
    }

    /// Asks for all of it, ahead of its use.
    #[inline(always)]
    pub(super) fn prefetch(&self) {
        prefetch(&self.x[0]);
        prefetch(&self.radius[0]);
        prefetch(&self.y[LANES - 1]);
    }

    /// Takes the newest grain away; there must be one.
    pub(super) fn pop(&mut self) {
        self.radius[META] -= 1;
    }

    /// Highest top of all grains of this block and of older ones.
    pub(super) fn top(&self) -> i32 {
        let tops = (0..self.count()).map(|lane| self.y[lane] + i32::from(self.radius[lane]));
        tops.fold(self.older_top(), i32::max)
    }
}
