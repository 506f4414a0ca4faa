//! Where in the snow it is deep: far from open air and from surfaces.
//!
//! The cells of a grid are joined to coarse ones. A coarse cell is snow where at least half of its cells hold
//! grains and no surface crosses it, and deep where all coarse cells around it, so many rings of them, are snow.

use super::packed_cells::{BRICK, within_brick};
use super::{CellEntry, GrainGrid, GridPosition, RADIUS_MASK, Storage};
use core::f64::consts::PI;
use snowgrain_math::DVec3;

/// Most coarse cells: a bit each. Where there would be more they are larger.
const MOST_CELLS: u64 = 1 << 31;

/// The coarse cells of a [`GrainGrid`], and which of them are deep.
#[derive(Clone, Debug)]
pub struct Interior {
    /// Cells along each edge of a coarse cell.
    edge: [i32; 3],
    inverse_edge: [f64; 3],
    /// Coarse cells along each axis.
    cells: [i32; 3],
    /// Of a cell of the grid, in cell quanta: its low face and its edges.
    margin: f64,
    side: [f64; 3],
    quantum: f64,
    deep: Bits,
}

impl Interior {
    /// Whether the coarse cell around a cell of the grid is deep.
    #[inline]
    #[must_use]
    pub fn is_deep(&self, cell: [i32; 3]) -> bool {
        self.index(self.coarse(cell)).is_some_and(|index| self.deep.get(index))
    }

    /// The coarse cell around a cell of the grid.
    #[inline]
    #[must_use]
    pub fn coarse(&self, cell: [i32; 3]) -> [i32; 3] {
        // Half a cell in, the product is never rounded to another whole number.
        std::array::from_fn(|axis| {
            ((f64::from(cell[axis]) + 0.5) * self.inverse_edge[axis]).floor() as i32
        })
    }

    /// Lets only those coarse cells be deep that `keeps` says so of.
    pub fn retain(&mut self, keeps: impl Fn([i32; 3]) -> bool) {
        for cell in self.deep_cells().collect::<Vec<_>>() {
            if !keeps(cell) {
                self.deep.clear(index_of(cell, self.cells));
            }
        }
    }

    /// The coarse cells that are deep.
    pub fn deep_cells(&self) -> impl Iterator<Item = [i32; 3]> + '_ {
        let [x, y, _] = self.cells.map(|n| n as u64);
        self.deep.set_bits().map(move |index| {
            [index % x, index / x % y, index / (x * y)].map(|coordinate| coordinate as i32)
        })
    }

    /// A place in units of coarse cells from the low corner of the grid.
    #[inline]
    #[must_use]
    pub fn coordinates(&self, place: GridPosition) -> DVec3 {
        DVec3::from_array(std::array::from_fn(|axis| {
            let within = (f64::from(place.local[axis]) - self.margin) / self.side[axis];
            (f64::from(place.cell[axis]) + within) / f64::from(self.edge[axis])
        }))
    }

    /// Edges of a coarse cell, metres.
    #[must_use]
    pub fn edges(&self) -> DVec3 {
        DVec3::from_array(std::array::from_fn(|axis| {
            f64::from(self.edge[axis]) * self.side[axis] * self.quantum
        }))
    }

    /// How far the centre of a grain may lie outside of a cell that lists it, in coarse cells along each axis.
    #[must_use]
    pub fn overhang(&self) -> DVec3 {
        DVec3::splat(self.margin * self.quantum) / self.edges()
    }

    /// Memory, bytes.
    #[must_use]
    pub fn memory_bytes(&self) -> u64 {
        size_of_val(self.deep.0.as_slice()) as u64
    }

    fn index(&self, coarse: [i32; 3]) -> Option<u64> {
        let inside = (0..3).all(|axis| (0..self.cells[axis]).contains(&coarse[axis]));
        inside.then(|| index_of(coarse, self.cells))
    }
}

impl GrainGrid {
    /// Area of the grains' discs per volume of the cells that hold grains, 1/m: what light that goes straight
    /// meets, about 3 phi / (4 r). Grains of shapes count as spheres of equal volume.
    #[must_use]
    pub fn extinction(&self) -> f64 {
        let (mut area, mut cells) = (0.0, 0u64);
        self.for_each_cell(|_, entry| {
            if entry.first_block() == 0 {
                return;
            }
            cells += 1;
            for index in entry.blocks() {
                area += self.area_of_block(index);
            }
        });
        let volume: f64 = self.side.map(f64::from).iter().product::<f64>() * cells as f64;
        if volume > 0.0 { area / (volume * self.quantum()) } else { 0.0 }
    }

    /// Coarse cells of about an edge, metres, those deep that have so many rings of snow around them.
    #[must_use]
    pub fn interior(&self, edge: f64, rings: u32) -> Interior {
        let mut edges = self.cell_edges().to_array().map(|side| whole(edge / side));
        let count = |edges: [i32; 3]| -> [i32; 3] {
            std::array::from_fn(|axis| (self.cells[axis] + edges[axis] - 1) / edges[axis])
        };
        while count(edges).iter().map(|&n| n as u64).product::<u64>() > MOST_CELLS {
            edges = edges.map(|edge| edge * 2);
        }
        let cells = count(edges);
        let snow = self.snow_cells(edges, cells);
        let mut deep = Bits::new(cells);
        snow.eroded(cells, rings.min(1 << 20).cast_signed(), &mut deep);
        Interior {
            edge: edges,
            inverse_edge: edges.map(|edge| 1.0 / f64::from(edge)),
            cells,
            margin: f64::from(self.margin),
            side: self.side.map(f64::from),
            quantum: self.quantum(),
            deep,
        }
    }

    /// The coarse cells that are snow.
    fn snow_cells(&self, edges: [i32; 3], cells: [i32; 3]) -> Bits {
        let volume: i32 = edges.iter().product();
        let mut full = std::collections::BTreeMap::<u64, i32>::new();
        self.for_each_cell(|cell, entry| {
            let coarse = std::array::from_fn(|axis| cell[axis] / edges[axis]);
            let count = full.entry(index_of(coarse, cells)).or_default();
            if entry.has_surface() {
                *count = i32::MIN / 2;
            } else if entry.first_block() != 0 {
                *count += 1;
            }
        });
        let mut snow = Bits::new(cells);
        for (index, count) in full {
            if 2 * count >= volume {
                snow.set(index);
            }
        }
        snow
    }

    /// Area of the discs of the grains of a block whose centres are in its cell, square quanta.
    fn area_of_block(&self, index: usize) -> f64 {
        let block = &self.blocks[index];
        let (low, side) = (self.margin, self.side);
        let own = |at: u16, axis: usize| (low..low + side[axis]).contains(&i32::from(at));
        let mut area = 0.0;
        for slot in 0..super::GRAINS_PER_BLOCK {
            if !(own(block.x[slot], 0) && own(block.y[slot], 1) && own(block.z[slot], 2)) {
                continue;
            }
            let radius = match &self.shapes {
                Some(shapes) => super::ShapeWord::of_slot(shapes.blocks[index][slot]).radius(),
                None => f64::from(block.radius[slot] & RADIUS_MASK),
            };
            area += PI * radius * radius;
        }
        area
    }

    /// Every cell that holds anything, and perhaps some that do not.
    pub(super) fn for_each_cell(&self, mut tell: impl FnMut([i32; 3], CellEntry)) {
        let mut tell_box =
            |low: [i32; 3], high: [i32; 3], entry: &dyn Fn([i32; 3]) -> CellEntry| {
                for z in low[2]..high[2] {
                    for y in low[1]..high[1] {
                        for x in low[0]..high[0] {
                            tell([x, y, z], entry([x, y, z]));
                        }
                    }
                }
            };
        match &self.storage {
            Storage::Packed(cells) => {
                let bricks = self.cells.map(|count| (count + BRICK - 1) / BRICK);
                for z in 0..bricks[2] {
                    for y in 0..bricks[1] {
                        for x in 0..bricks[0] {
                            let low = [x, y, z].map(|brick| brick * BRICK);
                            let Some(entries) = cells.brick(low) else { continue };
                            let high = std::array::from_fn(|a| (low[a] + BRICK).min(self.cells[a]));
                            tell_box(low, high, &|cell| entries[within_brick(cell)]);
                        }
                    }
                }
            }
            Storage::Lattice(cells) => tell_box([0; 3], self.cells, &|cell| cells.entry(cell)),
            Storage::Sites(_) => {}
        }
    }
}

/// The nearest whole number from 1 on.
fn whole(number: f64) -> i32 {
    number.round().clamp(1.0, 1e6) as i32
}

fn index_of(cell: [i32; 3], cells: [i32; 3]) -> u64 {
    let [x, y, z] = cell.map(|c| c as u64);
    (z * cells[1] as u64 + y) * cells[0] as u64 + x
}

/// A bit a coarse cell.
#[derive(Clone, Debug)]
struct Bits(Vec<u64>);

impl Bits {
    fn new(cells: [i32; 3]) -> Self {
        let count: u64 = cells.iter().map(|&n| n as u64).product();
        Self(vec![0; count.div_ceil(64) as usize])
    }

    #[inline]
    fn get(&self, index: u64) -> bool {
        self.0[(index / 64) as usize] >> (index % 64) & 1 != 0
    }

    fn set(&mut self, index: u64) {
        self.0[(index / 64) as usize] |= 1 << (index % 64);
    }

    fn clear(&mut self, index: u64) {
        self.0[(index / 64) as usize] &= !(1 << (index % 64));
    }

    /// The indices that are set, in order.
    fn set_bits(&self) -> impl Iterator<Item = u64> + '_ {
        self.0.iter().zip(0u64..).flat_map(|(&word, at)| {
            let mut rest = word;
            std::iter::from_fn(move || {
                let bit = u64::from(rest.trailing_zeros());
                let some = rest != 0;
                rest &= rest.wrapping_sub(1);
                some.then_some(at * 64 + bit)
            })
        })
    }

    /// Those all of whose neighbours up to so many rings away are set: along one axis after the other.
    fn eroded(mut self, cells: [i32; 3], rings: i32, out: &mut Self) {
        for axis in 0..3 {
            let mut next = Self(vec![0; self.0.len()]);
            let [u, v] = [(axis + 1) % 3, (axis + 2) % 3];
            for j in 0..cells[v] {
                for i in 0..cells[u] {
                    let mut run = 0;
                    for at in 0..cells[axis] {
                        let mut cell = [0; 3];
                        (cell[axis], cell[u], cell[v]) = (at, i, j);
                        run = if self.get(index_of(cell, cells)) { run + 1 } else { 0 };
                        if run > 2 * rings {
                            cell[axis] = at - rings;
                            next.set(index_of(cell, cells));
                        }
                    }
                }
            }
            self = next;
        }
        *out = self;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_cube_is_deep_where_it_is_eroded_on_all_sides() {
        let cells = [9, 8, 10];
        let mut snow = Bits::new(cells);
        for z in 1..9 {
            for y in 1..8 {
                for x in 2..9 {
                    snow.set(index_of([x, y, z], cells));
                }
            }
        }
        let mut deep = Bits::new(cells);
        snow.eroded(cells, 2, &mut deep);
        assert_eq!(deep.set_bits().count(), 3 * 3 * 4);
        for (cell, is_deep) in
            [([4, 3, 3], true), ([3, 3, 3], false), ([6, 5, 6], true), ([6, 5, 7], false)]
        {
            assert_eq!(deep.get(index_of(cell, cells)), is_deep, "{cell:?}");
        }
    }
}
