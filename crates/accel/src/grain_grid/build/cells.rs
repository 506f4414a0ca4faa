//! What happens to the cells of one brick: grains are counted, compared, and listed.

use super::Packer;
use super::batches::{HeldBrick, ReachingGrain};
use super::overlap::{ListedGrains, Shaped, mark_overlapping};
use crate::grain_grid::block::{MEETS_SURFACE, OVERLAPS};
use crate::grain_grid::packed_cells::{BRICK, CELLS_PER_BRICK};
use crate::grain_grid::{Block, BlockShapes, CellEntry, GRAINS_PER_BLOCK, ReachedFaces, ShapeWord};
use crate::strata::BlockStrata;
use fearless_simd::{Level, dispatch};
use snowgrain_math::{Aabb, DVec3};
use std::sync::atomic::Ordering::Relaxed;

/// Most grains that a cell may list.
pub(super) const MOST_PER_CELL: usize = CellEntry::MAX_BLOCKS_PER_CELL * GRAINS_PER_BLOCK;

/// The flags of [`Block::radius`] as bits of a byte, and the stratum above them.
const FLAGS_SHIFT: u32 = 14;
pub(super) const STRATUM_SHIFT: u32 = 2;

/// A grain in a cell of a brick.
#[derive(Clone, Copy, Debug)]
struct Listed {
    cell: u16,
    slot: u16,
    grain: u32,
}

/// What the work on a brick needs, kept from brick to brick.
#[derive(Debug, Default)]
pub(super) struct Scratch {
    listed: Vec<Listed>,
    blocks: Vec<Block>,
    owners: Vec<[u32; GRAINS_PER_BLOCK]>,
    overlapping: Vec<bool>,
    reached: Vec<ReachedFaces>,
}

/// What counting told of a batch.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Counted {
    /// Blocks needed.
    pub(super) blocks: usize,
    /// Grains of the most crowded cell.
    pub(super) most: usize,
}

impl Packer<'_> {
    /// Counts the grains of each cell into its entry, and marks those that overlap others or meet a
    /// surface.
    pub(super) fn count(
        &self,
        level: Level,
        brick: &HeldBrick,
        grains: &[ReachingGrain],
        entries: &mut [CellEntry],
        scratch: &mut Scratch,
    ) -> Counted {
        let place = self.layout.brick(brick.number as usize);
        let cells = self.layout.cells_in_brick(place);
        let mut counts = [0u16; CELLS_PER_BRICK];
        let mut most = 0;
        scratch.listed.clear();
        for (index, grain) in grains.iter().enumerate() {
            self.layout.for_cells(cells, grain.center, grain.radius, |cell, _| {
                let slot = counts[cell];
                counts[cell] = slot.saturating_add(1);
                most = most.max(counts[cell]);
                if usize::from(slot) < MOST_PER_CELL {
                    scratch.listed.push(Listed { cell: cell as u16, slot, grain: index as u32 });
                }
            });
        }
        let mut blocks = 0;
        for (cell, (entry, &count)) in entries.iter_mut().zip(&counts).enumerate() {
            let at = [cell & 7, cell >> 3 & 7, cell >> 6].map(|c| (c as u32).cast_signed());
            let exists = (0..3).all(|axis| at[axis] < cells[axis]);
            let surface = brick.surface && exists && {
                let from = std::array::from_fn(|axis| place[axis] * BRICK + at[axis]);
                self.crosses(from, from.map(|c| c + 1))
            };
            *entry = CellEntry(u32::from(count) | if surface { CellEntry::SURFACE } else { 0 });
            blocks += usize::from(count).div_ceil(GRAINS_PER_BLOCK);
        }
        if usize::from(most) <= MOST_PER_CELL {
            self.mark_overlapping(level, grains, &counts, scratch);
            if brick.surface {
                self.mark_meeting(place, grains, entries, &scratch.listed);
            }
        }
        Counted { blocks, most: usize::from(most) }
    }

    fn mark_overlapping(
        &self,
        level: Level,
        grains: &[ReachingGrain],
        counts: &[u16; CELLS_PER_BRICK],
        scratch: &mut Scratch,
    ) {
        let Scratch { listed, blocks, owners, overlapping, reached } = scratch;
        let mut starts = [0u32; CELLS_PER_BRICK];
        let mut needed = 0;
        for (start, &count) in starts.iter_mut().zip(counts) {
            *start = needed as u32;
            needed += usize::from(count).div_ceil(GRAINS_PER_BLOCK);
        }
        blocks.clear();
        blocks.resize(needed, Block::EMPTY);
        owners.resize(needed.max(owners.len()), [0; GRAINS_PER_BLOCK]);
        overlapping.clear();
        overlapping.extend(
            grains.iter().map(|g| self.flags[g.grain as usize].load(Relaxed) & flag(OVERLAPS) != 0),
        );
        for &Listed { cell, slot, grain } in listed.iter() {
            let cell = usize::from(cell);
            let slot = usize::from(slot);
            let at = starts[cell] as usize + slot / GRAINS_PER_BLOCK;
            let ReachingGrain { center, radius, .. } = grains[grain as usize];
            let corner = [cell & 7, cell >> 3 & 7, cell >> 6].map(|c| (c as u32).cast_signed());
            let local = std::array::from_fn(|axis| {
                (center[axis] - corner[axis] * self.layout.side[axis] + self.margin) as u16
            });
            blocks[at].set(slot % GRAINS_PER_BLOCK, local, radius);
            owners[at][slot % GRAINS_PER_BLOCK] = grain;
        }
        let listed = |cell: usize| {
            let (start, count) = (starts[cell] as usize, usize::from(counts[cell]));
            let range = start..start + count.div_ceil(GRAINS_PER_BLOCK);
            ListedGrains { blocks: &blocks[range.clone()], owners: &owners[range], count }
        };
        if self.words.is_empty() {
            dispatch!(level, simd => {
                for cell in 0..CELLS_PER_BRICK {
                    mark_overlapping(simd, &listed(cell), overlapping);
                }
            });
        } else {
            let words = |grain: u32| self.words[grains[grain as usize].grain as usize];
            let shaped = Shaped {
                hulls: self.hulls,
                words: &words,
                margin: self.margin,
                side: self.layout.side,
            };
            reached.clear();
            reached.extend(grains.iter().map(|g| self.reached_faces(g.grain)));
            for cell in 0..CELLS_PER_BRICK {
                shaped.mark_overlapping(&listed(cell), overlapping, reached);
            }
            for (grain, &faces) in grains.iter().zip(reached.iter()) {
                if faces != ReachedFaces::NONE {
                    self.reached[grain.grain as usize].fetch_or(faces.to_bits(), Relaxed);
                }
            }
        }
        for (grain, _) in grains.iter().zip(overlapping).filter(|(_, overlaps)| **overlaps) {
            self.set_flag(grain.grain, OVERLAPS);
        }
    }

    /// The faces of a grain that are known to be reached.
    fn reached_faces(&self, grain: u32) -> ReachedFaces {
        ReachedFaces::from_bits(self.reached[grain as usize].load(Relaxed))
    }

    /// Marks the grains listed in cells that a surface crosses, where it may cross the grain too.
    fn mark_meeting(
        &self,
        place: [i32; 3],
        grains: &[ReachingGrain],
        entries: &[CellEntry],
        listed: &[Listed],
    ) {
        let quantum = self.quantisation.quantum();
        for &Listed { cell, grain, .. } in listed {
            let ReachingGrain { center, grain, radius } = grains[grain as usize];
            let known = self.flags[grain as usize].load(Relaxed) & flag(MEETS_SURFACE) != 0;
            if known || !entries[usize::from(cell)].has_surface() {
                continue;
            }
            let center = std::array::from_fn(|axis| {
                let brick = i64::from(place[axis] * BRICK) * i64::from(self.layout.side[axis]);
                (self.layout.first[axis] + brick + i64::from(center[axis])) as i32
            });
            let metres =
                self.quantisation.grain(snowgrain_geometry::QuantisedGrain { center, radius });
            let reach = DVec3::splat(metres.radius + quantum);
            let around = Aabb::new(metres.center - reach, metres.center + reach);
            if self.surfaces.may_cross(&around) {
                self.set_flag(grain, MEETS_SURFACE);
            }
        }
    }

    fn set_flag(&self, grain: u32, flags: u16) {
        let known = &self.flags[grain as usize];
        if known.load(Relaxed) & flag(flags) == 0 {
            known.fetch_or(flag(flags), Relaxed);
        }
    }

    /// Lists the grains of a brick in its blocks, whose entries are known, in their order; `first`
    /// is the number of `blocks[0]`.
    pub(super) fn list(
        &self,
        brick: &HeldBrick,
        grains: &[ReachingGrain],
        (entries, first): (&[CellEntry], usize),
        (blocks, strata, shapes): (&mut [Block], &mut [BlockStrata], &mut [BlockShapes]),
    ) {
        let cells = self.layout.cells_in_brick(self.layout.brick(brick.number as usize));
        let mut counts = [0u8; CELLS_PER_BRICK];
        for grain in grains {
            let known = self.flags[grain.grain as usize].load(Relaxed);
            // What lies above the flags is shifted out.
            let flags = u16::from(known) << FLAGS_SHIFT;
            self.layout.for_cells(cells, grain.center, grain.radius, |cell, corner| {
                let slot = usize::from(counts[cell]);
                counts[cell] += 1;
                let at = entries[cell].first_block() - first + slot / GRAINS_PER_BLOCK;
                let local = std::array::from_fn(|axis| {
                    (grain.center[axis] - corner[axis] + self.margin) as u16
                });
                blocks[at].set(slot % GRAINS_PER_BLOCK, local, grain.radius | flags);
                if let Some(strata) = strata.get_mut(at) {
                    strata[slot % GRAINS_PER_BLOCK] = known >> STRATUM_SHIFT;
                }
                if let Some(shapes) = shapes.get_mut(at) {
                    let (slot, grain) = (slot % GRAINS_PER_BLOCK, grain.grain);
                    let of_grain = ShapeWord::of_slot(self.words[grain as usize]).shape();
                    shapes[slot] = ShapeWord::new(of_grain, self.reached_faces(grain)).to_slot();
                }
            });
        }
    }
}

fn flag(flags: u16) -> u8 {
    (flags >> FLAGS_SHIFT) as u8
}

/// Turns the counts of a batch's cells into entries, whose blocks are numbered from `next`.
pub(super) fn number_blocks(entries: &mut [CellEntry], mut next: usize) {
    for entry in entries {
        let count = (entry.0 & !CellEntry::SURFACE) as usize;
        let needed = count.div_ceil(GRAINS_PER_BLOCK);
        *entry = CellEntry::new(if needed == 0 { 0 } else { next }, needed, entry.has_surface());
        next += needed;
    }
}
