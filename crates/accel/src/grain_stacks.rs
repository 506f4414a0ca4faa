//! The store of fallen grains, which is also what a falling grain asks.
//!
//! The plan (x, z) is divided into square cells. Each cell owns a stack of blocks of 15 grains; a
//! block links to the next older one and knows the highest top of everything older, so a search
//! from above stops as soon as nothing older can reach what it has found. The newest block of a cell
//! lies where the cell says; full ones are laid down once and never move again: nothing is rebuilt,
//! no list overflows, and a fall costs the same at any depth.
//!
//! All lengths are in quanta of the scene's [`Quantisation`](snowgrain_geometry::Quantisation).
//! Candidates are found in single precision with a margin that covers its rounding; whether and
//! where they are met is then decided in double precision on the stored integers, so every answer
//! is the same at every SIMD level and equal to that of a search of all grains.

mod block;
mod fall;
mod near;
mod plan;
mod region;
#[cfg(test)]
mod tests;
mod tile;
mod window;

use crate::SimdLevel;
use plan::Plan;
use snowgrain_geometry::QuantisedGrain;
use thiserror::Error;
use tile::Tile;
use window::{Frame, Window};

pub use fall::{Fall, FallHit};
pub use plan::PlanRectangle;
pub use region::{RegionEdge, RegionLayout, StackRegion};
pub use window::Quad;

/// Most cells a plan may have: one gibibyte of them.
const MOST_CELLS: i64 = 1 << 27;
/// Cells of a part of the store, about.
const CELLS_PER_PART: i32 = 256;

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
    #[error("more than 4 000 000 000 grains lie over one square of 16 cells; use larger grains")]
    TooManyGrains,
}

/// Names a stored grain of a [`GrainStacks`] until another grain is stored or taken away.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct GrainSlot(u64);

/// Stacks of grains over a plan; see the [module](self).
#[derive(Clone, Debug)]
pub struct GrainStacks {
    plan: Plan,
    /// Along x, then along z.
    tiles: Vec<Tile>,
    /// Tiles ever made.
    names: u32,
}

impl GrainStacks {
    /// An empty store over `plan` (it may be enlarged later), with square cells of `side` quanta,
    /// 1..=65535; at least two largest radii is best. What falls moves by `drift` quanta along x
    /// and z for each quantum of height: `[0, 0]` straight down.
    ///
    /// # Errors
    /// [`GrainStacksError::AreaTooLarge`].
    pub fn new(plan: PlanRectangle, side: u16, drift: [f64; 2]) -> Result<Self, GrainStacksError> {
        let mut stacks =
            Self { plan: Plan::new(plan.min, side, false, drift), tiles: Vec::new(), names: 0 };
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
        counts: [u32; 2],
        side: u16,
        drift: [f64; 2],
    ) -> Result<Self, GrainStacksError> {
        let mut plan = Plan::new(corner, side, true, drift);
        let cells = i64::from(counts[0].max(1)).saturating_mul(counts[1].max(1).into());
        if cells > MOST_CELLS {
            return Err(GrainStacksError::AreaTooLarge { cells });
        }
        plan.counts = counts.map(|count| count.max(1).cast_signed());
        let mut stacks = Self { plan, tiles: Vec::new(), names: 0 };
        let [columns, rows] = plan.tiles();
        stacks.tiles = (0..columns * rows).map(|_| stacks.new_tile()).collect();
        Ok(stacks)
    }

    /// The same store, whose grains get other names than those of stores with other numbers.
    #[must_use]
    pub fn numbered(mut self, number: u8) -> Self {
        let base = u32::from(number) << 24;
        self.names = base;
        for tile in &mut self.tiles {
            self.names += 1;
            tile.rename(self.names);
        }
        self
    }

    fn new_tile(&mut self) -> Tile {
        self.names += 1;
        Tile::new(self.names)
    }

    /// Uses this SIMD level instead of the best one; answers do not change.
    ///
    /// # Panics
    /// If the machine does not have it.
    pub fn set_level(&mut self, level: SimdLevel) {
        self.plan.level = level.token().expect("the SIMD level was checked when it was chosen");
    }

    /// Prepares for grains of up to `radius` quanta; pushing larger ones does so too, but not
    /// through a [`StackRegion`].
    pub fn expect_radius(&mut self, radius: u16) {
        self.plan.largest_radius = self.plan.largest_radius.max(radius);
    }

    /// Number of grains.
    #[must_use]
    pub fn len(&self) -> u64 {
        self.tiles.iter().map(|tile| u64::from(tile.grains)).sum()
    }

    /// Whether there is no grain.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Memory held, bytes.
    #[must_use]
    pub fn bytes(&self) -> usize {
        self.tiles.iter().map(Tile::bytes).sum()
    }

    /// Radius, quanta, that no stored grain exceeds.
    #[must_use]
    pub fn largest_radius(&self) -> u16 {
        self.plan.largest_radius
    }

    /// Side of the cells, quanta.
    #[must_use]
    pub fn side(&self) -> u16 {
        self.plan.side as u16
    }

    /// Columns and rows of cells.
    #[must_use]
    pub fn counts(&self) -> [u32; 2] {
        self.plan.counts.map(i32::cast_unsigned)
    }

    /// What falls moves by so much along x and z for each length of height.
    #[must_use]
    pub fn drift(&self) -> [f64; 2] {
        [self.plan.drift.x, self.plan.drift.z]
    }

    /// The point at height `y` of the line of fall that crosses y = 0 at `x, z`; quanta.
    #[must_use]
    pub fn point(&self, x: f64, z: f64, y: f64) -> snowgrain_math::DVec3 {
        self.plan.point(x, z, y)
    }

    /// Edges of the period along x and z, quanta; `None` where the plan does not repeat.
    #[must_use]
    pub fn period(&self) -> Option<[i32; 2]> {
        self.plan.periodic.then(|| self.plan.counts.map(|count| count * self.plan.side))
    }

    /// Enlarges the plan so that it covers `plan` (where lines of fall cross y = 0) too. Grains
    /// stay where they are: only the table of tiles is copied. A periodic plan covers everything
    /// already.
    ///
    /// # Errors
    /// [`GrainStacksError::AreaTooLarge`]; the store is unchanged.
    pub fn cover(&mut self, rectangle: PlanRectangle) -> Result<(), GrainStacksError> {
        if self.plan.periodic {
            return Ok(());
        }
        let (first, counts) = self.plan.covering(rectangle)?;
        if (first, counts) == (self.plan.first, self.plan.counts) {
            return Ok(());
        }
        let old = self.plan;
        let mut kept = std::mem::take(&mut self.tiles).into_iter();
        (self.plan.first, self.plan.counts) = (first, counts);
        let [columns, rows] = self.plan.tiles();
        let edge = plan::TILE_EDGE;
        let mut tiles = Vec::with_capacity(columns as usize * rows as usize);
        for row in 0..rows {
            for column in 0..columns {
                let place = [column * edge + first[0], row * edge + first[1]];
                let was_there = (0..2).all(|axis| {
                    (old.first[axis]..old.first[axis] + old.counts[axis]).contains(&place[axis])
                });
                let tile = if was_there { kept.next() } else { None };
                tiles.push(tile.unwrap_or_else(|| self.new_tile()));
            }
        }
        self.tiles = tiles;
        Ok(())
    }

    /// Enlarges the plan so that it covers the place of `grain` with `reach` quanta around it.
    ///
    /// # Errors
    /// [`GrainStacksError::AreaTooLarge`]; the store is unchanged.
    pub fn cover_grain(
        &mut self,
        grain: QuantisedGrain,
        reach: i32,
    ) -> Result<(), GrainStacksError> {
        let [x, z] = self.plan.on_plan(grain);
        let at = [x, z].map(|c| c.clamp(i32::MIN.into(), i32::MAX.into()) as i32);
        self.cover(PlanRectangle {
            min: at.map(|c| c.saturating_sub(reach)),
            max: at.map(|c| c.saturating_add(reach)),
        })
    }

    /// Stores a grain; on a periodic plan its centre is first brought into the first period.
    ///
    /// # Errors
    /// [`GrainStacksError::OutsideArea`], [`GrainStacksError::TooManyGrains`].
    pub fn push(&mut self, grain: QuantisedGrain) -> Result<GrainSlot, GrainStacksError> {
        let (tile, cell, local) = self.locate(grain).ok_or(GrainStacksError::OutsideArea)?;
        let [_, y, _] = grain.center;
        let slot = self.tiles[tile].push(cell, local, y, grain.radius)?;
        self.expect_radius(grain.radius);
        Ok(slot)
    }

    /// Takes away the grain that was stored last of all in the cell where `grain` lies.
    pub fn pop(&mut self, grain: QuantisedGrain) {
        if let Some((tile, cell, _)) = self.locate(grain) {
            self.tiles[tile].pop(cell);
        }
    }

    /// Tile, cell and place in it.
    fn locate(&self, grain: QuantisedGrain) -> Option<(usize, usize, [u16; 2])> {
        let (cell, local) = self.plan.locate(grain);
        let place = self.plan.place(cell[0], cell[1])?;
        let tile = Frame::whole(&self.plan).tile_index(place)?;
        Some((tile, Tile::cell_index(place), local))
    }

    fn window(&self) -> Window<'_, Tile> {
        Window { plan: &self.plan, frame: Frame::whole(&self.plan), tiles: &self.tiles }
    }

    /// All grains, cell by cell (columns along x, rows along z), newest block first within a cell:
    /// an order that depends on what was pushed only.
    pub fn iter(&self) -> impl Iterator<Item = QuantisedGrain> + '_ {
        (0..self.parts()).flat_map(|part| {
            let mut grains = Vec::new();
            self.part(part, &mut grains);
            grains
        })
    }

    /// Number of parts that the grains can be walked in, each a band of rows of cells.
    #[must_use]
    pub fn parts(&self) -> usize {
        let [_, rows] = self.plan.counts;
        (rows as usize).div_ceil(self.rows_per_part() as usize)
    }

    fn rows_per_part(&self) -> i32 {
        (CELLS_PER_PART / self.plan.counts[0].max(1)).max(1)
    }

    /// Appends the grains of a part to `out`; those of all parts, one after another, come as from
    /// [`Self::iter`].
    pub fn part(&self, part: usize, out: &mut Vec<QuantisedGrain>) {
        let step = self.rows_per_part();
        let from = i32::try_from(part).unwrap_or(i32::MAX).saturating_mul(step);
        let until = from.saturating_add(step).min(self.plan.counts[1]);
        let mut blocks = Vec::new();
        for row in from..until {
            for column in (0..self.plan.counts[0]).step_by(plan::TILE_EDGE as usize) {
                self.row_of_tile([column, row], &mut blocks, out);
            }
        }
    }

    /// The grains of the cells of one tile in one row, from `column` on. Links are followed in all of
    /// these cells at a time, so that their memory is waited for together; `blocks` is overwritten.
    fn row_of_tile<'a>(
        &'a self,
        [column, row]: [i32; 2],
        blocks: &mut Vec<(i32, &'a block::Block)>,
        out: &mut Vec<QuantisedGrain>,
    ) {
        let index = Frame::whole(&self.plan).tile_index([column, row]);
        let Some(tile) = index.and_then(|index| self.tiles.get(index)) else { return };
        let end = (column + plan::TILE_EDGE).min(self.plan.counts[0]);
        let newest = |column| tile.newest(Tile::cell_index([column, row]));
        blocks.clear();
        blocks.extend((column..end).filter_map(|column| Some((column, newest(column)?))));
        let mut seen = 0;
        while seen < blocks.len() {
            let level = seen..blocks.len();
            seen = level.end;
            for at in level {
                let (column, block) = blocks[at];
                if let Some(older) = tile.below(block) {
                    blocks.push((column, older));
                }
            }
        }
        blocks.sort_by_key(|&(column, _)| column);
        let [first_column, first_row] = self.plan.first;
        for &(column, block) in &*blocks {
            let corner = self.plan.corner(first_column + column, first_row + row);
            out.extend(
                (0..block.count())
                    .map(|lane| self.plan.in_first_period(self.plan.grain(block, lane, corner))),
            );
        }
    }
}
