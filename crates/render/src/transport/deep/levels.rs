//! Cells of several sizes, small ones as far as they are told apart by more than chance.
//!
//! From the one cell that holds all on, each cell of half the width is expected to bring what its elders bring there, give
//! or take what cells of this width differ by; the mean of its own paths is known but for its chance. What it
//! is taken to bring lies between the two, by the weights of the best linear estimate: the more paths, the nearer to their
//! mean. How much cells of a width differ beyond chance is told by all of them together.

use super::outcome::Outcome;
use super::samples::Samples;
use rayon::prelude::*;
use rustc_hash::FxHashMap;
use snowgrain_math::DVec3;

/// Paths of which a cell is told at least.
const FEWEST: usize = 32;

/// A cell of a level.
pub(super) type Cell = [i32; 3];

/// Bits of the number of a cell along each axis, so that those of all fit into one number.
const BITS: u32 = 21;

/// The learnt cells of all levels; those of level `n` are `2^n` coarse cells wide, and the only one of the last holds all.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Levels {
    /// The corners of all places, from the low one of which cells are told.
    pub(super) low: DVec3,
    pub(super) high: DVec3,
    /// Of each level, its cells and the numbers of their outcomes.
    pub(super) cells: Vec<FxHashMap<Cell, u32>>,
    pub(super) slots: usize,
    pub(super) outcomes: Vec<Outcome>,
}

impl Levels {
    /// Of what paths brought.
    pub(super) fn of(samples: &Samples) -> Self {
        let places = samples.places();
        let low = places.iter().copied().reduce(DVec3::min).unwrap_or_default().floor();
        let high = places.iter().copied().reduce(DVec3::max).unwrap_or_default();
        let mut levels = Self { low, high, slots: samples.slots(), ..Self::default() };
        let cells: Vec<Cell> = places.par_iter().map(|&place| levels.cell(place)).collect();
        let mut order: Vec<(u64, u32)> =
            cells.iter().map(|&cell| interleaved(cell)).zip(0u32..).collect();
        order.par_sort_unstable();
        let indices: Vec<u32> = order.iter().map(|&(_, index)| index).collect();
        let is_one = |level: u32| {
            order.first().map(|first| first.0 >> (3 * level))
                == order.last().map(|last| last.0 >> (3 * level))
        };
        let last = (0..BITS).find(|&level| is_one(level)).unwrap_or(BITS);
        levels.cells = vec![FxHashMap::default(); last as usize + 1];
        for level in (0..=last).rev() {
            let mut rest = indices.as_slice();
            let groups = order.chunk_by(|a, b| a.0 >> (3 * level) == b.0 >> (3 * level));
            let groups: Vec<&[u32]> = groups
                .filter_map(|group| {
                    let (paths, others) = rest.split_at(group.len());
                    rest = others;
                    (paths.len() >= FEWEST || level == last).then_some(paths)
                })
                .collect();
            let of_group = |paths: &&[u32]| {
                let cell = cells[paths[0] as usize].map(|along| along >> level);
                levels.told(level, cell, paths, samples)
            };
            let told: Vec<Told> = groups.par_iter().map(of_group).collect();
            levels.add(level, told);
        }
        levels
    }

    /// What the paths in a cell brought, and what was to be expected there.
    fn told(&self, level: u32, cell: Cell, paths: &[u32], samples: &Samples) -> Told {
        let sum: DVec3 = paths.iter().map(|&path| samples.places()[path as usize]).sum();
        let middle = sum / paths.len() as f64;
        let brought: Vec<_> = samples.means(paths).collect();
        let expected = match self.cells.get(level as usize + 1) {
            None => brought.clone(),
            Some(above) => {
                let around = self.interpolated((level + 1, above), middle);
                (0..self.slots).map(|slot| self.outcome(&around, slot)).collect()
            }
        };
        Told { cell, paths: paths.len() as f64, brought, expected }
    }

    /// Adds the cells of a level.
    fn add(&mut self, level: u32, told: Vec<Told>) {
        let spreads: Vec<_> = (0..self.slots).map(|slot| Spread::of(&told, slot)).collect();
        for Told { cell, paths, brought, expected } in told {
            let number = (self.outcomes.len() / self.slots.max(1)) as u32;
            self.cells[level as usize].insert(cell, number);
            let slots = spreads.iter().zip(brought).zip(expected);
            self.outcomes.extend(
                slots.map(|((spread, brought), expected)| spread.between(expected, brought, paths)),
            );
        }
    }

    /// The coarse cell around a place.
    fn cell(&self, place: DVec3) -> Cell {
        let last = (1 << BITS) - 1;
        (place - self.low).floor().as_ivec3().to_array().map(|along| along.clamp(0, last))
    }

    /// Relative standard error of the mean of all paths, all slots together.
    pub(super) fn relative_error(&self) -> f64 {
        // The cell that holds all is the first one.
        let of_all = &self.outcomes[..self.slots.min(self.outcomes.len())];
        let light: f64 = of_all.iter().map(Outcome::light).sum();
        let variance: f64 =
            of_all.iter().map(|slot| f64::from(slot.standard_error * slot.standard_error)).sum();
        if light > 0.0 { variance.sqrt() / light } else { 0.0 }
    }

    /// Number of cells.
    pub(super) fn len(&self) -> usize {
        self.cells.iter().map(FxHashMap::len).sum()
    }

    pub(super) fn memory_bytes(&self) -> u64 {
        let cell = size_of::<(Cell, u32)>() + 1;
        let capacity: usize = self.cells.iter().map(FxHashMap::capacity).sum();
        (capacity * cell + size_of_val(self.outcomes.as_slice())) as u64
    }

    /// The mean outcome of a slot in some cells.
    pub(super) fn outcome(&self, around: &Around, slot: usize) -> Outcome {
        let mut outcome = Outcome::default();
        for (number, weight) in around.iter() {
            outcome.add(&self.outcomes[number as usize * self.slots + slot], weight);
        }
        outcome
    }

    /// The cells about a place, in coarse cells, and their weights, which sum to 1: of the finest level that knows it.
    /// A place beyond all that is known counts as the nearest within.
    pub(super) fn around(&self, place: DVec3) -> Around {
        let place = place.clamp(self.low, self.high);
        let cell = self.cell(place);
        let knows = |(level, cells): &(u32, &FxHashMap<Cell, u32>)| {
            cells.contains_key(&cell.map(|along| along >> level))
        };
        let finest = (0u32..).zip(&self.cells).find(knows);
        finest.map_or_else(Around::default, |level| self.interpolated(level, place))
    }

    /// Linear between the middles of the cells of a level, of those that are known.
    fn interpolated(&self, (level, cells): (u32, &FxHashMap<Cell, u32>), place: DVec3) -> Around {
        let corner = (place - self.low) / f64::from(1 << level) - DVec3::splat(0.5);
        let (low, part) = (corner.floor(), corner - corner.floor());
        let mut around = Around::default();
        for index in 0..8 {
            let upper = [0, 1, 2].map(|axis: usize| index >> axis & 1 == 1);
            let cell = std::array::from_fn(|axis| low[axis] as i32 + i32::from(upper[axis]));
            let along = |axis: usize| if upper[axis] { part[axis] } else { 1.0 - part[axis] };
            if let Some(&number) = cells.get(&cell) {
                around.push(number, (along(0) * along(1) * along(2)) as f32);
            }
        }
        around.normalised()
    }
}

/// What the paths in a cell brought on average, and what was to be expected there, of each slot.
struct Told {
    cell: Cell,
    paths: f64,
    brought: Vec<Outcome>,
    expected: Vec<Outcome>,
}

/// Of the light of a slot in the cells of a level, the variance of a path and that of cells from what is expected of them.
#[derive(Clone, Copy)]
struct Spread {
    of_path: f64,
    of_cells: f64,
}

impl Spread {
    fn of(told: &[Told], slot: usize) -> Self {
        let paths: f64 = told.iter().map(|told| told.paths).sum();
        let of_path = told.iter().map(|told| {
            let error = f64::from(told.brought[slot].standard_error);
            told.paths * told.paths * error * error
        });
        let of_path = of_path.sum::<f64>() / paths;
        let of_cells = told.iter().map(|told| {
            let off = told.brought[slot].light() - told.expected[slot].light();
            told.paths * off * off - of_path
        });
        Self { of_path, of_cells: (of_cells.sum::<f64>() / paths).max(0.0) }
    }

    /// What so many paths that brought this tell, beside what is expected.
    fn between(&self, expected: Outcome, brought: Outcome, paths: f64) -> Outcome {
        let chance = self.of_path / paths;
        let share = if chance > 0.0 { self.of_cells / (self.of_cells + chance) } else { 1.0 };
        let mut outcome = Outcome::default();
        outcome.add(&expected, (1.0 - share) as f32);
        outcome.add(&brought, share as f32);
        let before = (1.0 - share) * f64::from(expected.standard_error);
        outcome.standard_error = (share * chance + before * before).sqrt() as f32;
        outcome
    }
}

/// The bits of the three numbers of a cell in turn, so that the cells of every level follow each other in order.
fn interleaved(cell: Cell) -> u64 {
    let spread = |along: i32| {
        (0..BITS).fold(0, |sum, bit| sum | u64::from(along.cast_unsigned() >> bit & 1) << (3 * bit))
    };
    cell.map(spread).into_iter().rev().fold(0, |sum, bits| sum << 1 | bits)
}

/// Numbers of cells with their weights.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Around {
    cells: [(u32, f32); 8],
    count: usize,
}

impl Around {
    fn push(&mut self, number: u32, weight: f32) {
        self.cells[self.count] = (number, weight);
        self.count += 1;
    }

    fn normalised(mut self) -> Self {
        let sum: f32 = self.range().iter().map(|cell| cell.1).sum();
        self.cells.iter_mut().for_each(|cell| cell.1 /= sum);
        self
    }

    fn range(&self) -> &[(u32, f32)] {
        &self.cells[..self.count]
    }

    pub(super) fn iter(&self) -> impl Iterator<Item = (u32, f32)> + '_ {
        self.range().iter().copied()
    }
}
