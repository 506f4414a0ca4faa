//! Sixteen grains in two cache lines.

use crate::prefetch::prefetch;
use bytemuck::{Pod, Zeroable};
use snowgrain_math::DVec3;

/// Grains in a [`Block`].
pub const GRAINS_PER_BLOCK: usize = 16;

/// Bits of [`Block::radius`] that hold the radius.
pub(crate) const RADIUS_MASK: u16 = 0x3fff;
/// The grain reaches a surface: light inside it must ask the surfaces too.
pub(crate) const MEETS_SURFACE: u16 = 0x4000;
/// The grain overlaps another one: an end of a chord in it need not be an interface.
pub(crate) const OVERLAPS: u16 = 0x8000;

/// Up to 16 grains in cell quanta. An unused slot has radius 0, which no ray meets.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Pod, Zeroable)]
#[repr(C, align(128))]
pub struct Block {
    /// Centres.
    pub x: [u16; GRAINS_PER_BLOCK],
    /// Centres.
    pub y: [u16; GRAINS_PER_BLOCK],
    /// Centres.
    pub z: [u16; GRAINS_PER_BLOCK],
    /// Radii (14 bits) and two flags.
    pub radius: [u16; GRAINS_PER_BLOCK],
}

impl Block {
    pub(crate) const EMPTY: Self = Self { x: [0; 16], y: [0; 16], z: [0; 16], radius: [0; 16] };

    pub(crate) fn set(&mut self, slot: usize, center: [u16; 3], radius: u16) {
        [self.x[slot], self.y[slot], self.z[slot]] = center;
        self.radius[slot] = radius;
    }

    /// The centre in a slot.
    #[inline(always)]
    pub(crate) fn center(&self, slot: usize) -> DVec3 {
        DVec3::new(self.x[slot].into(), self.y[slot].into(), self.z[slot].into())
    }

    /// Asks for both cache lines ahead of their use.
    #[inline(always)]
    pub(crate) fn prefetch(&self) {
        prefetch(&self.x);
        prefetch(&self.z);
    }
}
