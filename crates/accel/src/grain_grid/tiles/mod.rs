//! Snow that repeats: what its tiles show is kept once.
//!
//! Cells and bricks are cut so that a tile is a whole number of bricks. A brick in which every grain of the tile lies
//! and no surface is near is numbered as the tile's own brick: the kernels see a grid as any other, exact to the last grain,
//! and memory grows with the surface of the snow alone. Bricks at the snow's edge and near surfaces are packed each for itself;
//! those that come out alike are kept once, and so are cells that show what the tile's do.

mod brick;
mod edge;

use super::build::{PAD, longest_side};
use super::packed_cells::BRICK;
use super::{GrainGrid, GridError, PackedCells, Packing, Storage};
use crate::{Surfaces, pages};
use brick::{Contents, TileBricks};
use edge::Shared;
use rayon::prelude::*;
use snowgrain_geometry::{Quantisation, QuantisedGrain};

/// Bricks of the snow that are looked at before what they show is put together.
const BRICKS_AT_ONCE: usize = 1024;

/// What becomes of the grains of tiles whose centres lie in a box.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Extent {
    /// All are there.
    Whole,
    /// None is.
    Empty,
    /// Some may be, or it is not known.
    Part,
}

/// Grains that repeat along all axes, and where they are. All lengths and places in quanta.
#[derive(Clone, Copy)]
pub struct TiledGrains<'a> {
    /// Of each variant of the tile the grains whose centres lie in it, from its low corner: `0..period`. Grains
    /// that reach a face of the tile are the same in all variants and come first, and grains that overlap others, where there are
    /// any, are at least three of the largest radii from all faces or the same, too.
    pub variants: &'a [&'a [QuantisedGrain]],
    /// Edges of the tile: multiples of [`tile_divisor`].
    pub period: [i64; 3],
    /// The low corner of tile (0, 0, 0).
    pub corner: [i64; 3],
    /// Which variant a tile shows.
    pub variant_of: &'a (dyn Fn([i64; 3]) -> usize + Sync),
    /// The box around the centres of all grains, ends included.
    pub bounds: [[i64; 2]; 3],
    /// What becomes of the grains whose centres lie in a box, ends included.
    pub extent: &'a (dyn Fn([[i64; 2]; 3]) -> Extent + Sync),
    /// Whether the grain with its centre in a place is there.
    pub holds: &'a (dyn Fn([i64; 3]) -> bool + Sync),
}

/// A number that the period of a tile must be a multiple of, so that equal cells of a good size fill it: eight
/// times the bricks along it. `radius` is that of the ball of mean volume, and `count` the number of grains in
/// a `volume`, in quanta.
#[must_use]
pub fn tile_divisor(period: f64, radius: f64, count: f64, volume: f64) -> i64 {
    let side = Packing::Fast.cell_side(radius, count / volume, false);
    let bricks = (period / (f64::from(BRICK) * side)).round().max(1.0) as i64;
    bricks * i64::from(BRICK)
}

/// What one brick of the snow shows.
enum Filling {
    Empty,
    /// What the tile's brick of this number does, which has so many grains.
    Tile(u32, u64),
    Own(Contents),
}

/// The cells of tiles, and where bricks lie.
struct Layout<'a> {
    tiled: &'a TiledGrains<'a>,
    quantisation: Quantisation,
    surfaces: &'a Surfaces,
    /// Edges of a cell.
    side: [i32; 3],
    /// Bricks of a tile along each axis.
    bricks: [i64; 3],
    margin: i32,
    largest: i64,
}

impl Layout<'_> {
    /// Edge of a brick along an axis.
    fn edge(&self, axis: usize) -> i64 {
        i64::from(BRICK) * i64::from(self.side[axis])
    }

    /// The number of a brick among those of its tile.
    fn number_in_tile(&self, brick: [i64; 3]) -> usize {
        let [x, y, z] =
            std::array::from_fn(|axis| brick[axis].rem_euclid(self.bricks[axis]) as usize);
        let [along_x, along_y, _] = self.bricks.map(|n| n as usize);
        (z * along_y + y) * along_x + x
    }

    fn bricks_of_tile(&self) -> usize {
        self.bricks.iter().product::<i64>() as usize
    }
}

impl GrainGrid {
    /// Packs grains of tiles, on the threads of the current pool; the result does not depend on them.
    ///
    /// # Errors
    /// Snow whose sizes or extent do not fit the structure; a period that equal cells of a good size do not fill.
    pub fn build_tiled(
        quantisation: Quantisation,
        tiled: &TiledGrains<'_>,
        surfaces: &Surfaces,
        packing: Packing,
    ) -> Result<Self, GridError> {
        let radii = || tiled.variants.iter().flat_map(|grains| grains.iter().map(|g| g.radius));
        let largest = radii().max().unwrap_or(0);
        let margin = i32::from(largest) + PAD;
        let side = sides(tiled, packing, margin)?;
        let layout = Layout {
            tiled,
            quantisation,
            surfaces,
            side,
            bricks: std::array::from_fn(|a| tiled.period[a] / i64::from(side[a] * BRICK)),
            margin,
            largest: i64::from(largest),
        };
        let tiles: Vec<TileBricks> =
            tiled.variants.iter().map(|grains| TileBricks::new(&layout, grains)).collect();
        let mut shared = Shared::new();
        for tile in &tiles {
            let contents: Result<Vec<Contents>, GridError> = (0..layout.bricks_of_tile())
                .into_par_iter()
                .map(|number| tile.contents(&layout, number))
                .collect();
            contents?.into_iter().for_each(|contents| shared.add_of_tile(&contents));
        }
        let (low, counts) = layout.bricks_of_snow()?;
        let count = PackedCells::count_bricks(counts)?;
        let mut table = pages::zeroed::<u32>(count);
        let mut grains = 0;
        for (first, table) in (0..).step_by(BRICKS_AT_ONCE).zip(table.chunks_mut(BRICKS_AT_ONCE)) {
            let fillings: Result<Vec<Filling>, GridError> = (first..first + table.len())
                .into_par_iter()
                .map(|number| {
                    let [x, y] = [counts[0], counts[1]].map(|n| n as usize);
                    let at = [number % x, number / x % y, number / x / y];
                    let brick =
                        std::array::from_fn(|axis| low[axis] + (at[axis] as u64).cast_signed());
                    edge::filling(&layout, &tiles, &shared, brick)
                })
                .collect();
            for (entry, filling) in table.iter_mut().zip(fillings?) {
                (*entry, grains) = match filling {
                    Filling::Empty => (0, grains),
                    Filling::Tile(number, own) => (number, grains + own),
                    Filling::Own(contents) => {
                        let own = contents.grains;
                        (shared.number_of(contents)?, grains + own)
                    }
                };
            }
        }
        let (entries, blocks) = shared.into_parts();
        Ok(Self {
            quantisation,
            first: std::array::from_fn(|a| tiled.corner[a] + low[a] * layout.edge(a)),
            side,
            cells: counts.map(|n| n * BRICK),
            periodic: [false; 3],
            margin,
            storage: Storage::Packed(PackedCells::of(counts, table, entries)),
            blocks,
            strata: Vec::new(),
            shapes: None,
            grains,
        })
    }
}

/// Edges of the cells: of those that divide a tile into bricks, the nearest to what the packing wants.
fn sides(tiled: &TiledGrains<'_>, packing: Packing, margin: i32) -> Result<[i32; 3], GridError> {
    let count: usize = tiled.variants.iter().map(|grains| grains.len()).sum();
    let cubes = tiled.variants.iter().flat_map(|grains| grains.iter());
    let cubes: u64 = cubes.map(|grain| u64::from(grain.radius).pow(3)).sum();
    if count == 0 {
        return Err(GridError::BadPeriod);
    }
    let radius = snowgrain_math::trig::cbrt(cubes as f64 / count as f64).max(1.0);
    let volume = tiled.period.iter().map(|&edge| edge as f64).product::<f64>();
    let density = count as f64 / (volume * tiled.variants.len() as f64);
    let wanted = packing.cell_side(radius, density, false);
    let longest = f64::from(longest_side(margin));
    let mut sides = [0; 3];
    for (side, &period) in sides.iter_mut().zip(&tiled.period) {
        let most = (period as f64 / (f64::from(BRICK) * radius)).max(1.0) as i64;
        let edges = (1..=most).map(|bricks| bricks * i64::from(BRICK));
        let edges = edges.filter(|cells| period % cells == 0).map(|cells| period / cells);
        let miss = |edge: &i64| {
            let ratio = *edge as f64 / wanted;
            ratio.max(1.0 / ratio)
        };
        let fitting = edges.filter(|&edge| edge as f64 <= longest);
        let best = fitting.min_by(|a, b| miss(a).total_cmp(&miss(b)));
        *side = best.ok_or(GridError::BadPeriod)? as i32;
    }
    Ok(sides)
}

impl Layout<'_> {
    /// The bricks that grains may reach, and how many there are along each axis.
    fn bricks_of_snow(&self) -> Result<([i64; 3], [i32; 3]), GridError> {
        let reach = self.largest + i64::from(PAD);
        let (mut low, mut counts) = ([0; 3], [0; 3]);
        for axis in 0..3 {
            let [from, to] = self.tiled.bounds[axis];
            let brick = |at: i64| (at - self.tiled.corner[axis]).div_euclid(self.edge(axis));
            low[axis] = brick(from - reach);
            let count = brick(to + reach) - low[axis] + 1;
            // Cells are counted in 32 bits.
            let fits = i32::try_from(count).ok().filter(|&n| n < i32::MAX / BRICK);
            counts[axis] = fits.ok_or(GridError::TooSparse { bricks: count as u128 })?;
        }
        Ok((low, counts))
    }
}

#[cfg(test)]
mod tests;
