//! Bricks in batches, each worked on by one thread: its grains are gathered and sorted by brick, so
//! that everything that happens to a brick happens in the nearest caches and in the order of the
//! grains, whatever the number of threads.

use super::layout::{BrickBox, Layout};
use super::survey::{Part, Survey};
use crate::grain_grid::GrainParts;
use crate::grain_grid::packed_cells::BRICK;
use std::ops::Range;

/// A brick that holds grains or is crossed by a surface.
#[derive(Clone, Copy, Debug)]
pub(super) struct HeldBrick {
    /// Its number in the table of all bricks.
    pub(super) number: u32,
    /// Grains that reach into it.
    pub(super) grains: u32,
    /// Whether a surface may cross it.
    pub(super) surface: bool,
}

/// Batches are at least so many; they are what is held in memory beside the cells, two of 32 where
/// two threads work.
const LEAST_BATCHES: usize = 32;
const BATCHES_PER_THREAD: usize = 4;

/// Cuts the bricks into batches of about as many grains.
pub(super) fn cut(held: &[HeldBrick]) -> Vec<Range<usize>> {
    let wanted = LEAST_BATCHES.max(BATCHES_PER_THREAD * rayon::current_num_threads());
    let all: u64 = held.iter().map(|brick| u64::from(brick.grains) + 1).sum();
    let most = all.div_ceil(wanted as u64).max(1);
    let mut batches = Vec::with_capacity(wanted + 1);
    let (mut start, mut sum) = (0, 0);
    for (index, brick) in held.iter().enumerate() {
        sum += u64::from(brick.grains) + 1;
        if sum >= most || index + 1 == held.len() {
            batches.push(start..index + 1);
            (start, sum) = (index + 1, 0);
        }
    }
    batches
}

/// A grain that reaches into a brick.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct ReachingGrain {
    /// Centre relative to the brick's low corner, quanta.
    pub(super) center: [i32; 3],
    /// Its number among all grains.
    pub(super) grain: u32,
    pub(super) radius: u16,
}

/// The grains of a batch, brick by brick.
#[derive(Debug, Default)]
pub(super) struct Gathered {
    grains: Vec<ReachingGrain>,
    /// Where those of each brick end.
    ends: Vec<usize>,
}

impl Gathered {
    /// Gathers what reaches into the bricks of a batch. `table` numbers bricks that are held from 1,
    /// and `first` is the index of the batch's first.
    pub(super) fn fill(
        &mut self,
        layout: &Layout,
        (grains, survey): (&GrainParts<'_>, &Survey),
        table: &[u32],
        (held, first): (&[HeldBrick], usize),
    ) {
        self.ends.clear();
        let mut sum = 0;
        for brick in held {
            self.ends.push(sum);
            sum += brick.grains as usize;
        }
        self.grains.clear();
        self.grains.resize(sum, ReachingGrain::default());
        let within = box_of(layout, held);
        let ends = &mut self.ends;
        for (index, part) in survey.parts.iter().enumerate() {
            if !may_reach(layout, part, &within) {
                continue;
            }
            let mut number = part.first;
            grains.for_each(index, |grain| {
                layout.for_bricks(grain, &within, |brick, center| {
                    // Bricks before the batch wrap around to far beyond it.
                    let at = (table[brick] as usize).wrapping_sub(first + 1);
                    if let Some(end) = ends.get_mut(at) {
                        self.grains[*end] =
                            ReachingGrain { center, grain: number, radius: grain.radius };
                        *end += 1;
                    }
                });
                number += 1;
            });
        }
    }

    /// The grains that reach into the batch's brick of that index, in their order.
    pub(super) fn of_brick(&self, index: usize) -> &[ReachingGrain] {
        let start = index.checked_sub(1).map_or(0, |before| self.ends[before]);
        &self.grains[start..self.ends[index]]
    }
}

/// A box around bricks that follow one another.
fn box_of(layout: &Layout, held: &[HeldBrick]) -> BrickBox {
    let [from, to] = [held.first(), held.last()]
        .map(|brick| layout.brick(brick.map_or(0, |brick| brick.number as usize)).map(i64::from));
    let mut within = layout.all_bricks();
    within[2] = [from[2], to[2]];
    if from[2] == to[2] {
        within[1] = [from[1], to[1]];
    }
    within
}

/// Whether the balls of a part may reach into a box of bricks.
fn may_reach(layout: &Layout, part: &Part, within: &BrickBox) -> bool {
    (0..3).all(|axis| {
        let edge = i64::from(BRICK) * i64::from(layout.side[axis]);
        let [low, high] =
            [within[axis][0], within[axis][1] + 1].map(|brick| layout.first[axis] + brick * edge);
        layout.periodic[axis] || (part.low[axis] <= high && part.high[axis] >= low)
    })
}
