//! Light in grains between parallel faces: sixteen paths at a time, each in the space of its own grain.
//!
//! What `arrive` and `go_on_in_ice` do with one path. A step takes each path that stands at the end of a chord out or back,
//! then in at its face if it has just arrived, and along one chord; those that are inside wait for the next step, since a
//! loop would be left at a point that no processor can foresee, and since other ice may lie at the end of the chord, of
//! which cells must be asked.
//!
//! The grain that a path in air may meet next is kept here too, until it is met.

use super::GROUP;
use super::candidates::Kinds;
use super::lane::BodyPart;
use super::slabs::{Bodies, D, Interfaces, Truth, Vectors, WIDTH, left, normals, turned};
use super::stretches::{copy_column, next, set_vector, vector};
use crate::flight::random::{NEXT_EVENT, prepared, uniform_24_bits, unprepared};
use crate::flight::vector::W;
use crate::grain_grid::{AXES, ReachedFaces, Slabs};
use fearless_simd::prelude::*;
use fearless_simd::{mask32x16, mask64x8};
use snowgrain_math::DVec3;
use snowgrain_math::sampler::PathKey;

/// The visits of a group. Lengths in radii, but for centres and radii.
#[derive(Clone, Debug)]
pub(super) struct Visits {
    /// Paths that stand outside, at the face by which they would enter, and paths inside, at the end of a chord.
    fresh: u32,
    inside: u32,
    /// Paths that have come from one grain into another.
    crossing: u32,
    /// Paths in grains that other ice may overlap, and which of their faces it may reach.
    overlapping: u32,
    reached: [ReachedFaces; GROUP],
    /// The grains: centres from the corners of the paths' home cells, the axes of their spaces in the world, radii.
    pub(super) center: [[f64; GROUP]; 3],
    axes: [[[f64; GROUP]; 3]; 3],
    radius: [f64; GROUP],
    word: [u64; GROUP],
    part: [u16; GROUP],
    block: [u32; GROUP],
    slot: [u32; GROUP],
    half: [[f64; GROUP]; AXES],
    shrink: [[f64; GROUP]; 2],
    /// Where a path is; of one in air, from where its distances are told.
    place: [[f64; GROUP]; 3],
    direction: [[f64; GROUP]; 3],
    /// Where on its stretch a path in air enters the grain.
    enter: [f64; GROUP],
    /// The face on which a path stands, or by which it enters.
    on: [f64; GROUP],
    ice: [f64; GROUP],
    key: [[u32; GROUP]; 2],
    event: [u32; GROUP],
    turns: [u32; GROUP],
}

impl Default for Visits {
    fn default() -> Self {
        Self {
            fresh: 0,
            inside: 0,
            crossing: 0,
            overlapping: 0,
            reached: [ReachedFaces::NONE; GROUP],
            center: [[0.0; GROUP]; 3],
            axes: [[[0.0; GROUP]; 3]; 3],
            radius: [1.0; GROUP],
            word: [0; GROUP],
            part: [0; GROUP],
            block: [0; GROUP],
            slot: [0; GROUP],
            half: [[0.0; GROUP]; AXES],
            shrink: [[0.0; GROUP]; 2],
            place: [[0.0; GROUP]; 3],
            direction: [[0.0; GROUP]; 3],
            enter: [0.0; GROUP],
            on: [0.0; GROUP],
            ice: [0.0; GROUP],
            key: [[0; GROUP]; 2],
            event: [0; GROUP],
            turns: [0; GROUP],
        }
    }
}

/// A grain that a path meets.
#[derive(Clone, Copy, Debug)]
pub(super) struct Met {
    pub(super) body: BodyPart,
    pub(super) block: usize,
    pub(super) slot: usize,
    pub(super) axes: [DVec3; 3],
    /// The path in the grain's space, and where it enters.
    pub(super) origin: DVec3,
    pub(super) direction: DVec3,
    pub(super) enter: f64,
    /// The face by which it does.
    pub(super) face: f64,
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
    /// Notes the grain that a path in air meets, as far as is known, and its faces where not all grains have the same.
    #[inline(always)]
    pub(super) fn meet(&mut self, at: usize, met: &Met, slabs: Option<&Slabs>) {
        set_vector(&mut self.center, at, met.body.center);
        for (axes, axis) in self.axes.iter_mut().zip(met.axes) {
            set_vector(axes, at, axis);
        }
        set_vector(&mut self.place, at, met.origin);
        set_vector(&mut self.direction, at, met.direction);
        self.radius[at] = met.body.radius;
        (self.word[at], self.part[at]) = (met.body.word, met.body.part);
        (self.block[at], self.slot[at]) = (met.block as u32, met.slot as u32);
        (self.enter[at], self.on[at]) = (met.enter, met.face);
        if let Some(Slabs { half, shrink, .. }) = slabs {
            for (row, half) in self.half.iter_mut().zip(half) {
                row[at] = *half;
            }
            (self.shrink[0][at], self.shrink[1][at]) = (shrink[0], shrink[1]);
        }
    }

    /// The part that was noted.
    pub(super) fn body(&self, at: usize) -> BodyPart {
        let center = vector(&self.center, at);
        BodyPart { center, radius: self.radius[at], word: self.word[at], part: self.part[at] }
    }

    /// Its block and slot.
    #[inline(always)]
    pub(super) fn slot(&self, at: usize) -> (usize, usize) {
        (self.block[at] as usize, self.slot[at] as usize)
    }

    pub(super) fn face(&self, at: usize) -> f64 {
        self.on[at]
    }

    pub(super) fn enter(&self, at: usize) -> f64 {
        self.enter[at]
    }

    #[inline(always)]
    pub(super) fn radius(&self, at: usize) -> f64 {
        self.radius[at]
    }

    #[inline(always)]
    pub(super) fn word(&self, at: usize) -> u64 {
        self.word[at]
    }

    /// Whether other ice may overlap the grain in which a path is.
    pub(super) fn overlaps(&self, at: usize) -> bool {
        self.overlapping >> at & 1 != 0
    }

    /// Takes paths in that have arrived at the grains that were noted.
    #[inline(always)]
    pub(super) fn arrive<S: Simd>(&mut self, simd: S, lanes: u32) {
        for first in [0, WIDTH] {
            let these: Truth<S> = mask64x8::from_bitmask(simd, bits(lanes, first));
            let place = Vectors::load(simd, &self.place, first);
            let direction = Vectors::load(simd, &self.direction, first);
            let enter = D::<S>::from_slice(simd, &self.enter[first..first + WIDTH]);
            let entered = place.plus(direction, enter);
            Vectors::choose(these, entered, place).store(&mut self.place, first);
            let ice = D::<S>::from_slice(simd, &self.ice[first..first + WIDTH]);
            let ice = these.select(D::<S>::splat(simd, 0.0), ice);
            ice.store_slice(&mut self.ice[first..first + WIDTH]);
        }
        self.fresh |= lanes;
    }

    /// Notes the random numbers of a path that arrives, and which faces of its grain other ice may reach.
    #[inline(always)]
    pub(super) fn begin(&mut self, at: usize, key: PathKey, event: u32, reached: ReachedFaces) {
        self.key[0][at] = prepared(key.lo);
        self.key[1][at] = prepared(key.hi);
        self.event[at] = prepared(event);
        self.turns[at] = 0;
        self.set_reached(at, reached);
    }

    /// Lets a path, that stands at the end of its chord `end` quanta after the beginning of its stretch, go on into another
    /// grain.
    pub(super) fn cross(&mut self, at: usize, met: &Met, slabs: Option<&Slabs>, end: f64) {
        self.meet(at, met, slabs);
        self.on[at] = 0.0;
        self.ice[at] = -(end / met.body.radius);
        self.inside &= !(1 << at);
        self.crossing |= 1 << at;
    }

    /// Tells which faces of the grain of a path other ice may reach.
    #[inline(always)]
    pub(super) fn set_reached(&mut self, at: usize, reached: ReachedFaces) {
        self.reached[at] = reached;
        self.overlapping &= !(1 << at);
        self.overlapping |= u32::from(reached != ReachedFaces::NONE) << at;
    }

    /// Whether any path is here.
    #[inline(always)]
    pub(super) fn any(&self) -> bool {
        self.fresh | self.inside | self.crossing != 0
    }

    /// Paths that have come from one grain into another, whose stretches have not begun in these.
    #[inline(always)]
    pub(super) fn crossing(&self) -> u32 {
        self.crossing
    }

    /// Length in ice of a path in its grain, quanta.
    #[inline(always)]
    pub(super) fn ice(&self, at: usize) -> f64 {
        self.ice[at] * self.radius[at]
    }

    /// Paths that stand at the end of a chord on faces that other ice may reach.
    #[inline(always)]
    pub(super) fn may_be_covered(&self) -> u32 {
        let (mut lanes, mut may) = (self.inside & self.overlapping, 0);
        while let Some(at) = next(&mut lanes) {
            may |= u32::from(self.reached[at].has(self.on[at])) << at;
        }
        may
    }

    /// Forgets a path.
    #[inline(always)]
    pub(super) fn end(&mut self, at: usize) {
        self.fresh &= !(1 << at);
        self.inside &= !(1 << at);
        self.crossing &= !(1 << at);
    }

    /// Paths that have met more interfaces than this without coming out.
    #[inline(always)]
    pub(super) fn longer_than<S: Simd>(&self, simd: S, turns: u32) -> u32 {
        let longer = W::<S>::from_slice(simd, &self.turns).simd_gt(W::<S>::splat(simd, turns));
        self.inside & longer.to_bitmask() as u32
    }

    /// Where a path is.
    #[inline(always)]
    pub(super) fn departure(&self, at: usize) -> Departure {
        Departure {
            place: vector(&self.place, at),
            direction: vector(&self.direction, at),
            face: self.on[at],
            ice: self.ice[at],
            event: unprepared(self.event[at]),
            turns: self.turns[at],
        }
    }

    /// Length in ice of a path, quanta, and its next random event.
    #[inline(always)]
    pub(super) fn outcome(&self, at: usize) -> (f64, u32) {
        (self.ice(at), unprepared(self.event[at]))
    }

    /// Copies the path at `from` of `source` to `to`.
    pub(super) fn copy(&mut self, to: usize, source: &Self, from: usize) {
        for (rows, theirs) in [
            (&mut self.center, &source.center),
            (&mut self.place, &source.place),
            (&mut self.direction, &source.direction),
        ] {
            copy_column(rows, to, theirs, from);
        }
        for (rows, theirs) in self.axes.iter_mut().zip(&source.axes) {
            copy_column(rows, to, theirs, from);
        }
        copy_column(&mut self.half, to, &source.half, from);
        copy_column(&mut self.shrink, to, &source.shrink, from);
        copy_column(&mut self.key, to, &source.key, from);
        self.radius[to] = source.radius[from];
        self.word[to] = source.word[from];
        self.part[to] = source.part[from];
        self.block[to] = source.block[from];
        self.slot[to] = source.slot[from];
        self.enter[to] = source.enter[from];
        self.on[to] = source.on[from];
        self.ice[to] = source.ice[from];
        self.event[to] = source.event[from];
        self.turns[to] = source.turns[from];
        self.end(to);
        self.fresh |= (source.fresh >> from & 1) << to;
        self.inside |= (source.inside >> from & 1) << to;
        self.crossing |= (source.crossing >> from & 1) << to;
        self.set_reached(to, source.reached[from]);
    }

    /// At the ends of chords: out, or reflected. Those that are outside.
    #[inline(always)]
    pub(super) fn turn<S: Simd>(&mut self, simd: S, kinds: Kinds<'_>, eta: f64) -> u32 {
        let random = self.random(simd);
        let at_end = self.inside;
        let mut inside = 0;
        for (half, &random) in random.iter().enumerate() {
            let first = half * WIDTH;
            let lanes = bits(at_end, first);
            if lanes != 0 {
                let stays = self.turn_eight(simd, kinds, (first, lanes), eta, random);
                inside |= (stays.to_bitmask() as u32) << first;
            }
        }
        self.use_events(simd, at_end);
        self.inside = inside;
        at_end & !inside
    }

    /// Takes those in that have arrived, in ice of relative index `eta`, and follows all that are inside to the end of a
    /// chord. Those that did not enter, and are no longer here.
    #[inline(always)]
    pub(super) fn travel<S: Simd>(&mut self, simd: S, kinds: Kinds<'_>, eta: f64) -> u32 {
        let random = self.random(simd);
        let (fresh, inside) = (self.fresh, self.inside | self.crossing);
        self.use_events(simd, fresh);
        self.inside = inside;
        for (half, &random) in random.iter().enumerate() {
            let first = half * WIDTH;
            let lanes = [bits(fresh, first), bits(inside, first)];
            if lanes != [0; 2] {
                let entered = self.travel_eight(simd, kinds, (first, lanes), eta, random);
                self.inside |= (entered.to_bitmask() as u32) << first;
            }
        }
        (self.fresh, self.crossing) = (0, 0);
        fresh & !self.inside
    }

    /// Counts an interface of each of these paths.
    #[inline(always)]
    fn use_events<S: Simd>(&mut self, simd: S, lanes: u32) {
        let used = mask32x16::from_bitmask(simd, u64::from(lanes));
        let none = W::<S>::splat(simd, 0);
        for (row, step) in [(&mut self.event, NEXT_EVENT), (&mut self.turns, 1)] {
            let added = used.select(W::<S>::splat(simd, step), none);
            (W::<S>::from_slice(simd, row) + added).store_slice(row);
        }
    }

    /// Places, directions and centres of the grains of eight paths, in the world: from the corners of their home cells.
    #[inline(always)]
    pub(super) fn in_the_world<S: Simd>(&self, simd: S, first: usize) -> [Vectors<S>; 3] {
        let axis = |axis: usize| Vectors::load(simd, &self.axes[axis], first);
        let axes = [axis(0), axis(1), axis(2)];
        let center = Vectors::load(simd, &self.center, first);
        let radius = D::<S>::from_slice(simd, &self.radius[first..first + WIDTH]);
        let place = turned(axes, Vectors::load(simd, &self.place, first));
        let direction = turned(axes, Vectors::load(simd, &self.direction, first));
        [center.plus(place, radius), direction, center]
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
    fn bodies<S: Simd>(&self, simd: S, kinds: Kinds<'_>, first: usize) -> Bodies<S> {
        kinds.bodies(simd, (&self.half, &self.shrink), first)
    }

    /// Of the eight paths from `first` on: which entered.
    #[inline(always)]
    fn travel_eight<S: Simd>(
        &mut self,
        simd: S,
        kinds: Kinds<'_>,
        (first, [fresh, inside]): (usize, [u64; 2]),
        eta: f64,
        random: D<S>,
    ) -> Truth<S> {
        let truth = |lanes| mask64x8::from_bitmask(simd, lanes);
        let (fresh, inside) = (truth(fresh), truth(inside));
        let bodies = self.bodies(simd, kinds, first);
        let place = Vectors::load(simd, &self.place, first);
        let direction = Vectors::load(simd, &self.direction, first);
        let on = D::<S>::from_slice(simd, &self.on[first..first + WIDTH]);
        let outward = normals(simd, &bodies, on, place);
        let at = Interfaces::new(simd, (direction, outward), 1.0 / eta, random);
        let entered = fresh & at.pass;
        let direction = Vectors::choose(fresh, at.turned, direction);
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
        kinds: Kinds<'_>,
        (first, at_end): (usize, u64),
        eta: f64,
        random: D<S>,
    ) -> Truth<S> {
        let at_end: Truth<S> = mask64x8::from_bitmask(simd, at_end);
        let bodies = self.bodies(simd, kinds, first);
        let place = Vectors::load(simd, &self.place, first);
        let direction = Vectors::load(simd, &self.direction, first);
        let on = D::<S>::from_slice(simd, &self.on[first..first + WIDTH]);
        let inward = normals(simd, &bodies, on, place).scaled(D::<S>::splat(simd, -1.0));
        let at = Interfaces::new(simd, (direction, inward), eta, random);
        Vectors::choose(at_end, at.turned, direction).store(&mut self.direction, first);
        at_end & !at.pass
    }
}

/// Those of the eight paths from `first` on.
#[inline(always)]
fn bits(lanes: u32, first: usize) -> u64 {
    u64::from(lanes >> first & ((1 << WIDTH) - 1))
}
