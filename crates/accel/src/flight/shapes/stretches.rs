//! The straight stretches of sixteen paths, in double precision: where each leaves its cell, and where it goes on after
//! a chord.
//!
//! What `Lane` and `air` do with one path, by the same arithmetic. A path is in one of the two: it is taken from here
//! (`land`) where it needs what few paths need, and put here (`board`) when it is in air again.

use super::GROUP;
use super::lane::Cells;
use super::near::Window;
use super::slabs::{D, Truth, Vectors, WIDTH};
use super::visits::Visits;
use crate::grain_grid::CellEntry;
use fearless_simd::prelude::*;
use fearless_simd::{f32x16, f64x8, i32x16, mask32x16, mask64x8, u32x16};
use snowgrain_math::DVec3;

/// The stretches of a group. Lengths in quanta.
#[derive(Clone, Debug)]
pub(super) struct Stretches {
    /// Paths in air.
    pub(super) air: u32,
    /// Paths at the end of a chord in a grain that other ice may overlap: the stretch begins there.
    pub(super) asking: u32,
    /// Paths that have come to another cell, of which it is not known yet what it holds.
    pub(super) moved: u32,
    pub(super) origin: [[f64; GROUP]; 3],
    pub(super) direction: [[f64; GROUP]; 3],
    pub(super) inverse: [[f64; GROUP]; 3],
    /// From the home cell to the present one.
    pub(super) offset: [[f64; GROUP]; 3],
    pub(super) travelled: [f64; GROUP],
    pub(super) cell: [[i32; GROUP]; 3],
    pub(super) home: [[i32; GROUP]; 3],
    /// The brick of the cell, its place there, and what it holds.
    pub(super) brick: [u32; GROUP],
    pub(super) within_brick: [u32; GROUP],
    pub(super) entry: [u32; GROUP],
    /// The part on which the path stands, which it does not meet: of no word where it stands on none.
    pub(super) own_center: [[f64; GROUP]; 3],
    pub(super) own_radius: [f64; GROUP],
    pub(super) own_word: [u64; GROUP],
    pub(super) own_part: [u16; GROUP],
    /// Paths that do not meet any grain with the centre of that part: it is its grain's only one.
    pub(super) alone: u32,
    /// Where the nearest grain that is known is entered; infinite where none is. The grain stands in `Visits`.
    pub(super) nearest: [f64; GROUP],
    /// Where the cell is left.
    pub(super) exit: [f64; GROUP],
    /// Paths that leave it across each axis, and those that go upwards.
    crosses: [u32; 3],
    upwards: [u32; 3],
    /// Place, direction, and where spheres that may be met end, as blocks are asked.
    pub(super) position: [[f32; GROUP]; 3],
    pub(super) course: [[f32; GROUP]; 3],
    last: [f32; GROUP],
    /// Those whose stretch begins in the cell.
    begins: u32,
    /// The centre, in the cell, of the grain that is not to be met.
    pub(super) own: [[f32; GROUP]; 3],
}

impl Default for Stretches {
    fn default() -> Self {
        Self {
            air: 0,
            asking: 0,
            moved: 0,
            origin: [[0.0; GROUP]; 3],
            direction: [[0.0; GROUP]; 3],
            inverse: [[0.0; GROUP]; 3],
            offset: [[0.0; GROUP]; 3],
            travelled: [0.0; GROUP],
            cell: [[0; GROUP]; 3],
            home: [[0; GROUP]; 3],
            brick: [0; GROUP],
            within_brick: [0; GROUP],
            entry: [0; GROUP],
            own_center: [[0.0; GROUP]; 3],
            own_radius: [0.0; GROUP],
            own_word: [0; GROUP],
            own_part: [0; GROUP],
            alone: 0,
            nearest: [f64::INFINITY; GROUP],
            exit: [0.0; GROUP],
            crosses: [0; 3],
            upwards: [0; 3],
            position: [[0.0; GROUP]; 3],
            course: [[0.0; GROUP]; 3],
            last: [0.0; GROUP],
            begins: 0,
            own: [[0.0; GROUP]; 3],
        }
    }
}

/// Takes the first of a set of lanes out of it.
#[inline(always)]
pub(super) fn next(lanes: &mut u32) -> Option<usize> {
    let at = lanes.trailing_zeros() as usize & (GROUP - 1);
    let any = *lanes != 0;
    *lanes &= lanes.wrapping_sub(1);
    any.then_some(at)
}

/// One vector of an array of vectors.
#[inline(always)]
pub(super) fn vector(axes: &[[f64; GROUP]; 3], at: usize) -> DVec3 {
    DVec3::new(axes[0][at], axes[1][at], axes[2][at])
}

#[inline(always)]
pub(super) fn set_vector(axes: &mut [[f64; GROUP]; 3], at: usize, vector: DVec3) {
    for axis in 0..3 {
        axes[axis][at] = vector[axis];
    }
}

/// Copies one column of rows.
pub(super) fn copy_column<T: Copy, const N: usize>(
    rows: &mut [[T; GROUP]; N],
    to: usize,
    source: &[[T; GROUP]; N],
    from: usize,
) {
    for (row, theirs) in rows.iter_mut().zip(source) {
        row[to] = theirs[from];
    }
}

/// Those of the eight paths from `first` on.
#[inline(always)]
fn truth<S: Simd>(simd: S, lanes: u32, first: usize) -> Truth<S> {
    mask64x8::from_bitmask(simd, u64::from(lanes >> first & ((1 << WIDTH) - 1)))
}

#[inline(always)]
fn load<S: Simd>(simd: S, row: &[f64; GROUP], first: usize) -> D<S> {
    D::<S>::from_slice(simd, &row[first..first + WIDTH])
}

/// Stores sixteen numbers in single precision.
#[inline(always)]
fn narrow<S: Simd>(simd: S, row: &mut [f32; GROUP], [low, high]: [D<S>; 2]) {
    let both: f32x16<S> = simd.narrow_f64x8(low, high);
    both.store_slice(row);
}

/// Stores what belongs to `lanes`.
#[inline(always)]
fn store<S: Simd>(simd: S, lanes: Truth<S>, value: D<S>, row: &mut [f64; GROUP], first: usize) {
    let before = load(simd, row, first);
    lanes.select(value, before).store_slice(&mut row[first..first + WIDTH]);
}

impl Stretches {
    /// Forgets a path.
    #[inline(always)]
    pub(super) fn end(&mut self, at: usize) {
        self.air &= !(1 << at);
        self.asking &= !(1 << at);
        self.moved &= !(1 << at);
    }

    /// Copies the path at `from` of `source` to `to`.
    pub(super) fn copy(&mut self, to: usize, source: &Self, from: usize) {
        for (rows, theirs) in [
            (&mut self.origin, &source.origin),
            (&mut self.direction, &source.direction),
            (&mut self.inverse, &source.inverse),
            (&mut self.offset, &source.offset),
            (&mut self.own_center, &source.own_center),
        ] {
            copy_column(rows, to, theirs, from);
        }
        copy_column(&mut self.cell, to, &source.cell, from);
        copy_column(&mut self.home, to, &source.home, from);
        self.travelled[to] = source.travelled[from];
        self.entry[to] = source.entry[from];
        self.own_radius[to] = source.own_radius[from];
        self.own_word[to] = source.own_word[from];
        self.own_part[to] = source.own_part[from];
        self.nearest[to] = source.nearest[from];
        self.end(to);
        self.alone &= !(1 << to);
        self.alone |= (source.alone >> from & 1) << to;
        self.air |= (source.air >> from & 1) << to;
        self.moved |= (source.moved >> from & 1) << to;
        self.brick[to] = source.brick[from];
        self.within_brick[to] = source.within_brick[from];
        self.asking |= (source.asking >> from & 1) << to;
    }

    /// Where each path leaves its cell, and what the blocks there are to be asked.
    #[inline(always)]
    pub(super) fn look_ahead<S: Simd>(&mut self, simd: S, cells: &Cells, concentric: bool) {
        // Where grains share centres, these do not tell which is which.
        let alone = if concentric { 0 } else { self.alone };
        (self.crosses, self.upwards, self.begins) = ([0; 3], [0; 3], 0);
        let low = self.look_ahead_eight(simd, cells, 0);
        let high = self.look_ahead_eight(simd, cells, WIDTH);
        narrow(simd, &mut self.position[0], [low.0.0, high.0.0]);
        narrow(simd, &mut self.position[1], [low.0.1, high.0.1]);
        narrow(simd, &mut self.position[2], [low.0.2, high.0.2]);
        narrow(simd, &mut self.last, [low.1, high.1]);
        for axis in 0..3 {
            let row = &self.direction[axis];
            let both = [load(simd, row, 0), load(simd, row, WIDTH)];
            narrow(simd, &mut self.course[axis], both);
            let own = [self.own(simd, alone, axis, 0), self.own(simd, alone, axis, WIDTH)];
            narrow(simd, &mut self.own[axis], own);
        }
    }

    /// The centre, in the cell, of the grain that is not to be met, of the eight paths from `first` on.
    #[inline(always)]
    fn own<S: Simd>(&self, simd: S, alone: u32, axis: usize, first: usize) -> D<S> {
        let center = load(simd, &self.own_center[axis], first);
        let local = center - load(simd, &self.offset[axis], first);
        truth(simd, alone, first).select(local, f64x8::splat(simd, -1.0))
    }

    #[inline(always)]
    fn look_ahead_eight<S: Simd>(
        &mut self,
        simd: S,
        cells: &Cells,
        first: usize,
    ) -> (Vectors<S>, D<S>) {
        let splat = |x: f64| f64x8::splat(simd, x);
        let zero = splat(0.0);
        let mut exit = splat(f64::INFINITY);
        let mut by = [mask64x8::splat(simd, false); 3];
        for axis in 0..3 {
            let low = splat(cells.margin) + load(simd, &self.offset[axis], first);
            let direction = load(simd, &self.direction[axis], first);
            let upwards = direction.simd_gt(zero);
            let face = upwards.select(low + splat(cells.side[axis]), low);
            let origin = load(simd, &self.origin[axis], first);
            let distance = (face - origin) * load(simd, &self.inverse[axis], first);
            let sooner = !direction.simd_eq(zero) & distance.simd_lt(exit);
            exit = sooner.select(distance, exit);
            for other in &mut by[..axis] {
                *other &= !sooner;
            }
            by[axis] = sooner;
            self.upwards[axis] |= (upwards.to_bitmask() as u32) << first;
        }
        for (crosses, by) in self.crosses.iter_mut().zip(by) {
            *crosses |= (by.to_bitmask() as u32) << first;
        }
        let travelled = load(simd, &self.travelled, first);
        let exit = exit.simd_gt(travelled).select(exit, travelled);
        exit.store_slice(&mut self.exit[first..first + WIDTH]);
        let nearest = load(simd, &self.nearest, first);
        let last = nearest.simd_lt(exit).select(nearest, exit) - travelled;
        self.begins |= (travelled.simd_le(zero).to_bitmask() as u32) << first;
        let origin = Vectors::load(simd, &self.origin, first);
        let direction = Vectors::load(simd, &self.direction, first);
        let local = origin.plus(direction, travelled);
        let local = local.minus(Vectors::load(simd, &self.offset, first));
        (local, last)
    }

    /// What of the stretch of a path lies in its cell.
    #[inline(always)]
    pub(super) fn window(&self, at: usize) -> Window {
        Window { begins: self.begins >> at & 1 != 0, last: self.last[at] }
    }

    /// Paths in air that enter the nearest grain before they leave their cell.
    #[inline(always)]
    pub(super) fn hits<S: Simd>(&self, simd: S) -> u32 {
        let of = |first: usize| {
            let nearest = load(simd, &self.nearest, first);
            (nearest.simd_le(load(simd, &self.exit, first)).to_bitmask() as u32) << first
        };
        (of(0) | of(WIDTH)) & self.air
    }

    /// Lets these paths go on to their next cells; those that stay, as they would leave the grid.
    #[inline(always)]
    pub(super) fn leave_cells<S: Simd>(&mut self, simd: S, cells: &Cells, lanes: u32) -> u32 {
        let none = i32x16::splat(simd, 0);
        let one = i32x16::splat(simd, 1);
        let set = |lanes: u32| mask32x16::from_bitmask(simd, u64::from(lanes));
        let mut moved = [none; 3];
        let mut outside = 0;
        for (axis, moved) in moved.iter_mut().enumerate() {
            let up = set(lanes & self.crosses[axis] & self.upwards[axis]);
            let down = set(lanes & self.crosses[axis] & !self.upwards[axis]);
            let cell = i32x16::from_slice(simd, &self.cell[axis]);
            *moved = cell + up.select(one, none) - down.select(one, none);
            let last = i32x16::splat(simd, cells.counts[axis] - 1);
            let beyond = moved.simd_lt(none) | moved.simd_gt(last);
            outside |= beyond.to_bitmask() as u32;
        }
        let stay = lanes & outside;
        let go = lanes & !outside;
        self.moved |= go;
        for (row, moved) in self.cell.iter_mut().zip(moved) {
            set(go).select(moved, i32x16::from_slice(simd, row)).store_slice(row);
        }
        for first in [0, WIDTH] {
            let exit = load(simd, &self.exit, first);
            store(simd, truth(simd, go, first), exit, &mut self.travelled, first);
            for axis in 0..3 {
                let crosses = truth(simd, go & self.crosses[axis], first);
                let side = D::<S>::splat(simd, cells.side[axis]);
                let zero = D::<S>::splat(simd, 0.0);
                let step = truth(simd, self.upwards[axis], first).select(side, zero - side);
                let offset = load(simd, &self.offset[axis], first);
                store(simd, crosses, offset + step, &mut self.offset[axis], first);
            }
        }
        stay
    }

    /// Begins stretches where these paths stand in their grains, along the directions that they have there; they stand on
    /// these grains. Those whose cells are beyond the grid.
    #[inline(always)]
    pub(super) fn begin<S: Simd>(
        &mut self,
        simd: S,
        cells: &Cells,
        lanes: u32,
        grains: &mut Visits,
    ) -> u32 {
        let low = self.begin_eight(simd, cells, (lanes, 0), grains);
        let high = self.begin_eight(simd, cells, (lanes, WIDTH), grains);
        let none = i32x16::splat(simd, 0);
        let these = mask32x16::from_bitmask(simd, u64::from(lanes));
        let mut outside = 0;
        for axis in 0..3 {
            let steps: f32x16<S> = simd.narrow_f64x8(low[axis], high[axis]);
            let steps: i32x16<S> = these.select(steps, f32x16::splat(simd, 0.0)).to_int();
            self.moved |= lanes & !(steps.simd_eq(none).to_bitmask() as u32);
            let before = i32x16::from_slice(simd, &self.cell[axis]);
            let cell = before + steps;
            cell.store_slice(&mut self.cell[axis]);
            let home = i32x16::from_slice(simd, &self.home[axis]);
            these.select(cell, home).store_slice(&mut self.home[axis]);
            let last = i32x16::splat(simd, cells.counts[axis] - 1);
            outside |= (cell.simd_lt(none) | cell.simd_gt(last)).to_bitmask() as u32;
        }
        let mut rest = lanes;
        while let Some(at) = next(&mut rest) {
            (self.own_word[at], self.own_part[at]) = (grains.word(at), 0);
            self.own_radius[at] = grains.radius(at);
        }
        self.alone |= lanes;
        outside & lanes
    }

    /// The same of the eight paths from `first` on; by how many cells each moves.
    #[inline(always)]
    fn begin_eight<S: Simd>(
        &mut self,
        simd: S,
        cells: &Cells,
        (lanes, first): (u32, usize),
        grains: &mut Visits,
    ) -> [D<S>; 3] {
        let splat = |x: f64| D::<S>::splat(simd, x);
        let these = truth(simd, lanes, first);
        let [place, direction, center] = grains.in_the_world(simd, first);
        let (mut origins, mut steps) = ([place.0, place.1, place.2], [splat(0.0); 3]);
        let (directions, mut centers) =
            ([direction.0, direction.1, direction.2], [center.0, center.1, center.2]);
        for axis in 0..3 {
            let offset = load(simd, &self.offset[axis], first);
            let local = origins[axis] - offset;
            let inverse = splat(cells.inverse_side[axis]);
            steps[axis] = ((local - splat(cells.margin)) * inverse).floor();
            let offset = offset + steps[axis] * splat(cells.side[axis]);
            origins[axis] -= offset;
            centers[axis] -= offset;
            store(simd, these, origins[axis], &mut self.origin[axis], first);
            store(simd, these, directions[axis], &mut self.direction[axis], first);
            let inverse = splat(1.0) / directions[axis];
            store(simd, these, inverse, &mut self.inverse[axis], first);
            store(simd, these, splat(0.0), &mut self.offset[axis], first);
            store(simd, these, centers[axis], &mut self.own_center[axis], first);
            store(simd, these, centers[axis], &mut grains.center[axis], first);
        }
        store(simd, these, splat(0.0), &mut self.travelled, first);
        store(simd, these, splat(f64::INFINITY), &mut self.nearest, first);
        steps
    }

    /// Whether the stretch of a path began on a grain.
    #[inline(always)]
    pub(super) fn stands_on_ice(&self, at: usize) -> bool {
        self.own_word[at] != 0
    }

    /// Whether a grain, whose centre is told from the cell, is the one that a path stands on.
    #[inline(always)]
    pub(super) fn is_own(&self, at: usize, center: DVec3, word: u64) -> bool {
        let is_same = || center + vector(&self.offset, at) == vector(&self.own_center, at);
        word == self.own_word[at] && is_same()
    }

    /// Paths in air that cross an empty brick, or in whose cell a surface lies.
    #[inline(always)]
    pub(super) fn rare<S: Simd>(&self, simd: S) -> u32 {
        let entry = u32x16::from_slice(simd, &self.entry);
        let surface = (entry & CellEntry::SURFACE).simd_gt(u32x16::splat(simd, 0));
        let empty = entry.simd_eq(u32x16::splat(simd, CellEntry::EMPTY_BRICK.0));
        self.air & (surface | empty).to_bitmask() as u32
    }

    /// Finds the bricks of the cells, by what a step of one brick along each axis adds to its number.
    #[inline(always)]
    pub(super) fn find_bricks<S: Simd>(&mut self, simd: S, brick_steps: [u32; 3]) {
        let (mut brick, mut within) = (u32x16::splat(simd, 0), u32x16::splat(simd, 0));
        for (axis, step) in brick_steps.into_iter().enumerate() {
            let cell: u32x16<S> = i32x16::from_slice(simd, &self.cell[axis]).bitcast();
            brick += (cell >> 3) * u32x16::splat(simd, step);
            within |= (cell & 7) << (3 * axis as u32);
        }
        brick.store_slice(&mut self.brick);
        within.store_slice(&mut self.within_brick);
    }

    /// The point at `t` of a stretch, in cell quanta of the present cell.
    pub(super) fn local(&self, at: usize, t: f64) -> DVec3 {
        let (origin, direction) = (vector(&self.origin, at), vector(&self.direction, at));
        origin + direction * t - vector(&self.offset, at)
    }

    #[inline(always)]
    pub(super) fn cell_of(&self, at: usize) -> [i32; 3] {
        [self.cell[0][at], self.cell[1][at], self.cell[2][at]]
    }
}
