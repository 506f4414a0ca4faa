//! The state of the paths in flight among packed grains.

use crate::STRATA;
use crate::flight::LANES;
use crate::flight::random::{prepared, unprepared};
use crate::grain_grid::{CellEntry, GridPosition};
use snowgrain_math::sampler::PathKey;

/// Paths of one group, which are updated together.
pub(super) const GROUP: usize = 16;
/// Groups in flight.
pub(super) const GROUPS: usize = LANES / GROUP;

/// No grain: larger than any distance inside a grid.
pub(super) const NOTHING: f32 = 1.0e30;

/// Sixteen paths. Lengths in quanta, positions in cell quanta. A path is in at most one of the sets
/// `air`, `ice` and `inside` (bit `i` for lane `i`); one that is in none waits for the caller.
#[derive(Clone, Debug, Default)]
#[repr(C, align(64))]
pub(super) struct Group {
    pub(super) position: [[f32; GROUP]; 3],
    /// Of unit length; for paths `inside`, what `sphere` keeps in its place.
    pub(super) direction: [[f32; GROUP]; 3],
    pub(super) cell: [[i32; GROUP]; 3],
    /// Centre of the grain that the path is in, relative to the path's cell.
    pub(super) grain: [[f32; GROUP]; 3],
    /// Radius of that grain, with its flags.
    pub(super) grain_radius: [u32; GROUP],
    /// The answer of the block test: [`NOTHING`], or the grain that was found.
    pub(super) found: [f32; GROUP],
    /// Its block.
    pub(super) found_block: [u32; GROUP],
    pub(super) found_grain: [[u16; GROUP]; 3],
    pub(super) found_radius: [u16; GROUP],
    /// Strata of that grain and of the one that the path is in, where the grid has any.
    pub(super) found_stratum: [u8; GROUP],
    pub(super) grain_stratum: [u8; GROUP],
    /// Length in ice of each stratum from 1 on.
    pub(super) ice_in_strata: [[f32; GROUP]; STRATA],
    /// Number of the brick of the path's cell, and the cell's place in it.
    pub(super) brick: [u32; GROUP],
    pub(super) within_brick: [u32; GROUP],
    /// What the path's cell holds.
    pub(super) entry: [u32; GROUP],
    /// Outside cosine of the current chord, shared by all reflections within one sphere; -1 where
    /// it has to be taken from the geometry.
    pub(super) cos_outside: [f32; GROUP],
    /// Length of the last chord.
    pub(super) chord: [f32; GROUP],
    pub(super) ice_length: [f32; GROUP],
    pub(super) air_length: [f32; GROUP],
    /// Key and next event as the hash wants them (`random`).
    pub(super) key: [[u32; GROUP]; 2],
    pub(super) event: [u32; GROUP],
    pub(super) visits: [u32; GROUP],
    /// Interfaces met since the path was last in air.
    pub(super) turns: [u32; GROUP],
    /// Periods crossed along each axis since the path entered the grid.
    pub(super) periods: [[i32; GROUP]; 3],
    /// Paths in air, looking for the next grain.
    pub(super) air: u32,
    /// Paths at the end of a chord of a grain that others overlap or that meets a surface: interface,
    /// or more ice?
    pub(super) ice: u32,
    /// Paths reflected inside a grain that touches nothing.
    pub(super) inside: u32,
    /// Paths of `air` and `ice` whose answer waits for the next update.
    pub(super) waiting: u32,
    /// Paths whose cell a surface crosses.
    pub(super) near_surface: u32,
    /// Paths whose cell holds more than one block.
    pub(super) crowded: u32,
}

/// The first grains that the paths of a group met; written once a path.
#[derive(Clone, Debug, Default)]
pub(super) struct FirstGrains {
    pub(super) normal: [[f32; GROUP]; 3],
    pub(super) position: [[f32; GROUP]; 3],
    pub(super) cell: [[i32; GROUP]; 3],
}

/// Where `lane` is kept: its group, and its place there.
pub(super) fn place_of(lane: usize) -> (usize, usize) {
    (lane / GROUP, lane % GROUP)
}

/// One component of every axis.
pub(super) fn get<T: Copy>(axes: &[[T; GROUP]; 3], at: usize) -> [T; 3] {
    [axes[0][at], axes[1][at], axes[2][at]]
}

/// Sets one component of every axis.
pub(super) fn set<T: Copy>(axes: &mut [[T; GROUP]; 3], at: usize, value: [T; 3]) {
    for (array, value) in axes.iter_mut().zip(value) {
        array[at] = value;
    }
}

impl Group {
    /// Paths in flight.
    pub(super) fn flying(&self) -> u32 {
        self.air | self.ice | self.inside
    }

    /// Takes the path at `at` out of flight.
    pub(super) fn pause(&mut self, at: usize) {
        let others = !(1 << at);
        self.air &= others;
        self.ice &= others;
        self.inside &= others;
        self.waiting &= others;
    }

    /// A new path, not yet in flight.
    pub(super) fn launch(&mut self, at: usize, key: PathKey, event: u32) {
        self.key[0][at] = prepared(key.lo);
        self.key[1][at] = prepared(key.hi);
        self.set_event(at, event);
        self.ice_length[at] = 0.0;
        self.ice_in_strata.iter_mut().for_each(|lengths| lengths[at] = 0.0);
        self.air_length[at] = 0.0;
        self.visits[at] = 0;
        self.turns[at] = 0;
        self.pause(at);
    }

    pub(super) fn path_key(&self, at: usize) -> PathKey {
        PathKey { lo: unprepared(self.key[0][at]), hi: unprepared(self.key[1][at]) }
    }

    pub(super) fn event(&self, at: usize) -> u32 {
        unprepared(self.event[at])
    }

    pub(super) fn set_event(&mut self, at: usize, event: u32) {
        self.event[at] = prepared(event);
    }

    pub(super) fn place(&self, at: usize) -> GridPosition {
        GridPosition { cell: get(&self.cell, at), local: get(&self.position, at) }
    }

    /// Tells what the path's cell holds.
    pub(super) fn set_entry(&mut self, at: usize, entry: CellEntry) {
        self.entry[at] = entry.0;
        let others = !(1 << at);
        let crowded = !entry.further_blocks().is_empty();
        self.near_surface = self.near_surface & others | u32::from(entry.has_surface()) << at;
        self.crowded = self.crowded & others | u32::from(crowded) << at;
    }

    /// Adds to the length in ice of the grain that the path is in, and takes away what is negative.
    pub(super) fn add_ice(&mut self, at: usize, length: f32) {
        self.ice_length[at] += length;
        if let Some(stratum) = usize::from(self.grain_stratum[at]).checked_sub(1) {
            self.ice_in_strata[stratum][at] += length;
        }
    }

    /// After an update: the paths `took` are in the grain that was found, and those of `chords` have made
    /// the chord that is in the length in ice already.
    pub(super) fn add_to_strata(&mut self, took: u32, mut chords: u32) {
        let mut rest = took;
        while rest != 0 {
            let at = rest.trailing_zeros() as usize & (GROUP - 1);
            rest &= rest - 1;
            self.grain_stratum[at] = self.found_stratum[at];
        }
        while chords != 0 {
            let at = chords.trailing_zeros() as usize & (GROUP - 1);
            chords &= chords - 1;
            if let Some(stratum) = usize::from(self.grain_stratum[at]).checked_sub(1) {
                self.ice_in_strata[stratum][at] += self.chord[at];
            }
        }
    }

    /// Copies the path at `from` of `source` to `to`.
    pub(super) fn copy_path(&mut self, to: usize, source: &Self, from: usize) {
        for (mine, theirs) in [
            (&mut self.position, &source.position),
            (&mut self.direction, &source.direction),
            (&mut self.grain, &source.grain),
        ] {
            set(mine, to, get(theirs, from));
        }
        set(&mut self.cell, to, get(&source.cell, from));
        set(&mut self.periods, to, get(&source.periods, from));
        set(&mut self.found_grain, to, get(&source.found_grain, from));
        self.found_radius[to] = source.found_radius[from];
        self.found_stratum[to] = source.found_stratum[from];
        self.grain_stratum[to] = source.grain_stratum[from];
        for (mine, theirs) in self.ice_in_strata.iter_mut().zip(&source.ice_in_strata) {
            mine[to] = theirs[from];
        }
        for (mine, theirs) in [
            (&mut self.cos_outside, &source.cos_outside),
            (&mut self.found, &source.found),
            (&mut self.chord, &source.chord),
            (&mut self.ice_length, &source.ice_length),
            (&mut self.air_length, &source.air_length),
        ] {
            mine[to] = theirs[from];
        }
        let [key_lo, key_hi] = &mut self.key;
        for (mine, theirs) in [
            (&mut self.grain_radius, &source.grain_radius),
            (key_lo, &source.key[0]),
            (key_hi, &source.key[1]),
            (&mut self.event, &source.event),
            (&mut self.visits, &source.visits),
            (&mut self.turns, &source.turns),
            (&mut self.entry, &source.entry),
        ] {
            mine[to] = theirs[from];
        }
        self.pause(to);
        for (mine, theirs) in [
            (&mut self.air, source.air),
            (&mut self.ice, source.ice),
            (&mut self.inside, source.inside),
            (&mut self.waiting, source.waiting),
            (&mut self.near_surface, source.near_surface),
            (&mut self.crowded, source.crowded),
        ] {
            *mine = *mine & !(1 << to) | (theirs >> from & 1) << to;
        }
    }
}
