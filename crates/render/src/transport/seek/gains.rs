//! Factors on what a search finds, fitted to what paths meet.
//!
//! Counts of both are kept by whence light arrived, order, angle of scattering, height of the direction in
//! which light leaves, and its angle from where the camera looks. A factor for each cell would be known badly,
//! so it is a product of three: one of whence, order and angle of scattering, one of height, and one of the angle
//! from the view, the latter two for few, some and many grains. They are those with which the counts
//! that a search would give agree with those of chance in every such class (iterative proportional fitting, Deming
//! and Stephan 1940, "On a Least Squares Adjustment of a Sampled Frequency Table When the Expected
//! Marginal Totals are Known").

use snowgrain_accel::ArrivalFrom;
use snowgrain_math::DVec3;

/// Orders that are told apart: the first of each class; the last holds all higher ones.
pub(super) const ORDERS: [u32; 6] = [1, 2, 3, 4, 6, 10];
/// Of each of these, whether it is one of few, some or many grains.
pub(super) const DEPTHS: [usize; ORDERS.len()] = [0, 0, 1, 1, 2, 2];
pub(super) const DEPTH_COUNT: usize = 3;
/// Bins of the angle of scattering, equal in the sine of its half.
pub(super) const ANGLES: usize = 6;
/// Bins of the height of the direction in which light leaves, equal in its sine: snow that fell is not alike
/// in all directions.
pub(super) const HEIGHTS: usize = 12;
/// Bins of the angle between the directions in which light leaves and whence the camera looks, equal
/// in the sine of its half: what goes back the way it came finds it open.
pub(super) const VIEWS: usize = 6;
/// Classes of the first factor.
const WAYS: usize = 2 * ORDERS.len() * ANGLES;
pub(super) const CELLS: usize = WAYS * HEIGHTS * VIEWS;
/// Added to both counts, so that few of them change little.
const PRIOR: f64 = 4.0;
/// Ways of which a search finds less than a part of so many are left to the others: it does not know them.
const MOST: f64 = 4.0;
/// What whole numbers of found ways are counted in parts of: sums are then the same in any order.
const UNIT: f64 = 1024.0;
/// Times that all factors are fitted: the counts then agree to 1e-6.
const ROUNDS: usize = 40;

/// What is told apart of light that leaves a grain.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Class {
    pub(super) way: usize,
    pub(super) depth: usize,
    pub(super) height: usize,
    pub(super) view: usize,
}

impl Class {
    /// For light of a path that the camera began along `seen_along`, that arrives along one
    /// unit vector and leaves along the other.
    pub(super) fn new(
        (from, order): (ArrivalFrom, u32),
        seen_along: DVec3,
        [arrives, leaves]: [DVec3; 2],
    ) -> Self {
        let from = match from {
            ArrivalFrom::Air => 0,
            ArrivalFrom::Ice => 1,
        };
        let order = ORDERS.iter().rposition(|&first| order >= first).unwrap_or(0);
        let bin = |part: f64, count: usize| ((part * count as f64) as usize).min(count - 1);
        let half_sine = (0.5 - 0.5 * arrives.dot(leaves)).max(0.0).sqrt();
        let half_cosine_of_view = (0.5 + 0.5 * seen_along.dot(leaves)).max(0.0).sqrt();
        Self {
            way: (from * ORDERS.len() + order) * ANGLES + bin(half_sine, ANGLES),
            depth: DEPTHS[order],
            height: bin(0.5 + 0.5 * leaves.y, HEIGHTS),
            view: bin(half_cosine_of_view, VIEWS),
        }
    }

    /// Index of its orders.
    pub(super) fn order(&self) -> usize {
        self.way / ANGLES % ORDERS.len()
    }

    fn cell(&self) -> usize {
        (self.way * HEIGHTS + self.height) * VIEWS + self.view
    }

    pub(super) fn of_cell(cell: usize) -> Self {
        let way = cell / (HEIGHTS * VIEWS);
        Self {
            way,
            depth: DEPTHS[way / ANGLES % ORDERS.len()],
            height: cell / VIEWS % HEIGHTS,
            view: cell % VIEWS,
        }
    }
}

/// One of the factors, by what it tells apart.
#[derive(Clone, Copy)]
enum Factor {
    Way,
    Height,
    View,
}

impl Factor {
    const ALL: [Self; 3] = [Self::Way, Self::View, Self::Height];

    /// How many values it has.
    fn count(self) -> usize {
        match self {
            Self::Way => WAYS,
            Self::Height => DEPTH_COUNT * HEIGHTS,
            Self::View => DEPTH_COUNT * VIEWS,
        }
    }

    /// Which of them a class takes.
    fn index(self, class: &Class) -> usize {
        match self {
            Self::Way => class.way,
            Self::Height => class.depth * HEIGHTS + class.height,
            Self::View => class.depth * VIEWS + class.view,
        }
    }
}

/// Factors on what a search finds.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Gains([Vec<f64>; Factor::ALL.len()]);

impl Default for Gains {
    fn default() -> Self {
        Self(Factor::ALL.map(|factor| vec![1.0; factor.count()]))
    }
}

impl Gains {
    pub(super) fn gain(&self, class: &Class) -> f64 {
        Factor::ALL.iter().zip(&self.0).map(|(factor, gains)| gains[factor.index(class)]).product()
    }
}

/// Counts of ways that a search finds, and of those by which paths escape.
#[derive(Clone, Debug)]
pub(super) struct Tally {
    /// Sums of the times that a way stands for, and of their squares, in parts of so many ([`UNIT`]).
    found: Vec<u64>,
    squares: Vec<u64>,
    pub(super) escaped: Vec<u64>,
}

impl Default for Tally {
    fn default() -> Self {
        Self { found: vec![0; CELLS], squares: vec![0; CELLS], escaped: vec![0; CELLS] }
    }
}

impl Tally {
    /// A way that is found and stands for so many.
    pub(super) fn found(&mut self, class: &Class, times: f64) {
        self.found[class.cell()] += (times * UNIT) as u64;
        self.squares[class.cell()] += (times * times * UNIT) as u64;
    }

    /// How many ways of a cell are found.
    pub(super) fn found_in(&self, cell: usize) -> f64 {
        self.found[cell] as f64 / UNIT
    }

    /// The sum of the squares of what they stand for.
    pub(super) fn squares_in(&self, cell: usize) -> f64 {
        self.squares[cell] as f64 / UNIT
    }

    pub(super) fn escaped(&mut self, class: &Class) {
        self.escaped[class.cell()] += 1;
    }

    pub(super) fn merged(mut self, other: &Self) -> Self {
        for cell in 0..CELLS {
            self.found[cell] += other.found[cell];
            self.squares[cell] += other.squares[cell];
            self.escaped[cell] += other.escaped[cell];
        }
        self
    }

    /// The factors with which both counts agree.
    pub(super) fn gains(&self) -> Gains {
        let escaped = |cell: usize, _: &Class| self.escaped[cell] as f64;
        let mut wanted = Factor::ALL.map(|factor| sums(factor, escaped));
        self.leave_unknown_ways(&mut wanted[0]);
        let mut gains = Gains::default();
        for _ in 0..ROUNDS {
            for (index, factor) in Factor::ALL.into_iter().enumerate() {
                let found = sums(factor, |cell, class| self.found_in(cell) * gains.gain(class));
                for (gain, (wanted, found)) in
                    gains.0[index].iter_mut().zip(wanted[index].iter().zip(found))
                {
                    // Without the factor itself, so that its prior is one count of gain 1.
                    let without = found / *gain;
                    *gain = (wanted + PRIOR) / (without + PRIOR);
                }
            }
        }
        gains
    }

    /// Gives the light of ways that a search hardly knows to the others after as many grains.
    fn leave_unknown_ways(&self, wanted: &mut [f64]) {
        let found = sums(Factor::Way, |cell, _| self.found_in(cell));
        let ways_of =
            |order: usize| (0..WAYS).filter(move |way| way / ANGLES % ORDERS.len() == order);
        for order in 0..ORDERS.len() {
            let all: f64 = ways_of(order).map(|way| wanted[way]).sum();
            for way in ways_of(order) {
                if wanted[way] > MOST * found[way] {
                    wanted[way] = 0.0;
                }
            }
            let known: f64 = ways_of(order).map(|way| wanted[way]).sum();
            if known > 0.0 {
                ways_of(order).for_each(|way| wanted[way] *= all / known);
            }
        }
    }
}

/// Sums of a number of each cell over those that take the same value of a factor.
fn sums(factor: Factor, of_cell: impl Fn(usize, &Class) -> f64) -> Vec<f64> {
    let mut sums = vec![0.0; factor.count()];
    for cell in 0..CELLS {
        let class = Class::of_cell(cell);
        sums[factor.index(&class)] += of_cell(cell, &class);
    }
    sums
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cells_are_numbered_without_gap_or_overlap() {
        for cell in 0..CELLS {
            assert_eq!(Class::of_cell(cell).cell(), cell);
        }
    }

    /// Whatever product of factors was forgotten is found again.
    #[test]
    fn factors_that_were_forgotten_are_found_again() {
        let truth = |class: &Class| {
            (1.0 + 0.3 * (class.way % ANGLES) as f64)
                * (0.7 + 0.05 * class.height as f64)
                * (1.2 - 0.1 * (class.view * class.depth) as f64)
        };
        let mut tally = Tally::default();
        for cell in 0..CELLS {
            let class = Class::of_cell(cell);
            tally.found[cell] = (4_000 + (cell * 7919 % 9_000) as u64) << 10;
            tally.escaped[cell] = (tally.found_in(cell) * truth(&class)).round() as u64;
        }
        let gains = tally.gains();
        for cell in 0..CELLS {
            let class = Class::of_cell(cell);
            let off = gains.gain(&class) / truth(&class) - 1.0;
            assert!(off.abs() < 2e-3, "{class:?}: {off}");
        }
    }

    /// Light that a search never finds is made up for by what it finds in the same directions.
    #[test]
    fn light_that_is_never_found_is_found_in_other_ways() {
        let mut tally = Tally::default();
        for cell in 0..CELLS {
            let class = Class::of_cell(cell);
            tally.escaped[cell] = 1_000;
            tally.found[cell] = if class.way % ANGLES == 5 { 0 } else { 1_000 << 10 };
        }
        let gains = tally.gains();
        for height in 0..HEIGHTS {
            let cells = || (0..CELLS).filter(|&cell| Class::of_cell(cell).height == height);
            let escaped: f64 = cells().map(|cell| tally.escaped[cell] as f64).sum();
            let found: f64 =
                cells().map(|cell| tally.found_in(cell) * gains.gain(&Class::of_cell(cell))).sum();
            assert!((found / escaped - 1.0).abs() < 1e-3, "{height}: {found} {escaped}");
        }
    }
}
