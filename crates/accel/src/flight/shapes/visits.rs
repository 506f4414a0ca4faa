//! Light in grains between parallel faces: sixteen paths at a time, each in the space of its own grain.
//!
//! What `arrive` and `go_on_in_ice` do with one path. A step takes each path in at its face, if it has just arrived,
//! along one chord, and out at its end; those that are reflected there wait for the next step, since a loop would be
//! left at a point that no processor can foresee. Between the chord and its end the caller looks whether other ice lies
//! there.

use super::GROUP;
use super::slabs::{Bodies, D, Interfaces, Truth, Vectors, WIDTH, left, normals};
use crate::flight::random::{NEXT_EVENT, prepared, uniform_24_bits, unprepared};
use crate::flight::vector::W;
use crate::grain_grid::{AXES, Slabs};
use fearless_simd::mask64x8;
use fearless_simd::prelude::*;
use snowgrain_math::DVec3;
use snowgrain_math::sampler::PathKey;

/// The visits of a group. Lengths in radii.
#[derive(Clone, Debug)]
pub(super) struct Visits {
    /// Paths that stand outside, at the face by which they would enter, and paths inside.
    fresh: u32,
    inside: u32,
    /// Paths that have made a chord and stand at its end.
    at_end: u32,
    /// Paths in grains that other ice may overlap.
    overlapping: u32,
    place: [[f64; GROUP]; 3],
    direction: [[f64; GROUP]; 3],
    /// The face on which a path stands.
    on: [f64; GROUP],
    half: [[f64; GROUP]; AXES],
    shrink: [[f64; GROUP]; 2],
    ice: [f64; GROUP],
    key: [[u32; GROUP]; 2],
    event: [u32; GROUP],
    turns: [u32; GROUP],
    /// Of all bodies that have been here.
    has_x: bool,
    has_round: bool,
}

impl Default for Visits {
    fn default() -> Self {
        Self {
            fresh: 0,
            inside: 0,
            at_end: 0,
            overlapping: 0,
            place: [[0.0; GROUP]; 3],
            direction: [[0.0; GROUP]; 3],
            on: [0.0; GROUP],
            half: [[0.0; GROUP]; AXES],
            shrink: [[0.0; GROUP]; 2],
            ice: [0.0; GROUP],
            key: [[0; GROUP]; 2],
            event: [0; GROUP],
            turns: [0; GROUP],
            has_x: false,
            has_round: false,
        }
    }
}

/// Light that arrives at a grain, in the grain's space.
pub(super) struct Arrival<'a> {
    pub(super) place: DVec3,
    pub(super) direction: DVec3,
    /// The face that it meets.
    pub(super) face: f64,
    pub(super) slabs: &'a Slabs,
    /// Whether other ice may overlap the grain.
    pub(super) overlaps: bool,
}

/// A path after its visit, in the grain's space, on the face of the grain.
pub(super) struct Departure {
    pub(super) place: DVec3,
    pub(super) direction: DVec3,
    pub(super) face: f64,
    /// Length in ice.
    pub(super) ice: f64,
    /// Next random event.
    pub(super) event: u32,
    /// Interfaces met, that of its arrival included.
    pub(super) turns: u32,
}

impl Visits {
    /// Takes a path in.
    #[inline(always)]
    pub(super) fn begin(&mut self, at: usize, arrival: &Arrival<'_>, key: PathKey, event: u32) {
        for axis in 0..3 {
            self.place[axis][at] = arrival.place[axis];
            self.direction[axis][at] = arrival.direction[axis];
        }
        let Slabs { half, shrink, .. } = arrival.slabs;
        for (row, half) in self.half.iter_mut().zip(half) {
            row[at] = *half;
        }
        self.shrink[0][at] = shrink[0];
        self.shrink[1][at] = shrink[1];
        self.has_x |= half[AXES - 1] < f64::INFINITY;
        self.has_round |= shrink[0] > 0.0;
        self.on[at] = arrival.face;
        self.ice[at] = 0.0;
        self.key[0][at] = prepared(key.lo);
        self.key[1][at] = prepared(key.hi);
        self.event[at] = prepared(event);
        self.turns[at] = 0;
        self.fresh |= 1 << at;
        self.overlapping &= !(1 << at);
        self.overlapping |= u32::from(arrival.overlaps) << at;
    }

    /// Whether no path is here.
    #[inline(always)]
    pub(super) fn is_empty(&self) -> bool {
        self.fresh | self.inside == 0
    }

    /// Forgets a path.
    pub(super) fn end(&mut self, at: usize) {
        self.fresh &= !(1 << at);
        self.inside &= !(1 << at);
        self.at_end &= !(1 << at);
    }

    /// Paths that have met more interfaces than this without coming out.
    #[inline(always)]
    pub(super) fn longer_than(&self, turns: u32) -> u32 {
        let is_longer = |at: usize| self.inside >> at & 1 != 0 && self.turns[at] > turns;
        (0..GROUP).filter(|&at| is_longer(at)).fold(0, |lanes, at| lanes | 1 << at)
    }

    /// Where a path is.
    #[inline(always)]
    pub(super) fn departure(&self, at: usize) -> Departure {
        let vector = |axes: &[[f64; GROUP]; 3]| DVec3::new(axes[0][at], axes[1][at], axes[2][at]);
        Departure {
            place: vector(&self.place),
            direction: vector(&self.direction),
            face: self.on[at],
            ice: self.ice[at],
            event: unprepared(self.event[at]),
            turns: self.turns[at],
        }
    }

    /// Copies the path at `from` of `source` to `to`.
    pub(super) fn copy(&mut self, to: usize, source: &Self, from: usize) {
        for axis in 0..3 {
            self.place[axis][to] = source.place[axis][from];
            self.direction[axis][to] = source.direction[axis][from];
        }
        for (row, theirs) in self.half.iter_mut().zip(&source.half) {
            row[to] = theirs[from];
        }
        for (row, theirs) in self.shrink.iter_mut().zip(&source.shrink) {
            row[to] = theirs[from];
        }
        for (row, theirs) in self.key.iter_mut().zip(&source.key) {
            row[to] = theirs[from];
        }
        self.on[to] = source.on[from];
        self.ice[to] = source.ice[from];
        self.event[to] = source.event[from];
        self.turns[to] = source.turns[from];
        self.has_x |= source.has_x;
        self.has_round |= source.has_round;
        self.end(to);
        self.fresh |= (source.fresh >> from & 1) << to;
        self.inside |= (source.inside >> from & 1) << to;
        self.overlapping &= !(1 << to);
        self.overlapping |= (source.overlapping >> from & 1) << to;
    }

    /// Takes those in that have arrived, in ice of relative index `eta`, and follows each to the end of its chord. Those of
    /// them are told where other ice may lie.
    #[inline(always)]
    pub(super) fn travel<S: Simd>(&mut self, simd: S, eta: f64) -> u32 {
        let random = self.random(simd);
        self.use_events(self.fresh);
        self.at_end = self.inside;
        for (half, &random) in random.iter().enumerate() {
            let first = half * WIDTH;
            let lanes = [self.fresh, self.inside].map(|lanes| bits(lanes, first));
            if lanes != [0; 2] {
                let entered = self.travel_eight(simd, (first, lanes), eta, random);
                self.at_end |= (entered.to_bitmask() as u32) << first;
            }
        }
        self.at_end & self.overlapping
    }

    /// At the ends of chords: out, or reflected. Those that are outside, and no longer here.
    #[inline(always)]
    pub(super) fn turn<S: Simd>(&mut self, simd: S, eta: f64) -> u32 {
        let random = self.random(simd);
        let here = self.fresh | self.inside;
        let mut inside = 0;
        for (half, &random) in random.iter().enumerate() {
            let first = half * WIDTH;
            let lanes = bits(self.at_end, first);
            if lanes != 0 {
                let stays = self.turn_eight(simd, (first, lanes), eta, random);
                inside |= (stays.to_bitmask() as u32) << first;
            }
        }
        self.use_events(self.at_end);
        (self.fresh, self.inside, self.at_end) = (0, inside, 0);
        here & !inside
    }

    /// Counts an interface of each of these paths.
    #[inline(always)]
    fn use_events(&mut self, lanes: u32) {
        for at in 0..GROUP {
            let used = lanes >> at & 1;
            self.event[at] = self.event[at].wrapping_add(NEXT_EVENT & 0u32.wrapping_sub(used));
            self.turns[at] += used;
        }
    }

    /// The first random number of the next event of each path.
    #[inline(always)]
    fn random<S: Simd>(&self, simd: S) -> [D<S>; GROUP / WIDTH] {
        let words = |row: &[u32; GROUP]| W::<S>::from_slice(simd, row);
        let key = [words(&self.key[0]), words(&self.key[1])];
        let (low, high) = simd.widen_f32x16(uniform_24_bits::<S>(key, words(&self.event)));
        let scale = D::<S>::splat(simd, 1.0 / 16_777_216.0);
        [low * scale, high * scale]
    }

    #[inline(always)]
    fn bodies<S: Simd>(&self, simd: S, first: usize) -> Bodies<S> {
        let flags = (self.has_x, self.has_round);
        Bodies::load(simd, (&self.half, &self.shrink), first, flags)
    }

    /// Of the eight paths from `first` on: which entered.
    #[inline(always)]
    fn travel_eight<S: Simd>(
        &mut self,
        simd: S,
        (first, [fresh, inside]): (usize, [u64; 2]),
        eta: f64,
        random: D<S>,
    ) -> Truth<S> {
        let truth = |lanes| mask64x8::from_bitmask(simd, lanes);
        let (fresh, inside) = (truth(fresh), truth(inside));
        let bodies = self.bodies(simd, first);
        let place = Vectors::load(simd, &self.place, first);
        let direction = Vectors::load(simd, &self.direction, first);
        let on = D::<S>::from_slice(simd, &self.on[first..first + WIDTH]);
        let outward = normals(simd, &bodies, on, place);
        let at = Interfaces::new(simd, (direction, outward), 1.0 / eta, random);
        let entered = fresh & at.pass;
        let turned = Vectors::choose(at.pass, at.refracted, at.reflected);
        let direction = Vectors::choose(fresh, turned, direction);
        direction.store(&mut self.direction, first);
        let travels = entered | inside;
        let (length, by) = left(simd, &bodies, (place, direction), on);
        let length = travels.select(length, D::<S>::splat(simd, 0.0));
        place.plus(direction, length).store(&mut self.place, first);
        travels.select(by, on).store_slice(&mut self.on[first..first + WIDTH]);
        let ice = D::<S>::from_slice(simd, &self.ice[first..first + WIDTH]) + length;
        ice.store_slice(&mut self.ice[first..first + WIDTH]);
        entered
    }

    /// Of the eight paths from `first` on: which are reflected at the end of their chord.
    #[inline(always)]
    fn turn_eight<S: Simd>(
        &mut self,
        simd: S,
        (first, at_end): (usize, u64),
        eta: f64,
        random: D<S>,
    ) -> Truth<S> {
        let at_end: Truth<S> = mask64x8::from_bitmask(simd, at_end);
        let bodies = self.bodies(simd, first);
        let place = Vectors::load(simd, &self.place, first);
        let direction = Vectors::load(simd, &self.direction, first);
        let on = D::<S>::from_slice(simd, &self.on[first..first + WIDTH]);
        let inward = normals(simd, &bodies, on, place).scaled(D::<S>::splat(simd, -1.0));
        let at = Interfaces::new(simd, (direction, inward), eta, random);
        let turned = Vectors::choose(at.pass, at.refracted, at.reflected);
        Vectors::choose(at_end, turned, direction).store(&mut self.direction, first);
        at_end & !at.pass
    }
}

/// Those of the eight paths from `first` on.
#[inline(always)]
fn bits(lanes: u32, first: usize) -> u64 {
    u64::from(lanes >> first & ((1 << WIDTH) - 1))
}
