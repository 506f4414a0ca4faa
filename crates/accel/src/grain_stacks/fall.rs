//! What a falling ray or sphere meets first.

use super::block::{Block, LANES, NO_BLOCK};
use super::plan::{Drift, Plan};
use super::tile::Tile;
use super::window::{Quad, SeenCell, Window};
use super::{GrainSlot, GrainStacks};
use crate::words::floats;
use fearless_simd::prelude::*;
use fearless_simd::{dispatch, f32x16, i32x16, u16x16};
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
        (name, block, lane): (u32, &Block, usize),
    ) {
        let grain = plan.grain(block, lane, cell.corner);
        let height = contact_height::<LEANING>(&plan.drift, grain, fall);
        if height > self.height && height <= fall.from {
            let slot = cell.tile.slot(name, lane);
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
            if may_beat::<LEANING>(plan, fall, cell.corner, cell.top(), found.height) {
                search_cell::<S, LEANING>(simd, plan, fall, &cell, &mut found);
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
            search_cell::<S, LEANING>(simd, plan, fall, &cell, found);
        }
        return;
    };
    if !fall.meets_all() {
        for cell in &cells {
            if may_beat::<LEANING>(plan, fall, cell.corner, cell.top(), found.height) {
                search_cell::<S, LEANING>(simd, plan, fall, cell, found);
            }
        }
        return;
    }
    let base = cells[0].newest.y[0];
    let nothing = f32x16::splat(simd, f32::NEG_INFINITY);
    let (mut heights, mut most) = ([nothing; 4], nothing);
    for (cell, heights) in cells.iter().zip(&mut heights) {
        let place = (cell.corner, base);
        let contacts = contacts::<S, LEANING>(simd, cell.newest, plan, fall, place);
        *heights = contacts.possible;
        most = most.max(contacts.certain);
    }
    // All but the highest of those that are surely met, to within the margins, lose.
    let best = most.reduce_max().max(f32::MIN);
    let least = f32x16::splat(simd, best - 2.0 * margin::<LEANING>() as f32);
    let mut lanes = 0u64;
    for (which, heights) in heights.into_iter().enumerate() {
        lanes |= (heights.simd_ge(least).to_bitmask() & 0xFFFF) << (LANES * which);
    }
    while lanes != 0 {
        let at = lanes.trailing_zeros();
        lanes &= lanes - 1;
        let cell = &cells[at as usize / LANES];
        let name = Tile::newest_name(cell.index);
        found.try_lane::<LEANING>(plan, fall, cell, (name, cell.newest, at as usize % LANES));
    }
    for cell in &cells {
        search_older::<S, LEANING>(simd, plan, fall, cell, found);
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

/// Searches a stack.
#[inline(always)]
fn search_cell<S: Simd, const LEANING: bool>(
    simd: S,
    plan: &Plan,
    fall: &Fall<'_>,
    cell: &SeenCell<'_>,
    found: &mut Found,
) {
    let newest = (Tile::newest_name(cell.index), cell.newest);
    search_block::<S, LEANING>(simd, plan, fall, cell, newest, found);
    search_older::<S, LEANING>(simd, plan, fall, cell, found);
}

/// Searches the blocks below the newest, as far as they can matter.
#[inline(always)]
fn search_older<S: Simd, const LEANING: bool>(
    simd: S,
    plan: &Plan,
    fall: &Fall<'_>,
    cell: &SeenCell<'_>,
    found: &mut Found,
) {
    let mut block = cell.newest;
    loop {
        let older = block.older();
        if older == NO_BLOCK
            || !may_beat::<LEANING>(plan, fall, cell.corner, block.older_top(), found.height)
        {
            return;
        }
        block = cell.tile.older(older);
        search_block::<S, LEANING>(simd, plan, fall, cell, (older, block), found);
    }
}

#[inline(always)]
fn search_block<S: Simd, const LEANING: bool>(
    simd: S,
    plan: &Plan,
    fall: &Fall<'_>,
    cell: &SeenCell<'_>,
    (name, block): (u32, &Block),
    found: &mut Found,
) {
    let mut lanes = candidates::<S, LEANING>(simd, block, plan, fall, cell.corner, found.height);
    while lanes != 0 {
        let lane = lanes.trailing_zeros() as usize;
        lanes &= lanes - 1;
        found.try_lane::<LEANING>(plan, fall, cell, (name, block, lane));
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

/// Heights over some base of the contacts with the grains of a block, to within the margin.
struct Contacts<S: Simd> {
    /// `-inf` where the grain is clearly not met, or there is none.
    possible: f32x16<S>,
    /// `-inf` but where the grain is met beyond doubt.
    certain: f32x16<S>,
}

#[inline(always)]
fn contacts<S: Simd, const LEANING: bool>(
    simd: S,
    block: &Block,
    plan: &Plan,
    fall: &Fall<'_>,
    (corner, base): ([i64; 2], i32),
) -> Contacts<S> {
    let splat = |v: f32| f32x16::splat(simd, v);
    let x = splat((fall.x - corner[0] as f64) as f32);
    let z = splat((fall.z - corner[1] as f64) as f32);
    let dx = x - floats(simd, u16x16::from_slice(simd, &block.x));
    let dz = z - floats(simd, u16x16::from_slice(simd, &block.z));
    let radius = floats(simd, u16x16::from_slice(simd, &block.radius));
    let reach = radius + splat(fall.radius as f32);
    let mut square = reach * reach - dx * dx - dz * dz;
    let mut along = splat(0.0);
    let rise = splat(plan.drift.rise as f32);
    if LEANING {
        along = (dx * splat(plan.drift.x as f32) + dz * splat(plan.drift.z as f32)) * rise;
        square += along * along;
    }
    let up = square.max(splat(0.0)).sqrt();
    let up = if LEANING { rise * (up - along) } else { up };
    let above = i32x16::from_slice(simd, &block.y) - i32x16::splat(simd, base);
    let at = simd.cvt_f32_i32x16(above) + up;
    let count = u16x16::splat(simd, block.count() as u16);
    let (low, high) = simd.widen_mask16x16(u16x16::from_slice(simd, &SLOTS).simd_lt(count));
    let held = simd.combine_mask32x8(low, high);
    let margin = splat(if LEANING { LEANING_SQUARE_MARGIN } else { SQUARE_MARGIN });
    let nothing = splat(f32::NEG_INFINITY);
    Contacts {
        possible: (square.simd_gt(-margin) & held).select(at, nothing),
        certain: (square.simd_gt(margin) & held).select(at, nothing),
    }
}

const SLOTS: [u16; LANES] = [0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15];

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
    let heights = contacts::<S, LEANING>(simd, block, plan, fall, (corner, base)).possible;
    let above = (best - f64::from(base) - margin::<LEANING>()) as f32;
    let below = (fall.from - f64::from(base) + margin::<LEANING>()) as f32;
    (heights.simd_gt(above) & heights.simd_le(below)).to_bitmask() as u32
}
