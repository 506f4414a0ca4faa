//! Which grains overlap others.

use crate::grain_grid::block::RADIUS_MASK;
use crate::grain_grid::{Block, GRAINS_PER_BLOCK};
use fearless_simd::Simd;

/// Grains whose surfaces interpenetrate by less than this many quanta only touch: rounding to the
/// lattice moves two grains by at most 1.74 quanta against each other.
const TOUCH: u16 = 3;

/// Whether two grains interpenetrate by more than rounding explains.
#[inline(always)]
pub(crate) fn overlaps(a: [i32; 3], radius_a: u16, b: [i32; 3], radius_b: u16) -> bool {
    // Of the smallest grains a few quanta are a large part.
    let touch = TOUCH.min(radius_a.min(radius_b) / 16);
    let sum = u32::from(radius_a) + u32::from(radius_b) - u32::from(touch);
    // Two radii are at most 15 bits: what is cut off there cannot overlap, and squares fit.
    let far = u32::from(2 * RADIUS_MASK + 1);
    let square = |axis: usize| {
        let d = a[axis].abs_diff(b[axis]).min(far);
        d * d
    };
    square(0) + square(1) + square(2) < sum * sum
}

/// Grains of a cell, as the test of its overlaps wants them.
pub(super) struct ListedGrains<'a> {
    pub(super) blocks: &'a [Block],
    /// The grain of each slot, among those of `overlapping`.
    pub(super) owners: &'a [[u32; GRAINS_PER_BLOCK]],
    /// Grains listed.
    pub(super) count: usize,
    /// By how much larger than the grains each of two balls is.
    pub(super) slack: u16,
}

/// Marks the grains of a cell that overlap another one of it.
#[inline(always)]
pub(super) fn mark_overlapping<S: Simd>(_: S, cell: &ListedGrains<'_>, overlapping: &mut [bool]) {
    for own in 0..cell.count {
        let (at, slot) = (own / GRAINS_PER_BLOCK, own % GRAINS_PER_BLOCK);
        let owner = cell.owners[at][slot] as usize;
        if overlapping[owner] {
            continue;
        }
        let block = &cell.blocks[at];
        let center = [block.x[slot], block.y[slot], block.z[slot]];
        let radius = block.radius[slot];
        overlapping[owner] = cell.blocks.iter().enumerate().any(|(other, block)| {
            let but = if other == at { slot } else { GRAINS_PER_BLOCK };
            overlaps_any(block, center, (radius, TOUCH + 2 * cell.slack), but)
        });
    }
}

/// Whether a grain overlaps one of the block but that in slot `but`. Without a branch a slot, so
/// that the compiler makes vectors of it.
#[inline(always)]
fn overlaps_any(
    block: &Block,
    center: [u16; 3],
    (radius, most_touch): (u16, u16),
    but: usize,
) -> bool {
    let mut hits = [0u16; GRAINS_PER_BLOCK];
    for (slot, hit) in hits.iter_mut().enumerate() {
        let other = block.radius[slot];
        let touch = most_touch.min(radius.min(other) / 16);
        let sum = radius + other - touch;
        let far = 2 * RADIUS_MASK + 1;
        let square = |a: u16, b: u16| {
            let d = u32::from(a.abs_diff(b).min(far));
            d * d
        };
        let distance2 = square(block.x[slot], center[0])
            + square(block.y[slot], center[1])
            + square(block.z[slot], center[2]);
        let sum2 = u32::from(sum) * u32::from(sum);
        *hit = u16::from((distance2 < sum2) & (other > 0));
    }
    if but < GRAINS_PER_BLOCK {
        hits[but] = 0;
    }
    hits.iter().fold(0, |any, &hit| any | hit) != 0
}
