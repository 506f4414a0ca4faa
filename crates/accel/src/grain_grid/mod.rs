//! What light asks of grains: a grid of cells, each one 128-byte block of up to 16 grains.
//!
//! A cell lists every grain that reaches into it, in 16-bit quanta relative to the cell, so one
//! aligned load of two cache lines answers "which grain is next on this stretch of the ray". Cells
//! are found through bricks of 8 x 8 x 8, so that empty space costs neither memory nor time; a
//! perfect lattice needs no cells at all ([`LatticeCells`]).
//!
//! Positions of light inside a cell are in *cell quanta*: the cell covers `margin..margin + side`
//! on each axis, where `margin` is the radius of the largest grain and a little more, so that all stored coordinates
//! are positive.

mod block;
mod build;
mod cell_bits;
mod cell_entry;
mod each;
mod hull;
mod inside;
mod interior;
mod lattice_cells;
mod packed_cells;
mod packing;
mod parts;
mod reached_faces;
mod shapes;
mod sites;
mod sizes;
mod slabs;
#[cfg(test)]
mod tests;
mod tiles;

pub use block::{Block, GRAINS_PER_BLOCK};
pub(crate) use block::{MEETS_SURFACE, OVERLAPS, RADIUS_MASK};
pub use cell_entry::CellEntry;
pub use each::GridGrain;
pub use interior::Interior;
pub use lattice_cells::{LatticeCell, LatticeCells};
pub use packed_cells::PackedCells;
pub(crate) use packed_cells::within_brick;
pub use packing::Packing;
pub use parts::{GrainParts, PartReader};
pub(crate) use reached_faces::ReachedFaces;
pub use shapes::ShapedGrains;
pub(crate) use shapes::{
    BlockShapes, GridShapes, Part, Placement, Planes, Prototype, Reach, SLACK, ShapeWord,
};
pub(crate) use sites::{LatticeSites, SiteKind};
pub use sizes::SizesPerVolume;
pub(crate) use slabs::{AXES, COS_30, ROUND, Slabs};
pub use tiles::{Extent, TiledGrains, tile_divisor};

use crate::strata::BlockStrata;
use crate::{STRATA, Surfaces};
use snowgrain_geometry::{Quantisation, QuantisedGrain};
use snowgrain_math::{Aabb, DVec3, Ray};
use thiserror::Error;

/// Why grains cannot be packed for light.
#[derive(Debug, Error, Clone, PartialEq)]
pub enum GridError {
    /// More grains reach into one cell than an entry can count.
    #[error(
        "{count} grains reach into one cell of {side} m (at most {most}), and smaller cells would take too much memory beside larger grains: narrow the range of radii, or use fewer of the smallest"
    )]
    CrowdedCell {
        /// Grains in the cell.
        count: usize,
        /// Most that are allowed.
        most: usize,
        /// Edge of the cell, metres.
        side: f64,
    },
    /// More blocks than an entry can number.
    #[error("the snow needs {blocks} blocks of grains, more than {most}: use fewer grains")]
    TooManyBlocks {
        /// Blocks needed.
        blocks: usize,
        /// Most that can be numbered.
        most: usize,
    },
    /// More grains than can be numbered.
    #[error("the snow holds more than 4 294 967 295 grains: use fewer, larger grains")]
    TooManyGrains,
    /// A period is not positive or cannot be cut into equal cells of a grain's size.
    #[error(
        "the period of the snow must be larger than the largest grain, and a multiple of a length of one to three of its radii in whole quanta"
    )]
    BadPeriod,
    /// A shape whose grains reach too far for the blocks.
    #[error(
        "grains of shape \"{shape}\" are too long beside their radius: use smaller grains in the scene, or an aspect nearer to 1"
    )]
    LongShape {
        /// The shape.
        shape: String,
    },
    /// A lattice so wide that its cells cannot be cut into pieces that hold 16-bit coordinates.
    #[error("the cells of the lattice are too wide; pack its grains one by one")]
    WideLattice,
    /// The box of the grains is too large for its cells to be numbered.
    #[error(
        "the snow spreads over {bricks} bricks of cells, more than can be numbered: bring it closer together or use larger grains"
    )]
    TooSparse {
        /// Bricks of 8 x 8 x 8 cells needed.
        bricks: u128,
    },
}

/// A place inside the grid: a cell and a position in cell quanta.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GridPosition {
    /// Cell, each component in `0..cells`.
    pub cell: [i32; 3],
    /// Position in cell quanta, `margin..=margin + side` on each axis.
    pub local: [f32; 3],
}

/// Where the blocks of the cells come from.
#[derive(Debug)]
pub(crate) enum Storage {
    /// Arbitrary snow.
    Packed(PackedCells),
    /// A lattice whose cells all show the same blocks.
    Lattice(LatticeCells),
    /// A lattice of grains that do not overlap, all alike.
    Sites(LatticeSites),
}

/// All grains of a scene, packed for light.
#[derive(Debug)]
pub struct GrainGrid {
    pub(crate) quantisation: Quantisation,
    /// Lattice coordinate of the low corner of cell (0, 0, 0), in quanta.
    pub(crate) first: [i64; 3],
    /// Edges of a cell in quanta.
    pub(crate) side: [i32; 3],
    /// Cells along each axis.
    pub(crate) cells: [i32; 3],
    /// Whether the grid repeats along an axis.
    pub(crate) periodic: [bool; 3],
    /// Local coordinate of a cell's low face: no grain reaches into the cell from farther away.
    pub(crate) margin: i32,
    storage: Storage,
    blocks: Vec<Block>,
    /// Of each block, where any grain has a stratum; else empty.
    strata: Vec<BlockStrata>,
    /// Where grains are not all spheres.
    shapes: Option<GridShapes>,
    grains: u64,
}

impl GrainGrid {
    /// Number of grains (of one period, where the grid is periodic).
    #[must_use]
    pub fn grains(&self) -> u64 {
        self.grains
    }

    /// Memory of the grains and their acceleration, bytes.
    #[must_use]
    pub fn memory_bytes(&self) -> u64 {
        let blocks = size_of_val(self.blocks.as_slice()) + size_of_val(self.strata.as_slice());
        let shapes = self.shapes.as_ref().map_or(0, |s| size_of_val(s.blocks.as_slice()));
        let cells = match &self.storage {
            Storage::Packed(cells) => cells.memory_bytes(),
            Storage::Lattice(cells) => cells.memory_bytes(),
            Storage::Sites(_) => 0,
        };
        (blocks + shapes + cells) as u64
    }

    /// Edge of a quantum, metres.
    #[must_use]
    pub fn quantum(&self) -> f64 {
        self.quantisation.quantum()
    }

    pub(crate) fn storage(&self) -> &Storage {
        &self.storage
    }

    /// Edges of a cell, metres.
    #[must_use]
    pub fn cell_edges(&self) -> DVec3 {
        DVec3::from_array(self.side.map(f64::from)) * self.quantum()
    }

    /// The box of all cells, metres; infinite along periodic axes.
    #[inline]
    #[must_use]
    pub fn bounds(&self) -> Aabb {
        if let Storage::Sites(sites) = &self.storage {
            let Aabb { min, max } = sites.bounds();
            return Aabb::new(self.metres(min), self.metres(max));
        }
        let mut bounds = self.cell_box([0; 3], self.cells);
        for axis in 0..3 {
            if self.periodic[axis] {
                bounds.min[axis] = f64::NEG_INFINITY;
                bounds.max[axis] = f64::INFINITY;
            }
        }
        bounds
    }

    /// The box of the cells `from..to`, metres.
    pub(crate) fn cell_box(&self, from: [i32; 3], to: [i32; 3]) -> Aabb {
        let corner = |cell: [i32; 3]| {
            let quanta = std::array::from_fn(|axis| {
                (self.first[axis] + i64::from(cell[axis]) * i64::from(self.side[axis])) as f64
            });
            self.metres(DVec3::from_array(quanta))
        };
        Aabb::new(corner(from), corner(to))
    }

    fn metres(&self, quanta: DVec3) -> DVec3 {
        self.quantisation.origin() + quanta * self.quantum()
    }

    fn quanta(&self, point: DVec3) -> DVec3 {
        (point - self.quantisation.origin()) / self.quantum()
    }

    /// Where the ray enters the box of cells: the distance in metres (0 if it starts inside) and
    /// the place. `None` if it misses.
    #[inline]
    #[must_use]
    pub fn enter(&self, ray: &Ray) -> Option<(f64, GridPosition)> {
        if self.grains == 0 {
            return None;
        }
        let (t, t_out) = self.bounds().intersect(ray)?;
        (t < t_out).then(|| (t, self.locate(ray.at(t))))
    }

    /// The place of a point in metres, clamped into the box of cells (wrapped along periodic axes).
    #[inline]
    #[must_use]
    pub fn locate(&self, point: DVec3) -> GridPosition {
        let quanta = self.quanta(point);
        if let Storage::Sites(sites) = &self.storage {
            return sites.locate(quanta);
        }
        let mut cell = [0; 3];
        let mut local = [0.0; 3];
        for axis in 0..3 {
            let side = f64::from(self.side[axis]);
            let from_corner = quanta[axis] - self.first[axis] as f64;
            let index = (from_corner / side).floor();
            let (index, wrapped) = if self.periodic[axis] {
                (index, (index as i64).rem_euclid(i64::from(self.cells[axis])) as i32)
            } else {
                let index = index.clamp(0.0, f64::from(self.cells[axis] - 1));
                (index, index as i32)
            };
            cell[axis] = wrapped;
            let within = (from_corner - index * side).clamp(0.0, side);
            local[axis] = (within + f64::from(self.margin)) as f32;
        }
        GridPosition { cell, local }
    }

    /// A place in metres (in the first period, where the grid is periodic).
    #[inline]
    #[must_use]
    pub fn world(&self, place: GridPosition) -> DVec3 {
        if let Storage::Sites(sites) = &self.storage {
            return self.metres(sites.world(place));
        }
        self.world_of(place.cell, DVec3::from_array(place.local.map(f64::from)))
    }

    /// The place at `local`, cell quanta, of a cell.
    #[inline]
    pub(crate) fn world_of(&self, cell: [i32; 3], local: DVec3) -> DVec3 {
        let quanta = std::array::from_fn(|axis| {
            let corner = self.first[axis] + i64::from(cell[axis]) * i64::from(self.side[axis]);
            corner as f64 + (local[axis] - f64::from(self.margin))
        });
        self.metres(DVec3::from_array(quanta))
    }

    /// The same place told from the cell that holds it; `None` where that is beyond the grid (periodic
    /// or not).
    #[inline]
    #[must_use]
    pub fn settled(&self, place: GridPosition) -> Option<GridPosition> {
        let GridPosition { mut cell, mut local } = place;
        for axis in 0..3 {
            let (side, margin) = (self.side[axis] as f32, self.margin as f32);
            let shift = ((local[axis] - margin) / side).floor();
            cell[axis] += shift as i32;
            local[axis] -= shift * side;
            if !(0..self.cells[axis]).contains(&cell[axis]) {
                return None;
            }
        }
        Some(GridPosition { cell, local })
    }

    /// From a place in the first period to the same one so many periods further, metres.
    pub(crate) fn beyond_first_period(&self, periods: [i32; 3]) -> DVec3 {
        let quanta = |axis: usize| {
            f64::from(periods[axis]) * f64::from(self.cells[axis]) * f64::from(self.side[axis])
        };
        DVec3::from_array(std::array::from_fn(quanta)) * self.quantum()
    }

    /// The entry of a cell, its first block already on the way from memory.
    #[inline(always)]
    pub(crate) fn fetchable_entry(&self, cell: [i32; 3]) -> CellEntry {
        let entry = self.entry(cell);
        self.prefetch_blocks(entry);
        entry
    }

    /// Asks for the blocks of a cell ahead of their use.
    #[inline(always)]
    pub(crate) fn prefetch_blocks(&self, entry: CellEntry) {
        self.blocks[entry.first_block()].prefetch();
        for block in &self.blocks[entry.further_blocks()] {
            block.prefetch();
        }
    }

    /// All blocks.
    pub(crate) fn blocks(&self) -> &[Block] {
        &self.blocks
    }

    /// The shapes of the grains, where they are not all spheres.
    pub(crate) fn shapes(&self) -> Option<&GridShapes> {
        self.shapes.as_ref()
    }

    /// Whether grains have shapes other than spheres.
    #[must_use]
    pub fn has_shapes(&self) -> bool {
        self.shapes.is_some()
    }

    /// Whether any grain has a stratum.
    #[must_use]
    pub fn has_strata(&self) -> bool {
        !self.strata.is_empty()
    }

    /// The strata of the grains of each block; empty where no grain has one.
    pub(crate) fn strata(&self) -> &[BlockStrata] {
        &self.strata
    }

    #[inline(always)]
    pub(crate) fn entry(&self, cell: [i32; 3]) -> CellEntry {
        match &self.storage {
            Storage::Packed(cells) => cells.entry(cell),
            Storage::Lattice(cells) => cells.entry(cell),
            Storage::Sites(_) => CellEntry::EMPTY,
        }
    }

    /// Packs grains into cells, on the threads of the current pool; the result does not depend on
    /// them.
    ///
    /// Cells are as large as the packing and the density of the snow want, and smaller where grains
    /// of very different sizes need it; a cell within a large grain takes a block (128 bytes) too.
    ///
    /// # Errors
    /// Snow whose sizes or extent do not fit the structure.
    pub fn build<'a>(
        quantisation: Quantisation,
        grains: impl Into<GrainParts<'a>>,
        surfaces: &Surfaces,
        packing: Packing,
    ) -> Result<Self, GridError> {
        let around = build::Around { surfaces, strata: &[], words: &[], hulls: &[] };
        build::build(quantisation, grains.into(), around, None, packing)
    }

    /// As [`Self::build`], with the stratum of each grain, at most [`crate::STRATA`], in the order of the
    /// grains.
    ///
    /// # Errors
    /// As [`Self::build`].
    ///
    /// # Panics
    /// If there are not as many strata as grains, or one is too large.
    pub fn build_in_strata<'a>(
        quantisation: Quantisation,
        grains: impl Into<GrainParts<'a>>,
        surfaces: &Surfaces,
        packing: Packing,
        strata: &[u8],
    ) -> Result<Self, GridError> {
        assert!(strata.iter().all(|&stratum| usize::from(stratum) <= STRATA), "strata are few");
        let around = build::Around { surfaces, strata, words: &[], hulls: &[] };
        build::build(quantisation, grains.into(), around, None, packing)
    }

    /// Packs grains that repeat along x and z with the given periods (quanta), over no surfaces.
    /// Grains must lie in `0..period`, and each period must be a multiple of some length of one to
    /// three radii of the largest grain in whole quanta, so that equal cells fill it (the period of
    /// a periodic floor is).
    ///
    /// # Errors
    /// Snow whose sizes or extent do not fit the structure.
    pub fn build_periodic<'a>(
        quantisation: Quantisation,
        grains: impl Into<GrainParts<'a>>,
        period_quanta: [i64; 2],
        packing: Packing,
    ) -> Result<Self, GridError> {
        let surfaces = Surfaces::default();
        let around = build::Around { surfaces: &surfaces, strata: &[], words: &[], hulls: &[] };
        build::build(quantisation, grains.into(), around, Some(period_quanta), packing)
    }

    /// As [`Self::build_periodic`], with strata as [`Self::build_in_strata`].
    ///
    /// # Errors
    /// As there.
    ///
    /// # Panics
    /// As there.
    pub fn build_periodic_in_strata<'a>(
        quantisation: Quantisation,
        grains: impl Into<GrainParts<'a>>,
        period_quanta: [i64; 2],
        packing: Packing,
        strata: &[u8],
    ) -> Result<Self, GridError> {
        assert!(strata.iter().all(|&stratum| usize::from(stratum) <= STRATA), "strata are few");
        let surfaces = Surfaces::default();
        let around = build::Around { surfaces: &surfaces, strata, words: &[], hulls: &[] };
        build::build(quantisation, grains.into(), around, Some(period_quanta), packing)
    }

    /// Packs grains of shapes: their bounding spheres as [`Self::build_in_strata`] does, or where there is a
    /// `period` as [`Self::build_periodic_in_strata`], and their shapes beside them. `strata` may be empty.
    ///
    /// # Errors
    /// As there; a shape that is too long.
    ///
    /// # Panics
    /// As there; if there are not as many shapes as grains.
    pub fn build_shaped(
        quantisation: Quantisation,
        (grains, shapes): (&[QuantisedGrain], ShapedGrains<'_>),
        (surfaces, strata): (&Surfaces, &[u8]),
        period_quanta: Option<[i64; 2]>,
        packing: Packing,
    ) -> Result<Self, GridError> {
        assert!(strata.iter().all(|&stratum| usize::from(stratum) <= STRATA), "strata are few");
        let (spheres, words) = shapes::bounding(grains, shapes)?;
        let hulls: Vec<_> = shapes.prototypes.iter().map(hull::Hull::new).collect();
        let around = build::Around { surfaces, strata, words: &words, hulls: &hulls };
        let mut grid =
            build::build(quantisation, spheres.as_slice().into(), around, period_quanta, packing)?;
        if let Some(grid) = &mut grid.shapes {
            grid.prototypes = shapes.prototypes.iter().map(Prototype::new).collect();
            grid.concentric = shapes::any_concentric(grains);
        }
        Ok(grid)
    }
}
