//! What a falling ray or sphere meets first.

use super::block::{Block, LANES, NO_BLOCK};
use super::plan::{Drift, Plan};
use super::tile::Tile;
use super::window::{Quad, SeenCell, Window};
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
        let reach = fall.radius + f64::from(self.plan.largest_radius);
        self.first_contact_at(&self.quad(fall.x, fall.z, reach), fall)
    }

    /// The same, with the four cells nearest to the line of fall already looked up.
    #[inline]
    pub(super) fn first_contact_at(&self, quad: &Quad, fall: &Fall<'_>) -> Option<FallHit> {
        if self.plan.drift.is_vertical() {
            dispatch!(self.plan.level, simd => search::<_, _, false>(simd, self, quad, fall))
        } else {
            dispatch!(self.plan.level, simd => search::<_, _, true>(simd, self, quad, fall))
        }
    }
}

/// What has been found so far.
struct Found {
    height: f64,
    hit: Option<(GrainSlot, QuantisedGrain)>,
}

impl Found {
    /// Keeps the grain of a lane if it is met higher.
    #[inline(always)]
    fn try_lane<const LEANING: bool>(
        &mut self,
        plan: &Plan,
        fall: &Fall<'_>,
        cell: &SeenCell<'_>,
        [index, lane]: [u32; 2],
    ) {
        let grain = plan.grain(cell.tile.block(index), lane as usize, cell.corner);
        let height = contact_height::<LEANING>(&plan.drift, grain, fall);
        if height > self.height && height <= fall.from {
            let slot = cell.tile.slot(index, lane as usize);
            if !fall.ignored.contains(&slot) {
                *self = Self { height, hit: Some((slot, grain)) };
            }
        }
    }
}

#[inline(always)]
fn search<S: Simd, T: Borrow<Tile>, const LEANING: bool>(
    simd: S,
    window: &Window<'_, T>,
    quad: &Quad,
    fall: &Fall<'_>,
) -> Option<FallHit> {
    let plan = window.plan;
    let mut found = Found { height: fall.down_to, hit: None };
    search_quad::<S, T, LEANING>(simd, window, quad, fall, &mut found);
    let [columns, rows] = quad.spans;
    if quad.is_all() {
        let height = found.height;
        return found.hit.map(|(slot, grain)| FallHit { slot, grain, height });
    }
    for row in rows.low..=rows.high {
        for column in columns.low..=columns.high {
            if quad.holds(column, row) {
                continue;
            }
            let Some(cell) = window.cell(column, row) else { continue };
            if may_beat::<LEANING>(plan, fall, cell.corner, cell.top, found.height) {
                search_cell::<S, LEANING>(simd, plan, fall, &cell, cell.newest, &mut found);
            }
        }
    }
    let height = found.height;
    found.hit.map(|(slot, grain)| FallHit { slot, grain, height })
}

/// Searches the four nearest cells: first their newest blocks, all four without a branch between
/// them, then what is older as far as it can matter.
#[inline(always)]
fn search_quad<S: Simd, T: Borrow<Tile>, const LEANING: bool>(
    simd: S,
    window: &Window<'_, T>,
    quad: &Quad,
    fall: &Fall<'_>,
    found: &mut Found,
) {
    let plan = window.plan;
    let Some(cells) = window.full_cells(quad) else {
        for which in 0..4 {
            let Some(cell) = window.quad_cell(quad, which) else { continue };
            search_cell::<S, LEANING>(simd, plan, fall, &cell, cell.newest, found);
        }
        return;
    };
    if !fall.meets_all() {
        for cell in &cells {
            if may_beat::<LEANING>(plan, fall, cell.corner, cell.top, found.height) {
                search_cell::<S, LEANING>(simd, plan, fall, cell, cell.newest, found);
            }
        }
        return;
    }
    let base = cells[0].top;
    let mut heights = [[0.0f32; LANES]; 4];
    let mut most = [f32::NEG_INFINITY; LANES];
    for (cell, heights) in cells.iter().zip(&mut heights) {
        let block = cell.tile.block(cell.newest);
        contact_heights::<LEANING>(block, plan, fall, (cell.corner, base), heights, &mut most);
    }
    let mut width = LANES / 2;
    while width > 0 {
        for lane in 0..width {
            most[lane] =
                if most[lane + width] > most[lane] { most[lane + width] } else { most[lane] };
        }
        width /= 2;
    }
    // All but the highest of those that are surely met, to within the margins, lose.
    let best = if most[0] > f32::MIN { most[0] } else { f32::MIN };
    let least = f32x16::splat(simd, best - 2.0 * margin::<LEANING>() as f32);
    let mut lanes = 0u64;
    for (which, heights) in heights.iter().enumerate() {
        let wanted = f32x16::from_slice(simd, heights).simd_ge(least).to_bitmask() as u16;
        lanes |= u64::from(wanted) << (16 * which);
    }
    while lanes != 0 {
        let at = lanes.trailing_zeros();
        lanes &= lanes - 1;
        let cell = &cells[at as usize / LANES];
        found.try_lane::<LEANING>(plan, fall, cell, [cell.newest, at % LANES as u32]);
    }
    for cell in &cells {
        let block = cell.tile.block(cell.newest);
        let older = block.older();
        if older != NO_BLOCK
            && may_beat::<LEANING>(plan, fall, cell.corner, block.older_top(), found.height)
        {
            search_cell::<S, LEANING>(simd, plan, fall, cell, older, found);
        }
    }
}

/// Whether grains of a cell with tops up to `top` may be met at or above `height`.
#[inline(always)]
fn may_beat<const LEANING: bool>(
    plan: &Plan,
    fall: &Fall<'_>,
    corner: [i64; 2],
    top: i32,
    height: f64,
) -> bool {
    // A contact is never higher than the grain's top plus the falling radius.
    f64::from(top) + fall.radius >= height
        && (LEANING || highest_contact(plan, fall, corner, top) > height)
}

/// Highest contact that grains of a cell can make with what falls straight down.
#[inline(always)]
fn highest_contact(plan: &Plan, fall: &Fall<'_>, corner: [i64; 2], top: i32) -> f64 {
    let side = f64::from(plan.side);
    let largest = f64::from(plan.largest_radius);
    let reach = fall.radius + largest;
    let (x0, z0) = (corner[0] as f64, corner[1] as f64);
    let dx = (x0 - fall.x).max(fall.x - (x0 + side)).max(0.0);
    let dz = (z0 - fall.z).max(fall.z - (z0 + side)).max(0.0);
    let square = reach * reach - dx * dx - dz * dz;
    if square < 0.0 {
        return f64::NEG_INFINITY;
    }
    // Of two grains with the same top, the larger lies lower and reaches farther.
    f64::from(top) - largest + square.sqrt() + 1.0
}

/// Searches a stack from block `index` down.
#[inline(always)]
fn search_cell<S: Simd, const LEANING: bool>(
    simd: S,
    plan: &Plan,
    fall: &Fall<'_>,
    cell: &SeenCell<'_>,
    mut index: u32,
    found: &mut Found,
) {
    loop {
        let block = cell.tile.block(index);
        let mut lanes =
            candidates::<S, LEANING>(simd, block, plan, fall, cell.corner, found.height);
        while lanes != 0 {
            let lane = lanes.trailing_zeros();
            lanes &= lanes - 1;
            found.try_lane::<LEANING>(plan, fall, cell, [index, lane]);
        }
        index = block.older();
        if index == NO_BLOCK
            || !may_beat::<LEANING>(plan, fall, cell.corner, block.older_top(), found.height)
        {
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

/// What a height in single precision may be off by.
#[inline(always)]
fn margin<const LEANING: bool>() -> f64 {
    ROUNDED_HEIGHT + if LEANING { LEANING_HEIGHT_MARGIN } else { HEIGHT_MARGIN }
}

/// Heights over `base` of the contacts with the grains of a block, to within the margin; `-inf`
/// where the grain is clearly not met, or there is none. `most` keeps, lane by lane, the highest of
/// those that are met beyond doubt.
#[inline(always)]
fn contact_heights<const LEANING: bool>(
    block: &Block,
    plan: &Plan,
    fall: &Fall<'_>,
    (corner, base): ([i64; 2], i32),
    heights: &mut [f32; LANES],
    most: &mut [f32; LANES],
) {
    let x = (fall.x - corner[0] as f64) as f32;
    let z = (fall.z - corner[1] as f64) as f32;
    let radius = fall.radius as f32;
    let (drift_x, drift_z, rise) =
        (plan.drift.x as f32, plan.drift.z as f32, plan.drift.rise as f32);
    let square_margin = if LEANING { LEANING_SQUARE_MARGIN } else { SQUARE_MARGIN };
    let count = block.count() as u32;
    for lane in 0..LANES {
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
        let held = (lane as u32) < count;
        heights[lane] = if (square > -square_margin) & held { at } else { f32::NEG_INFINITY };
        let sure = if (square > square_margin) & held { at } else { f32::NEG_INFINITY };
        most[lane] = if sure > most[lane] { sure } else { most[lane] };
    }
}

/// Lanes whose contact may lie between `best` and the start of the fall, found in single precision
/// with margins; never misses one.
#[inline(always)]
fn candidates<S: Simd, const LEANING: bool>(
    simd: S,
    block: &Block,
    plan: &Plan,
    fall: &Fall<'_>,
    corner: [i64; 2],
    best: f64,
) -> u32 {
    let base = block.y[0];
    let mut heights = [0.0f32; LANES];
    let mut unused = [0.0f32; LANES];
    contact_heights::<LEANING>(block, plan, fall, (corner, base), &mut heights, &mut unused);
    let above = (best - f64::from(base) - margin::<LEANING>()) as f32;
    let below = (fall.from - f64::from(base) + margin::<LEANING>()) as f32;
    let heights = f32x16::from_slice(simd, &heights);
    (heights.simd_gt(above) & heights.simd_le(below)).to_bitmask() as u32
}
