//! Which grains lie near a point.

use super::block::{Block, LANES};
use super::plan::Plan;
use super::tile::Tile;
use super::window::Window;
use super::{GrainSlot, GrainStacks};
use fearless_simd::prelude::*;
use fearless_simd::{dispatch, f32x16};
use snowgrain_geometry::QuantisedGrain;
use snowgrain_math::DVec3;
use std::borrow::Borrow;

/// Quanta by which single precision, and the whole quanta of a leaning plan, may misplace a distance
/// between grains that nearly meet.
const DISTANCE_MARGIN: f64 = 6.0;

impl GrainStacks {
    /// All grains whose surface comes within `reach` quanta of `center` (quanta): those with
    /// `|grain - center| <= reach + radius`, at the periodic image that does; appended to `out` in
    /// the order of the cells.
    pub fn near(&self, center: DVec3, reach: f64, out: &mut Vec<(GrainSlot, QuantisedGrain)>) {
        self.window().near(center, reach, out);
    }
}

impl<T: Borrow<Tile>> Window<'_, T> {
    /// As [`GrainStacks::near`], among the cells of the window.
    pub(super) fn near(
        &self,
        center: DVec3,
        reach: f64,
        out: &mut Vec<(GrainSlot, QuantisedGrain)>,
    ) {
        dispatch!(self.plan.level, simd => search(simd, self, center, reach, out));
    }
}

#[inline(always)]
fn search<S: Simd, T: Borrow<Tile>>(
    simd: S,
    window: &Window<'_, T>,
    center: DVec3,
    reach: f64,
    out: &mut Vec<(GrainSlot, QuantisedGrain)>,
) {
    let plan = window.plan;
    let widest = reach + f64::from(plan.largest_radius);
    let on_plan = plan.point(center.x, center.z, 0.0);
    let lean = plan.point(0.0, 0.0, center.y);
    let columns = plan.cell_range(on_plan.x - lean.x, widest, 0);
    let rows = plan.cell_range(on_plan.z - lean.z, widest, 1);
    let lowest_top = center.y - reach;
    for row in rows {
        for column in columns.clone() {
            let Some(cell) = window.cell(column, row) else { continue };
            if f64::from(cell.top()) < lowest_top {
                continue;
            }
            for (index, block) in cell.tile.blocks(cell.index) {
                let mut lanes = candidates(simd, block, plan, center, cell.corner, reach);
                while lanes != 0 {
                    let lane = lanes.trailing_zeros() as usize;
                    lanes &= lanes - 1;
                    let grain = plan.grain(block, lane, cell.corner);
                    if comes_within(grain, center, reach) {
                        out.push((cell.tile.slot(index, lane), grain));
                    }
                }
                if f64::from(block.older_top()) < lowest_top {
                    break;
                }
            }
        }
    }
}

fn comes_within(grain: QuantisedGrain, center: DVec3, reach: f64) -> bool {
    let [x, y, z] = grain.center.map(f64::from);
    let widest = reach + f64::from(grain.radius);
    (DVec3::new(x, y, z) - center).length_squared() <= widest * widest
}

/// Lanes that may be near, found in single precision with a margin; never misses one.
#[inline(always)]
fn candidates<S: Simd>(
    simd: S,
    block: &Block,
    plan: &Plan,
    center: DVec3,
    corner: [i64; 2],
    reach: f64,
) -> u32 {
    let lean = plan.point(0.0, 0.0, center.y);
    let x = (center.x - lean.x - corner[0] as f64) as f32;
    let z = (center.z - lean.z - corner[1] as f64) as f32;
    let (drift_x, drift_z) = (plan.drift.x as f32, plan.drift.z as f32);
    // The integer difference is exact; only what is near matters, and near it is exact as f32 too.
    let base = center.y.floor();
    let (base, fraction) = (base as i32, (center.y - base) as f32);
    let reach = (reach + DISTANCE_MARGIN) as f32;
    let mut excess = [0.0f32; LANES];
    for (lane, excess) in excess.iter_mut().enumerate() {
        let dy = block.y[lane].wrapping_sub(base) as f32 - fraction;
        let dx = f32::from(block.x[lane]) - x + dy * drift_x;
        let dz = f32::from(block.z[lane]) - z + dy * drift_z;
        let widest = f32::from(block.radius[lane]) + reach;
        *excess = dx * dx + dy * dy + dz * dz - widest * widest;
    }
    f32x16::from_slice(simd, &excess).simd_le(0.0).to_bitmask() as u32 & block.lanes()
}
