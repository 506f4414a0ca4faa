//! Cells that a query may look at: all of a store, or the part that one thread owns.

use super::block::Block;
use super::plan::{Plan, Span, TILE_BITS, TILE_EDGE};
use super::tile::Tile;
use std::borrow::Borrow;

/// A rectangle of tiles of a plan.
#[derive(Clone, Copy, Debug)]
pub(super) struct Frame {
    /// First column and row of the plan that it shows; multiples of a tile's edge.
    pub(super) first: [i32; 2],
    /// Columns and rows.
    pub(super) counts: [i32; 2],
    /// Tiles in a row of tiles.
    pub(super) tile_columns: i32,
}

impl Frame {
    pub(super) fn whole(plan: &Plan) -> Self {
        Self { first: [0, 0], counts: plan.counts, tile_columns: plan.tiles()[0] }
    }

    /// Index of the tile at a column and row of the plan; `None` outside.
    #[inline(always)]
    pub(super) fn tile_index(&self, place: [i32; 2]) -> Option<usize> {
        let (column, row) = (place[0] - self.first[0], place[1] - self.first[1]);
        let inside =
            (column as u32) < self.counts[0] as u32 && (row as u32) < self.counts[1] as u32;
        inside.then(|| ((row >> TILE_BITS) * self.tile_columns + (column >> TILE_BITS)) as usize)
    }
}

impl SeenCell<'_> {
    /// Highest top of the grains.
    #[inline(always)]
    pub(super) fn top(&self) -> i32 {
        self.tile.tops[self.index]
    }
}

/// Tiles that can be read.
pub(super) struct Window<'a, T> {
    pub(super) plan: &'a Plan,
    pub(super) frame: Frame,
    pub(super) tiles: &'a [T],
}

/// A cell, as a query sees it: where it lies after periodic wrapping.
#[derive(Clone, Copy)]
pub(super) struct SeenCell<'a> {
    pub(super) tile: &'a Tile,
    /// Index in the tile.
    pub(super) index: usize,
    /// Newest block; it may be empty.
    pub(super) newest: &'a Block,
    /// Least corner of the image of the cell that the query meets.
    pub(super) corner: [i64; 2],
}

/// The four cells nearest to a place of the plan, looked up: all within half a cell's side of it.
#[derive(Clone, Copy, Debug)]
pub struct Quad {
    /// Unwrapped columns and rows around.
    pub(super) spans: [Span; 2],
    /// Tile and cell of each, along x first; the tile is `NOWHERE` off the window.
    cells: [(u32, u32); 4],
}

const NOWHERE: u32 = u32::MAX;
/// Columns and rows of the four from the first.
const ASIDE: [[i32; 2]; 4] = [[0, 0], [1, 0], [0, 1], [1, 1]];

impl Quad {
    /// Whether these cells are all that a fall may touch.
    #[inline(always)]
    pub(super) fn is_all(&self) -> bool {
        let outside =
            self.spans.map(|s| i32::from(s.low < s.nearest) | i32::from(s.high > s.nearest + 1));
        outside[0] | outside[1] == 0
    }

    #[inline(always)]
    pub(super) fn holds(&self, column: i32, row: i32) -> bool {
        let [first_column, first_row] = self.spans.map(|span| span.nearest);
        (column == first_column || column == first_column + 1)
            && (row == first_row || row == first_row + 1)
    }
}

impl<'a, T: Borrow<Tile>> Window<'a, T> {
    /// The four cells nearest to a place of the plan, for a fall with this reach.
    #[inline(always)]
    pub(super) fn quad(&self, x: f64, z: f64, reach: f64) -> Quad {
        let spans = [self.plan.span(x, reach, 0), self.plan.span(z, reach, 1)];
        let [column, row] = spans.map(|span| span.nearest);
        let [c, r] =
            [0, 1].map(|axis| spans[axis].nearest - self.plan.first[axis] - self.frame.first[axis]);
        let [columns, rows] = self.frame.counts.map(|count| count - 1);
        if (c as u32) < columns as u32 && (r as u32) < rows as u32 {
            // All four lie in the window as they are.
            let last = TILE_EDGE - 1;
            let along_x = [c, c + 1].map(|c| (c >> TILE_BITS, c & last));
            let along_z = [r, r + 1]
                .map(|r| ((r >> TILE_BITS) * self.frame.tile_columns, (r & last) << TILE_BITS));
            let cells = std::array::from_fn(|which| {
                let (x, z) = (along_x[which & 1], along_z[which >> 1]);
                ((x.0 + z.0) as u32, (x.1 | z.1) as u32)
            });
            return Quad { spans, cells };
        }
        let cells = std::array::from_fn(|which| {
            let place = self.plan.place(column + ASIDE[which][0], row + ASIDE[which][1]);
            let tile = place.and_then(|place| self.frame.tile_index(place));
            let cell = place.map_or(0, Tile::cell_index);
            (tile.map_or(NOWHERE, |tile| tile as u32), cell as u32)
        });
        Quad { spans, cells }
    }

    /// One of the cells of a quad, where it is not off the window or in a tile without grains.
    #[inline(always)]
    pub(super) fn quad_cell(&self, quad: &Quad, which: usize) -> Option<SeenCell<'a>> {
        let (tile, cell) = quad.cells[which];
        let tile: &Tile = self.tiles.get(tile as usize)?.borrow();
        let index = cell as usize;
        let newest = tile.newest(index)?;
        let [column, row] = quad.spans.map(|span| span.nearest);
        let corner = self.plan.corner(column + ASIDE[which][0], row + ASIDE[which][1]);
        Some(SeenCell { tile, index, newest, corner })
    }

    /// All four cells, where each is on the window, in a tile with grains.
    #[inline(always)]
    pub(super) fn full_cells(&self, quad: &Quad) -> Option<[SeenCell<'a>; 4]> {
        let [a, b, c, d] = [0, 1, 2, 3].map(|which| self.quad_cell(quad, which));
        Some([a?, b?, c?, d?])
    }

    /// Asks for the newest blocks of a quad, ahead of their use.
    #[inline(always)]
    pub(super) fn prefetch(&self, quad: &Quad) {
        for (tile, cell) in quad.cells {
            if let Some(tile) = self.tiles.get(tile as usize)
                && let Some(block) = tile.borrow().newest(cell as usize)
            {
                block.prefetch();
            }
        }
    }

    /// The cell in an unwrapped column and row, `None` where it is off the window or in a tile
    /// without grains.
    #[inline(always)]
    pub(super) fn cell(&self, column: i32, row: i32) -> Option<SeenCell<'a>> {
        let place = self.plan.place(column, row)?;
        let tile: &Tile = self.tiles[self.frame.tile_index(place)?].borrow();
        let index = Tile::cell_index(place);
        let newest = tile.newest(index)?;
        Some(SeenCell { tile, index, newest, corner: self.plan.corner(column, row) })
    }
}
