//! What single arrivals brought.

use super::levels::Cell;
use super::outcome::Outcome;

/// Arrivals deep in the snow, where each counts and what followed: of each slot of light three channels, their sum times
/// three powers of the length in ice, and times the length in each stratum.
#[derive(Clone, Debug, Default)]
pub(super) struct Samples {
    slots: usize,
    strata: usize,
    cells: Vec<Cell>,
    values: Vec<f32>,
}

impl Samples {
    /// None yet, of so many slots and strata.
    pub(super) fn new(slots: usize, strata: usize) -> Self {
        Self { slots, strata, ..Self::default() }
    }

    pub(super) fn slots(&self) -> usize {
        self.slots
    }

    pub(super) fn len(&self) -> usize {
        self.cells.len()
    }

    /// Where each counts.
    pub(super) fn cells(&self) -> &[Cell] {
        &self.cells
    }

    /// Adds an arrival; values slot by slot.
    pub(super) fn push(
        &mut self,
        cell: Cell,
        of_slots: impl Iterator<Item = ([f64; 3], [f64; 3], [f64; snowgrain_accel::STRATA])>,
    ) {
        self.cells.push(cell);
        for (weight, powers, strata) in of_slots {
            let all = weight.into_iter().chain(powers).chain(strata);
            self.values.extend(all.take(self.width()).map(|value| value as f32));
        }
    }

    /// Adds those of another one behind.
    pub(super) fn append(&mut self, mut other: Self) {
        self.cells.append(&mut other.cells);
        self.values.append(&mut other.values);
    }

    fn width(&self) -> usize {
        6 + self.strata
    }

    /// The means of all slots over some arrivals, summed in their order.
    pub(super) fn means(&self, group: &[u32]) -> impl Iterator<Item = Outcome> {
        let width = self.width();
        let row = self.slots * width;
        let mut sums = vec![0.0_f64; row];
        for &index in group {
            let values = &self.values[index as usize * row..][..row];
            sums.iter_mut().zip(values).for_each(|(sum, &value)| *sum += f64::from(value));
        }
        let per = 1.0 / group.len() as f64;
        let strata = self.strata;
        (0..self.slots).map(move |slot| {
            let sums = &sums[slot * width..][..width];
            let mean = |index: usize| (sums[index] * per) as f32;
            Outcome {
                weight: std::array::from_fn(mean),
                lengths: std::array::from_fn(|power| mean(3 + power)),
                in_strata: std::array::from_fn(|s| if s < strata { mean(6 + s) } else { 0.0 }),
            }
        })
    }
}
