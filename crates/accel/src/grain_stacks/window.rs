//! Cells that a query may look at: all of a store, or the part that one thread owns.

use super::block::NO_BLOCK;
use super::plan::{Plan, TILE_EDGE};
use super::tile::Tile;
use std::borrow::Borrow;

/// A rectangle of tiles of a plan.
#[derive(Clone, Copy, Debug)]
pub(super) struct Frame {
    /// First column and row of the plan that it shows; multiples of [`TILE_EDGE`].
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
        let inside = (column as u32) < self.counts[0] as u32 && (row as u32) < self.counts[1] as u32;
        inside.then(|| (row / TILE_EDGE * self.tile_columns + column / TILE_EDGE) as usize)
    }
}

/// Tiles that can be read.
pub(super) struct Window<'a, T> {
    pub(super) plan: &'a Plan,
    pub(super) frame: Frame,
    pub(super) tiles: &'a [T],
}

/// A cell that holds grains, as a query sees it: where it lies after periodic wrapping.
#[derive(Clone, Copy)]
pub(super) struct SeenCell<'a> {
    pub(super) tile: &'a Tile,
    pub(super) newest: u32,
    pub(super) top: i32,
    /// Least corner of the image of the cell that the query meets.
    pub(super) corner: [i64; 2],
}

impl<'a, T: Borrow<Tile>> Window<'a, T> {
    /// The cell in an unwrapped column and row, `None` where it is off the plan or empty.
    #[inline(always)]
    pub(super) fn cell(&self, column: i32, row: i32) -> Option<SeenCell<'a>> {
        let place = self.plan.place(column, row)?;
        let tile: &Tile = self.tiles[self.frame.tile_index(place)?].borrow();
        let cell = tile.cells[Tile::cell_index(place)];
        (cell.newest != NO_BLOCK).then(|| SeenCell {
            tile,
            newest: cell.newest,
            top: cell.top,
            corner: self.plan.corner(column, row),
        })
    }
}
