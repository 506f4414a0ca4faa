//! What single paths brought.

use super::outcome::{Outcome, PARTS};
use snowgrain_accel::STRATA;
use snowgrain_math::DVec3;

/// Where paths first arrived deep in the snow, and what they brought from there: of each slot of light three channels, their sum
/// times three powers of the length in ice, and times the length in each stratum.
#[derive(Clone, Debug, Default)]
pub(super) struct Samples {
    slots: usize,
    strata: usize,
    places: Vec<DVec3>,
    throughputs: Vec<[f32; 3]>,
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
        self.places.len()
    }

    /// Where each counts, in coarse cells.
    pub(super) fn places(&self) -> &[DVec3] {
        &self.places
    }

    /// Adds a path of a throughput; outcomes slot by slot, times the throughput.
    pub(super) fn push(
        &mut self,
        place: DVec3,
        throughput: [f32; 3],
        of_slots: impl Iterator<Item = [f64; PARTS]>,
    ) {
        self.places.push(place);
        self.throughputs.push(throughput);
        for parts in of_slots {
            self.values.extend(parts.into_iter().take(self.width()).map(|part| part as f32));
        }
    }

    /// Adds those of another one behind.
    pub(super) fn append(&mut self, mut other: Self) {
        self.places.append(&mut other.places);
        self.throughputs.append(&mut other.throughputs);
        self.values.append(&mut other.values);
    }

    fn width(&self) -> usize {
        PARTS - STRATA + self.strata
    }

    /// What all slots bring on average over some paths for a throughput of 1, summed in their order: a path that ends with that
    /// brings as much on average as these did.
    pub(super) fn means(&self, group: &[u32]) -> impl Iterator<Item = Outcome> {
        let width = self.width();
        let row = self.slots * width;
        let (mut sums, mut squares) = (vec![0.0_f64; row], vec![0.0_f64; self.slots]);
        let mut throughput = [0.0_f64; 3];
        for &index in group {
            let values = &self.values[index as usize * row..][..row];
            sums.iter_mut().zip(values).for_each(|(sum, &value)| *sum += f64::from(value));
            for (sum, values) in squares.iter_mut().zip(values.chunks_exact(width)) {
                let light = f64::from(values[0] + values[1] + values[2]);
                *sum += light * light;
            }
            let of_path = self.throughputs[index as usize];
            throughput.iter_mut().zip(of_path).for_each(|(sum, part)| *sum += f64::from(part));
        }
        let of_all = throughput.iter().sum::<f64>() / 3.0;
        let count = group.len() as f64;
        (0..self.slots).map(move |slot| {
            let sums = &sums[slot * width..][..width];
            let parts = std::array::from_fn(|part| match sums.get(part) {
                Some(sum) => (sum / throughput.get(part).unwrap_or(&of_all)) as f32,
                None => 0.0,
            });
            let light = sums[..3].iter().sum::<f64>();
            let variance = (squares[slot] - light * light / count).max(0.0);
            Outcome::of_parts(parts, (variance.sqrt() / (3.0 * of_all)) as f32)
        })
    }
}
