//! What a falling ray or sphere meets first.

use super::block::{Block, LANES, NO_BLOCK};
use super::plan::{Drift, Plan};
use super::tile::Tile;
use super::window::{SeenCell, Window};
use super::{GrainSlot, GrainStacks};
use fearless_simd::prelude::*;
use fearless_simd::{dispatch, f32x16};
use snowgrain_geometry::QuantisedGrain;
use std::borrow::Borrow;

/// Single precision misplaces `h = reach^2 - distance^2` by less than this many square quanta (its
/// terms stay below 2^34, each rounded to within 2^-25) ...
const SQUARE_MARGIN: f32 = 4096.0;
/// ... and so the height of a contact by less than the root of twice that, plus what the height
/// itself is rounded by.
const HEIGHT_MARGIN: f64 = 100.0;
/// The same where the line of fall leans: a grain's place on the plan is then off by up to a
/// quantum along each axis, which moves `h` by up to twice that times the greatest reach.
const LEANING_SQUARE_MARGIN: f32 = 150_000.0;
const LEANING_HEIGHT_MARGIN: f64 = 600.0;
/// Heights up to 2^31 round by up to 2^7 in single precision.
const ROUNDED_HEIGHT: f64 = 256.0;

/// A sphere (or, with radius 0, a ray) that falls along the direction of fall; lengths in quanta.
#[derive(Clone, Copy, Debug)]
pub struct Fall<'a> {
    /// Where its line of fall crosses y = 0: where it falls, if it falls straight down.
    pub x: f64,
    /// Where its line of fall crosses y = 0.
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

    /// Whether the highest contact is the answer, whichever grain makes it.
    fn meets_all(&self) -> bool {
        self.from == f64::INFINITY && self.ignored.is_empty()
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
    /// The highest point at which a line of fall meets a grain.
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
        self.window().first_contact(fall)
    }
}

impl<T: Borrow<Tile>> Window<'_, T> {
    /// As [`GrainStacks::first_contact`], among the cells of the window.
    #[inline]
    pub(super) fn first_contact(&self, fall: &Fall<'_>) -> Option<FallHit> {
        if self.plan.drift.is_vertical() {
            dispatch!(self.plan.level, simd => search::<_, _, false>(simd, self, fall))
        } else {
            dispatch!(self.plan.level, simd => search::<_, _, true>(simd, self, fall))
        }
    }
}

/// What has been found so far.
struct Found {
    height: f64,
    hit: Option<(GrainSlot, QuantisedGrain)>,
}

#[inline(always)]
fn search<S: Simd, T: Borrow<Tile>, const LEANING: bool>(
    simd: S,
    window: &Window<'_, T>,
    fall: &Fall<'_>,
) -> Option<FallHit> {
    let plan = window.plan;
    let mut found = Found { height: fall.down_to, hit: None };
    let reach = fall.radius + f64::from(plan.largest_radius);
    let column = plan.nearest_cell_coordinate(fall.x, 0);
    let row = plan.nearest_cell_coordinate(fall.z, 1);
    if let Some(cell) = window.cell(column, row) {
        search_cell::<S, LEANING>(simd, plan, fall, &cell, &mut found);
    }
    let columns = plan.cell_range(fall.x, reach, 0);
    for r in plan.cell_range(fall.z, reach, 1) {
        for c in columns.clone() {
            if (c, r) == (column, row) {
                continue;
            }
            let Some(cell) = window.cell(c, r) else { continue };
            // A contact is never higher than the grain's top plus the falling radius.
            if f64::from(cell.top) + fall.radius >= found.height
                && (LEANING || highest_contact(plan, fall, &cell) > found.height)
            {
                search_cell::<S, LEANING>(simd, plan, fall, &cell, &mut found);
            }
        }
    }
    let height = found.height;
    found.hit.map(|(slot, grain)| FallHit { slot, grain, height })
}

/// Highest contact that grains of a cell can make with what falls straight down.
#[inline(always)]
fn highest_contact(plan: &Plan, fall: &Fall<'_>, cell: &SeenCell<'_>) -> f64 {
    let side = f64::from(plan.side);
    let largest = f64::from(plan.largest_radius);
    let reach = fall.radius + largest;
    let (x0, z0) = (cell.corner[0] as f64, cell.corner[1] as f64);
    let dx = (x0 - fall.x).max(fall.x - (x0 + side)).max(0.0);
    let dz = (z0 - fall.z).max(fall.z - (z0 + side)).max(0.0);
    let square = reach * reach - dx * dx - dz * dz;
    if square < 0.0 {
        return f64::NEG_INFINITY;
    }
    // Of two grains with the same top, the larger lies lower and reaches farther.
    f64::from(cell.top) - largest + square.sqrt() + 1.0
}

#[inline(always)]
fn search_cell<S: Simd, const LEANING: bool>(
    simd: S,
    plan: &Plan,
    fall: &Fall<'_>,
    cell: &SeenCell<'_>,
    found: &mut Found,
) {
    let mut index = cell.newest;
    loop {
        let block = cell.tile.block(index);
        let mut lanes = candidates::<S, LEANING>(simd, block, plan, fall, cell.corner, found.height);
        while lanes != 0 {
            let lane = lanes.trailing_zeros() as usize;
            lanes &= lanes - 1;
            let grain = plan.grain(block, lane, cell.corner);
            let height = contact_height::<LEANING>(&plan.drift, grain, fall);
            if height > found.height && height <= fall.from {
                let slot = cell.tile.slot(index, lane);
                if !fall.ignored.contains(&slot) {
                    *found = Found { height, hit: Some((slot, grain)) };
                }
            }
        }
        index = block.older();
        // A contact is never higher than the grain's top plus the falling radius.
        if index == NO_BLOCK || f64::from(block.older_top()) + fall.radius < found.height {
            return;
        }
    }
}

/// Height of the falling centre when it touches `grain`; `-inf` where it passes.
#[inline(always)]
fn contact_height<const LEANING: bool>(
    drift: &Drift,
    grain: QuantisedGrain,
    fall: &Fall<'_>,
) -> f64 {
    let reach = f64::from(grain.radius) + fall.radius;
    let [x, y, z] = grain.center.map(f64::from);
    if !LEANING {
        let (dx, dz) = (x - fall.x, z - fall.z);
        let square = reach * reach - dx * dx - dz * dz;
        return if square < 0.0 { f64::NEG_INFINITY } else { y + square.sqrt() };
    }
    // Of the line's point at the grain's height; `along` is its part upwards along the line.
    let dx = fall.x + y * drift.x - x;
    let dz = fall.z + y * drift.z - z;
    let along = (dx * drift.x + dz * drift.z) * drift.rise;
    let square = reach * reach - (dx * dx + dz * dz - along * along);
    if square < 0.0 { f64::NEG_INFINITY } else { y + drift.rise * (square.sqrt() - along) }
}

/// Lanes whose contact may be the highest between `best` and the start of the fall, found in single
/// precision with margins; never misses the one that is.
#[inline(always)]
fn candidates<S: Simd, const LEANING: bool>(
    simd: S,
    block: &Block,
    plan: &Plan,
    fall: &Fall<'_>,
    corner: [i64; 2],
    best: f64,
) -> u32 {
    let x = (fall.x - corner[0] as f64) as f32;
    let z = (fall.z - corner[1] as f64) as f32;
    let radius = fall.radius as f32;
    let base = block.y[0];
    let (drift_x, drift_z, rise) =
        (plan.drift.x as f32, plan.drift.z as f32, plan.drift.rise as f32);
    let square_margin = if LEANING { LEANING_SQUARE_MARGIN } else { SQUARE_MARGIN };
    let mut heights = [0.0f32; LANES];
    for (lane, height) in heights.iter_mut().enumerate() {
        let dx = x - f32::from(block.x[lane]);
        let dz = z - f32::from(block.z[lane]);
        let reach = f32::from(block.radius[lane]) + radius;
        let mut square = reach * reach - dx * dx - dz * dz;
        let mut along = 0.0;
        if LEANING {
            along = (dx * drift_x + dz * drift_z) * rise;
            square += along * along;
        }
        let up = if square > 0.0 { square } else { 0.0 }.sqrt();
        let up = if LEANING { rise * (up - along) } else { up };
        let at = (block.y[lane].wrapping_sub(base)) as f32 + up;
        *height = if square > -square_margin { at } else { f32::NEG_INFINITY };
    }
    let margin = if LEANING { LEANING_HEIGHT_MARGIN } else { HEIGHT_MARGIN } + ROUNDED_HEIGHT;
    let above = (best - f64::from(base) - margin) as f32;
    let lanes = f32x16::from_slice(simd, &heights);
    let mut wanted = lanes.simd_gt(above).to_bitmask() as u32 & block.lanes();
    if fall.meets_all() {
        // All but the highest, to within the margins, lose.
        let mut left = wanted & wanted.wrapping_sub(1);
        if left != 0 {
            let mut highest = heights[wanted.trailing_zeros() as usize];
            while left != 0 {
                let height = heights[left.trailing_zeros() as usize];
                highest = if height > highest { height } else { highest };
                left &= left - 1;
            }
            wanted &= lanes.simd_ge(highest - 2.0 * margin as f32).to_bitmask() as u32;
        }
        return wanted;
    }
    let below = (fall.from - f64::from(base) + margin) as f32;
    wanted & lanes.simd_le(below).to_bitmask() as u32
}
