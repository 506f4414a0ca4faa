//! Packing grains into cells, on all threads of the current pool and with the same result on any
//! number of them.
//!
//! The bricks that grains reach are found first; then, batch of bricks by batch, grains are counted
//! and compared; then, when all is numbered, listed.

mod batches;
mod cells;
mod layout;
mod overlap;
mod survey;

use super::hull::Hull;
use super::packed_cells::{BRICK, CELLS_PER_BRICK};
use super::{
    Block, BlockShapes, CellEntry, GrainGrid, GrainParts, GridError, GridShapes, PackedCells,
    Packing, Storage,
};
use crate::pages;
use crate::strata::BlockStrata;
use crate::{SimdLevel, Surfaces};
use batches::{Gathered, HeldBrick};
use cells::{Counted, MOST_PER_CELL, STRATUM_SHIFT, Scratch, number_blocks};
use layout::Layout;
pub(super) use overlap::overlaps;
use rayon::prelude::*;
use snowgrain_geometry::Quantisation;
use std::ops::Range;
use std::sync::atomic::{AtomicU8, AtomicU16, AtomicU32, Ordering::Relaxed};
use survey::Survey;

/// Rounding of positions while light moves stays far below one quantum; a grain this close to a
/// cell is listed there too.
pub(super) const PAD: i32 = 1;

/// Most memory that cells smaller than wanted may take, where grains of very different sizes need
/// them: bytes a grain, or in all.
const MOST_BYTES_PER_GRAIN: usize = 1024;
const MOST_BYTES_AT_LEAST: usize = 1 << 30;

/// Whether the ball around `center` (relative to the cell's low corner) reaches the cell.
pub(super) fn reaches_cell(center: [i32; 3], radius: u16, side: [i32; 3]) -> bool {
    let reach = i64::from(radius) + i64::from(PAD);
    let distance2: i64 = (0..3)
        .map(|axis| {
            let gap = i64::from((-center[axis]).max(center[axis] - side[axis]).max(0));
            gap * gap
        })
        .sum();
    distance2 <= reach * reach
}

/// Longest edge of a cell, quanta, such that every grain that reaches into it, from at most `margin`
/// away, has 16-bit coordinates in cell quanta.
pub(super) fn longest_side(margin: i32) -> i32 {
    i32::from(u16::MAX) - 2 * margin
}

/// What there is beside the places and sizes of grains.
pub(super) struct Around<'a> {
    pub(super) surfaces: &'a Surfaces,
    /// Of each grain, or none.
    pub(super) strata: &'a [u8],
    /// The shape of each grain, or none.
    pub(super) words: &'a [u64],
    /// Of each prototype.
    pub(super) hulls: &'a [Hull],
}

pub(super) fn build(
    quantisation: Quantisation,
    grains: GrainParts<'_>,
    Around { surfaces, strata, words, hulls }: Around<'_>,
    period: Option<[i64; 2]>,
    packing: Packing,
) -> Result<GrainGrid, GridError> {
    let survey = Survey::of(&grains)?;
    assert!(strata.is_empty() || strata.len() as u64 == survey.grains, "a stratum for each grain");
    let margin = i32::from(survey.largest) + PAD;
    if survey.grains == 0 {
        return Ok(GrainGrid {
            quantisation,
            first: [0; 3],
            side: [1; 3],
            cells: [1; 3],
            periodic: [false; 3],
            margin,
            storage: Storage::Packed(PackedCells::new([1; 3])?),
            blocks: vec![Block::EMPTY],
            strata: Vec::new(),
            shapes: None,
            grains: 0,
        });
    }
    let mut flags = Vec::new();
    match strata {
        [] => flags.resize_with(survey.grains as usize, || AtomicU8::new(0)),
        strata => {
            flags.extend(strata.iter().map(|stratum| AtomicU8::new(stratum << STRATUM_SHIFT)));
        }
    }
    let mut reached = Vec::new();
    reached.resize_with(words.len(), || AtomicU16::new(0));
    let wanted = survey.choose_side(&grains, packing, (margin, !words.is_empty()));
    let mut side = wanted;
    let mut crowded = None;
    loop {
        let layout = Layout::new(&survey, side, period, margin)?;
        let smaller = side < wanted;
        let packer = Packer {
            quantisation,
            grains,
            survey: &survey,
            surfaces,
            layout,
            margin,
            flags: &flags,
            has_strata: strata.iter().any(|&stratum| stratum != 0),
            words,
            reached: &reached,
            hulls,
            most_bytes: smaller
                .then(|| MOST_BYTES_AT_LEAST.max(MOST_BYTES_PER_GRAIN * survey.grains as usize)),
        };
        match packer.pack() {
            // Where a few sizes are much smaller than the rest, their heaps want smaller cells.
            Err(error @ GridError::CrowdedCell { .. }) if side > 1 => {
                crowded = Some(error);
                side /= 2;
            }
            Err(
                GridError::TooSparse { .. }
                | GridError::TooManyBlocks { .. }
                | GridError::BadPeriod,
            ) if smaller => {
                return Err(crowded.unwrap_or(GridError::BadPeriod));
            }
            packed => return packed,
        }
    }
}

/// All that packing needs to know.
struct Packer<'a> {
    quantisation: Quantisation,
    grains: GrainParts<'a>,
    survey: &'a Survey,
    surfaces: &'a Surfaces,
    layout: Layout,
    margin: i32,
    /// Of each grain, the flags of its copies, and its stratum above them.
    flags: &'a [AtomicU8],
    has_strata: bool,
    /// Of each grain its shape, where it may have any.
    words: &'a [u64],
    /// Of each such grain which of its faces other ice may reach.
    reached: &'a [AtomicU16],
    hulls: &'a [Hull],
    /// Memory of the cells beyond which they are too many.
    most_bytes: Option<usize>,
}

/// A batch of bricks and what belongs to it alone.
struct Batch<'a> {
    bricks: Range<usize>,
    entries: &'a mut [CellEntry],
    blocks: (&'a mut [Block], usize),
    strata: &'a mut [BlockStrata],
    shapes: &'a mut [BlockShapes],
}

impl Packer<'_> {
    fn pack(&self) -> Result<GrainGrid, GridError> {
        let (table, held) = self.find_bricks()?;
        let batches = batches::cut(&held);
        self.check_bytes((held.len() + 1) * CELLS_PER_BRICK * size_of::<CellEntry>())?;
        let mut entries = pages::zeroed::<CellEntry>((held.len() + 1) * CELLS_PER_BRICK);
        // Bricks need not divide a period.
        if self.layout.periodic == [false; 3] {
            entries[..CELLS_PER_BRICK].fill(CellEntry::EMPTY_BRICK);
        }
        let counted = self.count_all(&table, &held, &batches, &mut entries);
        let most = counted.iter().map(|batch| batch.most).max().unwrap_or(0);
        if most > MOST_PER_CELL {
            let side = f64::from(self.layout.side[1]) * self.quantisation.quantum();
            return Err(GridError::CrowdedCell { count: most, most: MOST_PER_CELL, side });
        }
        let needed = 1 + counted.iter().map(|batch| batch.blocks).sum::<usize>();
        if needed > CellEntry::MAX_BLOCKS {
            return Err(GridError::TooManyBlocks { blocks: needed, most: CellEntry::MAX_BLOCKS });
        }
        self.check_bytes(needed * size_of::<Block>())?;
        let mut blocks = pages::zeroed::<Block>(needed);
        let counts: Vec<usize> = counted.iter().map(|batch| batch.blocks).collect();
        let mut strata = vec![BlockStrata::default(); if self.has_strata { needed } else { 0 }];
        let with_shapes = if self.words.is_empty() { 0 } else { needed };
        let mut shapes = pages::zeroed::<BlockShapes>(with_shapes);
        let lists = Lists {
            entries: &mut entries,
            blocks: &mut blocks,
            strata: &mut strata,
            shapes: &mut shapes,
        };
        self.list_all(&table, &held, (&batches, &counts), lists);
        let prototypes = Vec::new();
        Ok(GrainGrid {
            quantisation: self.quantisation,
            first: self.layout.first,
            side: self.layout.side,
            cells: self.layout.cells,
            periodic: self.layout.periodic,
            margin: self.margin,
            storage: Storage::Packed(PackedCells::of(self.layout.bricks(), table, entries)),
            blocks,
            strata,
            shapes: (with_shapes > 0).then_some(GridShapes {
                prototypes,
                concentric: false,
                blocks: shapes,
            }),
            grains: self.survey.grains,
        })
    }

    fn check_bytes(&self, bytes: usize) -> Result<(), GridError> {
        match self.most_bytes {
            Some(most) if bytes > most => Err(GridError::TooManyBlocks {
                blocks: bytes / size_of::<Block>(),
                most: most / size_of::<Block>(),
            }),
            _ => Ok(()),
        }
    }

    /// The bricks that a grain reaches or a surface crosses: the table of all, in which they are
    /// numbered from 1 in its order, so that neighbours in space lie together in memory whatever the
    /// order of the grains; and a list of them.
    fn find_bricks(&self) -> Result<(Vec<u32>, Vec<HeldBrick>), GridError> {
        let count = PackedCells::count_bricks(self.layout.bricks())?;
        let mut reached: Vec<AtomicU32> = Vec::new();
        reached.resize_with(count, || AtomicU32::new(0));
        let all = self.layout.all_bricks();
        (0..self.survey.parts.len()).into_par_iter().for_each(|part| {
            self.grains.for_each(part, |grain| {
                self.layout.for_bricks(grain, &all, |brick, _| {
                    reached[brick].fetch_add(1, Relaxed);
                });
            });
        });
        let crossed: Vec<bool> = if self.surfaces.is_empty() {
            Vec::new()
        } else {
            let crosses = |brick: usize| {
                let from = self.layout.brick(brick).map(|b| b * BRICK);
                let to =
                    std::array::from_fn(|axis| (from[axis] + BRICK).min(self.layout.cells[axis]));
                self.crosses(from, to) && self.crosses_a_cell(from, to)
            };
            (0..count).into_par_iter().map(crosses).collect()
        };
        let mut held = Vec::new();
        let number = |(number, grains): (usize, AtomicU32)| {
            let grains = grains.into_inner();
            let surface = crossed.get(number).copied().unwrap_or(false);
            if grains == 0 && !surface {
                return 0;
            }
            held.push(HeldBrick { number: number as u32, grains, surface });
            held.len() as u32
        };
        let table = reached.into_iter().enumerate().map(number).collect();
        Ok((table, held))
    }

    fn crosses_a_cell(&self, from: [i32; 3], to: [i32; 3]) -> bool {
        (from[2]..to[2]).any(|z| {
            (from[1]..to[1])
                .any(|y| (from[0]..to[0]).any(|x| self.crosses([x, y, z], [x + 1, y + 1, z + 1])))
        })
    }

    /// Whether a surface may cross the cells `from..to`.
    fn crosses(&self, from: [i32; 3], to: [i32; 3]) -> bool {
        self.surfaces.may_cross(&self.layout.cell_box(self.quantisation, from, to))
    }

    fn count_all(
        &self,
        table: &[u32],
        held: &[HeldBrick],
        batches: &[Range<usize>],
        entries: &mut [CellEntry],
    ) -> Vec<Counted> {
        let level = SimdLevel::detect().token().expect("a level that was detected is there");
        let none = vec![0; batches.len()];
        let lists = Lists { entries, blocks: &mut [], strata: &mut [], shapes: &mut [] };
        let work = split(batches, &none, lists);
        work.into_par_iter()
            .map_init(<(Gathered, Scratch)>::default, |(gathered, scratch), batch| {
                let bricks = &held[batch.bricks.clone()];
                let grains = (&self.grains, self.survey);
                gathered.fill(&self.layout, grains, table, (bricks, batch.bricks.start));
                let cells = batch.entries.chunks_mut(CELLS_PER_BRICK);
                let mut sum = Counted::default();
                for (index, (brick, cells)) in bricks.iter().zip(cells).enumerate() {
                    let grains = gathered.of_brick(index);
                    let counted = self.count(level, brick, grains, cells, scratch);
                    sum.blocks += counted.blocks;
                    sum.most = sum.most.max(counted.most);
                }
                sum
            })
            .collect()
    }

    fn list_all(
        &self,
        table: &[u32],
        held: &[HeldBrick],
        (batches, counts): (&[Range<usize>], &[usize]),
        lists: Lists<'_>,
    ) {
        let work = split(batches, counts, lists);
        work.into_par_iter().for_each_init(Gathered::default, |gathered, batch| {
            let bricks = &held[batch.bricks.clone()];
            let grains = (&self.grains, self.survey);
            gathered.fill(&self.layout, grains, table, (bricks, batch.bricks.start));
            let ((blocks, first), strata, shapes) = (batch.blocks, batch.strata, batch.shapes);
            number_blocks(batch.entries, first);
            let cells = batch.entries.chunks(CELLS_PER_BRICK);
            for (index, (brick, cells)) in bricks.iter().zip(cells).enumerate() {
                let lists = (&mut *blocks, &mut *strata, &mut *shapes);
                self.list(brick, gathered.of_brick(index), (cells, first), lists);
            }
        });
    }
}

/// Entries of the cells, blocks, and the strata and shapes in them, if there are any.
struct Lists<'a> {
    entries: &'a mut [CellEntry],
    blocks: &'a mut [Block],
    strata: &'a mut [BlockStrata],
    shapes: &'a mut [BlockShapes],
}

/// Gives each batch its entries and its blocks; brick 0 and block 0 are nobody's.
fn split<'a>(
    batches: &[Range<usize>],
    counts: &[usize],
    Lists { entries, blocks, strata, shapes }: Lists<'a>,
) -> Vec<Batch<'a>> {
    let mut entries = &mut entries[CELLS_PER_BRICK..];
    let mut blocks = blocks.get_mut(1..).unwrap_or_default();
    let mut strata = strata.get_mut(1..).unwrap_or_default();
    let mut shapes = shapes.get_mut(1..).unwrap_or_default();
    let mut first = 1;
    let mut give = |(bricks, &count): (&Range<usize>, &usize)| {
        let (own_entries, rest) =
            std::mem::take(&mut entries).split_at_mut(bricks.len() * CELLS_PER_BRICK);
        entries = rest;
        let (own_blocks, rest) = std::mem::take(&mut blocks).split_at_mut(count);
        blocks = rest;
        let own = if strata.is_empty() { 0 } else { count };
        let (own_strata, rest) = std::mem::take(&mut strata).split_at_mut(own);
        strata = rest;
        let own = if shapes.is_empty() { 0 } else { count };
        let (own_shapes, rest) = std::mem::take(&mut shapes).split_at_mut(own);
        shapes = rest;
        let batch = Batch {
            bricks: bricks.clone(),
            entries: own_entries,
            blocks: (own_blocks, first),
            strata: own_strata,
            shapes: own_shapes,
        };
        first += count;
        batch
    };
    batches.iter().zip(counts).map(&mut give).collect()
}
