//! The cells of a grid, and which of them and of its bricks a grain reaches.

use super::survey::Survey;
use super::{PAD, longest_side};
use crate::grain_grid::GridError;
use crate::grain_grid::packed_cells::BRICK;
use snowgrain_geometry::{Quantisation, QuantisedGrain};
use snowgrain_math::{Aabb, DVec3};

/// Division by a fixed number, without dividing: exact below 2^40 for divisors below 2^20.
#[derive(Clone, Copy, Debug)]
pub(super) struct Divisor(u64);

impl Divisor {
    pub(super) fn new(divisor: i64) -> Self {
        Self((1 << 63) / divisor.unsigned_abs() + u64::from((1 << 63) % divisor.unsigned_abs() > 0))
    }

    /// The quotient, rounded down, of a number that is not negative.
    #[inline(always)]
    pub(super) fn divide(self, dividend: i64) -> i64 {
        ((u128::from(dividend.cast_unsigned()) * u128::from(self.0)) >> 63) as i64
    }
}

/// A period is cut into at most this many times the cells that it would have if they could have any
/// edge.
const MOST_PERIODIC_CELLS: i64 = 8;

/// Into how many equal cells a period is cut: their edge divides it, is at most `longest`, and near
/// to `side`, better a little below than above.
fn periodic_cells(length: i64, side: i32, longest: i32) -> Result<i64, GridError> {
    let at_most = |edge: i32| ((length + i64::from(edge) - 1) / i64::from(edge)).max(1);
    let (wanted, least) = (at_most(side), at_most(longest));
    let divides = |n: &i64| length % n == 0;
    (wanted..=2 * wanted)
        .find(divides)
        .or_else(|| (least..wanted).rev().find(divides))
        .or_else(|| (2 * wanted..=MOST_PERIODIC_CELLS * wanted).find(divides))
        .ok_or(GridError::BadPeriod)
}

/// A box of bricks, ends included.
pub(super) type BrickBox = [[i64; 2]; 3];

#[derive(Clone, Copy, Debug)]
pub(super) struct Layout {
    pub(super) first: [i64; 3],
    pub(super) side: [i32; 3],
    pub(super) cells: [i32; 3],
    pub(super) periodic: [bool; 3],
    by_side: [Divisor; 3],
    by_brick: [Divisor; 3],
}

impl Layout {
    /// Cells of edge `side` that cover all grains, and repeat along x and z with the periods given.
    pub(super) fn new(
        survey: &Survey,
        side: i32,
        period: Option<[i64; 2]>,
        margin: i32,
    ) -> Result<Self, GridError> {
        let (mut first, mut sides, mut periodic) = (survey.low, [side; 3], [false; 3]);
        let mut cells = [0; 3];
        for axis in 0..3 {
            let count = (survey.high[axis] - first[axis]) / i64::from(side) + 1;
            cells[axis] =
                i32::try_from(count).map_err(|_| GridError::TooSparse { bricks: count as u128 })?;
        }
        for (axis, length) in period.iter().flat_map(|&[x, z]| [(0, x), (2, z)]) {
            if length <= i64::from(margin) {
                return Err(GridError::BadPeriod);
            }
            let count = periodic_cells(length, side, longest_side(margin))?;
            first[axis] = 0;
            periodic[axis] = true;
            sides[axis] = (length / count) as i32;
            cells[axis] = count as i32;
        }
        let by = |factor: i64| sides.map(|side| Divisor::new(i64::from(side) * factor));
        let (by_side, by_brick) = (by(1), by(i64::from(BRICK)));
        Ok(Self { first, side: sides, cells, periodic, by_side, by_brick })
    }

    pub(super) fn bricks(&self) -> [i32; 3] {
        self.cells.map(|n| (n + BRICK - 1) / BRICK)
    }

    /// The number of a brick in the table.
    #[inline(always)]
    fn number(&self, [x, y, z]: [i64; 3]) -> usize {
        let [along_x, along_y, _] = self.bricks().map(i64::from);
        ((z * along_y + y) * along_x + x) as usize
    }

    /// The brick of that number.
    pub(super) fn brick(&self, number: usize) -> [i32; 3] {
        let [along_x, along_y, _] = self.bricks().map(|n| n as usize);
        [number % along_x, number / along_x % along_y, number / along_x / along_y]
            .map(|b| (b as u32).cast_signed())
    }

    /// Cells of a brick along each axis: fewer than eight at the grid's upper faces.
    pub(super) fn cells_in_brick(&self, brick: [i32; 3]) -> [i32; 3] {
        std::array::from_fn(|axis| BRICK.min(self.cells[axis] - brick[axis] * BRICK))
    }

    /// All bricks.
    pub(super) fn all_bricks(&self) -> BrickBox {
        self.bricks().map(|n| [0, i64::from(n) - 1])
    }

    /// Calls `visit` with the centre, from the grid's low corner, of each image of the grain that
    /// may reach into the grid.
    #[inline(always)]
    fn for_images(&self, grain: QuantisedGrain, mut visit: impl FnMut([i64; 3])) {
        let center: [i64; 3] =
            std::array::from_fn(|axis| i64::from(grain.center[axis]) - self.first[axis]);
        if self.periodic == [false; 3] {
            return visit(center);
        }
        let reach = i64::from(grain.radius) + i64::from(PAD);
        let images = |axis: usize| {
            let length = i64::from(self.cells[axis]) * i64::from(self.side[axis]);
            let at = center[axis];
            let [from, to] = match self.periodic[axis] {
                true => [at - reach, at + reach].map(|x| x.div_euclid(length)),
                false => [0, 0],
            };
            (from..=to).map(move |image| at - image * length)
        };
        for z in images(2) {
            for x in images(0) {
                visit([x, center[1], z]);
            }
        }
    }

    /// Calls `visit(number, center)` for every brick of `within` that the grain reaches, with its
    /// centre relative to that brick's low corner.
    #[inline(always)]
    pub(super) fn for_bricks(
        &self,
        grain: QuantisedGrain,
        within: &BrickBox,
        mut visit: impl FnMut(usize, [i32; 3]),
    ) {
        let reach = i64::from(grain.radius) + i64::from(PAD);
        self.for_images(grain, |center| {
            let mut from = [0; 3];
            let mut to = [0; 3];
            for axis in [2, 1, 0] {
                from[axis] =
                    self.by_brick[axis].divide((center[axis] - reach).max(0)).max(within[axis][0]);
                to[axis] = match center[axis] + reach {
                    above if above >= 0 => self.by_brick[axis].divide(above).min(within[axis][1]),
                    _ => return,
                };
                if from[axis] > to[axis] {
                    return;
                }
            }
            for z in from[2]..=to[2] {
                for y in from[1]..=to[1] {
                    for x in from[0]..=to[0] {
                        let brick = [x, y, z];
                        let local = std::array::from_fn(|axis| {
                            let edge = i64::from(BRICK) * i64::from(self.side[axis]);
                            (center[axis] - brick[axis] * edge) as i32
                        });
                        if self.reaches_brick(brick, local, reach) {
                            visit(self.number(brick), local);
                        }
                    }
                }
            }
        });
    }

    #[inline(always)]
    fn reaches_brick(&self, brick: [i64; 3], center: [i32; 3], reach: i64) -> bool {
        let mut distance2 = 0;
        for axis in 0..3 {
            let cells = BRICK.min(self.cells[axis] - brick[axis] as i32 * BRICK);
            let above = center[axis] - cells * self.side[axis];
            let gap = i64::from((-center[axis]).max(above).max(0));
            distance2 += gap * gap;
        }
        distance2 <= reach * reach
    }

    /// Calls `visit(cell, corner)` for every cell of a brick of `cells` cells that the ball reaches,
    /// with the cell's place in the brick and its low corner relative to the brick's, as `center` is.
    #[inline(always)]
    pub(super) fn for_cells(
        &self,
        cells: [i32; 3],
        center: [i32; 3],
        radius: u16,
        mut visit: impl FnMut(usize, [i32; 3]),
    ) {
        let reach = i32::from(radius) + PAD;
        let mut gaps = [[0u32; BRICK as usize]; 3];
        let mut ends = [[0usize; 2]; 3];
        for axis in 0..3 {
            let side = self.side[axis];
            let cell_of = |x: i32| self.by_side[axis].divide(i64::from(x.max(0))) as i32;
            let from = cell_of(center[axis] - reach);
            let to = cell_of(center[axis] + reach).min(cells[axis] - 1);
            if from > to {
                return;
            }
            ends[axis] = [from, to].map(|cell| cell as usize & 7);
            for cell in from..=to {
                let low = cell * side;
                let gap = (low - center[axis]).max(center[axis] - low - side).max(0);
                gaps[axis][cell as usize & 7] = (gap * gap).cast_unsigned();
            }
        }
        let reach2 = (reach * reach).cast_unsigned();
        for z in ends[2][0]..=ends[2][1] {
            for y in ends[1][0]..=ends[1][1] {
                let across = gaps[2][z] + gaps[1][y];
                for (x, gap) in gaps[0].iter().enumerate().take(ends[0][1] + 1).skip(ends[0][0]) {
                    if across + gap <= reach2 {
                        let at = [x, y, z].map(|c| (c as u32).cast_signed());
                        let corner = std::array::from_fn(|axis| at[axis] * self.side[axis]);
                        visit((z * 8 + y) * 8 + x, corner);
                    }
                }
            }
        }
    }

    /// The box of the cells `from..to` with a pad, metres.
    pub(super) fn cell_box(
        &self,
        quantisation: Quantisation,
        from: [i32; 3],
        to: [i32; 3],
    ) -> Aabb {
        let corner = |cell: [i32; 3], pad: f64| {
            let quanta: [f64; 3] = std::array::from_fn(|axis| {
                (self.first[axis] + i64::from(cell[axis]) * i64::from(self.side[axis])) as f64 + pad
            });
            quantisation.origin() + DVec3::from_array(quanta) * quantisation.quantum()
        };
        Aabb::new(corner(from, -f64::from(PAD)), corner(to, f64::from(PAD)))
    }
}

#[cfg(test)]
mod tests {
    use super::Divisor;

    #[test]
    fn quotients_are_exact() {
        for divisor in [1, 2, 3, 7, 8, 1000, 4369, 65_535, 524_280, (1 << 20) - 1] {
            let by = Divisor::new(divisor);
            for quotient in [0, 1, 2, 1234, (1 << 32) / divisor] {
                for dividend in [quotient * divisor - 1, quotient * divisor, quotient * divisor + 1]
                {
                    if dividend >= 0 {
                        assert_eq!(by.divide(dividend), dividend / divisor, "{dividend}/{divisor}");
                    }
                }
            }
        }
    }
}
