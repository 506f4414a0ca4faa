//! The plan that stacks stand on: square cells, seen along the direction of fall.

use super::block::{Block, LANES};
use super::{GrainStacksError, MOST_CELLS};
use fearless_simd::Level;
use snowgrain_geometry::QuantisedGrain;
use snowgrain_math::DVec3;
use std::ops::RangeInclusive;

/// A plan rectangle `[x0, x1) x [z0, z1)`, quanta.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PlanRectangle {
    /// Least x and z.
    pub min: [i32; 2],
    /// Greatest x and z.
    pub max: [i32; 2],
}

/// The direction of fall, as what a falling point moves along x and z while it rises by one.
///
/// The plan place of a point is where its line of fall crosses y = 0. That of a grain is shifted by
/// whole quanta, `floor(y * drift)`, so that it gives the grain back exactly.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Drift {
    pub(super) x: f64,
    pub(super) z: f64,
    /// Height gained per length along the line.
    pub(super) rise: f64,
    /// Half-widths along x and z of the shadow on the plan of a unit ball.
    pub(super) shadow: [f64; 2],
}

impl Drift {
    pub(super) fn new([x, z]: [f64; 2]) -> Self {
        Self {
            x,
            z,
            rise: 1.0 / (1.0 + x * x + z * z).sqrt(),
            shadow: [(1.0 + x * x).sqrt(), (1.0 + z * z).sqrt()],
        }
    }

    pub(super) fn is_vertical(&self) -> bool {
        self.x == 0.0 && self.z == 0.0
    }

    /// How far along x and z a grain at height `y` stands from its plan place.
    #[inline(always)]
    fn offsets(&self, y: i32) -> [i64; 2] {
        if self.is_vertical() {
            return [0, 0];
        }
        [self.x, self.z].map(|drift| (f64::from(y) * drift).floor() as i64)
    }
}

/// Cells along each edge of a tile, and the logarithm of that.
pub(super) const TILE_EDGE: i32 = 1 << TILE_BITS;
pub(super) const TILE_BITS: u32 = 4;

/// Quanta by which a grain may come to rest beside the exact place on the plan, with room for the
/// rounding of cells.
const ROUNDING: f64 = 4.0;

/// Columns or rows around a place of the plan, unwrapped.
#[derive(Clone, Copy, Debug)]
pub(super) struct Span {
    /// First of the two that are nearest.
    pub(super) nearest: i32,
    /// First and last of those that a fall may touch.
    pub(super) low: i32,
    pub(super) high: i32,
}

/// Where the cells are and what every query needs to know.
#[derive(Clone, Copy, Debug)]
pub(super) struct Plan {
    pub(super) side: i32,
    cells_per_quantum: f64,
    pub(super) anchor: [i32; 2],
    /// Column and row of the first cell, counted from the anchor; multiples of [`TILE_EDGE`].
    pub(super) first: [i32; 2],
    /// Columns and rows.
    pub(super) counts: [i32; 2],
    pub(super) periodic: bool,
    pub(super) drift: Drift,
    pub(super) largest_radius: u16,
    pub(super) level: Level,
}

impl Plan {
    pub(super) fn new(anchor: [i32; 2], side: u16, periodic: bool, drift: [f64; 2]) -> Self {
        Self {
            side: i32::from(side.max(1)),
            cells_per_quantum: 1.0 / f64::from(side.max(1)),
            anchor,
            first: [0, 0],
            counts: [0, 0],
            periodic,
            drift: Drift::new(drift),
            largest_radius: 0,
            level: Level::new(),
        }
    }

    /// Tiles along x and z.
    pub(super) fn tiles(&self) -> [i32; 2] {
        self.counts.map(|count| (count + TILE_EDGE - 1) / TILE_EDGE)
    }

    /// First cell and counts that cover `plan` too, in whole tiles.
    pub(super) fn covering(
        &self,
        plan: PlanRectangle,
    ) -> Result<([i32; 2], [i32; 2]), GrainStacksError> {
        let (mut first, mut counts) = ([0i32; 2], [0i32; 2]);
        let edge = i64::from(TILE_EDGE);
        for axis in 0..2 {
            let mut low = self.cell_coordinate(plan.min[axis].into(), axis);
            let mut high = self.cell_coordinate(plan.max[axis].into(), axis) + 1;
            if self.counts[axis] > 0 {
                low = low.min(self.first[axis].into());
                high = high.max(i64::from(self.first[axis]) + i64::from(self.counts[axis]));
            }
            low = low.div_euclid(edge) * edge;
            high = -((-high).div_euclid(edge) * edge);
            first[axis] = low as i32;
            counts[axis] = (high - low).max(edge) as i32;
        }
        let cells = i64::from(counts[0]) * i64::from(counts[1]);
        if cells > MOST_CELLS {
            return Err(GrainStacksError::AreaTooLarge { cells });
        }
        Ok((first, counts))
    }

    /// Column (axis 0) or row (axis 1) of a whole coordinate on the plan, before wrapping.
    pub(super) fn cell_coordinate(&self, coordinate: i64, axis: usize) -> i64 {
        (coordinate - i64::from(self.anchor[axis])).div_euclid(self.side.into())
    }

    /// Column or row of a coordinate, but for rounding: within much less than a quantum of the
    /// border between two, either of them.
    #[inline(always)]
    pub(super) fn nearest_cell_coordinate(&self, coordinate: f64, axis: usize) -> i32 {
        let cells = (coordinate - f64::from(self.anchor[axis])) * self.cells_per_quantum;
        let towards_zero = cells as i32;
        towards_zero - i32::from(f64::from(towards_zero) > cells)
    }

    /// Columns or rows of all grains whose surface, grown by `reach` less their radius, may hold a
    /// point over this place of the plan.
    #[inline(always)]
    pub(super) fn cell_range(
        &self,
        coordinate: f64,
        reach: f64,
        axis: usize,
    ) -> RangeInclusive<i32> {
        let reach = reach * self.drift.shadow[axis] + 1.0;
        self.nearest_cell_coordinate(coordinate - reach, axis)
            ..=self.nearest_cell_coordinate(coordinate + reach, axis)
    }

    /// Columns or rows that hold all grains which a sphere that falls here with a reach of `reach`,
    /// its radius and that of the largest grain, may meet, and the places where it may rest.
    #[inline(always)]
    pub(super) fn span(&self, coordinate: f64, reach: f64, axis: usize) -> Span {
        let cells = (coordinate - f64::from(self.anchor[axis])) * self.cells_per_quantum;
        let towards_zero = cells as i32;
        let here = towards_zero - i32::from(f64::from(towards_zero) > cells);
        let part = cells - f64::from(here);
        let reach = (reach * self.drift.shadow[axis] + ROUNDING) * self.cells_per_quantum;
        let nearest = here - i32::from(part < 0.5);
        if reach < 1.0 {
            let low = here - i32::from(part < reach);
            return Span { nearest, low, high: here + i32::from(part + reach >= 1.0) };
        }
        let low = here + (part - reach).floor() as i32;
        Span { nearest, low, high: here + (part + reach) as i32 }
    }

    /// Least corner of the cell in an unwrapped column and row.
    #[inline(always)]
    pub(super) fn corner(&self, column: i32, row: i32) -> [i64; 2] {
        [
            i64::from(self.anchor[0]) + i64::from(column) * i64::from(self.side),
            i64::from(self.anchor[1]) + i64::from(row) * i64::from(self.side),
        ]
    }

    /// Column and row from the first cell on, wrapped where the plan repeats; `None` outside.
    #[inline(always)]
    pub(super) fn place(&self, column: i32, row: i32) -> Option<[i32; 2]> {
        let mut place = [column - self.first[0], row - self.first[1]];
        for (at, count) in place.iter_mut().zip(self.counts) {
            if !(0..count).contains(at) {
                if !self.periodic {
                    return None;
                }
                *at = at.rem_euclid(count);
            }
        }
        Some(place)
    }

    /// Plan place of a grain.
    #[inline(always)]
    pub(super) fn on_plan(&self, grain: QuantisedGrain) -> [i64; 2] {
        let [x, y, z] = grain.center;
        let offsets = self.drift.offsets(y);
        [i64::from(x) - offsets[0], i64::from(z) - offsets[1]]
    }

    /// Column, row and place within that cell of a grain.
    #[inline(always)]
    pub(super) fn locate(&self, grain: QuantisedGrain) -> ([i32; 2], [u16; 2]) {
        let on_plan = self.on_plan(grain);
        let (mut cell, mut local) = ([0i32; 2], [0u16; 2]);
        for axis in 0..2 {
            // A multiplication finds the cell but for rounding, which the remainder mends.
            let from_anchor = on_plan[axis] - i64::from(self.anchor[axis]);
            let near = (from_anchor as f64 * self.cells_per_quantum) as i64;
            let rest = from_anchor - near * i64::from(self.side);
            let mend = i64::from(rest >= self.side.into()) - i64::from(rest < 0);
            cell[axis] = (near + mend) as i32;
            local[axis] = (rest - mend * i64::from(self.side)) as u16;
        }
        (cell, local)
    }

    /// The grain of a lane, seen where the cell's corner is at `corner`.
    #[inline(always)]
    pub(super) fn grain(&self, block: &Block, lane: usize, corner: [i64; 2]) -> QuantisedGrain {
        debug_assert!(lane < LANES);
        let y = block.y[lane];
        let offsets = self.drift.offsets(y);
        QuantisedGrain {
            center: [
                (corner[0] + i64::from(block.x[lane]) + offsets[0]) as i32,
                y,
                (corner[1] + i64::from(block.z[lane]) + offsets[1]) as i32,
            ],
            radius: block.radius[lane],
        }
    }

    /// The grain at its image in the first period.
    pub(super) fn in_first_period(&self, mut grain: QuantisedGrain) -> QuantisedGrain {
        if self.periodic && !self.drift.is_vertical() {
            for (axis, at) in [(0, 0), (1, 2)] {
                let period = self.counts[axis] * self.side;
                let from = self.anchor[axis];
                grain.center[at] = (grain.center[at] - from).rem_euclid(period) + from;
            }
        }
        grain
    }

    /// The point at height `y` of the line of fall through this place of the plan.
    #[inline(always)]
    pub(super) fn point(&self, x: f64, z: f64, y: f64) -> DVec3 {
        if self.drift.is_vertical() {
            return DVec3::new(x, y, z);
        }
        DVec3::new(x + y * self.drift.x, y, z + y * self.drift.z)
    }
}
