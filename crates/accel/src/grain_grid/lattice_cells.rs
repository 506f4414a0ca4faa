//! The cells of a perfect lattice, which need no memory: every cell shows the same grains, less
//! those of neighbours that lie outside the block of crystal.

use super::block::OVERLAPS;
use super::build::{overlaps, reaches_cell};
use super::{Block, CellEntry, GRAINS_PER_BLOCK, GridError};
use snowgrain_geometry::Quantisation;

/// A conventional cell of a crystal lattice, in quanta.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct LatticeCell {
    /// Edges of the cell.
    pub side_quanta: [i32; 3],
    /// Centres of the grains that belong to the cell, each in `0..side`.
    pub basis: Vec<[i32; 3]>,
    /// Radius of every grain.
    pub radius_quanta: u16,
}

/// One entry for each of the 8 x 8 x 8 combinations of "has a lower neighbour, is inside, has an
/// upper neighbour" along the three axes.
#[derive(Debug)]
pub struct LatticeCells {
    table: Box<[CellEntry; 512]>,
    /// Conventional cells along each axis; 0 where periodic.
    counts: [i32; 3],
}

impl LatticeCells {
    /// The table, its blocks, and the cells of the grid: one layer more than the crystal on each
    /// side of an axis that does not repeat.
    pub(crate) fn new(
        quantisation: Quantisation,
        cell: &LatticeCell,
        counts: [u32; 3],
        periodic: [bool; 3],
    ) -> Result<(Self, Vec<Block>, [i32; 3]), GridError> {
        let mut blocks = vec![Block::EMPTY];
        let mut table = Box::new([CellEntry::EMPTY; 512]);
        let overlapping = basis_overlaps(cell);
        for (combination, entry) in table.iter_mut().enumerate() {
            let masks = [combination & 7, combination >> 3 & 7, combination >> 6 & 7];
            let grains = grains_of(cell, masks);
            let needed = grains.len().div_ceil(GRAINS_PER_BLOCK);
            if needed > CellEntry::MAX_BLOCKS_PER_CELL {
                return Err(GridError::CrowdedCell {
                    count: grains.len(),
                    most: CellEntry::MAX_BLOCKS_PER_CELL * GRAINS_PER_BLOCK,
                    side: f64::from(cell.side_quanta[0]) * quantisation.quantum(),
                });
            }
            if grains.is_empty() {
                continue;
            }
            *entry = CellEntry::new(blocks.len(), needed, false);
            let radius = cell.radius_quanta | if overlapping { OVERLAPS } else { 0 };
            for chunk in grains.chunks(GRAINS_PER_BLOCK) {
                let mut block = Block::EMPTY;
                for (slot, &center) in chunk.iter().enumerate() {
                    block.set(slot, center, radius);
                }
                blocks.push(block);
            }
        }
        let inner = counts.map(|n| n as i32);
        let cells = std::array::from_fn(|axis| inner[axis] + if periodic[axis] { 0 } else { 2 });
        let counts = std::array::from_fn(|axis| if periodic[axis] { 0 } else { inner[axis] });
        Ok((Self { table, counts }, blocks, cells))
    }

    pub(crate) fn memory_bytes(&self) -> usize {
        size_of_val(self.table.as_slice())
    }

    #[inline(always)]
    pub(crate) fn entry(&self, cell: [i32; 3]) -> CellEntry {
        // The grid's cell 0 lies below the crystal's cell 0.
        let mask = |axis: usize| {
            let (c, n) = (cell[axis], self.counts[axis]);
            if n == 0 {
                return 7;
            }
            usize::from(c >= 2) | usize::from(c >= 1 && c <= n) << 1 | usize::from(c < n) << 2
        };
        self.table[mask(0) | mask(1) << 3 | mask(2) << 6]
    }
}

/// The grains of a cell and of those of its neighbours that the masks allow which reach into it.
fn grains_of(cell: &LatticeCell, masks: [usize; 3]) -> Vec<[u16; 3]> {
    let mut found = Vec::new();
    let margin = i32::from(cell.radius_quanta);
    for neighbour in 0..27 {
        let step = [neighbour % 3, neighbour / 3 % 3, neighbour / 9];
        if (0..3).any(|axis| masks[axis] >> step[axis] & 1 == 0) {
            continue;
        }
        for basis in &cell.basis {
            let center: [i32; 3] = std::array::from_fn(|axis| {
                basis[axis] + (step[axis] as i32 - 1) * cell.side_quanta[axis]
            });
            if reaches_cell(center, cell.radius_quanta, cell.side_quanta) {
                found.push(center.map(|c| (c + margin) as u16));
            }
        }
    }
    found
}

fn basis_overlaps(cell: &LatticeCell) -> bool {
    let all: Vec<[i32; 3]> = (0..27)
        .flat_map(|neighbour| {
            let step = [neighbour % 3 - 1, neighbour / 3 % 3 - 1, neighbour / 9 - 1];
            cell.basis.iter().map(move |basis| {
                std::array::from_fn(|axis| basis[axis] + step[axis] * cell.side_quanta[axis])
            })
        })
        .collect();
    let r = cell.radius_quanta;
    cell.basis.iter().any(|a| all.iter().any(|b| a != b && overlaps(*a, r, *b, r)))
}
