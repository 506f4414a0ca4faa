//! What happens to sixteen paths after their block tests: scatter at a grain, go on in ice, or step
//! to the next cell; all at once and without a branch a path.

use super::block_test::NOTHING;
use super::lanes::{Axes, Lanes, mode};
use crate::grain_grid::{CellEntry, GrainGrid, MEETS_SURFACE, OVERLAPS, RADIUS_MASK};
use fearless_simd::prelude::*;
use fearless_simd::{f32x16, i32x16, mask32x16, u32x16};

/// Paths in one vector.
pub(crate) const GROUP: usize = 16;

/// A grain found this far beyond the cell's exit (in quanta) is still taken: its distance and the
/// exit's are rounded differently, and it may be listed in this cell alone.
pub(crate) const EXIT_TOLERANCE: f32 = 0.0625;

/// Optical constants of the grains, rounded once.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Ice {
    pub(crate) eta: f32,
    pub(crate) inverse_eta: f32,
}

impl Ice {
    pub(crate) fn new(eta: f64) -> Self {
        Self { eta: eta as f32, inverse_eta: (1.0 / eta) as f32 }
    }
}

type F<S> = f32x16<S>;
type M<S> = mask32x16<S>;

#[derive(Clone, Copy)]
struct Vector<S: Simd>(F<S>, F<S>, F<S>);

impl<S: Simd> Vector<S> {
    #[inline(always)]
    fn load(simd: S, axes: &Axes<f32>, at: usize) -> Self {
        let part = |axis: usize| F::from_slice(simd, &axes.0[axis][at..at + GROUP]);
        Self(part(0), part(1), part(2))
    }

    #[inline(always)]
    fn store(self, axes: &mut Axes<f32>, at: usize) {
        self.0.store_slice(&mut axes.0[0][at..at + GROUP]);
        self.1.store_slice(&mut axes.0[1][at..at + GROUP]);
        self.2.store_slice(&mut axes.0[2][at..at + GROUP]);
    }

    #[inline(always)]
    fn dot(self, other: Self) -> F<S> {
        self.0 * other.0 + self.1 * other.1 + self.2 * other.2
    }

    /// `self + other * factor`, rounded twice.
    #[inline(always)]
    fn plus(self, other: Self, factor: F<S>) -> Self {
        Self(self.0 + other.0 * factor, self.1 + other.1 * factor, self.2 + other.2 * factor)
    }

    #[inline(always)]
    fn minus(self, other: Self) -> Self {
        Self(self.0 - other.0, self.1 - other.1, self.2 - other.2)
    }

    #[inline(always)]
    fn scaled(self, factor: F<S>) -> Self {
        Self(self.0 * factor, self.1 * factor, self.2 * factor)
    }

    #[inline(always)]
    fn unit(self) -> Self {
        let length = self.dot(self).sqrt();
        Self(self.0 / length, self.1 / length, self.2 / length)
    }

    #[inline(always)]
    fn choose(mask: M<S>, yes: Self, no: Self) -> Self {
        Self(mask.select(yes.0, no.0), mask.select(yes.1, no.1), mask.select(yes.2, no.2))
    }
}

#[inline(always)]
fn words<S: Simd>(simd: S, array: &[u32], at: usize) -> u32x16<S> {
    u32x16::from_slice(simd, &array[at..at + GROUP])
}

#[inline(always)]
fn numbers<S: Simd>(simd: S, array: &[f32], at: usize) -> F<S> {
    F::from_slice(simd, &array[at..at + GROUP])
}

/// First number of event `event` of each path: `snowgrain_math::sampler::numbers(key, event)[0]`.
#[inline(always)]
fn uniform<S: Simd>(simd: S, lo: u32x16<S>, hi: u32x16<S>, event: u32x16<S>) -> F<S> {
    let multiplier = u32x16::splat(simd, 1_664_525);
    let increment = u32x16::splat(simd, 1_013_904_223);
    let (mut x, mut y, mut z) =
        (lo * multiplier + increment, hi * multiplier + increment, event * multiplier + increment);
    x += y * z;
    y += z * x;
    z += x * y;
    x ^= x >> 16;
    y ^= y >> 16;
    z ^= z >> 16;
    x += y * z;
    let top: i32x16<S> = (x >> 8).bitcast();
    simd.cvt_f32_i32x16(top) * F::splat(simd, 1.0 / 16_777_216.0)
}

/// The cell that each path is in: how far its faces lie ahead.
struct Exits<S: Simd> {
    distance: F<S>,
    /// The axis that is crossed first.
    axis: [M<S>; 3],
    /// Cells that the crossing moves along each axis, if it is crossed.
    cells: [i32x16<S>; 3],
    /// Least and greatest move along each axis that is not crossed: within an empty brick, else none.
    stay: [[i32x16<S>; 2]; 3],
}

/// Along one axis: distance to the face ahead, the cells that crossing it moves (signed), and the
/// least and greatest move where another face is crossed.
#[inline(always)]
#[expect(clippy::too_many_arguments, reason = "a closure would not be inlined with its SIMD level")]
fn exit_along<S: Simd>(
    simd: S,
    grid: &GrainGrid,
    lanes: &Lanes,
    at: usize,
    axis: usize,
    position: F<S>,
    direction: F<S>,
    brick: M<S>,
) -> (F<S>, i32x16<S>, [i32x16<S>; 2]) {
    let (none, one) = (i32x16::splat(simd, 0), i32x16::splat(simd, 1));
    let seven = i32x16::splat(simd, 7);
    let margin = F::splat(simd, grid.margin as f32);
    let side = F::splat(simd, grid.side[axis] as f32);
    let cell = i32x16::from_slice(simd, &lanes.cell.0[axis][at..at + GROUP]);
    let below = brick.select(cell & seven, none);
    // The last brick may reach beyond the grid, where surfaces must be asked for.
    let in_brick = seven - (cell & seven);
    let in_grid = i32x16::splat(simd, grid.cells[axis] - 1) - cell;
    let above = brick.select(in_brick.simd_lt(in_grid).select(in_brick, in_grid), none);
    let forward = direction.simd_gt(F::splat(simd, 0.0));
    let low = margin - simd.cvt_f32_i32x16(below) * side;
    let high = margin + side + simd.cvt_f32_i32x16(above) * side;
    let parallel = direction.abs().simd_lt(F::splat(simd, 1.0e-20));
    let divisor = parallel.select(F::splat(simd, 1.0), direction);
    let t = (forward.select(high, low) - position) / divisor;
    let t = parallel.select(F::splat(simd, NOTHING), t);
    (t, forward.select(above + one, none - below - one), [none - below, above])
}

#[inline(always)]
fn exits<S: Simd>(
    simd: S,
    grid: &GrainGrid,
    lanes: &Lanes,
    at: usize,
    position: Vector<S>,
    direction: Vector<S>,
) -> Exits<S> {
    let zero = F::splat(simd, 0.0);
    let entry = words(simd, &lanes.entry, at);
    let brick = entry.simd_eq(u32x16::splat(simd, CellEntry::EMPTY_BRICK.0));
    let (tx, mx, sx) = exit_along(simd, grid, lanes, at, 0, position.0, direction.0, brick);
    let (ty, my, sy) = exit_along(simd, grid, lanes, at, 1, position.1, direction.1, brick);
    let (tz, mz, sz) = exit_along(simd, grid, lanes, at, 2, position.2, direction.2, brick);
    let x = tx.simd_le(ty) & tx.simd_le(tz);
    let y = !x & ty.simd_le(tz);
    let z = !(x | y);
    let distance = x.select(tx, y.select(ty, tz));
    let distance = distance.simd_gt(zero).select(distance, zero);
    Exits { distance, axis: [x, y, z], cells: [mx, my, mz], stay: [sx, sy, sz] }
}

/// Applies the answers of the block tests to the paths `at..at + 16`.
#[inline(always)]
pub(crate) fn update_group<S: Simd>(
    simd: S,
    grid: &GrainGrid,
    ice: Ice,
    lanes: &mut Lanes,
    at: usize,
) {
    let splat = |v: f32| F::splat(simd, v);
    let (zero, one, two) = (splat(0.0), splat(1.0), splat(2.0));
    let word = |v: u32| u32x16::splat(simd, v);

    let now = words(simd, &lanes.mode, at);
    let air = now.simd_eq(word(mode::AIR));
    let in_ice = now.simd_eq(word(mode::ICE));
    let position = Vector::load(simd, &lanes.position, at);
    let direction = Vector::load(simd, &lanes.direction, at);
    let found = numbers(simd, &lanes.found, at);
    let exits = exits(simd, grid, lanes, at, position, direction);

    // 1. What happens to each path.
    let exists = found.simd_lt(splat(NOTHING));
    let hit = air & exists & found.simd_le(exits.distance + splat(EXIT_TOLERANCE));
    let step = air & !hit;
    let go_on = in_ice & exists;
    let end = in_ice & !exists;
    let interface = hit | end;

    // 2. Where it happens, re-projected onto the sphere.
    let travelled = hit.select(found, step.select(exits.distance, go_on.select(-found, zero)));
    let arrived = position.plus(direction, travelled);
    let center = Vector::choose(
        end,
        Vector::load(simd, &lanes.grain, at),
        Vector::load(simd, &lanes.found_grain, at),
    );
    let radius_bits =
        end.select(words(simd, &lanes.grain_radius, at), words(simd, &lanes.found_radius, at));
    let radius_word: i32x16<S> = (radius_bits & word(u32::from(RADIUS_MASK))).bitcast();
    let radius = simd.cvt_f32_i32x16(radius_word);
    let normal = arrived.minus(center).unit();
    let surface = center.plus(normal, radius);

    // 3. Fresnel. All reflections inside one sphere meet its surface at the same angle, so the
    // outside cosine of the entry serves them all; only a chord that came from another grain or
    // from a surface takes its angle from the geometry.
    let eta = splat(ice.eta);
    let inverse_eta = splat(ice.inverse_eta);
    let along = direction.dot(normal);
    let kept = numbers(simd, &lanes.cos_outside, at);
    let fresh = end & kept.simd_lt(zero);
    let entry_cosine = clamp01(simd, zero - along);
    let cos_known = hit.select(entry_cosine, kept);
    let sin2_inside = (one - cos_known * cos_known) * (inverse_eta * inverse_eta);
    let inner = clamp01(simd, along);
    let cos_inside = fresh.select(inner, (one - sin2_inside).sqrt());
    let cos2_outside = one - eta * eta * (one - inner * inner);
    let cos2_outside = cos2_outside.simd_gt(zero).select(cos2_outside, zero);
    let cos_outside = fresh.select(cos2_outside.sqrt(), cos_known);
    let rs = (cos_outside - eta * cos_inside) / (cos_outside + eta * cos_inside);
    let rp = (eta * cos_outside - cos_inside) / (eta * cos_outside + cos_inside);
    let transmittance = one - (rs * rs + rp * rp) * splat(0.5);

    let key_lo = words(simd, &lanes.key_lo, at);
    let key_hi = words(simd, &lanes.key_hi, at);
    let mut event = words(simd, &lanes.event, at);
    let passes = uniform(simd, key_lo, key_hi, event).simd_lt(transmittance);
    event += interface.select(word(1), word(0));
    let enter = hit & passes;
    let leave = end & passes;
    let inside = enter | (end & !passes);

    let reflect_weight = zero - two * along;
    let scale = enter.select(inverse_eta, leave.select(eta, one));
    let weight = enter.select(
        cos_outside * inverse_eta - cos_inside,
        leave.select(cos_outside - eta * cos_inside, reflect_weight),
    );
    let scattered = direction.scaled(scale).plus(normal, weight).unit();
    let mut new_direction = Vector::choose(interface, scattered, direction);

    // 4. The chord that begins inside.
    let chord = zero - two * radius * new_direction.dot(normal);
    let mut far_normal = surface.plus(new_direction, chord).minus(center).unit();
    let mut new_position = Vector::choose(inside, center.plus(far_normal, radius), surface);
    let mut ice_length =
        numbers(simd, &lanes.ice_length, at) + inside.select(chord, go_on.select(travelled, zero));

    // 5. A grain that touches nothing: reflect inside until it lets the light out (the closed form
    // of a visit; only its own sphere has to be asked).
    let bound = radius_bits & word(u32::from(OVERLAPS | MEETS_SURFACE));
    let lone = bound.simd_eq(word(0));
    let mut waiting = enter & lone;
    while waiting.any_true() {
        let out = waiting & uniform(simd, key_lo, key_hi, event).simd_lt(transmittance);
        event += waiting.select(word(1), word(0));
        let back = waiting & !out;
        let weight =
            out.select(cos_outside - eta * cos_inside, zero - two * new_direction.dot(far_normal));
        let turned = new_direction.scaled(out.select(eta, one)).plus(far_normal, weight).unit();
        new_direction = Vector::choose(waiting, turned, new_direction);
        let inner_chord = zero - two * radius * new_direction.dot(far_normal);
        let next = new_position.plus(new_direction, inner_chord).minus(center).unit();
        new_position = Vector::choose(back, center.plus(next, radius), new_position);
        far_normal = Vector::choose(back, next, far_normal);
        ice_length += back.select(inner_chord, zero);
        waiting = back;
    }
    let chord_open = inside & !lone;

    // 6. The layers of the film want the first grain that a path meets.
    let visits = words(simd, &lanes.visits, at);
    let first = hit & visits.simd_eq(word(0));
    if first.any_true() {
        store_first(simd, lanes, at, first, normal, surface);
    }

    // 7. Write back, moved to the cell that now holds the path.
    let moved = move_cells(
        simd,
        grid,
        lanes,
        at,
        &exits,
        step,
        air | in_ice,
        [
            step.select(arrived.0, new_position.0),
            step.select(arrived.1, new_position.1),
            step.select(arrived.2, new_position.2),
        ],
        [position, center],
    );
    let active = air | in_ice;
    let stays_in_ice = chord_open | go_on;
    let was = |array: &[f32]| numbers(simd, array, at);
    active
        .select(new_direction.0, direction.0)
        .store_slice(&mut lanes.direction.0[0][at..at + GROUP]);
    active
        .select(new_direction.1, direction.1)
        .store_slice(&mut lanes.direction.0[1][at..at + GROUP]);
    active
        .select(new_direction.2, direction.2)
        .store_slice(&mut lanes.direction.0[2][at..at + GROUP]);
    moved.store(&mut lanes.position, at);
    let chord = go_on.select(travelled, chord_open.select(chord, was(&lanes.chord)));
    chord.store_slice(&mut lanes.chord[at..at + GROUP]);
    let kept = go_on.select(splat(-1.0), interface.select(cos_outside, kept));
    kept.store_slice(&mut lanes.cos_outside[at..at + GROUP]);
    active
        .select(ice_length, was(&lanes.ice_length))
        .store_slice(&mut lanes.ice_length[at..at + GROUP]);
    let air_length = was(&lanes.air_length) + air.select(travelled, zero);
    air_length.store_slice(&mut lanes.air_length[at..at + GROUP]);
    let next_mode = stays_in_ice.select(word(mode::ICE), active.select(word(mode::AIR), now));
    next_mode.store_slice(&mut lanes.mode[at..at + GROUP]);
    stays_in_ice
        .select(radius_bits, words(simd, &lanes.grain_radius, at))
        .store_slice(&mut lanes.grain_radius[at..at + GROUP]);
    event.store_slice(&mut lanes.event[at..at + GROUP]);
    (visits + hit.select(word(1), word(0))).store_slice(&mut lanes.visits[at..at + GROUP]);
    stays_in_ice
        .select(words(simd, &lanes.turns, at) + word(1), word(0))
        .store_slice(&mut lanes.turns[at..at + GROUP]);
}

#[inline(always)]
fn clamp01<S: Simd>(simd: S, v: F<S>) -> F<S> {
    let (zero, one) = (F::splat(simd, 0.0), F::splat(simd, 1.0));
    let v = v.simd_gt(zero).select(v, zero);
    v.simd_lt(one).select(v, one)
}

#[inline(always)]
fn store_first<S: Simd>(
    simd: S,
    lanes: &mut Lanes,
    at: usize,
    first: M<S>,
    normal: Vector<S>,
    surface: Vector<S>,
) {
    let old = Vector::load(simd, &lanes.first_normal, at);
    Vector::choose(first, normal, old).store(&mut lanes.first_normal, at);
    let old = Vector::load(simd, &lanes.first_position, at);
    Vector::choose(first, surface, old).store(&mut lanes.first_position, at);
    for axis in 0..3 {
        let old = i32x16::from_slice(simd, &lanes.first_cell.0[axis][at..at + GROUP]);
        let cell = i32x16::from_slice(simd, &lanes.cell.0[axis][at..at + GROUP]);
        first.select(cell, old).store_slice(&mut lanes.first_cell.0[axis][at..at + GROUP]);
    }
}

/// Moves each path to the cell that holds its position: along the crossed axis exactly by the
/// crossing, so that the position lies on the face that was crossed; along the others, and after a
/// chord, by where the position is. The centre of the current grain moves with it.
#[inline(always)]
#[expect(clippy::too_many_arguments, reason = "one step of one function, split for reading")]
fn move_cells<S: Simd>(
    simd: S,
    grid: &GrainGrid,
    lanes: &mut Lanes,
    at: usize,
    exits: &Exits<S>,
    step: M<S>,
    active: M<S>,
    position: [F<S>; 3],
    [before, center]: [Vector<S>; 2],
) -> Vector<S> {
    let margin = F::splat(simd, grid.margin as f32);
    let zero = F::splat(simd, 0.0);
    let none = i32x16::splat(simd, 0);
    let mut moved = [before.0, before.1, before.2];
    let centers = [center.0, center.1, center.2];
    for axis in 0..3 {
        let side = F::splat(simd, grid.side[axis] as f32);
        let crossed = step & exits.axis[axis];
        let by_place = ((position[axis] - margin) / side).floor();
        let by_place: i32x16<S> = by_place.to_int();
        // A path on an edge of a brick must not be moved back out of it by its other coordinate.
        let [least, greatest] = exits.stay[axis];
        let within = by_place.simd_lt(least).select(least, by_place);
        let within = within.simd_gt(greatest).select(greatest, within);
        let by_place = step.select(within, by_place);
        let shift = crossed.select(exits.cells[axis], by_place);
        let shift = active.select(shift, none);
        let forward = exits.cells[axis].simd_gt(none);
        let face = forward.select(margin, margin + side);
        let offset = simd.cvt_f32_i32x16(shift) * side;
        let place = crossed.select(face, position[axis] - offset);
        let cell = i32x16::from_slice(simd, &lanes.cell.0[axis][at..at + GROUP]);
        (cell + shift).store_slice(&mut lanes.cell.0[axis][at..at + GROUP]);
        (centers[axis] - active.select(offset, zero))
            .store_slice(&mut lanes.grain.0[axis][at..at + GROUP]);
        moved[axis] = active.select(place, moved[axis]);
    }
    Vector(moved[0], moved[1], moved[2])
}
