//! Every grain of a grid, told once, for what is made from them beside light.

use super::packed_cells::{BRICK, CELLS_PER_BRICK};
use super::{CellEntry, GRAINS_PER_BLOCK, GrainGrid, RADIUS_MASK, ShapeWord, Storage};
use snowgrain_geometry::GrainShape;
use snowgrain_math::{Aabb, DVec3};

/// A grain of a grid.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GridGrain {
    /// Centre, metres.
    pub center: DVec3,
    /// Radius, metres; of a shape that of the sphere of equal volume.
    pub radius: f64,
    /// Which of the prototypes of the grid it has the shape of, and how it is turned; `None` in a grid of spheres.
    pub shape: Option<GrainShape>,
    /// Its stratum; 0 is none.
    pub stratum: u8,
}

impl GrainGrid {
    /// Tells every grain whose centre is in the grid, in an order that is always the same; of one period where the grid
    /// repeats.
    ///
    /// Tells nothing in a lattice of grains apart that stores nothing: build it by [`GrainGrid::lattice_in_cells`].
    pub fn for_each_grain(&self, mut tell: impl FnMut(GridGrain)) {
        let quantum = self.quantum();
        self.for_each_cell(|cell, entry| {
            if entry.first_block() == 0 {
                return;
            }
            for index in entry.blocks() {
                for slot in 0..GRAINS_PER_BLOCK {
                    let Some((local, radius)) = self.own_grain(index, slot) else { continue };
                    tell(GridGrain {
                        center: self.world_of(cell, local),
                        radius: radius * quantum,
                        shape: self.shape_of(index, slot),
                        stratum: self.strata.get(index).map_or(0, |strata| strata[slot]),
                    });
                }
            }
        });
    }

    /// The shape of a grain in a block.
    fn shape_of(&self, index: usize, slot: usize) -> Option<GrainShape> {
        let shapes = self.shapes.as_ref()?;
        Some(ShapeWord::of_slot(shapes.blocks[index][slot]).shape())
    }

    /// Every cell that holds anything, and perhaps some that do not.
    fn for_each_cell(&self, mut tell: impl FnMut([i32; 3], CellEntry)) {
        match &self.storage {
            Storage::Packed(packed) => packed.for_each_brick(|brick, number| {
                let entries = &packed.entries()[number * CELLS_PER_BRICK..][..CELLS_PER_BRICK];
                for (within, &entry) in (0..).zip(entries) {
                    let at: [i32; 3] = [within & 7, within >> 3 & 7, within >> 6];
                    let cell = std::array::from_fn(|axis| brick[axis] * BRICK + at[axis]);
                    if (0..3).all(|axis| cell[axis] < self.cells[axis]) {
                        tell(cell, entry);
                    }
                }
            }),
            Storage::Lattice(lattice) => self.for_cells(|cell| tell(cell, lattice.entry(cell))),
            Storage::Sites(_) => {}
        }
    }

    /// The box of all cells, metres; of one period along the axes on which the grid repeats.
    #[must_use]
    pub fn first_period(&self) -> Aabb {
        self.cell_box([0; 3], self.cells)
    }

    /// The axes on which the grid repeats.
    #[must_use]
    pub fn repeats(&self) -> [bool; 3] {
        self.periodic
    }

    /// Centre and radius of a grain whose centre is in the cell that lists it, cell quanta.
    pub(super) fn own_grain(&self, index: usize, slot: usize) -> Option<(DVec3, f64)> {
        let block = &self.blocks[index];
        let center = [block.x[slot], block.y[slot], block.z[slot]].map(i32::from);
        let (low, side) = (self.margin, self.side);
        let is_own = (0..3).all(|axis| (low..low + side[axis]).contains(&center[axis]));
        let radius = match &self.shapes {
            Some(_) if block.radius[slot] & RADIUS_MASK == 0 => 0.0,
            Some(shapes) => shapes.placement(shapes.blocks[index][slot], block.radius[slot]).radius,
            None => f64::from(block.radius[slot] & RADIUS_MASK),
        };
        (is_own && radius > 0.0).then(|| (DVec3::from_array(center.map(f64::from)), radius))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Packing, Surfaces};
    use snowgrain_geometry::Quantisation;
    use snowgrain_math::sampler::{PathKey, numbers};

    #[test]
    fn every_grain_is_told_once() {
        let quantisation = Quantisation::for_grains(DVec3::ZERO, 0.5);
        let random = |index, event| numbers(PathKey::new(2, index, 0), event).map(f64::from);
        let grains: Vec<_> = (0..500)
            .map(|index| {
                let center = DVec3::from_array(random(index, 0)) * DVec3::new(9.0, 7.0, 8.0);
                quantisation.round(center, 0.2 + 0.3 * random(index, 1)[0]).unwrap()
            })
            .collect();
        for packing in [Packing::Fast, Packing::Compact] {
            let grid =
                GrainGrid::build(quantisation, &grains[..], &Surfaces::default(), packing).unwrap();
            let mut told = Vec::new();
            grid.for_each_grain(|grain| told.push((grain.center, grain.radius)));
            assert_eq!(told.len(), grains.len());
            for grain in &grains {
                let center = quantisation.origin()
                    + DVec3::from_array(grain.center.map(f64::from)) * quantisation.quantum();
                let near = |(c, _): &&(DVec3, f64)| c.distance(center) < 1e-9;
                assert_eq!(told.iter().filter(near).count(), 1);
            }
        }
    }
}
