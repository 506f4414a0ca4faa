//! Where in the snow it is deep: far from open air and from surfaces.
//!
//! The cells of a grid are joined to coarse ones. A coarse cell is snow where at least half of its cells hold
//! grains and no surface crosses it, and deep where all coarse cells around it, so many rings of them, are snow.

use super::cell_bits::CellBits;
use super::packed_cells::{BRICK, CELLS_PER_BRICK};
use super::{CellEntry, GrainGrid, GridPosition, PackedCells, Storage};
use snowgrain_math::DVec3;

/// Most coarse cells: two bits each. Where there would be more they are larger.
const MOST_CELLS: u64 = 1 << 28;

/// The coarse cells of a [`GrainGrid`], and which of them are deep.
#[derive(Clone, Debug)]
pub struct Interior {
    /// Of the edge of a coarse cell in cells, the binary logarithm.
    shift: [u32; 3],
    /// Of a cell of the grid, in cell quanta: its low face and its edges.
    margin: f64,
    side: [f64; 3],
    quantum: f64,
    deep: CellBits,
}

impl Interior {
    /// Whether the coarse cell around a cell of the grid is deep.
    #[inline]
    #[must_use]
    pub fn is_deep(&self, cell: [i32; 3]) -> bool {
        self.deep.get(self.coarse(cell))
    }

    /// Whether any snow is deep.
    #[must_use]
    pub fn has_deep(&self) -> bool {
        self.deep.any()
    }

    /// The coarse cell around a cell of the grid.
    #[inline]
    #[must_use]
    pub fn coarse(&self, cell: [i32; 3]) -> [i32; 3] {
        std::array::from_fn(|axis| cell[axis] >> self.shift[axis])
    }

    /// A place in units of coarse cells from the low corner of the grid.
    #[inline]
    #[must_use]
    pub fn coordinates(&self, place: GridPosition) -> DVec3 {
        DVec3::from_array(std::array::from_fn(|axis| {
            let within = (f64::from(place.local[axis]) - self.margin) / self.side[axis];
            (f64::from(place.cell[axis]) + within) / f64::from(1 << self.shift[axis])
        }))
    }

    /// Edges of a coarse cell, metres.
    #[must_use]
    pub fn edges(&self) -> DVec3 {
        DVec3::from_array(std::array::from_fn(|axis| {
            f64::from(1 << self.shift[axis]) * self.side[axis] * self.quantum
        }))
    }

    /// Memory, bytes.
    #[must_use]
    pub fn memory_bytes(&self) -> u64 {
        self.deep.memory_bytes()
    }
}

impl GrainGrid {
    /// Coarse cells of about an edge, metres, those deep that have so many rings of snow around them.
    #[must_use]
    pub fn interior(&self, edge: f64, rings: u32) -> Interior {
        // The power of two nearest to the edge, so that coarse cells fit into bricks.
        let mut shift = self.cell_edges().to_array().map(|side| {
            let cells = edge / side / core::f64::consts::SQRT_2;
            (0..30).take_while(|&shift| f64::from(1 << shift) < cells).count() as u32
        });
        let count = |shift: [u32; 3]| -> [i32; 3] {
            std::array::from_fn(|axis| ((self.cells[axis] - 1) >> shift[axis]) + 1)
        };
        while count(shift).iter().map(|&n| n as u64).product::<u64>() > MOST_CELLS {
            shift = shift.map(|shift| shift + 1);
        }
        let cells = count(shift);
        let deep = self.snow_cells(shift, cells).eroded(rings);
        Interior {
            shift,
            margin: f64::from(self.margin),
            side: self.side.map(f64::from),
            quantum: self.quantum(),
            deep,
        }
    }

    /// The coarse cells that are snow.
    fn snow_cells(&self, shift: [u32; 3], cells: [i32; 3]) -> CellBits {
        let mut snow = CellBits::new(cells);
        let least = 1_i64 << (shift.iter().sum::<u32>().max(1) - 1);
        let mut tell = |coarse: [i32; 3], full: i64| {
            if full >= least {
                snow.set(coarse);
            }
        };
        match &self.storage {
            Storage::Packed(packed) => {
                let within = shift.map(|shift| shift.min(3));
                let parts = within.map(|shift| BRICK >> shift);
                let counts = counts_of_bricks(packed, within, parts);
                let of_brick = parts.iter().product::<i32>() as usize;
                let mut sums = Sums::new(cells, shift.iter().any(|&shift| shift > 3));
                packed.for_each_brick(|brick, number| {
                    let counts = &counts[number * of_brick..][..of_brick];
                    for (index, &full) in (0..).zip(counts) {
                        let [x, y] = [parts[0], parts[1]];
                        let part = [index % x, index / x % y, index / (x * y)];
                        let coarse: [i32; 3] = std::array::from_fn(|axis| {
                            (brick[axis] * parts[axis] + part[axis]) >> (shift[axis] - within[axis])
                        });
                        if (0..3).all(|axis| coarse[axis] < cells[axis]) {
                            sums.add(coarse, full.into(), &mut tell);
                        }
                    }
                });
                sums.finish(&mut tell);
            }
            Storage::Lattice(lattice) => {
                let mut sums = Sums::new(cells, true);
                self.for_cells(|cell| {
                    let coarse = std::array::from_fn(|axis| cell[axis] >> shift[axis]);
                    sums.add(coarse, full_of(lattice.entry(cell)).into(), &mut tell);
                });
                sums.finish(&mut tell);
            }
            Storage::Sites(_) => {}
        }
        snow
    }

    /// All cells of the grid.
    pub(super) fn for_cells(&self, mut tell: impl FnMut([i32; 3])) {
        for z in 0..self.cells[2] {
            for y in 0..self.cells[1] {
                for x in 0..self.cells[0] {
                    tell([x, y, z]);
                }
            }
        }
    }
}

/// What makes a sum of full cells negative: a surface crosses it.
const CROSSED: i32 = -(1 << 20);

/// 1 where a cell holds grains, and far below 0 where a surface crosses it.
fn full_of(entry: CellEntry) -> i32 {
    if entry.has_surface() { CROSSED } else { i32::from(entry.first_block() != 0) }
}

/// Of each brick in the table's numbers, the full cells of each of its parts.
fn counts_of_bricks(packed: &PackedCells, within: [u32; 3], parts: [i32; 3]) -> Vec<i32> {
    let of_brick = parts.iter().product::<i32>() as usize;
    let bricks = packed.entries().as_chunks::<CELLS_PER_BRICK>().0;
    let mut counts = vec![0; bricks.len() * of_brick];
    for (brick, counts) in bricks.iter().zip(counts.chunks_mut(of_brick)) {
        for (cell, &entry) in (0..).zip(brick) {
            let at: [i32; 3] = [cell & 7, cell >> 3 & 7, cell >> 6];
            let [x, y, z]: [i32; 3] = std::array::from_fn(|axis| at[axis] >> within[axis]);
            counts[((z * parts[1] + y) * parts[0] + x) as usize] += full_of(entry);
        }
    }
    counts
}

/// Sums over coarse cells that come in several pieces, or go on at once.
struct Sums {
    cells: [i32; 3],
    pieces: Option<Vec<i64>>,
}

impl Sums {
    fn new(cells: [i32; 3], in_pieces: bool) -> Self {
        let count = cells.iter().map(|&n| n as usize).product();
        Self { cells, pieces: in_pieces.then(|| vec![0; count]) }
    }

    fn add(&mut self, coarse: [i32; 3], full: i64, tell: &mut impl FnMut([i32; 3], i64)) {
        let [along_x, along_y, _] = self.cells;
        match &mut self.pieces {
            None => tell(coarse, full),
            Some(sums) => {
                let row = coarse[2] as usize * along_y as usize + coarse[1] as usize;
                sums[row * along_x as usize + coarse[0] as usize] += full;
            }
        }
    }

    fn finish(self, tell: &mut impl FnMut([i32; 3], i64)) {
        let [x, y, _] = self.cells.map(|n| n as usize);
        for (index, full) in self.pieces.into_iter().flatten().enumerate() {
            tell(
                [index % x, index / x % y, index / (x * y)].map(|c| (c as u32).cast_signed()),
                full,
            );
        }
    }
}
