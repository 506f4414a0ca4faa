//! Which grains lie near a point.

use super::block::{Block, LANES};
use super::{GrainSlot, GrainStacks};
use fearless_simd::prelude::*;
use fearless_simd::{dispatch, f32x16};
use snowgrain_geometry::QuantisedGrain;
use snowgrain_math::DVec3;

/// Quanta by which single precision may misplace a distance between grains that nearly meet.
const DISTANCE_MARGIN: f64 = 4.0;

impl GrainStacks {
    /// All grains whose surface comes within `reach` quanta of `center` (quanta): those with
    /// `|grain - center| <= reach + radius`, at the periodic image that does; appended to `out` in
    /// the order of the cells.
    pub fn near(&self, center: DVec3, reach: f64, out: &mut Vec<(GrainSlot, QuantisedGrain)>) {
        dispatch!(self.level, simd => search(simd, self, center, reach, out));
    }
}

#[inline(always)]
fn search<S: Simd>(
    simd: S,
    stacks: &GrainStacks,
    center: DVec3,
    reach: f64,
    out: &mut Vec<(GrainSlot, QuantisedGrain)>,
) {
    let widest = reach + f64::from(stacks.largest_radius);
    let columns = stacks.cell_range(center.x, widest, 0);
    let rows = stacks.cell_range(center.z, widest, 1);
    let lowest_top = center.y - reach;
    for row in rows {
        for column in columns.clone() {
            let Some(cell) = stacks.seen_cell(column, row) else { continue };
            if f64::from(cell.top) < lowest_top {
                continue;
            }
            for (index, block) in stacks.blocks_from(cell.newest) {
                let mut lanes = candidates(simd, block, center, cell.corner, reach);
                while lanes != 0 {
                    let lane = lanes.trailing_zeros() as usize;
                    lanes &= lanes - 1;
                    let grain = block.grain(lane, cell.corner);
                    if comes_within(grain, center, reach) {
                        out.push((GrainSlot::new(index, lane), grain));
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
fn candidates<S: Simd>(simd: S, block: &Block, center: DVec3, corner: [i64; 2], reach: f64) -> u64 {
    let x = (center.x - corner[0] as f64) as f32;
    let z = (center.z - corner[1] as f64) as f32;
    // The integer difference is exact; only what is near matters, and near it is exact as f32 too.
    let base = center.y.floor();
    let (base, fraction) = (base as i32, (center.y - base) as f32);
    let reach = (reach + DISTANCE_MARGIN) as f32;
    let mut excess = [0.0f32; LANES];
    for (lane, excess) in excess.iter_mut().enumerate() {
        let dx = f32::from(block.x[lane]) - x;
        let dy = block.y[lane].wrapping_sub(base) as f32 - fraction;
        let dz = f32::from(block.z[lane]) - z;
        let widest = f32::from(block.radius[lane]) + reach;
        *excess = dx * dx + dy * dy + dz * dz - widest * widest;
    }
    f32x16::from_slice(simd, &excess).simd_le(0.0).to_bitmask() & block.lanes()
}
