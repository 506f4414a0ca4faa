//! What a falling ray or sphere meets first.

use super::block::{Block, LANES, NO_BLOCK};
use super::{GrainSlot, GrainStacks, SeenCell};
use fearless_simd::prelude::*;
use fearless_simd::{dispatch, f32x16};
use snowgrain_geometry::QuantisedGrain;

/// Single precision misplaces `h = reach^2 - dx^2 - dz^2` by less than this many square quanta
/// (its terms stay below 2^34, each rounded to within 2^-25) ...
const SQUARE_MARGIN: f32 = 4096.0;
/// ... and so the height of a contact by less than the root of twice that, plus what the height
/// itself is rounded by.
const HEIGHT_MARGIN: f32 = 100.0;

/// A sphere (or, with radius 0, a ray) that falls straight down; lengths in quanta.
#[derive(Clone, Copy, Debug)]
pub struct Fall<'a> {
    /// Where it falls.
    pub x: f64,
    /// Where it falls.
    pub z: f64,
    /// Radius of the falling sphere; 0 for a ray.
    pub radius: f64,
    /// Height from which its centre falls; contacts above it do not count.
    pub from: f64,
    /// Contacts at or below this height do not count (something else stops it there).
    pub down_to: f64,
    /// Grains that it does not meet (those it rolls off).
    pub ignored: &'a [GrainSlot],
}

impl Fall<'_> {
    /// A ray or sphere of `radius` from above everything.
    #[must_use]
    pub fn from_above(x: f64, z: f64, radius: f64) -> Self {
        Self { x, z, radius, from: f64::INFINITY, down_to: f64::NEG_INFINITY, ignored: &[] }
    }
}

/// The first grain that a [`Fall`] meets.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FallHit {
    /// Its name.
    pub slot: GrainSlot,
    /// The grain, at the periodic image that is met.
    pub grain: QuantisedGrain,
    /// Height of the falling centre (or of the ray's hit) then, quanta.
    pub height: f64,
}

impl GrainStacks {
    /// The highest point at which a vertical ray from above meets a grain.
    #[must_use]
    pub fn ray_down(&self, x: f64, z: f64) -> Option<FallHit> {
        self.first_contact(&Fall::from_above(x, z, 0.0))
    }

    /// The first contact of a falling sphere of `radius` quanta that starts above everything.
    #[must_use]
    pub fn drop_sphere(&self, x: f64, z: f64, radius: f64) -> Option<FallHit> {
        self.first_contact(&Fall::from_above(x, z, radius))
    }

    /// The first grain that `fall` meets; of two met at the same height, the one in the lower slot
    /// of the cell searched first.
    #[must_use]
    pub fn first_contact(&self, fall: &Fall<'_>) -> Option<FallHit> {
        dispatch!(self.level, simd => search(simd, self, fall))
    }
}

/// What has been found so far.
struct Found {
    height: f64,
    hit: Option<(GrainSlot, QuantisedGrain)>,
}

#[inline(always)]
fn search<S: Simd>(simd: S, stacks: &GrainStacks, fall: &Fall<'_>) -> Option<FallHit> {
    let mut found = Found { height: fall.down_to, hit: None };
    let reach = fall.radius + f64::from(stacks.largest_radius);
    let column = stacks.nearest_cell_coordinate(fall.x, 0);
    let row = stacks.nearest_cell_coordinate(fall.z, 1);
    if let Some(cell) = stacks.seen_cell(column, row) {
        search_cell(simd, stacks, fall, &cell, &mut found);
    }
    let columns = stacks.cell_range(fall.x, reach, 0);
    for r in stacks.cell_range(fall.z, reach, 1) {
        for c in columns.clone() {
            if (c, r) == (column, row) {
                continue;
            }
            let Some(cell) = stacks.seen_cell(c, r) else { continue };
            if highest_contact(stacks, fall, &cell, cell.top) > found.height {
                search_cell(simd, stacks, fall, &cell, &mut found);
            }
        }
    }
    let height = found.height;
    found.hit.map(|(slot, grain)| FallHit { slot, grain, height })
}

/// Highest contact that grains of a cell with tops up to `top` can make.
#[inline(always)]
fn highest_contact(stacks: &GrainStacks, fall: &Fall<'_>, cell: &SeenCell, top: i32) -> f64 {
    let side = f64::from(stacks.side);
    let largest = f64::from(stacks.largest_radius);
    let reach = fall.radius + largest;
    let (x0, z0) = (cell.corner[0] as f64, cell.corner[1] as f64);
    let dx = (x0 - fall.x).max(fall.x - (x0 + side)).max(0.0);
    let dz = (z0 - fall.z).max(fall.z - (z0 + side)).max(0.0);
    let square = reach * reach - dx * dx - dz * dz;
    if square < 0.0 {
        return f64::NEG_INFINITY;
    }
    f64::from(top) - largest + square.sqrt() + 1.0
}

#[inline(always)]
fn search_cell<S: Simd>(
    simd: S,
    stacks: &GrainStacks,
    fall: &Fall<'_>,
    cell: &SeenCell,
    found: &mut Found,
) {
    let mut index = cell.newest;
    loop {
        let block = stacks.block(index);
        let mut lanes = candidates(simd, block, fall, cell.corner, found.height);
        while lanes != 0 {
            let lane = lanes.trailing_zeros() as usize;
            lanes &= lanes - 1;
            let grain = block.grain(lane, cell.corner);
            let height = contact_height(grain, fall);
            if height > found.height && height <= fall.from {
                let slot = GrainSlot::new(index, lane);
                if !fall.ignored.contains(&slot) {
                    *found = Found { height, hit: Some((slot, grain)) };
                }
            }
        }
        index = block.older();
        // A grain's contact is never higher than its top plus the falling radius.
        if index == NO_BLOCK || f64::from(block.older_top()) + fall.radius < found.height {
            return;
        }
    }
}

/// Height of the falling centre when it touches `grain`; `-inf` where it passes.
#[inline(always)]
fn contact_height(grain: QuantisedGrain, fall: &Fall<'_>) -> f64 {
    let reach = f64::from(grain.radius) + fall.radius;
    let dx = f64::from(grain.center[0]) - fall.x;
    let dz = f64::from(grain.center[2]) - fall.z;
    let square = reach * reach - dx * dx - dz * dz;
    if square < 0.0 { f64::NEG_INFINITY } else { f64::from(grain.center[1]) + square.sqrt() }
}

/// Lanes whose contact may lie between `best` and the start of the fall, found in single precision
/// with margins; never misses one.
#[inline(always)]
fn candidates<S: Simd>(
    simd: S,
    block: &Block,
    fall: &Fall<'_>,
    corner: [i64; 2],
    best: f64,
) -> u64 {
    let x = (fall.x - corner[0] as f64) as f32;
    let z = (fall.z - corner[1] as f64) as f32;
    let radius = fall.radius as f32;
    let base = block.y[0];
    let mut heights = [0.0f32; LANES];
    for (lane, height) in heights.iter_mut().enumerate() {
        let dx = f32::from(block.x[lane]) - x;
        let dz = f32::from(block.z[lane]) - z;
        let reach = f32::from(block.radius[lane]) + radius;
        let square = reach * reach - dx * dx - dz * dz;
        let rise = if square > 0.0 { square } else { 0.0 }.sqrt();
        let at = (block.y[lane].wrapping_sub(base)) as f32 + rise;
        *height = if square > -SQUARE_MARGIN { at } else { f32::NEG_INFINITY };
    }
    // Heights up to 2^31 round by up to 2^7 in single precision.
    let margin = f64::from(HEIGHT_MARGIN) + 256.0;
    let above = (best - f64::from(base) - margin) as f32;
    let below = (fall.from - f64::from(base) + margin) as f32;
    let heights = f32x16::from_slice(simd, &heights);
    let wanted = heights.simd_gt(above) & heights.simd_le(below);
    wanted.to_bitmask() & block.lanes()
}
