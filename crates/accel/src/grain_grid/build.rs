//! Packing grains into cells: count, number, fill, then mark which grains stand alone.

use super::block::{MEETS_SURFACE, OVERLAPS, RADIUS_MASK};
use super::packed_cells::{BRICK, CELLS_PER_BRICK};
use super::{Block, CellEntry, GRAINS_PER_BLOCK, GrainGrid, GridError, PackedCells, Storage};
use crate::Surfaces;
use crate::pages;
use snowgrain_geometry::{Quantisation, QuantisedGrain};
use snowgrain_math::{Aabb, DVec3, trig};

/// Rounding of positions while light moves stays far below one quantum; a grain this close to a
/// cell is listed there too.
pub(super) const PAD: i32 = 1;

/// Grains whose surfaces interpenetrate by less than this many quanta only touch: rounding to the
/// lattice moves two grains by at most 1.74 quanta against each other.
const TOUCH: i64 = 3;

/// Wanted grains listed in a cell that lies within snow: few enough that a block of 16 seldom runs
/// over, many enough that memory and steps from cell to cell stay few.
const GRAINS_PER_CELL: f64 = 10.5;

/// Whether the ball around `center` (relative to the cell's low corner) reaches the cell.
pub(super) fn reaches_cell(center: [i32; 3], radius: u16, side: [i32; 3]) -> bool {
    let reach = i64::from(radius) + i64::from(PAD);
    let distance2: i64 = (0..3)
        .map(|axis| {
            let gap = i64::from((-center[axis]).max(center[axis] - side[axis]).max(0));
            gap * gap
        })
        .sum();
    distance2 <= reach * reach
}

/// Whether two grains interpenetrate by more than rounding explains.
pub(super) fn overlaps(a: [i32; 3], radius_a: u16, b: [i32; 3], radius_b: u16) -> bool {
    // Of the smallest grains a few quanta are a large part.
    let touch = TOUCH.min(i64::from(radius_a.min(radius_b)) / 16);
    let sum = i64::from(radius_a) + i64::from(radius_b) - touch;
    let distance2: i64 = (0..3)
        .map(|axis| {
            let d = i64::from(a[axis]) - i64::from(b[axis]);
            d * d
        })
        .sum();
    sum > 0 && distance2 < sum * sum
}

/// Longest edge of a cell, quanta, such that every grain that reaches into it, from at most `margin`
/// away, has 16-bit coordinates in cell quanta.
pub(super) fn longest_side(margin: i32) -> i32 {
    i32::from(u16::MAX) - 2 * margin
}

/// Edge of the cells in quanta: such that a cell within the snow lists about [`GRAINS_PER_CELL`]
/// grains, at least what keeps a grain within its neighbours' cells, at most what 16 bits hold.
fn choose_side(grains: &[QuantisedGrain], margin: i32) -> Result<i32, GridError> {
    let cubes: f64 = grains.iter().map(|g| cube(f64::from(g.radius))).sum();
    let radius = trig::cbrt(cubes / grains.len().max(1) as f64).max(1.0);
    let ball = 4.0 / 3.0 * std::f64::consts::PI * cube(radius);
    let density = grains.len() as f64 / occupied_volume(grains, 4.0 * radius)?;
    // Grains whose balls reach into a cube of edge s: their centres fill its parallel body.
    let listed = |s: f64| {
        let pi = std::f64::consts::PI;
        density * (cube(s) + 6.0 * s * s * radius + 3.0 * pi * s * radius * radius + ball)
    };
    let mut side = 1.5 * radius;
    while listed(side * 1.02) <= GRAINS_PER_CELL && side < f64::from(u16::MAX) {
        side *= 1.02;
    }
    Ok((side as i32).clamp(margin.max(1), longest_side(margin).max(1)))
}

fn cube(x: f64) -> f64 {
    x * x * x
}

/// Volume of the cells of edge `side` that hold the centre of a grain, in cubic quanta.
fn occupied_volume(grains: &[QuantisedGrain], side: f64) -> Result<f64, GridError> {
    let layout = lay_out(grains, side.ceil() as i32)?;
    let cell_of = |grain: &QuantisedGrain| -> [i32; 3] {
        std::array::from_fn(|axis| {
            let from_corner = i64::from(grain.center[axis]) - layout.first[axis];
            (from_corner / i64::from(layout.side[axis])) as i32
        })
    };
    let mut cells = PackedCells::new(layout.cells)?;
    grains.iter().for_each(|grain| cells.touch(cell_of(grain)));
    cells.seal_bricks(true);
    let mut occupied = vec![false; cells.entries().len()];
    grains.iter().for_each(|grain| occupied[cells.index(cell_of(grain))] = true);
    let count = occupied.iter().filter(|&&held| held).count();
    Ok(count as f64 * cube(f64::from(layout.side[0])))
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

struct Layout {
    first: [i64; 3],
    side: [i32; 3],
    cells: [i32; 3],
    periodic: [bool; 3],
}

/// Cells of edge `side` that cover all grains.
fn lay_out(grains: &[QuantisedGrain], side: i32) -> Result<Layout, GridError> {
    let mut low = [i64::MAX; 3];
    let mut high = [i64::MIN; 3];
    for grain in grains {
        for axis in 0..3 {
            let (c, r) = (i64::from(grain.center[axis]), i64::from(grain.radius) + 2);
            low[axis] = low[axis].min(c - r);
            high[axis] = high[axis].max(c + r);
        }
    }
    let mut layout = Layout { first: low, side: [side; 3], cells: [1; 3], periodic: [false; 3] };
    for axis in 0..3 {
        let cells = (high[axis] - low[axis]) / i64::from(side) + 1;
        layout.cells[axis] =
            i32::try_from(cells).map_err(|_| GridError::TooSparse { bricks: cells as u128 })?;
    }
    Ok(layout)
}

pub(super) fn build(
    quantisation: Quantisation,
    grains: &[QuantisedGrain],
    surfaces: &Surfaces,
    period: Option<[i64; 2]>,
) -> Result<GrainGrid, GridError> {
    let margin = grains.iter().map(|g| i32::from(g.radius)).max().unwrap_or(0) + PAD;
    if grains.is_empty() {
        return Ok(GrainGrid {
            quantisation,
            first: [0; 3],
            side: [1; 3],
            cells: [1; 3],
            periodic: [false; 3],
            margin,
            storage: Storage::Packed(PackedCells::new([1; 3])?),
            blocks: vec![Block::EMPTY],
            grains: 0,
        });
    }
    let mut layout = lay_out(grains, choose_side(grains, margin)?)?;
    if let Some(period) = period {
        layout.repeat(period, margin)?;
    }
    let mut cells = PackedCells::new(layout.cells)?;
    for &grain in grains {
        layout.for_cells(grain, |cell, _| cells.touch(cell));
    }
    let surface_cells = if surfaces.is_empty() {
        Vec::new()
    } else {
        layout.surface_cells(quantisation, surfaces, cells.bricks())
    };
    for &cell in &surface_cells {
        cells.touch(cell);
    }
    // Bricks need not divide a period.
    cells.seal_bricks(layout.periodic == [false; 3]);
    let mut crosses = vec![false; if surface_cells.is_empty() { 0 } else { cells.entries().len() }];
    for &cell in &surface_cells {
        crosses[cells.index(cell)] = true;
    }
    let blocks = fill(&layout, &mut cells, grains, &crosses, margin, quantisation)?;
    let mut grid = GrainGrid {
        quantisation,
        first: layout.first,
        side: layout.side,
        cells: layout.cells,
        periodic: layout.periodic,
        margin,
        storage: Storage::Packed(cells),
        blocks,
        grains: grains.len() as u64,
    };
    mark(&mut grid, &layout, grains, surfaces);
    Ok(grid)
}

/// Counts the grains of each cell, numbers the blocks in the order of the cells, and fills them in
/// the order of the grains.
fn fill(
    layout: &Layout,
    cells: &mut PackedCells,
    grains: &[QuantisedGrain],
    crosses: &[bool],
    margin: i32,
    quantisation: Quantisation,
) -> Result<Vec<Block>, GridError> {
    let mut counts = vec![0u16; cells.entries().len()];
    for &grain in grains {
        layout.for_cells(grain, |cell, _| {
            let count = &mut counts[cells.index(cell)];
            *count = count.saturating_add(1);
        });
    }
    let most = CellEntry::MAX_BLOCKS_PER_CELL * GRAINS_PER_BLOCK;
    let mut next = 1;
    let bricks = cells.entries_mut().iter_mut().zip(&mut counts).enumerate();
    for (index, (entry, count)) in bricks.skip(CELLS_PER_BRICK) {
        let surface = crosses.get(index).copied().unwrap_or(false);
        let in_cell = usize::from(*count);
        if in_cell > most {
            let side = f64::from(layout.side[1]) * quantisation.quantum();
            return Err(GridError::CrowdedCell { count: in_cell, most, side });
        }
        let needed = in_cell.div_ceil(GRAINS_PER_BLOCK);
        if next + needed > CellEntry::MAX_BLOCKS {
            return Err(GridError::TooManyBlocks {
                blocks: next + needed,
                most: CellEntry::MAX_BLOCKS,
            });
        }
        *entry = CellEntry::new(if needed == 0 { 0 } else { next }, needed, surface);
        next += needed;
        *count = 0;
    }
    let mut blocks = pages::filled(next, Block::EMPTY);
    for &grain in grains {
        layout.for_cells(grain, |cell, center| {
            let index = cells.index(cell);
            let slot = usize::from(counts[index]);
            counts[index] += 1;
            let block = cells.entries()[index].blocks().start + slot / GRAINS_PER_BLOCK;
            let center = center.map(|c| (c + margin) as u16);
            blocks[block].set(slot % GRAINS_PER_BLOCK, center, grain.radius);
        });
    }
    Ok(blocks)
}

/// Marks, in every copy of each grain, whether it overlaps another or reaches a surface.
fn mark(grid: &mut GrainGrid, layout: &Layout, grains: &[QuantisedGrain], surfaces: &Surfaces) {
    let Storage::Packed(cells) = &grid.storage else { return };
    let margin = grid.margin;
    let quantum = grid.quantisation.quantum();
    let blocks = &mut grid.blocks;
    for &grain in grains {
        let mut flags = 0;
        let mut near_surface = false;
        layout.for_cells(grain, |cell, center| {
            let entry = cells.entries()[cells.index(cell)];
            near_surface |= entry.has_surface();
            let own = center.map(|c| (c + margin) as u16);
            if flags == 0 && entry.blocks().any(|b| overlaps_any(&blocks[b], own, grain.radius)) {
                flags = OVERLAPS;
            }
        });
        if near_surface {
            let metres = grid.quantisation.grain(grain);
            let reach = DVec3::splat(metres.radius + quantum);
            if surfaces.may_cross(&Aabb::new(metres.center - reach, metres.center + reach)) {
                flags |= MEETS_SURFACE;
            }
        }
        if flags == 0 {
            continue;
        }
        layout.for_cells(grain, |cell, center| {
            let own = center.map(|c| (c + margin) as u16);
            for b in cells.entries()[cells.index(cell)].blocks() {
                let block = &mut blocks[b];
                for slot in 0..GRAINS_PER_BLOCK {
                    let here = [block.x[slot], block.y[slot], block.z[slot]];
                    if here == own && block.radius[slot] & RADIUS_MASK == grain.radius {
                        block.radius[slot] |= flags;
                    }
                }
            }
        });
    }
}

/// Whether a grain overlaps another of the block; an identical twin overlaps too, the grain itself
/// is met once.
fn overlaps_any(block: &Block, center: [u16; 3], radius: u16) -> bool {
    let own = center.map(i32::from);
    let mut met = 0;
    let mut twins = 0;
    for slot in 0..GRAINS_PER_BLOCK {
        let other = [block.x[slot], block.y[slot], block.z[slot]].map(i32::from);
        let other_radius = block.radius[slot] & RADIUS_MASK;
        let hit = other_radius > 0 && overlaps(own, radius, other, other_radius);
        met += u32::from(hit);
        twins += u32::from(hit && other == own && other_radius == radius);
    }
    met > twins.min(1)
}

impl Layout {
    /// Makes the cells repeat along x and z with these periods.
    fn repeat(&mut self, [x, z]: [i64; 2], margin: i32) -> Result<(), GridError> {
        for (axis, length) in [(0, x), (2, z)] {
            if length <= i64::from(margin) {
                return Err(GridError::BadPeriod);
            }
            let cells = periodic_cells(length, self.side[axis], longest_side(margin))?;
            self.first[axis] = 0;
            self.periodic[axis] = true;
            self.side[axis] = (length / cells) as i32;
            self.cells[axis] = cells as i32;
        }
        Ok(())
    }

    /// Calls `visit(cell, center)` for every cell that the grain reaches, with its centre relative
    /// to that cell's low corner.
    fn for_cells(&self, grain: QuantisedGrain, mut visit: impl FnMut([i32; 3], [i32; 3])) {
        let reach = i64::from(grain.radius) + i64::from(PAD);
        let mut from = [0i64; 3];
        let mut to = [0i64; 3];
        for axis in 0..3 {
            let center = i64::from(grain.center[axis]) - self.first[axis];
            let side = i64::from(self.side[axis]);
            from[axis] = (center - reach).div_euclid(side);
            to[axis] = (center + reach).div_euclid(side);
            if !self.periodic[axis] {
                from[axis] = from[axis].max(0);
                to[axis] = to[axis].min(i64::from(self.cells[axis]) - 1);
            }
        }
        for z in from[2]..=to[2] {
            for y in from[1]..=to[1] {
                for x in from[0]..=to[0] {
                    let at = [x, y, z];
                    let center = std::array::from_fn(|axis| {
                        (i64::from(grain.center[axis])
                            - self.first[axis]
                            - at[axis] * i64::from(self.side[axis])) as i32
                    });
                    if reaches_cell(center, grain.radius, self.side) {
                        let cell = std::array::from_fn(|axis| {
                            at[axis].rem_euclid(i64::from(self.cells[axis])) as i32
                        });
                        visit(cell, center);
                    }
                }
            }
        }
    }

    fn cell_box(&self, quantisation: Quantisation, from: [i32; 3], to: [i32; 3]) -> Aabb {
        let corner = |cell: [i32; 3], pad: f64| {
            let quanta: [f64; 3] = std::array::from_fn(|axis| {
                (self.first[axis] + i64::from(cell[axis]) * i64::from(self.side[axis])) as f64 + pad
            });
            quantisation.origin() + DVec3::from_array(quanta) * quantisation.quantum()
        };
        Aabb::new(corner(from, -f64::from(PAD)), corner(to, f64::from(PAD)))
    }

    /// The cells that a surface passes through, found brick by brick.
    fn surface_cells(
        &self,
        quantisation: Quantisation,
        surfaces: &Surfaces,
        bricks: [i32; 3],
    ) -> Vec<[i32; 3]> {
        let mut found = Vec::new();
        let crosses = |from: [i32; 3], to: [i32; 3]| {
            surfaces.may_cross(&self.cell_box(quantisation, from, to))
        };
        for_box([0; 3], bricks, |brick| {
            let from = brick.map(|b| b * BRICK);
            let to: [i32; 3] = std::array::from_fn(|a| (from[a] + BRICK).min(self.cells[a]));
            if crosses(from, to) {
                for_box(from, to, |cell| {
                    if crosses(cell, cell.map(|c| c + 1)) {
                        found.push(cell);
                    }
                });
            }
        });
        found
    }
}

fn for_box(from: [i32; 3], to: [i32; 3], mut visit: impl FnMut([i32; 3])) {
    for z in from[2]..to[2] {
        for y in from[1]..to[1] {
            for x in from[0]..to[0] {
                visit([x, y, z]);
            }
        }
    }
}
