//! The state of the paths in flight, one array a quantity.

use crate::flight::LANES;
use snowgrain_math::IVec3;

/// What a path is doing.
pub(crate) mod mode {
    /// Waits for the caller: unused, retired, or stopped by an event.
    pub(crate) const PAUSED: u32 = 0;
    /// In air, at `position`, looking for the next grain.
    pub(crate) const AIR: u32 = 1;
    /// In ice, at the end of a chord of the current grain: interface, or more ice?
    pub(crate) const ICE: u32 = 2;
}

/// Floats of every lane.
pub(crate) type Floats = [f32; LANES];
/// Words of every lane.
pub(crate) type Words = [u32; LANES];

/// One quantity along three axes.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(64))]
pub(crate) struct Axes<T>(pub(crate) [[T; LANES]; 3]);

impl<T: Copy> Axes<T> {
    pub(crate) fn get(&self, lane: usize) -> [T; 3] {
        [self.0[0][lane], self.0[1][lane], self.0[2][lane]]
    }

    pub(crate) fn set(&mut self, lane: usize, value: [T; 3]) {
        for (array, value) in self.0.iter_mut().zip(value) {
            array[lane] = value;
        }
    }
}

/// Everything that changes while light travels. Lengths in quanta, positions in cell quanta.
#[derive(Clone, Debug)]
#[repr(C, align(64))]
pub(crate) struct Lanes {
    pub(crate) position: Axes<f32>,
    pub(crate) direction: Axes<f32>,
    pub(crate) cell: Axes<i32>,
    /// Centre of the grain that the path is in, relative to the path's cell.
    pub(crate) grain: Axes<f32>,
    /// The answer of the block test: entry distance (air) or negated exit distance (ice).
    pub(crate) found: Floats,
    /// Centre of the grain of that answer.
    pub(crate) found_grain: Axes<f32>,
    /// First grain met: outward normal and place, for the film's layers.
    pub(crate) first_normal: Axes<f32>,
    pub(crate) first_position: Axes<f32>,
    pub(crate) first_cell: Axes<i32>,
    /// Outside cosine of the current chord, shared by all reflections within one sphere; -1 where
    /// it has to be taken from the geometry.
    pub(crate) cos_outside: Floats,
    /// Length of the last chord.
    pub(crate) chord: Floats,
    pub(crate) ice_length: Floats,
    pub(crate) air_length: Floats,
    pub(crate) mode: Words,
    /// Raw radius (with flags) of the grain that the path is in.
    pub(crate) grain_radius: Words,
    pub(crate) found_radius: Words,
    pub(crate) entry: Words,
    pub(crate) key_lo: Words,
    pub(crate) key_hi: Words,
    /// Next event of the path's random numbers.
    pub(crate) event: Words,
    pub(crate) visits: Words,
    /// Interfaces met since the path was last in air.
    pub(crate) turns: Words,
}

impl Lanes {
    pub(crate) fn new() -> Box<Self> {
        let floats = [0.0; LANES];
        let words = [0; LANES];
        let axes = Axes([floats; 3]);
        Box::new(Self {
            position: axes,
            direction: axes,
            cell: Axes([[0; LANES]; 3]),
            grain: axes,
            found: floats,
            found_grain: axes,
            first_normal: axes,
            first_position: axes,
            first_cell: Axes([[0; LANES]; 3]),
            cos_outside: floats,
            chord: floats,
            ice_length: floats,
            air_length: floats,
            mode: words,
            grain_radius: words,
            found_radius: words,
            entry: words,
            key_lo: words,
            key_hi: words,
            event: words,
            visits: words,
            turns: words,
        })
    }

    /// Copies the path of lane `from` to lane `to`.
    pub(crate) fn copy_lane(&mut self, from: usize, to: usize) {
        for axes in [
            &mut self.position,
            &mut self.direction,
            &mut self.grain,
            &mut self.found_grain,
            &mut self.first_normal,
            &mut self.first_position,
        ] {
            axes.set(to, axes.get(from));
        }
        for axes in [&mut self.cell, &mut self.first_cell] {
            axes.set(to, axes.get(from));
        }
        for floats in [
            &mut self.found,
            &mut self.cos_outside,
            &mut self.chord,
            &mut self.ice_length,
            &mut self.air_length,
        ] {
            floats[to] = floats[from];
        }
        for words in [
            &mut self.mode,
            &mut self.grain_radius,
            &mut self.found_radius,
            &mut self.entry,
            &mut self.key_lo,
            &mut self.key_hi,
            &mut self.event,
            &mut self.visits,
            &mut self.turns,
        ] {
            words[to] = words[from];
        }
    }

    pub(crate) fn cell_of(&self, lane: usize) -> IVec3 {
        IVec3::from_array(self.cell.get(lane))
    }
}
