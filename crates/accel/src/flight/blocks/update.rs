//! What happens to sixteen paths after their block tests: scatter at a grain, go on in ice, or step
//! to the next cell; all at once and without a branch a path.

use super::arrivals::Arrivals;
use super::exit::{AxisExit, CellShape, Exit};
use super::paths::{FirstGrains, GROUP, Group, NOTHING, get, set};
use crate::flight::MAX_TURNS_IN_ICE;
use crate::flight::random::NEXT_EVENT;
use crate::flight::sphere::{Angles, Ice, Transmittance};
use crate::flight::vector::{F, M, Vector, W};
use crate::grain_grid::{MEETS_SURFACE, OVERLAPS, RADIUS_MASK};
use crate::words::floats;
use fearless_simd::prelude::*;
use fearless_simd::{i32x16, mask32x16, u16x16};

/// A grain found this far beyond the cell's exit (in quanta) is still taken: its distance and the
/// exit's are rounded differently, and it may be listed in this cell alone.
pub(super) const EXIT_TOLERANCE: f32 = 0.0625;
/// What is found beyond so many times the exit is surely not taken: the number of the slot in the
/// distance of the block test moves it by 2^-19 of it at most.
const CLEARLY: f32 = 1.0 + 1.0 / 131_072.0;

type I<S> = i32x16<S>;

/// Which of the paths is in a set.
#[inline(always)]
fn members<S: Simd>(simd: S, set: u32) -> M<S> {
    mask32x16::from_bitmask(simd, u64::from(set))
}

/// What an update keeps of paths beside their state.
pub(super) struct Notes<'a, 'w> {
    /// First grains of the paths of the group.
    pub(super) first: &'a mut FirstGrains,
    /// Arrivals at grains, and the lane of the first path of the group.
    pub(super) arrivals: &'a mut Arrivals<'w>,
    pub(super) first_lane: usize,
}

/// Applies the answers of the block tests, where grains have `strata` to those too; the set of paths
/// that need a closer look: they may have left the grid, met a surface within their grain, or be
/// trapped.
#[inline(always)]
pub(super) fn update_group<S: Simd>(
    simd: S,
    shape: &CellShape,
    (ice, strata): (Ice, bool),
    group: &mut Group,
    Notes { first, arrivals, first_lane }: Notes<'_, '_>,
) -> u32 {
    let (zero, one) = (F::<S>::splat(simd, 0.0), F::<S>::splat(simd, 1.0));
    let eta = F::<S>::splat(simd, ice.eta);
    let inverse_eta = F::<S>::splat(simd, ice.inverse_eta);
    let (no, once) = (W::<S>::splat(simd, 0), W::<S>::splat(simd, 1));

    let air = members(simd, group.air);
    let in_ice = members(simd, group.ice);
    let inside = members(simd, group.inside);
    let position = Vector::load(simd, &group.position, 0);
    let direction = Vector::load(simd, &group.direction, 0);
    let exit = Exit::of(simd, shape, group, position, direction);
    let exit_distance = exit.distance;

    // 1. The grain found: where the ray enters and leaves it, as in the block test.
    let exists = F::<S>::from_slice(simd, &group.found).simd_lt(F::<S>::splat(simd, NOTHING));
    let found_grain = Vector(
        floats(simd, u16x16::from_slice(simd, &group.found_grain[0])),
        floats(simd, u16x16::from_slice(simd, &group.found_grain[1])),
        floats(simd, u16x16::from_slice(simd, &group.found_grain[2])),
    );
    let (low, high) = simd.widen_u16x16(u16x16::from_slice(simd, &group.found_radius));
    let found_bits = simd.combine_u32x8(low, high);
    let radius_mask = W::<S>::splat(simd, u32::from(RADIUS_MASK));
    let found_radius: I<S> = (found_bits & radius_mask).bitcast();
    let found_radius = simd.cvt_f32_i32x16(found_radius);
    let to_center = found_grain.plus(position, zero - one);
    let middle = to_center.dot(direction);
    let residual = to_center.plus(direction, zero - middle);
    let discriminant = found_radius * found_radius - residual.dot(residual);
    let half = discriminant.simd_gt(zero).select(discriminant, zero).sqrt();

    // 2. What happens to each path.
    let enters_at = middle - half;
    let reach = exit_distance + F::<S>::splat(simd, EXIT_TOLERANCE);
    let hit = air & exists & enters_at.simd_le(reach);
    let step = air & !hit;
    let go_on = in_ice & exists;
    let end = in_ice & !exists;
    let at_grain = end | inside;
    let at_interface = hit | at_grain;
    if arrivals.are_wanted() {
        arrivals.note(group, first_lane, [hit, go_on].map(|mask| mask.to_bitmask() as u32));
    }

    // 3. The outward normal there. Everything that other paths get is 0, so that no garbage spreads.
    let grain = Vector::load(simd, &group.grain, 0);
    let grain_bits = W::<S>::from_slice(simd, &group.grain_radius);
    let own_radius: I<S> = (grain_bits & radius_mask).bitcast();
    let own_radius = simd.cvt_f32_i32x16(own_radius);
    let center = Vector::choose(at_grain, grain, found_grain);
    let radius = at_grain.select(own_radius, found_radius);
    let inverse_radius = at_interface.select(one / at_interface.select(radius, one), zero);
    let from_foot = residual.plus(direction, half).scaled(zero - one);
    let from_center = position.plus(grain, zero - one);
    let outward = Vector::choose(at_grain, from_center, from_foot).scaled(inverse_radius);
    let normal = outward.straightened(simd);

    // 4. Fresnel. All reflections inside one sphere meet its surface at the same angle, so the
    // outside cosine of the entry serves them all; only a chord that came from another grain or
    // from a surface takes its angle from the geometry.
    let kept = F::<S>::from_slice(simd, &group.cos_outside);
    let fresh = end & kept.simd_lt(zero);
    let known = hit.select(half * inverse_radius, kept);
    let along = clamp01(simd, direction.dot(normal));
    let angles = Angles::at_sphere(simd, ice, fresh, along, known);
    let transmittance = Transmittance::new(simd, ice, angles);
    let key = [W::<S>::from_slice(simd, &group.key[0]), W::<S>::from_slice(simd, &group.key[1])];
    let next = W::<S>::splat(simd, NEXT_EVENT);
    let event = W::<S>::from_slice(simd, &group.event);
    let passes = transmittance.passes(key, event);
    let enter = hit & passes;
    let leave = end & passes;
    let bounce = end & !passes;
    let flags = W::<S>::splat(simd, u32::from(OVERLAPS | MEETS_SURFACE));
    let lone = (found_bits & flags).simd_eq(no);
    let enter_bound = enter & !lone;
    let through = (enter & lone) | inside;

    // 5. Out, or on along a chord: one chain of steps with other factors (module `sphere`).
    // Beyond the critical angle only the geometry knows the angle inside.
    let inner = bounce.select(along, angles.inside);
    let chord = inner + inner;
    let bend = angles.outside - eta * angles.inside;
    let back = inside.select(eta * chord, bounce.select(chord, zero));
    let refracts = enter | leave;
    let mirror = hit.select(angles.outside + angles.outside, zero - back);
    let u = direction.scaled(leave.select(eta, one)).plus(normal, refracts.select(bend, mirror));
    let slanted = (enter | inside).select(chord * inverse_eta, zero);
    let far = normal.plus(u, bounce.select(chord, slanted));
    let event = event + (hit | end).select(next, no);
    let out = through & transmittance.passes(key, event);
    let event = event + through.select(next, no);
    let stays_inside = through & !out;
    let turned = u
        .scaled(enter_bound.select(inverse_eta, one))
        .plus(far, out.select(bend, zero))
        .straightened(simd);
    let new_direction = Vector::choose(stays_inside, u, turned);

    // 6. The layers of the film want the first grain that a path meets.
    let visits = W::<S>::from_slice(simd, &group.visits);
    let meets_first = (hit & visits.simd_eq(no)).to_bitmask() as u32;
    if meets_first != 0 {
        remember(group, first, meets_first, center, normal, radius);
    }

    // 7. Write back, moved to the cell that now holds the path.
    let leaves_at = middle + half;
    let travelled = step.select(exit_distance, go_on.select(leaves_at, zero));
    let on_grain = center.plus(far, radius);
    let new_position = Vector::choose(at_interface, on_grain, position.plus(direction, travelled));
    let new_ice = enter_bound | bounce | go_on;
    let chord_made = enter | inside | bounce;
    let chord = go_on.select(leaves_at, chord_made.select(chord * radius, zero));
    let ice_length = F::<S>::from_slice(simd, &group.ice_length) + chord;
    let in_air = hit.select(enters_at, step.select(exit_distance, zero));
    let air_length = F::<S>::from_slice(simd, &group.air_length) + in_air;
    let flies = air | in_ice | inside;
    let took_found = hit | go_on;
    let new_grain = Vector::choose(took_found, found_grain, grain);
    let cos_outside = go_on.select(zero - one, at_interface.select(angles.outside, kept));
    let turns = new_ice.select(W::<S>::from_slice(simd, &group.turns) + once, no);
    let new_bits = took_found.select(found_bits, grain_bits);

    Vector::choose(at_interface, new_direction, direction).store(&mut group.direction, 0);
    new_bits.store_slice(&mut group.grain_radius);
    chord.store_slice(&mut group.chord);
    if strata {
        let chords = (go_on | chord_made).to_bitmask() as u32;
        group.add_to_strata(took_found.to_bitmask() as u32, chords);
    }
    cos_outside.store_slice(&mut group.cos_outside);
    ice_length.store_slice(&mut group.ice_length);
    air_length.store_slice(&mut group.air_length);
    event.store_slice(&mut group.event);
    (visits + hit.select(once, no)).store_slice(&mut group.visits);
    turns.store_slice(&mut group.turns);
    new_grain.store(&mut group.grain, 0);
    let outside = move_group(simd, shape, group, &exit, [step, flies], new_position);
    group.waiting = 0;
    let to_air = step | (hit & !passes) | leave | out;
    group.air = to_air.to_bitmask() as u32;
    group.ice = new_ice.to_bitmask() as u32;
    group.inside = stays_inside.to_bitmask() as u32;
    let meets = (new_bits & W::<S>::splat(simd, u32::from(MEETS_SURFACE))).simd_gt(no);
    let turned_long = turns.simd_gt(W::<S>::splat(simd, MAX_TURNS_IN_ICE));
    ((flies & outside) | (new_ice & (meets | turned_long))).to_bitmask() as u32
}

/// Lets the paths in air that surely meet no grain in their cell step to the next; all others wait for
/// [`update_group`]. The set of paths that need a closer look: they may have left the grid.
#[inline(always)]
pub(super) fn step_group<S: Simd>(simd: S, shape: &CellShape, group: &mut Group) -> u32 {
    let position = Vector::load(simd, &group.position, 0);
    let direction = Vector::load(simd, &group.direction, 0);
    let exit = Exit::of(simd, shape, group, position, direction);
    let reach = exit.distance * F::<S>::splat(simd, CLEARLY) + F::<S>::splat(simd, EXIT_TOLERANCE);
    let clear = F::<S>::from_slice(simd, &group.found).simd_gt(reach);
    let step = members(simd, group.air & !group.waiting) & clear;
    let zero = F::<S>::splat(simd, 0.0);
    let travelled = step.select(exit.distance, zero);
    (F::<S>::from_slice(simd, &group.air_length) + travelled).store_slice(&mut group.air_length);
    let new_position = position.plus(direction, travelled);
    let outside = move_group(simd, shape, group, &exit, [step, step], new_position);
    group.waiting = (group.air | group.ice) & !(step.to_bitmask() as u32);
    (step & outside).to_bitmask() as u32
}

/// What became of the probes of a group: bits of their lanes.
pub(super) struct ProbedSets {
    /// Met the grain that was found.
    pub(super) met: u32,
    /// Began within another grain than their own.
    pub(super) covered: u32,
    /// Have reached their length.
    pub(super) ended: u32,
    /// Perhaps beyond the grid.
    pub(super) beyond: u32,
}

/// Applies the answers of the block tests to straight rays, whose length stands where paths keep their
/// chord. Those that are at the end of a chord have asked whether another grain covers their start.
#[inline(always)]
pub(super) fn probe_group<S: Simd>(simd: S, shape: &CellShape, group: &mut Group) -> ProbedSets {
    let position = Vector::load(simd, &group.position, 0);
    let direction = Vector::load(simd, &group.direction, 0);
    let exit = Exit::of(simd, shape, group, position, direction);
    let found = F::<S>::from_slice(simd, &group.found);
    let exists = found.simd_lt(F::<S>::splat(simd, NOTHING));
    let travelled = F::<S>::from_slice(simd, &group.air_length);
    let to_go = F::<S>::from_slice(simd, &group.chord) - travelled;
    let (air, starts) = (members(simd, group.air), members(simd, group.ice));
    let reach = exit.distance + F::<S>::splat(simd, EXIT_TOLERANCE);
    let hit = air & exists & found.simd_le(reach);
    let met = hit & found.simd_lt(to_go);
    let ended = (hit & !met) | (air & !hit & exit.distance.simd_ge(to_go));
    let step = air & !hit & !ended;
    let distance = step.select(exit.distance, F::<S>::splat(simd, 0.0));
    // Where a grain was met, its distance is told from where the probe now stands.
    (travelled + distance).store_slice(&mut group.air_length);
    let new_position = position.plus(direction, distance);
    let outside = move_group(simd, shape, group, &exit, [step, step], new_position);
    let covered = starts & exists;
    group.air = (step | (starts & !exists)).to_bitmask() as u32;
    group.ice = 0;
    ProbedSets {
        met: met.to_bitmask() as u32,
        covered: covered.to_bitmask() as u32,
        ended: ended.to_bitmask() as u32,
        beyond: (step & outside).to_bitmask() as u32,
    }
}

/// Writes back where the paths `moves` are now, of which `step` crossed a face: their cell, place and
/// grain; which of them are beyond the grid.
#[inline(always)]
fn move_group<S: Simd>(
    simd: S,
    shape: &CellShape,
    group: &mut Group,
    exit: &Exit<S>,
    [step, moves]: [M<S>; 2],
    position: Vector<S>,
) -> M<S> {
    let mut outside = mask32x16::splat(simd, false);
    let (mut brick, mut within_brick) = (W::<S>::splat(simd, 0), W::<S>::splat(simd, 0));
    for (axis, place) in [position.0, position.1, position.2].into_iter().enumerate() {
        let crossed = step & exit.by[axis];
        let masks = [crossed, step, moves];
        let moved = move_along(simd, shape, group, axis, &exit.along[axis], masks, place);
        let before = F::<S>::from_slice(simd, &group.position[axis]);
        moves.select(moved.position, before).store_slice(&mut group.position[axis]);
        moved.cell.store_slice(&mut group.cell[axis]);
        let grain = F::<S>::from_slice(simd, &group.grain[axis]);
        (grain - moved.offset).store_slice(&mut group.grain[axis]);
        outside |= moved.outside;
        let cell: W<S> = moved.cell.bitcast();
        brick += (cell >> 3) * W::<S>::splat(simd, shape.brick_steps[axis]);
        within_brick |= (cell & W::<S>::splat(simd, 7)) << (3 * axis as u32);
    }
    brick.store_slice(&mut group.brick);
    within_brick.store_slice(&mut group.within_brick);
    outside
}

struct Moved<S: Simd> {
    position: F<S>,
    cell: I<S>,
    /// How far the corner of the cell moved.
    offset: F<S>,
    /// Whether the cell is beyond the grid.
    outside: M<S>,
}

/// Moves each path to the cell that holds its position: along the crossed axis exactly by the
/// crossing, so that the position lies on the face that was crossed; along the others, and after a
/// chord, by where the position is.
#[inline(always)]
fn move_along<S: Simd>(
    simd: S,
    shape: &CellShape,
    group: &Group,
    axis: usize,
    exit: &AxisExit<S>,
    [crossed, step, flies]: [M<S>; 3],
    position: F<S>,
) -> Moved<S> {
    let none = I::splat(simd, 0);
    let margin = F::<S>::splat(simd, shape.margin);
    let side = F::<S>::splat(simd, shape.side[axis]);
    let by_place = ((position - margin) * F::<S>::splat(simd, shape.inverse_side[axis])).floor();
    let by_place: I<S> = by_place.to_int();
    // A path on an edge of a brick must not be moved back out of it by its other coordinate.
    let within = by_place.simd_lt(exit.least).select(exit.least, by_place);
    let within = within.simd_gt(exit.greatest).select(exit.greatest, within);
    let shift = crossed.select(exit.crossing, step.select(within, by_place));
    let shift = flies.select(shift, none);
    let offset = simd.cvt_f32_i32x16(shift) * side;
    let face = exit.crossing.simd_gt(none).select(margin, margin + side);
    let cell = I::from_slice(simd, &group.cell[axis]) + shift;
    let last = I::splat(simd, shape.cells[axis] - 1);
    Moved {
        position: crossed.select(face, position - offset),
        cell,
        offset,
        outside: cell.simd_lt(none) | cell.simd_gt(last),
    }
}

#[inline(always)]
fn clamp01<S: Simd>(simd: S, v: F<S>) -> F<S> {
    let (zero, one) = (F::<S>::splat(simd, 0.0), F::<S>::splat(simd, 1.0));
    let v = v.simd_gt(zero).select(v, zero);
    v.simd_lt(one).select(v, one)
}

/// Keeps the first grain of the paths `which`.
#[inline(always)]
fn remember<S: Simd>(
    group: &Group,
    first: &mut FirstGrains,
    mut which: u32,
    center: Vector<S>,
    normal: Vector<S>,
    radius: F<S>,
) {
    let surface = center.plus(normal, radius);
    let (mut normals, mut places) = ([[0.0; GROUP]; 3], [[0.0; GROUP]; 3]);
    normal.store(&mut normals, 0);
    surface.store(&mut places, 0);
    while which != 0 {
        let at = which.trailing_zeros() as usize & (GROUP - 1);
        which &= which - 1;
        set(&mut first.normal, at, get(&normals, at));
        set(&mut first.position, at, get(&places, at));
        set(&mut first.cell, at, get(&group.cell, at));
    }
}
