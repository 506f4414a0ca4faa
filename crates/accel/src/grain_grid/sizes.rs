//! How many grains there are in a volume of snow, and how large.

use super::packed_cells::CELLS_PER_BRICK;
use super::{CellEntry, GRAINS_PER_BLOCK, GrainGrid, RADIUS_MASK, Storage};

/// Sums over the grains in a volume; of shapes the radii of the spheres of equal volume.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct SizesPerVolume {
    /// Of the squares of the radii, 1/m.
    pub squared_radii: f64,
    /// Of their cubes.
    pub cubed_radii: f64,
}

impl GrainGrid {
    /// How many grains there are and how large: sums over the volume of the cells that hold any, of each prototype in turn
    /// (one, where grains are spheres). Empty for a lattice of which no cells are kept.
    #[must_use]
    pub fn sizes_per_volume(&self) -> Vec<SizesPerVolume> {
        let mut sums = Sums { grid: self, sizes: Vec::new(), cells: 0.0 };
        match &self.storage {
            Storage::Packed(packed) => {
                let bricks = packed.entries().as_chunks::<CELLS_PER_BRICK>().0;
                let mut times = vec![0u32; bricks.len()];
                packed.for_each_brick(|_, number| times[number] += 1);
                for (brick, times) in bricks.iter().zip(times).filter(|(_, times)| *times > 0) {
                    brick.iter().for_each(|&entry| sums.add(entry, times.into()));
                }
            }
            Storage::Lattice(lattice) => self.for_cells(|cell| sums.add(lattice.entry(cell), 1.0)),
            Storage::Sites(_) => {}
        }
        let volume = self.side.map(f64::from).iter().product::<f64>() * sums.cells;
        for sizes in &mut sums.sizes {
            sizes.squared_radii /= volume * self.quantum();
            sizes.cubed_radii /= volume;
        }
        sums.sizes
    }
}

impl GrainGrid {
    /// Area of the discs of all grains, by their radii, per volume of the cells that hold any, 1/m: what light that goes
    /// straight meets, about 3 phi / (4 r).
    #[must_use]
    pub fn extinction(&self) -> f64 {
        let squares: f64 = self.sizes_per_volume().iter().map(|sizes| sizes.squared_radii).sum();
        core::f64::consts::PI * squares
    }
}

struct Sums<'a> {
    grid: &'a GrainGrid,
    sizes: Vec<SizesPerVolume>,
    cells: f64,
}

impl Sums<'_> {
    /// Adds the grains of a cell that is there so many times.
    fn add(&mut self, entry: CellEntry, times: f64) {
        if entry.first_block() == 0 {
            return;
        }
        self.cells += times;
        for index in entry.blocks() {
            self.add_block(index, times);
        }
    }

    /// Adds the grains of a block whose centres are in its cell, in quanta.
    fn add_block(&mut self, index: usize, times: f64) {
        let grid = self.grid;
        let block = &grid.blocks[index];
        let own = |at: u16, axis: usize| {
            (grid.margin..grid.margin + grid.side[axis]).contains(&i32::from(at))
        };
        for slot in 0..GRAINS_PER_BLOCK {
            if !(own(block.x[slot], 0) && own(block.y[slot], 1) && own(block.z[slot], 2)) {
                continue;
            }
            let (prototype, radius) = match &grid.shapes {
                Some(shapes) => {
                    let word = shapes.blocks[index][slot];
                    let placement = shapes.placement(word, block.radius[slot]);
                    (placement.prototype, placement.radius)
                }
                None => (0, f64::from(block.radius[slot] & RADIUS_MASK)),
            };
            if self.sizes.len() <= prototype {
                self.sizes.resize(prototype + 1, SizesPerVolume::default());
            }
            self.sizes[prototype].squared_radii += times * radius * radius;
            self.sizes[prototype].cubed_radii += times * radius * radius * radius;
        }
    }
}
