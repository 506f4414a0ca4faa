//! The state of one path among shaped grains.
//!
//! A path is a chain of straight stretches. Each has one origin, told from its *home* cell, and all that it
//! may meet is told as a distance from there: so a grain is met at the same distance, to the last bit,
//! whichever cell asks.

use super::body::{ELLIPSOID, LocalRay, NOWHERE};
use crate::grain_grid::{CellEntry, GridShapes, Placement, ShapeWord};
use crate::{GrainGrid, STRATA, SurfaceHit, SurfaceId};
use snowgrain_math::sampler::PathKey;
use snowgrain_math::{DVec3, Ray};

/// What a path waits for.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) enum Phase {
    /// It is not in flight.
    #[default]
    Still,
    /// In air, for what its cell holds.
    Air,
    /// In a grain between parallel faces, with others (`visits`).
    Visit,
    /// At the end of a chord, for what its cell holds: interface, or more ice?
    Ice,
}

/// A convex part of a grain.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct BodyPart {
    /// Centre of the grain from the corner of the home cell, quanta: a whole number.
    pub(super) center: DVec3,
    /// Radius of the grain, quanta.
    pub(super) radius: f64,
    pub(super) word: u64,
    pub(super) part: u16,
}

impl BodyPart {
    pub(super) const NONE: Self = Self { center: DVec3::ZERO, radius: 0.0, word: 0, part: 0 };

    /// How its grain is placed.
    #[inline(always)]
    pub(super) fn placement(&self) -> Placement {
        Placement::new(ShapeWord::of_slot(self.word).shape(), self.radius)
    }
}

/// The ice that a path is in.
#[derive(Clone, Copy, Debug)]
pub(super) struct Inside {
    pub(super) body: BodyPart,
    /// How its grain lies.
    pub(super) placement: Placement,
    /// Where on the stretch the path leaves it, and through which part of its surface.
    pub(super) leave: f64,
    pub(super) through: u16,
    /// Whether a surface may cross the grain, and whether other ice may.
    pub(super) meets_surface: bool,
    pub(super) overlaps: bool,
    pub(super) stratum: u8,
}

impl Default for Inside {
    fn default() -> Self {
        Self {
            body: BodyPart::NONE,
            placement: Placement::default(),
            leave: 0.0,
            through: NOWHERE,
            meets_surface: false,
            overlaps: false,
            stratum: 0,
        }
    }
}

/// A grain that a stretch in air enters.
#[derive(Clone, Copy, Debug)]
pub(super) struct Entry {
    /// Where on the stretch.
    pub(super) at: f64,
    /// The same in radii, as the grain's interval says.
    pub(super) at_radii: f64,
    pub(super) body: BodyPart,
    /// Block and slot of the grain.
    pub(super) block: usize,
    pub(super) slot: usize,
    /// The face by which it is entered, of grains between parallel faces.
    pub(super) face: Option<f64>,
}

/// The cells of a grid, in doubles.
#[derive(Clone, Copy, Debug)]
pub(super) struct Cells {
    pub(super) margin: f64,
    pub(super) side: DVec3,
    pub(super) inverse_side: DVec3,
    pub(super) counts: [i32; 3],
    pub(super) periodic: [bool; 3],
}

impl Cells {
    pub(super) fn of(grid: &GrainGrid) -> Self {
        let side = DVec3::from_array(grid.side.map(f64::from));
        Self {
            margin: grid.margin.into(),
            side,
            inverse_side: side.recip(),
            counts: grid.cells,
            periodic: grid.periodic,
        }
    }

    /// Cells from the one that `local` is told from to the one that holds it, along an axis.
    #[inline(always)]
    pub(super) fn steps(&self, local: DVec3, axis: usize) -> i32 {
        ((local[axis] - self.margin) * self.inverse_side[axis]).floor() as i32
    }
}

/// What the surfaces answered for this stretch.
#[derive(Clone, Copy, Debug, Default)]
pub(super) enum SurfaceAnswer {
    #[default]
    NotAsked,
    /// The nearest hit from the origin of the stretch.
    Told(Option<SurfaceHit>),
}

/// One path. Lengths in quanta. What every visit needs comes first, in as few cache lines as can be.
#[derive(Clone, Copy, Debug)]
#[repr(C, align(64))]
pub(super) struct Lane {
    pub(super) phase: Phase,
    pub(super) in_ice: bool,
    pub(super) event: u32,
    pub(super) key: PathKey,
    pub(super) visits: u32,
    /// Interfaces met since the path was last in air.
    pub(super) turns: u32,
    /// Up to where the stretch is in the lengths already.
    pub(super) counted: f64,
    pub(super) air_length: f64,
    pub(super) ice_length: f64,
    /// Periods crossed along each axis since the path entered the grid.
    pub(super) periods: [i32; 3],
    pub(super) home_periods: [i32; 3],
    /// The piece of surface that the stretch left.
    pub(super) left_surface: Option<SurfaceId>,
    pub(super) surface: SurfaceAnswer,
    /// Place, metres, and normal of the first grain met.
    pub(super) first: Option<[DVec3; 2]>,
    pub(super) ice_in_strata: [f64; STRATA],
    pub(super) inside: Inside,
    /// Where the stretch begins, in cell quanta of the home cell, and that cell.
    pub(super) origin: DVec3,
    pub(super) home: [i32; 3],
    pub(super) direction: DVec3,
    pub(super) inverse_direction: DVec3,
    /// How far the path has come on the stretch.
    pub(super) travelled: f64,
    pub(super) cell: [i32; 3],
    /// From the home cell to the present one, whole quanta.
    pub(super) offset: DVec3,
    /// What a cell holds, and which: the present one, unless the path has just moved on.
    pub(super) entry: CellEntry,
    pub(super) entry_of: [i32; 3],
    /// In air: the nearest of the grains whose bounding spheres the stretch has entered so far.
    pub(super) nearest: Option<Entry>,
    /// In air: the part that the stretch left, which it cannot meet again (convexity).
    pub(super) leaving: Option<BodyPart>,
    /// Of a straight ray: centre of a grain that it does not meet.
    pub(super) shadowless: Option<DVec3>,
}

impl Default for Lane {
    fn default() -> Self {
        Self {
            phase: Phase::Still,
            in_ice: false,
            key: PathKey { lo: 0, hi: 0 },
            event: 0,
            origin: DVec3::ZERO,
            home: [0; 3],
            direction: DVec3::X,
            inverse_direction: DVec3::ONE,
            travelled: 0.0,
            counted: 0.0,
            cell: [0; 3],
            offset: DVec3::ZERO,
            periods: [0; 3],
            home_periods: [0; 3],
            entry: CellEntry::EMPTY,
            entry_of: [0; 3],
            nearest: None,
            leaving: None,
            shadowless: None,
            inside: Inside::default(),
            left_surface: None,
            surface: SurfaceAnswer::NotAsked,
            ice_length: 0.0,
            ice_in_strata: [0.0; STRATA],
            air_length: 0.0,
            visits: 0,
            turns: 0,
            first: None,
        }
    }
}

impl Lane {
    pub(super) fn launched(key: PathKey, event: u32) -> Self {
        Self { key, event, ..Self::default() }
    }

    /// The point at `t` of the stretch, in cell quanta of the present cell.
    #[inline(always)]
    pub(super) fn local(&self, t: f64) -> DVec3 {
        self.origin + self.direction * t - self.offset
    }

    /// The stretch from its origin, metres: where it is in the first period.
    pub(super) fn stretch(&self, grid: &GrainGrid) -> Ray {
        Ray::new(grid.world_of(self.home, self.origin), self.direction)
    }

    /// The ray of the stretch in the prototype's space of a part, whose grain is placed so.
    #[inline(always)]
    pub(super) fn ray_to(&self, center: DVec3, placement: &Placement) -> LocalRay {
        LocalRay {
            origin: placement.to_prototype(self.origin - center),
            direction: placement.turned_back(self.direction),
        }
    }

    /// The outward unit normal at the end of the chord.
    #[inline(always)]
    pub(super) fn outward(&self, shapes: &GridShapes) -> DVec3 {
        let Inside { body, placement, leave, through, .. } = self.inside;
        let part = &shapes.of(&placement).parts[usize::from(body.part)];
        let end = if through == ELLIPSOID {
            let ray = self.ray_to(body.center, &placement);
            ray.origin + ray.direction * (leave / placement.radius)
        } else {
            // All of a face has one normal.
            DVec3::ZERO
        };
        placement.rotation * super::body::normal(part, through, end)
    }

    /// Goes to the cell that holds the point at `t` of the stretch, within the grid.
    #[inline(always)]
    pub(super) fn seek_cell(&mut self, cells: &Cells, t: f64) {
        let local = self.local(t);
        let steps = [cells.steps(local, 0), cells.steps(local, 1), cells.steps(local, 2)];
        if steps != [0; 3] {
            for (axis, steps) in steps.into_iter().enumerate() {
                self.step_cells(cells, axis, steps);
            }
            self.stay_inside(cells);
        }
    }

    /// Moves by whole cells along an axis.
    #[inline(always)]
    pub(super) fn step_cells(&mut self, cells: &Cells, axis: usize, steps: i32) {
        self.cell[axis] += steps;
        self.offset[axis] += f64::from(steps) * cells.side[axis];
    }

    /// Back into the first period, or to the nearest cell of the grid.
    #[inline(always)]
    pub(super) fn stay_inside(&mut self, cells: &Cells) {
        for axis in 0..3 {
            let n = cells.counts[axis];
            let cell = self.cell[axis];
            if (0..n).contains(&cell) {
                continue;
            }
            if cells.periodic[axis] {
                self.cell[axis] = cell.rem_euclid(n);
                self.periods[axis] += cell.div_euclid(n);
            } else {
                let steps = cell.clamp(0, n - 1) - cell;
                self.step_cells(cells, axis, steps);
            }
        }
    }

    /// Begins a stretch where this one is at `t`, along `direction`.
    #[inline(always)]
    pub(super) fn begin_stretch(&mut self, cells: &Cells, t: f64, direction: DVec3) {
        self.seek_cell(cells, t);
        self.origin = self.local(t);
        self.inside.body.center -= self.offset;
        self.offset = DVec3::ZERO;
        self.home = self.cell;
        self.direction = direction;
        self.inverse_direction = direction.recip();
        self.travelled = 0.0;
        (self.leaving, self.nearest) = (None, None);
        self.begin_afresh();
    }

    /// Forgets what belongs to the stretch that came before.
    #[inline(always)]
    pub(super) fn begin_afresh(&mut self) {
        self.counted = 0.0;
        self.home_periods = self.periods;
        self.left_surface = None;
        self.surface = SurfaceAnswer::NotAsked;
    }

    /// Counts the stretch as ice of the present grain up to `t`.
    #[inline(always)]
    pub(super) fn count_ice(&mut self, t: f64) {
        self.add_ice(t - self.counted);
        self.counted = t;
    }

    /// Counts a length in ice of the present grain.
    #[inline(always)]
    pub(super) fn add_ice(&mut self, length: f64) {
        self.ice_length += length;
        if let Some(stratum) = usize::from(self.inside.stratum).checked_sub(1) {
            self.ice_in_strata[stratum] += length;
        }
    }

    /// Counts the stretch as air up to `t`.
    #[inline(always)]
    pub(super) fn count_air(&mut self, t: f64) {
        self.air_length += t - self.counted;
        self.counted = t;
    }
}
