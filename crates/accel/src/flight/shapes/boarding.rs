//! Paths on their way between [`Lane`], which is followed alone, and [`Stretches`], where sixteen are.

use super::candidates::Kinds;
use super::lane::{BodyPart, Cells, Entry, Lane};
use super::stretches::{Stretches, set_vector, vector};
use super::visits::Visits;
use crate::grain_grid::CellEntry;
use snowgrain_math::DVec3;

impl Stretches {
    /// Takes a path in that is in air.
    #[inline(always)]
    pub(super) fn board(&mut self, at: usize, lane: &Lane, kinds: Kinds<'_>) {
        self.take_place(at, lane);
        self.nearest[at] = lane.nearest.map_or(f64::INFINITY, |nearest| nearest.at);
        let leaving = lane.leaving.unwrap_or(BodyPart::NONE);
        set_vector(&mut self.own_center, at, leaving.center);
        (self.own_word[at], self.own_part[at]) = (leaving.word, leaving.part);
        self.own_radius[at] = leaving.radius;
        let is_alone = leaving.word != 0 && kinds.has_slabs(leaving.word);
        self.alone &= !(1 << at);
        self.alone |= u32::from(is_alone) << at;
        self.entry[at] = lane.entry.0;
        self.air |= 1 << at;
        self.moved |= 1 << at;
    }

    /// Takes over where a path is.
    #[inline(always)]
    pub(super) fn take_place(&mut self, at: usize, lane: &Lane) {
        set_vector(&mut self.origin, at, lane.origin);
        set_vector(&mut self.direction, at, lane.direction);
        set_vector(&mut self.inverse, at, lane.inverse_direction);
        set_vector(&mut self.offset, at, lane.offset);
        self.travelled[at] = lane.travelled;
        for axis in 0..3 {
            self.cell[axis][at] = lane.cell[axis];
            self.home[axis][at] = lane.home[axis];
        }
    }

    /// Tells a path where it is, and what it may meet.
    pub(super) fn land(&self, at: usize, lane: &mut Lane, met: &Visits, kinds: Kinds<'_>) {
        self.tell_place(at, lane);
        lane.nearest = (self.nearest[at] < f64::INFINITY).then(|| {
            let body = met.body(at);
            let face = kinds.has_slabs(body.word).then_some(met.face(at));
            let (block, slot) = met.slot(at);
            Entry { at: self.nearest[at], at_radii: met.enter(at), body, block, slot, face }
        });
        let (word, part) = (self.own_word[at], self.own_part[at]);
        let (center, radius) = (vector(&self.own_center, at), self.own_radius[at]);
        lane.leaving = (word != 0).then_some(BodyPart { center, radius, word, part });
    }

    /// Tells a path where it is.
    pub(super) fn tell_place(&self, at: usize, lane: &mut Lane) {
        lane.origin = vector(&self.origin, at);
        lane.direction = vector(&self.direction, at);
        lane.inverse_direction = vector(&self.inverse, at);
        lane.offset = vector(&self.offset, at);
        lane.travelled = self.travelled[at];
        lane.cell = self.cell.map(|row| row[at]);
        lane.home = self.home.map(|row| row[at]);
        (lane.entry, lane.entry_of) = (CellEntry(self.entry[at]), lane.cell);
    }

    /// Brings a path back into the first period, or to the nearest cell of the grid, that has just begun a stretch.
    pub(super) fn stay_inside(
        &mut self,
        cells: &Cells,
        at: usize,
        lane: &mut Lane,
        grains: &mut Visits,
    ) {
        self.tell_place(at, lane);
        lane.stay_inside(cells);
        let offset = lane.offset;
        lane.origin -= offset;
        lane.offset = DVec3::ZERO;
        lane.home = lane.cell;
        self.take_place(at, lane);
        self.moved |= 1 << at;
        for centers in [&mut self.own_center, &mut grains.center] {
            let center = vector(centers, at);
            set_vector(centers, at, center - offset);
        }
    }

    /// Goes on along a stretch, up to `end` of it, in another grain.
    pub(super) fn go_on(
        &mut self,
        cells: &Cells,
        at: usize,
        lane: &mut Lane,
        end: f64,
        into: BodyPart,
    ) {
        self.tell_place(at, lane);
        lane.seek_cell(cells, end);
        lane.travelled = end;
        self.take_place(at, lane);
        self.moved |= 1 << at;
        set_vector(&mut self.own_center, at, into.center);
        (self.own_word[at], self.own_part[at]) = (into.word, into.part);
        self.own_radius[at] = into.radius;
    }
}
