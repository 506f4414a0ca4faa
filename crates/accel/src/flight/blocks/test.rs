//! One ray against the sixteen grains of a block, SIMD over the grains.
//!
//! The ray enters a grain at `t - s` and leaves it at `t + s` ([`Meeting`]); this one interval decides entering
//! and leaving.

use super::paths::{GROUP, Group, NOTHING, get};
use crate::flight::meeting::{Meeting, meet};
use crate::grain_grid::{Block, CellEntry};
use crate::strata::BlockStrata;
use fearless_simd::prelude::*;
use fearless_simd::{f32x16, mask32x16, u16x16, u32x16};

/// Bits of a distance that give way to the number of the grain's slot, so that one minimum finds
/// both: 2^-19 of the distance, and distances in a cell are below 2^16 quanta, so that grains less
/// than an eighth of a quantum apart may be taken for each other.
const SLOT_BITS: u32 = 15;

/// The least of the values of the grains that are `valid`, its last bits the slot of the grain.
#[inline(always)]
fn least<S: Simd>(simd: S, valid: mask32x16<S>, value: f32x16<S>) -> f32 {
    let slots = u32x16::from_slice(simd, &SLOTS);
    let bits: u32x16<S> = value.bitcast();
    let named: f32x16<S> = (bits & u32x16::splat(simd, !SLOT_BITS) | slots).bitcast();
    valid.select(named, f32x16::splat(simd, NOTHING)).reduce_min()
}

const SLOTS: [u32; GROUP] = [0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15];

/// In air: the least distance at which the ray enters a grain, and its slot. Grains whose centre lies
/// behind are left, not entered: a ray that starts on a sphere and leaves it is excluded by
/// convexity, without an epsilon.
#[inline(always)]
fn entered<S: Simd>(simd: S, block: &Block, group: &Group, at: usize) -> f32 {
    let (position, direction) = (get(&group.position, at), get(&group.direction, at));
    let Meeting { met, middle, half } = meet(simd, block, position, direction);
    let ahead = middle.simd_gt(f32x16::splat(simd, 0.0));
    least(simd, met & ahead, middle - half)
}

/// In ice, at the end of a chord: of the other grains that cover this point, the greatest distance at
/// which one is left, negated, and its slot.
#[inline(always)]
fn left<S: Simd>(simd: S, block: &Block, group: &Group, at: usize) -> f32 {
    let (position, direction) = (get(&group.position, at), get(&group.direction, at));
    let Meeting { met, middle, half } = meet(simd, block, position, direction);
    let zero = f32x16::splat(simd, 0.0);
    let x = u16x16::splat(simd, group.grain[0][at] as u16);
    let y = u16x16::splat(simd, group.grain[1][at] as u16);
    let z = u16x16::splat(simd, group.grain[2][at] as u16);
    let itself = u16x16::from_slice(simd, &block.x).simd_eq(x)
        & u16x16::from_slice(simd, &block.y).simd_eq(y)
        & u16x16::from_slice(simd, &block.z).simd_eq(z);
    let (low, high) = simd.widen_mask16x16(itself);
    let itself = simd.combine_mask32x8(low, high);
    let (enter, leave) = (middle - half, middle + half);
    let covers = met & enter.simd_le(zero) & leave.simd_gt(zero) & !itself;
    least(simd, covers, zero - leave)
}

/// Which test a path needs.
#[derive(Clone, Copy)]
enum Question {
    Entered,
    Left,
}

impl Question {
    #[inline(always)]
    fn ask<S: Simd>(self, simd: S, block: &Block, group: &Group, at: usize) -> f32 {
        match self {
            Self::Entered => entered(simd, block, group, at),
            Self::Left => left(simd, block, group, at),
        }
    }
}

/// Asks the blocks of the cell of every path that is in air or at the end of a chord and has no answer
/// yet.
#[inline(always)]
pub(super) fn test_group<S: Simd>(
    simd: S,
    (blocks, strata): (&[Block], &[BlockStrata]),
    group: &mut Group,
) {
    let asking = !group.waiting;
    ask(simd, blocks, group, group.air & asking, Question::Entered);
    ask(simd, blocks, group, group.ice & asking, Question::Left);
    // What was found is taken in a pass of its own: it waits for the minimum, which would else hold
    // up the next test.
    let mut lanes = (group.air | group.ice) & asking;
    while lanes != 0 {
        let at = lanes.trailing_zeros() as usize & (GROUP - 1);
        lanes &= lanes - 1;
        let slot = (group.found[at].to_bits() & SLOT_BITS) as usize;
        let block = &blocks[group.found_block[at] as usize];
        group.found_grain[0][at] = block.x[slot];
        group.found_grain[1][at] = block.y[slot];
        group.found_grain[2][at] = block.z[slot];
        group.found_radius[at] = block.radius[slot];
    }
    if strata.is_empty() {
        return;
    }
    let mut lanes = (group.air | group.ice) & asking;
    while lanes != 0 {
        let at = lanes.trailing_zeros() as usize & (GROUP - 1);
        lanes &= lanes - 1;
        let slot = (group.found[at].to_bits() & SLOT_BITS) as usize;
        group.found_stratum[at] = strata[group.found_block[at] as usize][slot];
    }
}

#[inline(always)]
fn ask<S: Simd>(simd: S, blocks: &[Block], group: &mut Group, lanes: u32, question: Question) {
    let mut rest = lanes;
    while rest != 0 {
        let at = rest.trailing_zeros() as usize & (GROUP - 1);
        rest &= rest - 1;
        let first = CellEntry(group.entry[at]).first_block();
        group.found[at] = question.ask(simd, &blocks[first], group, at);
        group.found_block[at] = first as u32;
    }
    let mut rest = lanes & group.crowded;
    while rest != 0 {
        let at = rest.trailing_zeros() as usize & (GROUP - 1);
        rest &= rest - 1;
        for index in CellEntry(group.entry[at]).further_blocks() {
            let value = question.ask(simd, &blocks[index], group, at);
            if value < group.found[at] {
                group.found[at] = value;
                group.found_block[at] = index as u32;
            }
        }
    }
}
