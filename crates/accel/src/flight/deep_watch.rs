//! When a path counts as deep in the snow, and what a flight does then.

use crate::GrainGrid;
use crate::grain_grid::{GridPosition, Interior};
use snowgrain_math::DVec3;
use snowgrain_math::sampler::{PathKey, numbers};

/// What tells the random number by which the grains before are rounded from others of a path.
const ROUNDED: u32 = 0xdee9_0a1f;

/// What a flight does with paths that arrive deep in the snow.
#[derive(Clone, Copy, Debug)]
pub struct DeepWatch<'a> {
    /// Where it is deep.
    pub interior: &'a Interior,
    /// Grains that a path has met before it counts as deep, at least.
    pub after: GrainsBefore,
    /// What is done.
    pub answer: DeepAnswer,
}

/// What is done with a path that arrives at a grain deep in the snow.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum DeepAnswer {
    /// It stops there ([`super::FlightEvent::Deep`]).
    Stop,
    /// The arrival is noted, and no other.
    Note,
}

/// How many grains a path meets before it counts as deep: fewer where the pixels of a picture are wide, which do not
/// show single grains. In between it is the one number or the other, by a random number of the path, so that no
/// seam is seen.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GrainsBefore {
    /// Where pixels are narrow, and how many fewer where they are wide.
    narrow: u32,
    fewer: u32,
    /// How wide pixels are, from 0, narrow, to 1, wide, in the cell (0, 0, 0), and how much wider by a cell along each axis.
    first: f64,
    by_cell: DVec3,
}

impl GrainsBefore {
    /// The same number everywhere.
    #[must_use]
    pub fn everywhere(grains: u32) -> Self {
        Self { narrow: grains, fewer: 0, first: 0.0, by_cell: DVec3::ZERO }
    }

    /// These numbers where pixels are narrow and where they are wide; `width` tells how wide they are at a place (metres),
    /// from 0, narrow, to 1, wide, and may be beyond both: it is taken to be linear in the place.
    #[must_use]
    pub fn by_width(
        [narrow, wide]: [u32; 2],
        grid: &GrainGrid,
        width: impl Fn(DVec3) -> f64,
    ) -> Self {
        let at = |cell: [i32; 3]| width(grid.world(GridPosition { cell, local: [0.0; 3] }));
        let first = at([0; 3]);
        let by_cell = [[1, 0, 0], [0, 1, 0], [0, 0, 1]].map(|cell| at(cell) - first);
        Self {
            narrow,
            fewer: narrow.saturating_sub(wide),
            first,
            by_cell: DVec3::from_array(by_cell),
        }
    }

    /// Whether so many grains are enough for a path in a cell.
    #[inline]
    #[must_use]
    pub fn are_met(&self, grains: u32, cell: [i32; 3], key: PathKey) -> bool {
        if grains >= self.narrow || !self.may_be_met(grains) {
            return grains >= self.narrow;
        }
        let width = self.first + self.by_cell.dot(DVec3::from_array(cell.map(f64::from)));
        let fewer = width.clamp(0.0, 1.0) * f64::from(self.fewer);
        let [random, _, _] = numbers(PathKey { lo: key.lo ^ ROUNDED, ..key }, 0);
        f64::from(self.narrow - grains) <= fewer + f64::from(random)
    }

    /// Whether so many grains are enough anywhere.
    #[inline(always)]
    fn may_be_met(&self, grains: u32) -> bool {
        grains + self.fewer >= self.narrow
    }
}

impl DeepWatch<'_> {
    /// Whether an arrival of a path in a cell is deep, where it has met so many grains before.
    #[inline(always)]
    pub(super) fn is_deep(&self, grains_before: u32, cell: [i32; 3], key: PathKey) -> bool {
        self.after.may_be_met(grains_before)
            && self.interior.is_deep(cell)
            && self.after.are_met(grains_before, cell, key)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Packing, Surfaces};
    use snowgrain_geometry::Quantisation;

    /// Of 100 000 paths.
    fn part(after: &GrainsBefore, grains: u32, x: i32) -> f64 {
        let met = |index: &u64| after.are_met(grains, [x, 5, 5], PathKey::new(7, *index, 0));
        (0..100_000).filter(met).count() as f64 / 100_000.0
    }

    #[test]
    fn as_many_grains_are_met_as_pixels_are_narrow() {
        let after =
            GrainsBefore { narrow: 4, fewer: 2, first: -0.5, by_cell: DVec3::new(0.01, 0.0, 0.0) };
        // 4 up to cell 50, 2 from cell 150 on, and in between on average what lies between.
        for (x, mean) in
            [(0, 4.0), (50, 4.0), (75, 3.5), (100, 3.0), (130, 2.4), (150, 2.0), (999, 2.0)]
        {
            assert!((part(&after, 1, x), part(&after, 4, x)) == (0.0, 1.0), "{x}");
            let waits = 1.0 - part(&after, 2, x) + 1.0 - part(&after, 3, x);
            // Five standard errors of 100 000 coins.
            assert!((2.0 + waits - mean).abs() < 5.0 * 0.0016, "{x}: {}", 2.0 + waits);
        }
    }

    /// Pixels as wide as a place is far along an axis, in a row of grains from 0 to 100 m: narrow up to 40 m, wide from 60 m on.
    #[test]
    fn the_width_of_a_pixel_is_that_at_the_place_of_a_cell() {
        let quantisation = Quantisation::for_grains(DVec3::ZERO, 1.0);
        let row = (0..=50).map(|i| DVec3::new(2.0 * f64::from(i), 0.0, 0.0));
        let grains: Vec<_> = row.map(|center| quantisation.round(center, 1.0).unwrap()).collect();
        let grid = GrainGrid::build(quantisation, &grains[..], &Surfaces::default(), Packing::Fast)
            .unwrap();
        let after = GrainsBefore::by_width([4, 2], &grid, |place| (place.x - 40.0) / 20.0);
        for (x, expected) in [(10.0, 0.0), (30.0, 0.0), (70.0, 1.0), (95.0, 1.0)] {
            let cell = grid.locate(DVec3::new(x, 0.0, 0.0)).cell;
            let met = |index| after.are_met(2, cell, PathKey::new(7, index, 0));
            let part = (0..100).filter(|&index| met(index)).count();
            assert!((part as f64 - 100.0 * expected).abs() < 1e-9, "{x}: {part}");
        }
    }

    #[test]
    fn a_number_that_holds_everywhere_is_that_number() {
        let after = GrainsBefore::everywhere(3);
        for x in [0, 1_000] {
            assert_eq!([2, 3].map(|grains| part(&after, grains, x)), [0.0, 1.0]);
        }
    }
}
