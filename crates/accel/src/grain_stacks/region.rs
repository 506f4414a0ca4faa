//! Parts of a store that threads own while grains fall.
//!
//! A [`RegionLayout`] divides the plan into squares. A fall whose cells all lie in one square can be
//! followed by the thread that owns it; others wait. What waits must not be overtaken: it *claims*
//! its cells in every square that it touches, and whatever comes later and needs one of them waits
//! too ([`StackRegion::claim`]). So two falls that share a cell keep their order.

use super::fall::{Fall, FallHit};
use super::plan::{Plan, TILE_BITS, TILE_EDGE};
use super::tile::Tile;
use super::window::{Frame, Quad, Window};
use super::{GrainSlot, GrainStacks, GrainStacksError};
use snowgrain_geometry::QuantisedGrain;
use snowgrain_math::DVec3;

/// How large regions are: short edges give more threads work on a small plan, long ones leave fewer
/// falls between regions.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum RegionEdge {
    /// 32 cells.
    Short,
    /// 64 cells (a row of them is a word of claims).
    Long,
}

/// A division of a plan into square regions.
#[derive(Clone, Copy, Debug)]
pub struct RegionLayout {
    plan: Plan,
    /// Logarithm of the cells along the edge of a region.
    edge_bits: u32,
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
        let [column, row] = place.map(|at| (at + self.shift) >> self.edge_bits);
        (row * self.counts[0] + column) as usize
    }

    /// The region of the cell where a line of fall crosses y = 0; `None` off the plan.
    #[must_use]
    pub fn home(&self, x: f64, z: f64) -> Option<usize> {
        let column = self.plan.nearest_cell_coordinate(x, 0);
        let row = self.plan.nearest_cell_coordinate(z, 1);
        Some(self.region_at(self.plan.place(column, row)?))
    }

    /// Calls `touched` with each region that owns cells whose grains a sphere may meet, or where it
    /// may come to rest; `reach` is its radius and the largest stored, `buffer` is overwritten.
    #[inline]
    pub fn each_touched(
        &self,
        [x, z, reach]: [f64; 3],
        buffer: &mut Vec<u32>,
        mut touched: impl FnMut(u32),
    ) {
        let spans = [self.plan.span(x, reach, 0), self.plan.span(z, reach, 1)];
        let inside = [0, 1].map(|axis| {
            let low = spans[axis].low - self.plan.first[axis];
            let high = spans[axis].high - self.plan.first[axis];
            let region = (low + self.shift) >> self.edge_bits;
            let alone = low >= 0
                && high < self.plan.counts[axis]
                && region == (high + self.shift) >> self.edge_bits;
            (alone, region)
        });
        let [(one_column, column), (one_row, row)] = inside;
        if one_column && one_row {
            touched((row * self.counts[0] + column) as u32);
            return;
        }
        buffer.clear();
        let [columns, rows] = spans;
        for row in rows.low..=rows.high {
            for column in columns.low..=columns.high {
                let Some(place) = self.plan.place(column, row) else { continue };
                let region = self.region_at(place) as u32;
                if !buffer.contains(&region) {
                    buffer.push(region);
                    touched(region);
                }
            }
        }
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
    /// Divides the plan into regions, from the first cell or `shifted` by half an edge.
    #[must_use]
    pub fn layout(&self, edge: RegionEdge, shifted: bool) -> RegionLayout {
        let edge_bits = match edge {
            RegionEdge::Short => TILE_BITS + 1,
            RegionEdge::Long => TILE_BITS + 2,
        };
        let edge = 1 << edge_bits;
        let shift = if shifted { edge / 2 } else { 0 };
        let counts = self.plan.counts.map(|count| (count + shift + edge - 1) / edge);
        RegionLayout { plan: self.plan, edge_bits, shift, counts }
    }

    /// The regions of a layout of this plan, in its order.
    pub fn regions(&mut self, layout: &RegionLayout) -> Vec<StackRegion<'_>> {
        let tile_columns = self.plan.tiles()[0];
        let mut regions: Vec<StackRegion<'_>> = (0..layout.counts[0] * layout.counts[1])
            .map(|index| {
                let at = [index % layout.counts[0], index / layout.counts[0]];
                let first = at.map(|at| ((at << layout.edge_bits) - layout.shift).max(0));
                let counts = [0, 1].map(|axis| {
                    let end = ((at[axis] + 1) << layout.edge_bits) - layout.shift;
                    end.min(self.plan.counts[axis]) - first[axis]
                });
                let tile_columns = (counts[0] + TILE_EDGE - 1) / TILE_EDGE;
                StackRegion {
                    plan: self.plan,
                    frame: Frame { first, counts, tile_columns },
                    tiles: Vec::with_capacity(1 << (2 * (layout.edge_bits - TILE_BITS))),
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

    /// Whether the fall that `quad` was looked up for may be followed now: all its cells belong to
    /// this region, and none is claimed. Otherwise it claims them.
    #[inline]
    pub fn claim(&mut self, quad: &Quad) -> bool {
        let [columns, rows] = quad.spans;
        let from = [0, 1].map(|axis| self.plan.first[axis] + self.frame.first[axis]);
        let (left, right) = (columns.low - from[0], columns.high - from[0]);
        let (low, high) = (rows.low - from[1], rows.high - from[1]);
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
        for row in rows.low..=rows.high {
            for column in columns.low..=columns.high {
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

    /// Looks up the cells that a fall on this line, with a reach of its radius and the largest
    /// stored, will ask first.
    #[must_use]
    #[inline]
    pub fn quad(&self, x: f64, z: f64, reach: f64) -> Quad {
        self.window().quad(x, z, reach)
    }

    /// As [`Self::first_contact`], with the cells of its line looked up.
    #[must_use]
    #[inline]
    pub fn first_contact_at(&self, quad: &Quad, fall: &Fall<'_>) -> Option<FallHit> {
        self.window().first_contact_at(quad, fall)
    }

    /// Asks for the newest blocks of a quad, ahead of their use.
    #[inline]
    pub fn prefetch(&self, quad: &Quad) {
        self.window().prefetch(quad);
    }
}
