//! What must be known of all grains before cells are laid out: their box, their sizes, their density.

use super::layout::Divisor;
use super::longest_side;
use crate::grain_grid::{GrainParts, GridError, Packing};
use rayon::prelude::*;
use snowgrain_geometry::QuantisedGrain;
use snowgrain_math::trig;
use std::sync::atomic::{AtomicU64, Ordering::Relaxed};

/// The grains of a part.
#[derive(Clone, Copy, Debug)]
pub(super) struct Part {
    /// Number of the first among all grains.
    pub(super) first: u32,
    grains: u64,
    /// The box of all balls, quanta, with room for a pad.
    pub(super) low: [i64; 3],
    pub(super) high: [i64; 3],
    largest: u16,
    /// Sum of the cubes of the radii.
    cubes: u128,
}

impl Part {
    const EMPTY: Self =
        Self { first: 0, grains: 0, low: [i64::MAX; 3], high: [i64::MIN; 3], largest: 0, cubes: 0 };

    fn of(grains: &GrainParts<'_>, part: usize) -> Self {
        let (mut low, mut high) = ([i32::MAX; 3], [i32::MIN; 3]);
        let (mut largest, mut count, mut cubes, mut pending) = (0, 0u64, 0u128, 0u64);
        grains.for_each(part, |QuantisedGrain { center, radius }| {
            let reach = i32::from(radius) + 2;
            for axis in 0..3 {
                low[axis] = low[axis].min(center[axis] - reach);
                high[axis] = high[axis].max(center[axis] + reach);
            }
            largest = largest.max(radius);
            count += 1;
            pending += u64::from(radius).pow(3);
            if count % (1 << 16) == 0 {
                cubes += u128::from(std::mem::take(&mut pending));
            }
        });
        cubes += u128::from(pending);
        let [low, high] = [low, high].map(|corner| corner.map(i64::from));
        Self { first: 0, grains: count, low, high, largest, cubes }
    }

    fn and(mut self, other: &Self) -> Self {
        for axis in 0..3 {
            self.low[axis] = self.low[axis].min(other.low[axis]);
            self.high[axis] = self.high[axis].max(other.high[axis]);
        }
        self.grains += other.grains;
        self.largest = self.largest.max(other.largest);
        self.cubes += other.cubes;
        self
    }
}

#[derive(Debug)]
pub(super) struct Survey {
    pub(super) parts: Vec<Part>,
    pub(super) grains: u64,
    pub(super) low: [i64; 3],
    pub(super) high: [i64; 3],
    pub(super) largest: u16,
    cubes: u128,
}

impl Survey {
    /// # Errors
    /// More grains than 32 bits number.
    pub(super) fn of(grains: &GrainParts<'_>) -> Result<Self, GridError> {
        let mut parts: Vec<Part> =
            (0..grains.count()).into_par_iter().map(|part| Part::of(grains, part)).collect();
        let mut first = 0;
        for part in &mut parts {
            part.first = u32::try_from(first).map_err(|_| GridError::TooManyGrains)?;
            first += part.grains;
        }
        u32::try_from(first).map_err(|_| GridError::TooManyGrains)?;
        let all = parts.iter().fold(Part::EMPTY, Part::and);
        let Part { grains, low, high, largest, cubes, .. } = all;
        Ok(Self { parts, grains, low, high, largest, cubes })
    }

    /// Edge of the cells in quanta: such that a cell within the snow lists about as many grains as
    /// the packing wants, at most what 16 bits hold.
    pub(super) fn choose_side(
        &self,
        grains: &GrainParts<'_>,
        packing: Packing,
        (margin, have_shapes): (i32, bool),
    ) -> i32 {
        let radius = trig::cbrt(self.cubes as f64 / self.grains as f64).max(1.0);
        let density = self.grains as f64 / self.occupied_volume(grains, 4.0 * radius);
        let side = packing.cell_side(radius, density, have_shapes);
        (side as i32).clamp(1, longest_side(margin).max(1))
    }

    /// Volume of the cells of edge `side`, or of a multiple of it where that would be very many, that
    /// hold the centre of a grain; cubic quanta.
    fn occupied_volume(&self, grains: &GrainParts<'_>, side: f64) -> f64 {
        // A word for every 4 x 4 x 4 cells.
        let mut side = side.ceil() as i64;
        let words_along = |side: i64| -> [i64; 3] {
            std::array::from_fn(|axis| (self.high[axis] - self.low[axis]) / (4 * side) + 1)
        };
        let count = |words: [i64; 3]| words.iter().map(|&n| n as u128).product::<u128>();
        while count(words_along(side)) > u128::from(self.grains.max(MOST_WORDS_AT_LEAST)) {
            side *= 2;
        }
        let along: [i64; 3] = words_along(side);
        let by_side = Divisor::new(side);
        let occupied: Vec<AtomicU64> = (0..count(along)).map(|_| AtomicU64::new(0)).collect();
        (0..self.parts.len()).into_par_iter().for_each(|part| {
            grains.for_each(part, |grain| {
                let cell: [i64; 3] = std::array::from_fn(|axis| {
                    by_side.divide(i64::from(grain.center[axis]) - self.low[axis])
                });
                let [x, y, z] = cell.map(|c| c >> 2);
                let word = &occupied[((z * along[1] + y) * along[0] + x) as usize];
                let [x, y, z] = cell.map(|c| c & 3);
                let bit = 1 << ((z * 4 + y) * 4 + x);
                if word.load(Relaxed) & bit == 0 {
                    word.fetch_or(bit, Relaxed);
                }
            });
        });
        let cells: u64 =
            occupied.iter().map(|word| u64::from(word.load(Relaxed).count_ones())).sum();
        cells as f64 * cube(side as f64)
    }
}

/// So many words are never too many.
const MOST_WORDS_AT_LEAST: u64 = 1 << 16;

fn cube(x: f64) -> f64 {
    x * x * x
}
