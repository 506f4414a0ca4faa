//! Where sixteen paths leave their cells, or the empty bricks that they cross in one step.

use super::paths::{Group, NOTHING};
use crate::flight::vector::{F, M, Vector, W};
use crate::grain_grid::{CellEntry, GrainGrid, Storage};
use fearless_simd::i32x16;
use fearless_simd::prelude::*;

type I<S> = i32x16<S>;

/// The cells of a grid, as the vectors want them.
#[derive(Clone, Copy, Debug)]
pub(super) struct CellShape {
    pub(super) margin: f32,
    pub(super) side: [f32; 3],
    pub(super) inverse_side: [f32; 3],
    pub(super) cells: [i32; 3],
    /// What a step of one brick along each axis adds to the number of the brick.
    pub(super) brick_steps: [u32; 3],
}

impl CellShape {
    pub(super) fn of(grid: &GrainGrid) -> Self {
        let side = grid.side.map(|side| side as f32);
        Self {
            margin: grid.margin as f32,
            side,
            inverse_side: side.map(|side| 1.0 / side),
            cells: grid.cells,
            brick_steps: match grid.storage() {
                Storage::Packed(cells) => cells.brick_steps(),
                Storage::Lattice(_) | Storage::Sites(_) => [0; 3],
            },
        }
    }
}

/// The way out of each path's cell (or empty brick) along one axis.
#[derive(Clone, Copy)]
pub(super) struct AxisExit<S: Simd> {
    pub(super) distance: F<S>,
    /// Cells that crossing the face moves.
    pub(super) crossing: I<S>,
    /// Least and greatest move where another face is crossed: within an empty brick, else none.
    pub(super) least: I<S>,
    pub(super) greatest: I<S>,
}

#[inline(always)]
fn exit_along<S: Simd>(
    simd: S,
    shape: &CellShape,
    group: &Group,
    axis: usize,
    position: F<S>,
    direction: F<S>,
) -> AxisExit<S> {
    let (none, one, seven) = (I::splat(simd, 0), I::splat(simd, 1), I::splat(simd, 7));
    let margin = F::<S>::splat(simd, shape.margin);
    let side = F::<S>::splat(simd, shape.side[axis]);
    let entry = W::<S>::from_slice(simd, &group.entry);
    let brick = entry.simd_eq(W::<S>::splat(simd, CellEntry::EMPTY_BRICK.0));
    let cell = I::from_slice(simd, &group.cell[axis]);
    let below = brick.select(cell & seven, none);
    // The last brick may reach beyond the grid, where surfaces must be asked for.
    let in_brick = seven - (cell & seven);
    let in_grid = I::splat(simd, shape.cells[axis] - 1) - cell;
    let above = brick.select(in_brick.simd_lt(in_grid).select(in_brick, in_grid), none);
    let forward = direction.simd_gt(F::<S>::splat(simd, 0.0));
    let low = margin - simd.cvt_f32_i32x16(below) * side;
    let high = margin + side + simd.cvt_f32_i32x16(above) * side;
    let parallel = direction.abs().simd_lt(F::<S>::splat(simd, 1.0e-20));
    let divisor = parallel.select(F::<S>::splat(simd, 1.0), direction);
    let distance = (forward.select(high, low) - position) / divisor;
    AxisExit {
        distance: parallel.select(F::<S>::splat(simd, NOTHING), distance),
        crossing: forward.select(above + one, none - below - one),
        least: none - below,
        greatest: above,
    }
}

/// The way out of each path's cell (or empty brick).
#[derive(Clone, Copy)]
pub(super) struct Exit<S: Simd> {
    pub(super) along: [AxisExit<S>; 3],
    /// Which axis it crosses.
    pub(super) by: [M<S>; 3],
    pub(super) distance: F<S>,
}

impl<S: Simd> Exit<S> {
    #[inline(always)]
    pub(super) fn of(
        simd: S,
        shape: &CellShape,
        group: &Group,
        position: Vector<S>,
        direction: Vector<S>,
    ) -> Self {
        let zero = F::<S>::splat(simd, 0.0);
        let along = [
            exit_along(simd, shape, group, 0, position.0, direction.0),
            exit_along(simd, shape, group, 1, position.1, direction.1),
            exit_along(simd, shape, group, 2, position.2, direction.2),
        ];
        let (x, y, z) = (along[0].distance, along[1].distance, along[2].distance);
        let by_x = x.simd_le(y) & x.simd_le(z);
        let by_y = !by_x & y.simd_le(z);
        let by_z = !(by_x | by_y);
        let distance = by_x.select(x, by_y.select(y, z));
        let distance = distance.simd_gt(zero).select(distance, zero);
        Self { along, by: [by_x, by_y, by_z], distance }
    }
}
