//! The cells of a perfect lattice, which need no memory: every cell shows the same grains, less
//! those of neighbours that lie outside the block of crystal.

use super::block::OVERLAPS;
use super::build::{PAD, longest_side, overlaps, reaches_cell};
use super::{Block, CellEntry, GRAINS_PER_BLOCK, GrainGrid, GridError, LatticeSites, Storage};
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

impl LatticeCell {
    /// Halvings of the cell along each axis after which coordinates around a piece fit 16 bits:
    /// none where the cell is narrow, one for the tightest lattices. `None` where an edge of such a
    /// piece would not be a whole number of quanta (a lattice of grains far apart).
    #[must_use]
    pub fn pieces(&self) -> Option<[u32; 3]> {
        let longest = longest_side(i32::from(self.radius_quanta) + PAD);
        let mut pieces = [0; 3];
        for (axis, &side) in self.side_quanta.iter().enumerate() {
            while side >> pieces[axis] > longest {
                pieces[axis] += 1;
            }
            if side >> pieces[axis] << pieces[axis] != side || pieces[axis] > MOST_HALVINGS {
                return None;
            }
        }
        Some(pieces)
    }
}

/// Halvings of a cell along an axis: beyond them a table costs more than packing the grains.
const MOST_HALVINGS: u32 = 2;

/// For every piece of a cell, one entry for each of the 8 x 8 x 8 combinations of "the cell has a
/// lower neighbour, is inside, has an upper neighbour" along the three axes.
#[derive(Debug)]
pub struct LatticeCells {
    table: Box<[CellEntry]>,
    /// Halvings of a conventional cell along each axis.
    pieces: [u32; 3],
    /// Conventional cells along each axis; 0 where periodic.
    counts: [i32; 3],
}

impl LatticeCells {
    /// The table, its blocks, and the cells of the grid, which are the pieces of the conventional
    /// ones: with one conventional layer more than the crystal on each side of an axis that does
    /// not repeat.
    pub(crate) fn new(
        quantisation: Quantisation,
        cell: &LatticeCell,
        pieces: [u32; 3],
        counts: [u32; 3],
        periodic: [bool; 3],
    ) -> Result<(Self, Vec<Block>, [i32; 3]), GridError> {
        let mut blocks = vec![Block::EMPTY];
        let mut table = vec![CellEntry::EMPTY; COMBINATIONS << (pieces[0] + pieces[1] + pieces[2])];
        let overlapping = basis_overlaps(cell);
        for (index, entry) in table.iter_mut().enumerate() {
            let masks = [index & 7, index >> 3 & 7, index >> 6 & 7];
            let mut rest = (index / COMBINATIONS) as u32;
            let piece = pieces.map(|halvings| {
                let along = rest & ((1 << halvings) - 1);
                rest >>= halvings;
                along.cast_signed()
            });
            let grains = grains_of(cell, pieces, piece, masks);
            let needed = grains.len().div_ceil(GRAINS_PER_BLOCK);
            if needed > CellEntry::MAX_BLOCKS_PER_CELL {
                return Err(GridError::CrowdedCell {
                    count: grains.len(),
                    most: CellEntry::MAX_BLOCKS_PER_CELL * GRAINS_PER_BLOCK,
                    side: f64::from(cell.side_quanta[0] >> pieces[0]) * quantisation.quantum(),
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
        let inner = counts.map(u32::cast_signed);
        let cells = std::array::from_fn(|axis| {
            (inner[axis] + if periodic[axis] { 0 } else { 2 }) << pieces[axis]
        });
        let counts = std::array::from_fn(|axis| if periodic[axis] { 0 } else { inner[axis] });
        Ok((Self { table: table.into_boxed_slice(), pieces, counts }, blocks, cells))
    }

    pub(crate) fn memory_bytes(&self) -> usize {
        size_of_val(&*self.table)
    }

    #[inline(always)]
    pub(crate) fn entry(&self, cell: [i32; 3]) -> CellEntry {
        // The grid's conventional cell 0 lies below the crystal's cell 0.
        let mask = |axis: usize| {
            let (c, n) = (cell[axis] >> self.pieces[axis], self.counts[axis]);
            if n == 0 {
                return 7;
            }
            usize::from(c >= 2) | usize::from(c >= 1 && c <= n) << 1 | usize::from(c < n) << 2
        };
        let piece = |axis: usize| (cell[axis] & ((1 << self.pieces[axis]) - 1)) as usize;
        let [x, y, _] = self.pieces;
        let piece = piece(0) | piece(1) << x | piece(2) << (x + y);
        let combination = mask(0) | mask(1) << 3 | mask(2) << 6;
        self.table[piece * COMBINATIONS + combination]
    }
}

/// Entries of one piece.
const COMBINATIONS: usize = 512;

/// The grains of a cell and of those of its neighbours that the masks allow which reach into the
/// piece of it, in cell quanta of that piece.
fn grains_of(
    cell: &LatticeCell,
    pieces: [u32; 3],
    piece: [i32; 3],
    masks: [usize; 3],
) -> Vec<[u16; 3]> {
    let mut found = Vec::new();
    let margin = i32::from(cell.radius_quanta) + PAD;
    let side: [i32; 3] = std::array::from_fn(|axis| cell.side_quanta[axis] >> pieces[axis]);
    for neighbour in 0..27 {
        let step = [neighbour % 3, neighbour / 3 % 3, neighbour / 9];
        if (0..3).any(|axis| (masks[axis] >> step[axis]) & 1 == 0) {
            continue;
        }
        for basis in &cell.basis {
            let center: [i32; 3] = std::array::from_fn(|axis| {
                let cells_away = step[axis] - 1;
                basis[axis] + cells_away * cell.side_quanta[axis] - piece[axis] * side[axis]
            });
            if reaches_cell(center, cell.radius_quanta, side) {
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

impl GrainGrid {
    /// A crystal lattice of `counts` conventional cells whose first has its low corner at the
    /// lattice coordinate `first`; no memory, or that of one cell's blocks where grains overlap or
    /// are not all alike (hexagonal lattices). `periodic` repeats it for ever along an axis.
    ///
    /// # Errors
    /// A cell that holds too many grains, or that is too wide ([`LatticeCell::pieces`]).
    pub fn lattice(
        quantisation: Quantisation,
        cell: &LatticeCell,
        counts: [u32; 3],
        first: [i32; 3],
        periodic: [bool; 3],
    ) -> Result<Self, GridError> {
        let grains = counts.map(u64::from).iter().product::<u64>() * cell.basis.len() as u64;
        if let Some(sites) = LatticeSites::new(cell, counts, first, periodic) {
            return Ok(Self {
                quantisation,
                first: first.map(i64::from),
                side: cell.side_quanta,
                cells: counts.map(u32::cast_signed),
                periodic,
                margin: 0,
                storage: Storage::Sites(sites),
                blocks: Vec::new(),
                strata: Vec::new(),
                shapes: None,
                grains,
            });
        }
        Self::lattice_in_cells(quantisation, cell, counts, first, periodic)
    }

    /// As [`Self::lattice`], always of cells whose blocks can be asked: what light that looks for other
    /// light at each grain needs.
    ///
    /// # Errors
    /// As there.
    pub fn lattice_in_cells(
        quantisation: Quantisation,
        cell: &LatticeCell,
        counts: [u32; 3],
        first: [i32; 3],
        periodic: [bool; 3],
    ) -> Result<Self, GridError> {
        let grains = counts.map(u64::from).iter().product::<u64>() * cell.basis.len() as u64;
        let pieces = cell.pieces().ok_or(GridError::WideLattice)?;
        let (storage, blocks, cells) =
            LatticeCells::new(quantisation, cell, pieces, counts, periodic)?;
        Ok(Self {
            quantisation,
            // One layer of conventional cells below the first holds what protrudes from it.
            first: std::array::from_fn(|axis| {
                let below = if periodic[axis] { 0 } else { i64::from(cell.side_quanta[axis]) };
                i64::from(first[axis]) - below
            }),
            side: std::array::from_fn(|axis| cell.side_quanta[axis] >> pieces[axis]),
            cells,
            periodic,
            margin: i32::from(cell.radius_quanta) + PAD,
            storage: Storage::Lattice(storage),
            blocks,
            strata: Vec::new(),
            shapes: None,
            grains,
        })
    }
}
