//! Grains whose bounding spheres paths have come to: eight at a time, where they lie between parallel faces.

use super::axes::{axes, radii};
use super::body::{ELLIPSOID, is_met};
use super::lane::Lane;
use super::near::{around, near};
use super::slabs::{Bodies, D, Vectors, WIDTH, Within, turned_back, within};
use super::stretches::{Stretches, next, vector};
use super::visits::{Met, Visits};
use super::{BodyPart, GROUP, ShapeFlight};
use crate::grain_grid::{
    AXES, Block, BlockShapes, CellEntry, GRAINS_PER_BLOCK, GridShapes, MEETS_SURFACE, Prototype,
    RADIUS_MASK, ROUND, ShapeWord, Slabs,
};
use crate::prefetch::prefetch;
use fearless_simd::prelude::*;
use fearless_simd::u64x8;
use snowgrain_math::DVec3;

/// What the prototypes of a grid are, as far as the vectors ask.
#[derive(Clone, Copy, Debug)]
pub(super) struct Kinds<'a> {
    prototypes: &'a [Prototype],
    /// The only one, if it lies between parallel faces.
    only: Option<&'a Prototype>,
    all_have_slabs: bool,
    /// Whether any has faces along x, and whether any is round.
    has_x: bool,
    has_round: bool,
}

impl<'a> Kinds<'a> {
    pub(super) fn of(shapes: &'a GridShapes) -> Self {
        let prototypes = shapes.prototypes.as_slice();
        let slabs = || prototypes.iter().filter_map(|prototype| prototype.slabs.as_ref());
        Self {
            prototypes,
            only: match prototypes {
                [only] if only.slabs.is_some() => Some(only),
                _ => None,
            },
            all_have_slabs: slabs().count() == prototypes.len(),
            has_x: slabs().any(|slabs| slabs.half[AXES - 1] < f64::INFINITY),
            has_round: slabs().any(|slabs| slabs.shrink[0] > 0.0),
        }
    }

    #[inline(always)]
    fn prototype(&self, word: u64) -> &'a Prototype {
        &self.prototypes[ShapeWord::of_slot(word).shape().prototype()]
    }

    /// The parallel faces of a grain.
    #[inline(always)]
    fn slabs(&self, word: u64) -> Option<&'a Slabs> {
        self.prototype(word).slabs.as_ref()
    }

    /// The same, but `None` where all grains have the same.
    #[inline(always)]
    fn slabs_of(&self, word: u64) -> Option<&'a Slabs> {
        if self.only.is_some() { None } else { self.slabs(word) }
    }

    /// Whether a grain lies between parallel faces.
    #[inline(always)]
    pub(super) fn has_slabs(&self, word: u64) -> bool {
        self.all_have_slabs || self.slabs(word).is_some()
    }

    /// Eight bodies, of whose numbers there are rows.
    #[inline(always)]
    pub(super) fn bodies<S: Simd, const N: usize>(
        &self,
        simd: S,
        rows: (&[[f64; N]; AXES], &[[f64; N]; 2]),
        first: usize,
    ) -> Bodies<S> {
        let flags = (self.has_x, self.has_round);
        match self.only.and_then(|only| only.slabs.as_ref()) {
            Some(slabs) => Bodies::alike(simd, slabs, flags),
            None => Bodies::load(simd, rows, first, flags),
        }
    }
}

/// A block that a path asked.
#[derive(Clone, Copy, Debug, Default)]
struct Asked {
    at: u32,
    block: u32,
}

/// Room for the blocks that the paths of a group ask.
const MOST_ASKED: usize = (GROUP * CellEntry::MAX_BLOCKS_PER_CELL).next_power_of_two();

/// A grain that holds the end of a path's chord.
#[derive(Debug)]
struct Cover {
    at: usize,
    /// Where on the stretch it is left.
    gone: f64,
    met: Met,
}

/// The candidates of a group: grains that its paths may meet, or that may cover the ends of their chords.
#[derive(Debug)]
pub(super) struct Candidates {
    asked: [Asked; MOST_ASKED],
    /// Of each candidate which block was asked, and its slot there in the last four bits.
    candidates: [u32; (MOST_ASKED + 1) * GRAINS_PER_BLOCK],
    count: usize,
    /// Paths that grains of other shapes cover.
    covered: u32,
}

impl Default for Candidates {
    fn default() -> Self {
        Self {
            asked: [Asked::default(); MOST_ASKED],
            candidates: [0; (MOST_ASKED + 1) * GRAINS_PER_BLOCK],
            count: 0,
            covered: 0,
        }
    }
}

/// Room for what is told of candidates.
#[derive(Debug)]
pub(super) struct Scratch {
    covers: Vec<Cover>,
    eights: Vec<Eight>,
    told: Told,
}

impl Default for Scratch {
    fn default() -> Self {
        Self { covers: Vec::new(), eights: Vec::new(), told: Told::NOTHING }
    }
}

/// Candidates as they are listed.
struct List<'a> {
    of_group: &'a mut Candidates,
    blocks: usize,
    found: usize,
}

impl List<'_> {
    /// Adds the `near` slots of a block, asked by a path, and asks for their shapes.
    #[inline(always)]
    fn add(&mut self, (at, number): (usize, usize), mut near: u32, shapes: &BlockShapes) {
        let Candidates { asked, candidates, .. } = &mut *self.of_group;
        let tag = (self.blocks << 4) as u32;
        // Of most blocks two grains at most are near: those are written without a branch that would wait for the answer.
        for _ in 0..2 {
            let slot = near.trailing_zeros() as usize % GRAINS_PER_BLOCK;
            candidates[self.found] = tag | slot as u32;
            prefetch(&shapes[slot]);
            self.found += usize::from(near != 0);
            near &= near.wrapping_sub(1);
        }
        while near != 0 {
            let slot = near.trailing_zeros() as usize % GRAINS_PER_BLOCK;
            candidates[self.found] = tag | slot as u32;
            prefetch(&shapes[slot]);
            self.found += 1;
            near &= near - 1;
        }
        asked[self.blocks] = Asked { at: at as u32, block: number as u32 };
        self.blocks += 1;
    }
}

/// Eight candidates as the vectors want them.
#[derive(Clone, Copy, Debug)]
struct Eight {
    /// Which of them there are: path, block and slot of each.
    used: u32,
    places: [(usize, usize, usize); WIDTH],
    /// From the grain to where the stretch begins, and along what that goes.
    origin: [[f64; WIDTH]; 3],
    direction: [[f64; WIDTH]; 3],
    word: [u64; WIDTH],
    /// Radii of bounding spheres.
    bounding: [f64; WIDTH],
    half: [[f64; WIDTH]; AXES],
    shrink: [[f64; WIDTH]; 2],
    /// How many radii there are to the radius of a bounding sphere.
    inverse_reach: [f64; WIDTH],
}

/// What is told of eight candidates.
#[derive(Debug)]
struct Told {
    axes: [[[f64; WIDTH]; 3]; 3],
    radius: [f64; WIDTH],
    /// The stretch in the spaces of the grains.
    origin: [[f64; WIDTH]; 3],
    direction: [[f64; WIDTH]; 3],
    enter: [f64; WIDTH],
    by: [f64; WIDTH],
    /// Where on the stretch they are entered and left, quanta.
    at: [f64; WIDTH],
    gone: [f64; WIDTH],
    /// Those that are met.
    met: u32,
}

impl Eight {
    const NONE: Self = Self {
        used: 0,
        places: [(0, 0, 0); WIDTH],
        origin: [[0.0; WIDTH]; 3],
        direction: [[0.0; WIDTH]; 3],
        word: [0; WIDTH],
        bounding: [5.0; WIDTH],
        half: [[1.0; WIDTH]; AXES],
        shrink: [[0.0; WIDTH]; 2],
        inverse_reach: [1.0; WIDTH],
    };

    #[inline(always)]
    fn set(
        &mut self,
        i: usize,
        (stretches, at): (&Stretches, usize),
        (block, slot): (&Block, usize),
        word: u64,
    ) {
        self.bounding[i] = f64::from(block.radius[slot] & RADIUS_MASK);
        let center = [block.x[slot], block.y[slot], block.z[slot]];
        for axis in 0..3 {
            let center = f64::from(center[axis]) + stretches.offset[axis][at];
            self.origin[axis][i] = stretches.origin[axis][at] - center;
            self.direction[axis][i] = stretches.direction[axis][at];
        }
        self.word[i] = word;
    }

    #[inline(always)]
    fn set_faces(&mut self, i: usize, Prototype { reach, slabs, .. }: &Prototype) {
        self.inverse_reach[i] = reach.inverse;
        let Some(slabs) = slabs else { return };
        for (row, half) in self.half.iter_mut().zip(slabs.half) {
            row[i] = half;
        }
        (self.shrink[0][i], self.shrink[1][i]) = (slabs.shrink[0], slabs.shrink[1]);
    }

    /// What of the lines lies within the grains; each as the placement of one grain would say.
    #[inline(always)]
    fn ask<S: Simd>(&self, simd: S, kinds: Kinds<'_>, told: &mut Told) {
        let words = u64x8::from_slice(simd, &self.word);
        let axes = axes(simd, words);
        let inverse_reach = match kinds.only {
            Some(only) => D::<S>::splat(simd, only.reach.inverse),
            None => D::<S>::from_slice(simd, &self.inverse_reach),
        };
        let bounding = D::<S>::from_slice(simd, &self.bounding);
        let radius = radii(simd, bounding, inverse_reach);
        let load = |rows: &[[f64; WIDTH]; 3]| Vectors::<S>::load(simd, rows, 0);
        let inverse = D::<S>::splat(simd, 1.0) / radius;
        let origin = turned_back(axes, load(&self.origin)).scaled(inverse);
        let direction = turned_back(axes, load(&self.direction));
        let bodies = kinds.bodies(simd, (&self.half, &self.shrink), 0);
        let Within { enter, leave, by } = within(simd, &bodies, origin, direction);
        let (at, gone) = (enter * radius, leave * radius);
        told.met = enter.simd_lt(leave).to_bitmask() as u32;
        let [x, y, z] = axes;
        x.store(&mut told.axes[0], 0);
        y.store(&mut told.axes[1], 0);
        z.store(&mut told.axes[2], 0);
        radius.store_slice(&mut told.radius);
        origin.store(&mut told.origin, 0);
        direction.store(&mut told.direction, 0);
        enter.store_slice(&mut told.enter);
        by.store_slice(&mut told.by);
        at.store_slice(&mut told.at);
        gone.store_slice(&mut told.gone);
    }
}

impl Told {
    const NOTHING: Self = Self {
        axes: [[[0.0; WIDTH]; 3]; 3],
        radius: [0.0; WIDTH],
        origin: [[0.0; WIDTH]; 3],
        direction: [[0.0; WIDTH]; 3],
        enter: [0.0; WIDTH],
        by: [0.0; WIDTH],
        at: [0.0; WIDTH],
        gone: [0.0; WIDTH],
        met: 0,
    };

    /// The grain of one of the eight.
    #[inline(always)]
    fn met(&self, i: usize, (block, slot): (usize, usize), body: BodyPart) -> Met {
        let of = |rows: &[[f64; WIDTH]; 3]| DVec3::new(rows[0][i], rows[1][i], rows[2][i]);
        Met {
            body,
            block,
            slot,
            axes: self.axes.each_ref().map(of),
            origin: of(&self.origin),
            direction: of(&self.direction),
            enter: self.enter[i],
            face: self.by[i],
        }
    }
}

impl ShapeFlight<'_> {
    /// Notes the grains that the paths of a group may meet before they leave their cells, or that may cover the ends of
    /// their chords, and looks at once at those of other shapes.
    #[inline(always)]
    pub(super) fn gather<S: Simd>(&mut self, simd: S, first: usize) {
        let stretches = &self.stretches[first / GROUP];
        let shapes = self.shapes.blocks.as_slice();
        let get = |rows: &[[f32; GROUP]; 3], at: usize| [rows[0][at], rows[1][at], rows[2][at]];
        let of_group = &mut self.candidates[first / GROUP];
        let mut list = List { of_group, blocks: 0, found: 0 };
        let mut lanes = stretches.air;
        while let Some(at) = next(&mut lanes) {
            let ray = (get(&stretches.position, at), get(&stretches.course, at));
            let window = stretches.window(at);
            let but = get(&stretches.own, at);
            for number in CellEntry(stretches.entry[at]).blocks() {
                let block = &self.grid.blocks()[number];
                let near = near(simd, block, ray, window, but);
                list.add((at, number), near.to_bitmask() as u32, &shapes[number]);
            }
        }
        let mut lanes = stretches.asking;
        while let Some(at) = next(&mut lanes) {
            let (position, but) = (get(&stretches.position, at), get(&stretches.own, at));
            for number in CellEntry(stretches.entry[at]).blocks() {
                let block = &self.grid.blocks()[number];
                let around = around(simd, block, position, but);
                list.add((at, number), around.to_bitmask() as u32, &shapes[number]);
            }
        }
        (list.of_group.count, list.of_group.covered) = (list.found, 0);
        if !self.kinds.all_have_slabs || self.shapes.concentric {
            let others = self.sort_out(first);
            self.candidates[first / GROUP].covered = self.look_at_others(simd, first, others);
        }
    }

    /// Takes the grains of other shapes, and those that paths stand on, out of the candidates; the paths that may meet the
    /// former.
    fn sort_out(&mut self, first: usize) -> u32 {
        let Candidates { asked, candidates, count, .. } = &mut self.candidates[first / GROUP];
        let (mut kept, mut others) = (0, 0);
        for index in 0..*count {
            let candidate = candidates[index];
            let Asked { at, block } = asked[candidate as usize / GRAINS_PER_BLOCK];
            let (block, slot) = (block as usize, candidate as usize % GRAINS_PER_BLOCK);
            let word = self.shapes.blocks[block][slot];
            let center = self.grid.blocks()[block].center(slot);
            if !self.kinds.has_slabs(word) {
                others |= 1 << at;
            } else if !self.stretches[first / GROUP].is_own(at as usize, center, word) {
                candidates[kept] = candidate;
                kept += 1;
            }
        }
        *count = kept;
        others
    }

    /// Looks at the grains of other shapes that these paths may meet, one by one, and notes the nearest; which paths are
    /// covered.
    #[inline(always)]
    fn look_at_others<S: Simd>(&mut self, simd: S, first: usize, mut lanes: u32) -> u32 {
        let mut covered = 0;
        while let Some(at) = next(&mut lanes) {
            if self.stretches[first / GROUP].asking >> at & 1 != 0 {
                self.tell_where_inside(first + at);
                covered |= u32::from(self.farthest_cover(simd, first + at).is_some()) << at;
            } else {
                self.land(first + at);
                self.note_nearest_of_others(simd, first + at);
            }
        }
        covered
    }

    /// Looks at the grains of other shapes that a path in air may meet, which has been told where it is.
    #[inline(always)]
    fn note_nearest_of_others<S: Simd>(&mut self, simd: S, index: usize) {
        let lane: &Lane = &self.lanes[index];
        let limit = self.stretches[index / GROUP].exit[index % GROUP];
        let mut nearest = lane.nearest;
        self.for_each_near(simd, lane, limit, |block, slot| {
            if !self.kinds.has_slabs(self.shapes.blocks[block][slot]) {
                nearest = self.nearer(lane, (block, slot), nearest);
            }
            nearest
        });
        let Some(entry) = nearest.filter(|entry| entry.face.is_none()) else { return };
        let met = Met {
            body: entry.body,
            block: entry.block,
            slot: entry.slot,
            axes: [DVec3::X, DVec3::Y, DVec3::Z],
            origin: DVec3::ZERO,
            direction: DVec3::X,
            enter: entry.at_radii,
            face: 0.0,
        };
        self.in_grains[index / GROUP].meet(index % GROUP, &met, None);
        self.stretches[index / GROUP].nearest[index % GROUP] = entry.at;
    }

    /// Looks at candidates: of each path in air the nearest that it enters, the first of two that it enters in one point;
    /// and those that hold the ends of chords.
    #[inline(always)]
    pub(super) fn meet<S: Simd>(&mut self, simd: S, first: usize) {
        let Candidates { asked, candidates, count, .. } = &self.candidates[first / GROUP];
        let Scratch { covers, eights, told } = &mut *self.scratch;
        let (kinds, blocks, shapes) = (self.kinds, self.grid.blocks(), self.shapes);
        let stretches = &mut self.stretches[first / GROUP];
        let grains: &mut Visits = &mut self.in_grains[first / GROUP];
        let needed = count.div_ceil(WIDTH);
        if eights.len() < needed {
            eights.resize(needed, Eight::NONE);
        }
        // All are written before any is read: a vector of numbers that were just written one by one must wait for them.
        for (eight, some) in eights.iter_mut().zip(candidates[..*count].chunks(WIDTH)) {
            eight.used = (1 << some.len()) - 1;
            for (i, &candidate) in some.iter().enumerate() {
                let Asked { at, block } = asked[candidate as usize / GRAINS_PER_BLOCK % MOST_ASKED];
                let (at, number) = (at as usize & (GROUP - 1), block as usize);
                let (block, slot) = (&blocks[number], candidate as usize % GRAINS_PER_BLOCK);
                eight.places[i] = (at, number, slot);
                let word = shapes.blocks[number][slot];
                eight.set(i, (stretches, at), (block, slot), word);
                if kinds.only.is_none() {
                    eight.set_faces(i, kinds.prototype(word));
                }
            }
        }
        for eight in &eights[..needed] {
            eight.ask(simd, kinds, told);
            let mut met = told.met & eight.used;
            while met != 0 {
                let i = met.trailing_zeros() as usize & (WIDTH - 1);
                met &= met - 1;
                let (at, block, slot) = eight.places[i];
                let (enters, gone) = (told.at[i], told.gone[i]);
                let asks = stretches.asking >> at & 1 != 0;
                let travelled = stretches.travelled[at];
                let is_covered = asks & (gone > travelled) & (enters <= travelled);
                let is_met = is_met([enters, gone], travelled, stretches.stands_on_ice(at));
                if !is_covered & (asks | !is_met | (enters >= stretches.nearest[at])) {
                    continue;
                }
                let word = eight.word[i];
                let center = vector(&stretches.offset, at) + blocks[block].center(slot);
                let radius = told.radius[i];
                let body = BodyPart { center, radius, word, part: 0 };
                let met = told.met(i, (block, slot), body);
                if is_covered {
                    covers.push(Cover { at, gone, met });
                } else {
                    stretches.nearest[at] = enters;
                    grains.meet(at, &met, kinds.slabs_of(word));
                }
            }
        }
    }

    /// Lets the paths at whose chords' ends other ice lies go on into the grain that they leave last; but those that are
    /// covered by grains of other shapes, and those that few paths are like, as those in such grains do.
    #[inline(always)]
    pub(super) fn cross(&mut self, first: usize) {
        let mut covered = self.candidates[first / GROUP].covered;
        if self.scratch.covers.is_empty() && covered == 0 {
            return;
        }
        let mut covers = std::mem::take(&mut self.scratch.covers);
        let (mut crosses, is_noted) = (0u32, self.visits.is_some());
        for cover in &covers {
            let flags = self.grid.blocks()[cover.met.block].radius[cover.met.slot];
            let is_rare = is_noted || flags & MEETS_SURFACE != 0;
            crosses |= 1 << cover.at;
            covered |= u32::from(is_rare) << cover.at;
        }
        crosses &= !covered;
        while let Some(at) = next(&mut crosses) {
            let of_it = covers.iter().filter(|cover| cover.at == at);
            let last = of_it.reduce(|last, next| if next.gone > last.gone { next } else { last });
            if let Some(cover) = last {
                self.cross_into(first + at, cover);
            }
        }
        covers.clear();
        self.scratch.covers = covers;
        while let Some(at) = next(&mut covered) {
            self.leave_visit(first + at);
        }
    }

    /// Lets a path go on into another grain along its stretch.
    fn cross_into(&mut self, index: usize, Cover { gone, met, .. }: &Cover) {
        let (group, at) = (index / GROUP, index % GROUP);
        let (lane, grains) = (&mut self.lanes[index], &mut self.in_grains[group]);
        lane.add_ice(grains.ice(at));
        lane.inside.stratum =
            self.grid.strata().get(met.block).map_or(0, |strata| strata[met.slot]);
        let end = self.stretches[group].travelled[at];
        grains.cross(at, met, self.kinds.slabs_of(met.body.word), end);
        grains.set_reached(at, ShapeWord::of_slot(met.body.word).reached());
        self.stretches[group].go_on(&self.cells, at, lane, *gone, met.body);
    }
}

/// The part of the surface of a body that a face is.
#[inline(always)]
pub(super) fn part_of(slabs: &Slabs, face: f64) -> u16 {
    if face == ROUND { ELLIPSOID } else { slabs.face(face) }
}
