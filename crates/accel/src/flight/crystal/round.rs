//! One round of all paths: across a face, then perhaps through a grain.

use super::{CrystalFlight, FirstGrains, GROUP, Group};
use crate::flight::FlightEvent;
use crate::flight::sphere::{Arrival, Ice, visit};
use crate::flight::vector::{F, M, Vector, W, WIDTH};
use crate::grain_grid::{LatticeSites, SiteKind};
use fearless_simd::prelude::*;

/// A lattice, by the faces of its Voronoi cells.
trait Lattice {
    /// Takes all pairs of opposite faces into account.
    fn faces<S: Simd>(simd: S, exit: Exit<S>) -> Exit<S>;
}

struct SimpleCubic;
struct BodyCentred;
struct FaceCentred;

impl Lattice for SimpleCubic {
    #[inline(always)]
    fn faces<S: Simd>(simd: S, exit: Exit<S>) -> Exit<S> {
        exit.pair::<1, 0, 0, 2>(simd).pair::<0, 1, 0, 2>(simd).pair::<0, 0, 1, 2>(simd)
    }
}

impl Lattice for BodyCentred {
    #[inline(always)]
    fn faces<S: Simd>(simd: S, exit: Exit<S>) -> Exit<S> {
        let exit = SimpleCubic::faces(simd, exit);
        let exit = exit.pair::<1, 1, 1, 1>(simd).pair::<1, 1, -1, 1>(simd);
        exit.pair::<1, -1, 1, 1>(simd).pair::<-1, 1, 1, 1>(simd)
    }
}

impl Lattice for FaceCentred {
    #[inline(always)]
    fn faces<S: Simd>(simd: S, exit: Exit<S>) -> Exit<S> {
        let exit = exit.pair::<1, 1, 0, 1>(simd).pair::<1, -1, 0, 1>(simd);
        let exit = exit.pair::<1, 0, 1, 1>(simd).pair::<1, 0, -1, 1>(simd);
        exit.pair::<0, 1, 1, 1>(simd).pair::<0, 1, -1, 1>(simd)
    }
}

/// Rounds until a path leaves or none is in flight.
#[inline(always)]
pub(super) fn run<S: Simd>(
    simd: S,
    flight: &mut CrystalFlight<'_>,
    events: &mut Vec<(usize, FlightEvent)>,
) {
    match flight.sites.kind {
        SiteKind::SimpleCubic => run_in::<S, SimpleCubic>(simd, flight, events),
        SiteKind::BodyCentred => run_in::<S, BodyCentred>(simd, flight, events),
        SiteKind::FaceCentred => run_in::<S, FaceCentred>(simd, flight, events),
    }
}

#[inline(always)]
fn run_in<S: Simd, L: Lattice>(
    simd: S,
    flight: &mut CrystalFlight<'_>,
    events: &mut Vec<(usize, FlightEvent)>,
) {
    let groups = flight.in_use.div_ceil(GROUP);
    if flight.groups[..groups].iter().all(|group| group.flies == [0; GROUP]) {
        return;
    }
    while events.is_empty() {
        for index in 0..groups {
            let (group, first) = (&mut flight.groups[index], &mut flight.first[index]);
            let mut left = 0;
            for at in (0..GROUP).step_by(WIDTH) {
                left |= round::<S, L>(simd, flight.sites, flight.ice, group, first, at) << at;
            }
            while left != 0 {
                events.push((index * GROUP + left.trailing_zeros() as usize, FlightEvent::Left));
                left &= left - 1;
            }
        }
    }
}

/// `value` with its sign flipped where that of `sign` is set.
#[inline(always)]
fn signed<S: Simd>(simd: S, value: F<S>, sign: F<S>) -> F<S> {
    let mask = W::<S>::splat(simd, 1 << 31);
    let bits: W<S> = value.bitcast();
    let sign: W<S> = sign.bitcast();
    (bits ^ (sign & mask)).bitcast()
}

/// `i x + j y + k z` for factors -1, 0 and 1.
#[inline(always)]
fn along<S: Simd, const I: i8, const J: i8, const K: i8>(simd: S, v: Vector<S>) -> F<S> {
    let sum = plus_signed::<S, K>(plus_signed::<S, J>(plus_signed::<S, I>(None, v.0), v.1), v.2);
    match sum {
        Some(sum) => sum,
        None => F::<S>::splat(simd, 0.0),
    }
}

#[inline(always)]
fn plus_signed<S: Simd, const SIGN: i8>(sum: Option<F<S>>, value: F<S>) -> Option<F<S>> {
    match (sum, SIGN) {
        (sum, 0) => sum,
        (None, 1) => Some(value),
        (Some(sum), 1) => Some(sum + value),
        (None, _) => Some(-value),
        (Some(sum), _) => Some(sum - value),
    }
}

/// Where paths leave their cells.
#[derive(Clone, Copy)]
struct Exit<S: Simd> {
    position: Vector<S>,
    direction: Vector<S>,
    half_edge: F<S>,
    /// Distance to the face, and the step to the site beyond.
    distance: F<S>,
    step: Vector<S>,
}

impl<S: Simd> Exit<S> {
    /// Through the nearest face of `L`, never behind the path.
    #[inline(always)]
    fn find<L: Lattice>(
        simd: S,
        half_edge: f32,
        position: Vector<S>,
        direction: Vector<S>,
    ) -> Self {
        let zero = F::<S>::splat(simd, 0.0);
        let exit = L::faces(
            simd,
            Self {
                position,
                direction,
                half_edge: F::<S>::splat(simd, half_edge),
                distance: F::<S>::splat(simd, f32::INFINITY),
                step: Vector(zero, zero, zero),
            },
        );
        Self { distance: exit.distance.simd_gt(zero).select(exit.distance, zero), ..exit }
    }

    /// The faces half way to the sites at `STEPS (I, J, K)` and `-STEPS (I, J, K)`, in half edges.
    #[inline(always)]
    fn pair<const I: i8, const J: i8, const K: i8, const STEPS: u8>(self, simd: S) -> Self {
        let half_length = 0.5 * f32::from(STEPS) * f32::from(I * I + J * J + K * K);
        let limit = self.half_edge * F::<S>::splat(simd, half_length);
        let speed = along::<S, I, J, K>(simd, self.direction);
        let ahead = limit - signed(simd, along::<S, I, J, K>(simd, self.position), speed);
        let (pace, tiny) = (speed.abs(), F::<S>::splat(simd, 1.0e-30));
        let distance = ahead / pace.simd_gt(tiny).select(pace, tiny);
        let nearer = distance.simd_lt(self.distance);
        let step = Vector(
            step_along::<S, I, STEPS>(simd, speed),
            step_along::<S, J, STEPS>(simd, speed),
            step_along::<S, K, STEPS>(simd, speed),
        );
        Self {
            distance: nearer.select(distance, self.distance),
            step: Vector::choose(nearer, step, self.step),
            ..self
        }
    }
}

/// `STEPS * SIGN`, with the sign of `speed` too.
#[inline(always)]
fn step_along<S: Simd, const SIGN: i8, const STEPS: u8>(simd: S, speed: F<S>) -> F<S> {
    let length = F::<S>::splat(simd, f32::from(STEPS) * f32::from(SIGN));
    if SIGN == 0 { length } else { signed(simd, length, speed) }
}

/// A round of the paths from `at` on; the bits of those that have left. Lanes without a path compute
/// what nobody looks at.
#[inline(always)]
fn round<S: Simd, L: Lattice>(
    simd: S,
    sites: &LatticeSites,
    ice: Ice,
    group: &mut Group,
    first: &mut FirstGrains,
    at: usize,
) -> u64 {
    let splat = |v: f32| F::<S>::splat(simd, v);
    let word = |v: u32| W::<S>::splat(simd, v);
    let zero = splat(0.0);
    let range = at..at + WIDTH;
    let words = |array: &[u32; GROUP]| W::<S>::from_slice(simd, &array[range.clone()]);
    let numbers = |array: &[f32; GROUP]| F::<S>::from_slice(simd, &array[range.clone()]);

    // Across the face.
    let flies = M::<S>::from_slice(simd, &group.flies[range.clone()]);
    let crosses = M::<S>::from_slice(simd, &group.crosses[range.clone()]);
    let direction = Vector::load(simd, &group.direction, at);
    let position = Vector::load(simd, &group.position, at);
    let exit = Exit::find::<L>(simd, sites.half_edge, position, direction);
    let distance = crosses.select(exit.distance, zero);
    let step = Vector::choose(crosses, exit.step, Vector(zero, zero, zero));
    let position = position.plus(direction, distance).plus(step, splat(0.0 - sites.half_edge));
    let site = Vector::load(simd, &group.site, at).plus(step, splat(1.0));
    site.store(&mut group.site, at);

    // Where that is: in the crystal, at its ragged edge, or beyond it.
    let (middle, reach) = (sites.middle, sites.reach);
    let x = (site.0 - splat(middle[0])).abs() - splat(reach[0]);
    let y = (site.1 - splat(middle[1])).abs() - splat(reach[1]);
    let z = (site.2 - splat(middle[2])).abs() - splat(reach[2]);
    let xy = x.simd_gt(y).select(x, y);
    let beyond = xy.simd_gt(z).select(xy, z);
    let left = flies & beyond.simd_gt(splat(1.5));
    let occupied = beyond.simd_lt(splat(0.5));

    // Is its grain met? The perpendicular from the centre is squared directly, so that nothing
    // cancels (Haines et al. 2019, "Precision Improvements for Ray/Sphere Intersection").
    let middle = zero - position.dot(direction);
    let foot = position.plus(direction, middle);
    let radius = splat(sites.radius);
    let discriminant = radius * radius - foot.dot(foot);
    let inside = M::<S>::from_slice(simd, &group.inside[range.clone()]);
    let hit = occupied & middle.simd_gt(zero) & discriminant.simd_gt(zero) & !inside;
    let half = discriminant.simd_gt(zero).select(discriminant, zero).sqrt();
    let travelled = distance + hit.select(middle - half, zero);
    let inverse_radius = splat(1.0 / sites.radius);
    let foot = Vector::choose(inside, position, foot);
    let normal = foot.plus(direction, inside.select(zero, zero - half)).scaled(inverse_radius);
    let cosine = hit.select(half * inverse_radius, zero);
    let outside = inside.select(numbers(&group.cos_outside), cosine);
    outside.store_slice(&mut group.cos_outside[range.clone()]);

    let visits = words(&group.visits);
    let meets_first = hit & visits.simd_eq(word(0));
    if meets_first.any_true() {
        remember(first, at, meets_first, normal, site);
    }
    let key = [words(&group.key[0]), words(&group.key[1])];
    let arrival = Arrival { hit, inside, direction, normal, outside };
    let after = visit(simd, ice, &arrival, key, words(&group.event));

    after.direction.store(&mut group.direction, at);
    Vector::choose(hit | inside, after.normal.scaled(radius), position)
        .store(&mut group.position, at);
    (numbers(&group.ice_length) + after.chord * radius)
        .store_slice(&mut group.ice_length[range.clone()]);
    (numbers(&group.air_length) + travelled).store_slice(&mut group.air_length[range.clone()]);
    after.event.store_slice(&mut group.event[range.clone()]);
    (visits + hit.select(word(1), word(0))).store_slice(&mut group.visits[range.clone()]);
    (flies & !left).store_slice(&mut group.flies[range.clone()]);
    after.inside.store_slice(&mut group.inside[range.clone()]);
    (!after.inside).store_slice(&mut group.crosses[range]);
    left.to_bitmask()
}

/// Keeps the first grain of the paths `which`.
#[inline(never)]
fn remember<S: Simd>(
    first: &mut FirstGrains,
    at: usize,
    which: M<S>,
    normal: Vector<S>,
    site: Vector<S>,
) {
    let mut left = which.to_bitmask();
    while left != 0 {
        let lane = left.trailing_zeros() as usize;
        left &= left - 1;
        for (axis, (normal, site)) in
            [(normal.0, site.0), (normal.1, site.1), (normal.2, site.2)].iter().enumerate()
        {
            first.normal[axis][at + lane] = normal.as_slice()[lane];
            first.site[axis][at + lane] = site.as_slice()[lane];
        }
    }
}
