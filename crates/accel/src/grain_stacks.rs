//! The store of fallen grains, which is also what a falling grain asks.
//!
//! The plan (x, z) is divided into square cells. Each cell owns a stack of blocks of 15 grains; a
//! block links to the next older one and knows the highest top of everything older, so a search
//! from above stops as soon as nothing older can reach what it has found. Blocks are only ever
//! appended: nothing is rebuilt, no list overflows, and a fall costs the same at any depth.
//!
//! All lengths are in quanta of the scene's [`Quantisation`](snowgrain_geometry::Quantisation).
//! Candidates are found in single precision with a margin that covers its rounding; whether and
//! where they are met is then decided in double precision on the stored integers, so every answer
//! is the same at every SIMD level and equal to that of a search of all grains.

mod block;
mod fall;
mod near;
#[cfg(test)]
mod tests;

use crate::SimdLevel;
use block::{Block, GRAINS_PER_BLOCK, NO_BLOCK};
use fearless_simd::Level;
use snowgrain_geometry::QuantisedGrain;
use std::ops::RangeInclusive;
use thiserror::Error;

pub use fall::{Fall, FallHit};

/// Blocks are allocated in chunks of this many, so that growing never copies nor doubles.
const BLOCKS_PER_CHUNK: usize = 4096;
/// Most cells a plan may have: one gibibyte of them.
const MOST_CELLS: i64 = 1 << 27;
/// Most blocks that a grain's name can tell apart.
const MOST_BLOCKS: u32 = 1 << 28;

/// Why grains cannot be stored.
#[derive(Debug, Error, Clone, Copy, PartialEq, Eq)]
pub enum GrainStacksError {
    /// The plan has too many cells.
    #[error(
        "the snow's area would need {cells} cells of a grain's size (at most {MOST_CELLS} can be \
         held); use larger grains or a smaller area"
    )]
    AreaTooLarge {
        /// Cells that it would need.
        cells: i64,
    },
    /// The grain lies outside the plan.
    #[error("a grain lies outside the area of the snow")]
    OutsideArea,
    /// There are too many grains.
    #[error("more than {} grains cannot be stored", MOST_BLOCKS as u64 * GRAINS_PER_BLOCK as u64)]
    TooManyGrains,
}

/// Names a stored grain for as long as its [`GrainStacks`] lives.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct GrainSlot(u32);

impl GrainSlot {
    fn new(block: u32, lane: usize) -> Self {
        Self(block << 4 | lane as u32)
    }
}

/// A plan rectangle `[x0, x1) x [z0, z1)`, quanta.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PlanRectangle {
    /// Least x and z.
    pub min: [i32; 2],
    /// Greatest x and z.
    pub max: [i32; 2],
}

#[derive(Clone, Copy, Debug)]
struct Cell {
    /// Newest block, or [`NO_BLOCK`].
    newest: u32,
    /// Highest top of its grains.
    top: i32,
}

const EMPTY_CELL: Cell = Cell { newest: NO_BLOCK, top: i32::MIN };

/// Stacks of grains over a plan; see the [module](self).
#[derive(Debug)]
pub struct GrainStacks {
    side: i32,
    cells_per_quantum: f64,
    /// Indices of the first column and row, in cells from the lattice's origin shifted by `anchor`.
    first: [i32; 2],
    counts: [i32; 2],
    anchor: [i32; 2],
    periodic: bool,
    cells: Vec<Cell>,
    chunks: Vec<Vec<Block>>,
    blocks: u32,
    grains: u64,
    largest_radius: u16,
    level: Level,
}

/// A cell of the plan as a query sees it: where it lies after periodic wrapping.
#[derive(Clone, Copy, Debug)]
struct SeenCell {
    newest: u32,
    top: i32,
    /// Least corner of the image of the cell that the query meets.
    corner: [i64; 2],
}

impl GrainStacks {
    /// An empty store over `plan` (it may be enlarged later), with square cells of `side` quanta,
    /// 1..=65535; at least two largest radii is best.
    ///
    /// # Errors
    /// [`GrainStacksError::AreaTooLarge`].
    pub fn new(plan: PlanRectangle, side: u16) -> Result<Self, GrainStacksError> {
        let mut stacks = Self::without_cells(plan.min, side, false);
        stacks.cover(plan)?;
        Ok(stacks)
    }

    /// An empty store over a plan of `counts` cells of `side` quanta from `corner`, that repeats
    /// for ever along x and z.
    ///
    /// # Errors
    /// [`GrainStacksError::AreaTooLarge`].
    pub fn periodic(
        corner: [i32; 2],
        counts: [u16; 2],
        side: u16,
    ) -> Result<Self, GrainStacksError> {
        let mut stacks = Self::without_cells(corner, side, true);
        stacks.counts = counts.map(|count| i32::from(count.max(1)));
        let cells = i64::from(stacks.counts[0]) * i64::from(stacks.counts[1]);
        if cells > MOST_CELLS {
            return Err(GrainStacksError::AreaTooLarge { cells });
        }
        stacks.cells = vec![EMPTY_CELL; cells as usize];
        Ok(stacks)
    }

    fn without_cells(anchor: [i32; 2], side: u16, periodic: bool) -> Self {
        Self {
            side: i32::from(side.max(1)),
            cells_per_quantum: 1.0 / f64::from(side.max(1)),
            first: [0, 0],
            counts: [0, 0],
            anchor,
            periodic,
            cells: Vec::new(),
            chunks: Vec::new(),
            blocks: 0,
            grains: 0,
            largest_radius: 0,
            level: Level::new(),
        }
    }

    /// Uses this SIMD level instead of the best one; answers do not change.
    ///
    /// # Panics
    /// If the machine does not have it.
    pub fn set_level(&mut self, level: SimdLevel) {
        self.level = level.token().expect("the SIMD level was checked when it was chosen");
    }

    /// Number of grains.
    #[must_use]
    pub fn len(&self) -> u64 {
        self.grains
    }

    /// Whether there is no grain.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.grains == 0
    }

    /// Memory held, bytes.
    #[must_use]
    pub fn bytes(&self) -> usize {
        self.cells.capacity() * size_of::<Cell>()
            + self.chunks.len() * BLOCKS_PER_CHUNK * size_of::<Block>()
            + self.chunks.capacity() * size_of::<Vec<Block>>()
    }

    /// Radius of the largest grain stored, quanta.
    #[must_use]
    pub fn largest_radius(&self) -> u16 {
        self.largest_radius
    }

    /// Edges of the period along x and z, quanta; `None` where the plan does not repeat.
    #[must_use]
    pub fn period(&self) -> Option<[i32; 2]> {
        self.periodic.then(|| self.counts.map(|count| count * self.side))
    }

    /// Enlarges the plan so that it covers `plan` too. Grains stay where they are: only the table
    /// of cells is copied. A periodic plan covers everything already.
    ///
    /// # Errors
    /// [`GrainStacksError::AreaTooLarge`]; the store is unchanged.
    pub fn cover(&mut self, plan: PlanRectangle) -> Result<(), GrainStacksError> {
        if self.periodic {
            return Ok(());
        }
        let (mut first, mut counts) = ([0i32; 2], [0i32; 2]);
        for axis in 0..2 {
            let mut low = self.cell_coordinate(plan.min[axis], axis);
            let mut high = self.cell_coordinate(plan.max[axis], axis) + 1;
            if self.counts[axis] > 0 {
                low = low.min(self.first[axis].into());
                high = high.max(i64::from(self.first[axis]) + i64::from(self.counts[axis]));
            }
            first[axis] = low as i32;
            counts[axis] = (high - low).max(1) as i32;
        }
        let cells = i64::from(counts[0]) * i64::from(counts[1]);
        if cells > MOST_CELLS {
            return Err(GrainStacksError::AreaTooLarge { cells });
        }
        if (first, counts) != (self.first, self.counts) {
            self.replace_cells(first, counts);
        }
        Ok(())
    }

    fn replace_cells(&mut self, first: [i32; 2], counts: [i32; 2]) {
        let mut cells = vec![EMPTY_CELL; counts[0] as usize * counts[1] as usize];
        for row in 0..self.counts[1] {
            let from = (row * self.counts[0]) as usize;
            let to = (row + self.first[1] - first[1]) as usize * counts[0] as usize
                + (self.first[0] - first[0]) as usize;
            let width = self.counts[0] as usize;
            cells[to..to + width].copy_from_slice(&self.cells[from..from + width]);
        }
        (self.cells, self.first, self.counts) = (cells, first, counts);
    }

    /// Stores a grain; on a periodic plan its centre is first brought into the first period.
    ///
    /// # Errors
    /// [`GrainStacksError::OutsideArea`], [`GrainStacksError::TooManyGrains`].
    pub fn push(&mut self, grain: QuantisedGrain) -> Result<GrainSlot, GrainStacksError> {
        let [x, y, z] = grain.center;
        let column = self.cell_coordinate(x, 0);
        let row = self.cell_coordinate(z, 1);
        let index = self.cell_index(column, row).ok_or(GrainStacksError::OutsideArea)?;
        let corner = self.corner(column, row);
        let cell = self.cells[index];
        let mut head = cell.newest;
        if head == NO_BLOCK || self.block(head).count() == GRAINS_PER_BLOCK {
            head = self.append(Block::new(cell.newest, cell.top))?;
        }
        let local = [(i64::from(x) - corner[0]) as u16, (i64::from(z) - corner[1]) as u16];
        let lane = self.block_mut(head).push(local, y, grain.radius);
        let top = cell.top.max(y + i32::from(grain.radius));
        self.cells[index] = Cell { newest: head, top };
        self.grains += 1;
        self.largest_radius = self.largest_radius.max(grain.radius);
        Ok(GrainSlot::new(head, lane))
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

    /// All grains, cell by cell (columns along x, rows along z), newest block first within a cell:
    /// an order that depends on what was pushed only.
    pub fn iter(&self) -> impl Iterator<Item = QuantisedGrain> + '_ {
        let columns = self.counts[0].max(1);
        (0i32..).zip(&self.cells).flat_map(move |(index, cell)| {
            let corner = self.corner(
                i64::from(self.first[0] + index % columns),
                i64::from(self.first[1] + index / columns),
            );
            self.blocks_from(cell.newest).flat_map(move |(_, block)| {
                (0..block.count()).map(move |lane| block.grain(lane, corner))
            })
        })
    }

    fn blocks_from(&self, newest: u32) -> impl Iterator<Item = (u32, &Block)> {
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

    #[inline(always)]
    fn block(&self, index: u32) -> &Block {
        &self.chunks[index as usize / BLOCKS_PER_CHUNK][index as usize % BLOCKS_PER_CHUNK]
    }

    fn block_mut(&mut self, index: u32) -> &mut Block {
        &mut self.chunks[index as usize / BLOCKS_PER_CHUNK][index as usize % BLOCKS_PER_CHUNK]
    }

    /// Column (axis 0) or row (axis 1) of a whole coordinate, before wrapping.
    fn cell_coordinate(&self, coordinate: i32, axis: usize) -> i64 {
        (i64::from(coordinate) - i64::from(self.anchor[axis])).div_euclid(self.side.into())
    }

    /// Column or row of a coordinate, but for rounding: within much less than a quantum of the
    /// border between two, either of them.
    #[inline(always)]
    fn nearest_cell_coordinate(&self, coordinate: f64, axis: usize) -> i64 {
        let cells = (coordinate - f64::from(self.anchor[axis])) * self.cells_per_quantum;
        let towards_zero = cells as i64;
        towards_zero - i64::from(towards_zero as f64 > cells)
    }

    /// Columns or rows of all grains whose centres lie within `reach` quanta of a coordinate.
    #[inline(always)]
    fn cell_range(&self, coordinate: f64, reach: f64, axis: usize) -> RangeInclusive<i64> {
        self.nearest_cell_coordinate(coordinate - reach - 1.0, axis)
            ..=self.nearest_cell_coordinate(coordinate + reach + 1.0, axis)
    }

    /// Least corner of the cell in an unwrapped column and row.
    #[inline(always)]
    fn corner(&self, column: i64, row: i64) -> [i64; 2] {
        [
            i64::from(self.anchor[0]) + column * i64::from(self.side),
            i64::from(self.anchor[1]) + row * i64::from(self.side),
        ]
    }

    #[inline(always)]
    fn cell_index(&self, column: i64, row: i64) -> Option<usize> {
        let mut column = column - i64::from(self.first[0]);
        let mut row = row - i64::from(self.first[1]);
        let (columns, rows) = (i64::from(self.counts[0]), i64::from(self.counts[1]));
        if !(0..columns).contains(&column) || !(0..rows).contains(&row) {
            if !self.periodic {
                return None;
            }
            column = column.rem_euclid(columns);
            row = row.rem_euclid(rows);
        }
        Some((row * columns + column) as usize)
    }

    /// The cell in an unwrapped column and row, `None` where it is off the plan or empty.
    #[inline(always)]
    fn seen_cell(&self, column: i64, row: i64) -> Option<SeenCell> {
        let cell = self.cells[self.cell_index(column, row)?];
        (cell.newest != NO_BLOCK).then(|| SeenCell {
            newest: cell.newest,
            top: cell.top,
            corner: self.corner(column, row),
        })
    }
}
