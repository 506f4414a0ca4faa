//! Parts of a store that threads own while grains fall.
//!
//! A [`RegionLayout`] divides the plan into squares. A fall whose cells all lie in one square can be
//! followed by the thread that owns it; others wait. What waits must not be overtaken: it *claims*
//! its cells in every square that it touches, and whatever comes later and needs one of them waits
//! too ([`StackRegion::claim`]). So two falls that share a cell keep their order.

use super::block::NO_BLOCK;
use super::fall::{Fall, FallHit};
use super::plan::{Plan, TILE_EDGE};
use super::tile::Tile;
use super::window::{Frame, Window};
use super::{GrainSlot, GrainStacks, GrainStacksError};
use crate::prefetch::prefetch;
use snowgrain_geometry::QuantisedGrain;
use snowgrain_math::DVec3;
use std::ops::RangeInclusive;

/// Most tiles along an edge of a region: its rows of cells are the bits of a word.
const MOST_TILES: i32 = 64 / TILE_EDGE;
/// Quanta by which a grain may come to rest beside the exact place.
const ROUNDING: f64 = 3.0;

/// A division of a plan into square regions.
#[derive(Clone, Copy, Debug)]
pub struct RegionLayout {
    plan: Plan,
    /// Cells along the edge of a region.
    edge: i32,
    /// Cells by which the regions are shifted to lower columns and rows.
    shift: i32,
    /// Regions along x and z.
    counts: [i32; 2],
}

impl RegionLayout {
    /// Number of regions.
    #[must_use]
    pub fn len(&self) -> usize {
        self.counts[0] as usize * self.counts[1] as usize
    }

    /// Whether there is no region.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    fn region_at(&self, place: [i32; 2]) -> usize {
        let [column, row] = place.map(|at| (at + self.shift) / self.edge);
        (row * self.counts[0] + column) as usize
    }

    /// The region of the cell where a line of fall crosses y = 0; `None` off the plan.
    #[must_use]
    pub fn home(&self, x: f64, z: f64) -> Option<usize> {
        let column = self.plan.nearest_cell_coordinate(x, 0);
        let row = self.plan.nearest_cell_coordinate(z, 1);
        Some(self.region_at(self.plan.place(column, row)?))
    }

    /// The regions that own cells whose grains a sphere of radius `reach` less the largest stored
    /// may meet, or where it may come to rest; to `touched`, each once.
    #[inline]
    pub fn touched(&self, x: f64, z: f64, reach: f64, touched: &mut Vec<u32>) {
        touched.clear();
        let Footprint { columns, rows } = Footprint::new(&self.plan, x, z, reach);
        let low = self.plan.place(*columns.start(), *rows.start());
        let high = self.plan.place(*columns.end(), *rows.end());
        if let (Some(low), Some(high)) = (low, high)
            && low[0] <= high[0]
            && low[1] <= high[1]
            && self.region_at(low) == self.region_at(high)
        {
            touched.push(self.region_at(low) as u32);
            return;
        }
        for row in rows {
            for column in columns.clone() {
                let Some(place) = self.plan.place(column, row) else { continue };
                let region = self.region_at(place) as u32;
                if !touched.contains(&region) {
                    touched.push(region);
                }
            }
        }
    }
}

/// The cells that a fall may read or write.
struct Footprint {
    columns: RangeInclusive<i32>,
    rows: RangeInclusive<i32>,
}

impl Footprint {
    #[inline(always)]
    fn new(plan: &Plan, x: f64, z: f64, reach: f64) -> Self {
        let reach = reach + ROUNDING;
        Self { columns: plan.cell_range(x, reach, 0), rows: plan.cell_range(z, reach, 1) }
    }
}

/// A part of a store, or all of it, to fall on.
#[derive(Debug)]
pub struct StackRegion<'a> {
    plan: Plan,
    frame: Frame,
    tiles: Vec<&'a mut Tile>,
    /// Claimed cells: a word a row, a bit a column.
    claimed: [u64; 64],
}

impl GrainStacks {
    /// Divides the plan into regions of about `tiles` tiles of 16 cells along an edge (1..=4), from
    /// the first cell or `shifted` by half an edge.
    #[must_use]
    pub fn layout(&self, tiles: u8, shifted: bool) -> RegionLayout {
        let edge = i32::from(tiles).clamp(1, MOST_TILES) * TILE_EDGE;
        let shift = if shifted { (edge / 2 / TILE_EDGE).max(1) * TILE_EDGE } else { 0 };
        let counts = self.plan.counts.map(|count| (count + shift + edge - 1) / edge);
        RegionLayout { plan: self.plan, edge, shift, counts }
    }

    /// The regions of a layout of this plan, in its order.
    pub fn regions(&mut self, layout: &RegionLayout) -> Vec<StackRegion<'_>> {
        let tile_columns = self.plan.tiles()[0];
        let mut regions: Vec<StackRegion<'_>> = (0..layout.len() as i32)
            .map(|index| {
                let at = [index % layout.counts[0], index / layout.counts[0]];
                let first = at.map(|at| (at * layout.edge - layout.shift).max(0));
                let counts = [0, 1].map(|axis| {
                    let end = (at[axis] + 1) * layout.edge - layout.shift;
                    end.min(self.plan.counts[axis]) - first[axis]
                });
                let tile_columns = (counts[0] + TILE_EDGE - 1) / TILE_EDGE;
                StackRegion {
                    plan: self.plan,
                    frame: Frame { first, counts, tile_columns },
                    tiles: Vec::with_capacity((layout.edge / TILE_EDGE).pow(2) as usize),
                    claimed: [0; 64],
                }
            })
            .collect();
        for (index, tile) in (0i32..).zip(&mut self.tiles) {
            let place = [index % tile_columns * TILE_EDGE, index / tile_columns * TILE_EDGE];
            regions[layout.region_at(place)].tiles.push(tile);
        }
        regions
    }

    /// All of the store as one region.
    pub fn whole(&mut self) -> StackRegion<'_> {
        StackRegion {
            plan: self.plan,
            frame: Frame::whole(&self.plan),
            tiles: self.tiles.iter_mut().collect(),
            claimed: [0; 64],
        }
    }
}

impl<'a> StackRegion<'a> {
    fn window(&self) -> Window<'_, &'a mut Tile> {
        Window { plan: &self.plan, frame: self.frame, tiles: &self.tiles }
    }

    /// Whether a fall with this line and reach (as in [`RegionLayout::touched`]) may be followed
    /// now: all its cells belong to this region, and none is claimed. Otherwise it claims them.
    #[inline]
    pub fn claim(&mut self, x: f64, z: f64, reach: f64) -> bool {
        let Footprint { columns, rows } = Footprint::new(&self.plan, x, z, reach);
        let from = [0, 1].map(|axis| self.plan.first[axis] + self.frame.first[axis]);
        let (left, right) = (columns.start() - from[0], columns.end() - from[0]);
        let (low, high) = (rows.start() - from[1], rows.end() - from[1]);
        let inside =
            left >= 0 && low >= 0 && right < self.frame.counts[0] && high < self.frame.counts[1];
        if inside {
            let mask = (u64::MAX >> (63 - (right - left))) << left;
            let words = &mut self.claimed[low as usize..=high as usize];
            if words.iter().all(|word| word & mask == 0) {
                return true;
            }
            words.iter_mut().for_each(|word| *word |= mask);
            return false;
        }
        for row in rows {
            for column in columns.clone() {
                let Some(place) = self.plan.place(column, row) else { continue };
                if self.frame.tile_index(place).is_some() {
                    let row = (place[1] - self.frame.first[1]) as usize;
                    self.claimed[row] |= 1 << (place[0] - self.frame.first[0]);
                }
            }
        }
        false
    }

    /// As [`GrainStacks::first_contact`], among the grains of this region.
    #[must_use]
    #[inline]
    pub fn first_contact(&self, fall: &Fall<'_>) -> Option<FallHit> {
        self.window().first_contact(fall)
    }

    /// As [`GrainStacks::near`], among the grains of this region.
    pub fn near(&self, center: DVec3, reach: f64, out: &mut Vec<(GrainSlot, QuantisedGrain)>) {
        self.window().near(center, reach, out);
    }

    /// The point at height `y` of the line of fall that crosses y = 0 at `x, z`; quanta.
    #[must_use]
    #[inline]
    pub fn point(&self, x: f64, z: f64, y: f64) -> DVec3 {
        self.plan.point(x, z, y)
    }

    /// As [`GrainStacks::push`].
    ///
    /// # Errors
    /// [`GrainStacksError::OutsideArea`] outside this region; [`GrainStacksError::TooManyGrains`].
    #[inline]
    pub fn push(&mut self, grain: QuantisedGrain) -> Result<GrainSlot, GrainStacksError> {
        let (cell, local) = self.plan.locate(grain);
        let place = self.plan.place(cell[0], cell[1]).ok_or(GrainStacksError::OutsideArea)?;
        let index = self.frame.tile_index(place).ok_or(GrainStacksError::OutsideArea)?;
        let [_, y, _] = grain.center;
        self.tiles[index].push(Tile::cell_index(place), local, y, grain.radius)
    }

    /// Asks for the head of the stack where a line of fall crosses y = 0, ahead of its use.
    #[inline]
    pub fn prefetch_cell(&self, x: f64, z: f64) {
        if let Some((tile, cell)) = self.tile_and_cell(x, z) {
            prefetch(&tile.cells[cell]);
        }
    }

    /// Asks for the newest block there, ahead of its use.
    #[inline]
    pub fn prefetch_block(&self, x: f64, z: f64) {
        if let Some((tile, cell)) = self.tile_and_cell(x, z) {
            let newest = tile.cells[cell].newest;
            if newest != NO_BLOCK {
                tile.block(newest).prefetch();
            }
        }
    }

    #[inline(always)]
    fn tile_and_cell(&self, x: f64, z: f64) -> Option<(&Tile, usize)> {
        let column = self.plan.nearest_cell_coordinate(x, 0);
        let row = self.plan.nearest_cell_coordinate(z, 1);
        let place = self.plan.place(column, row)?;
        Some((&*self.tiles[self.frame.tile_index(place)?], Tile::cell_index(place)))
    }
}
