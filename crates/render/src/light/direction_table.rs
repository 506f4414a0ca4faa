//! Densities over directions that are constant in each cell of a grid.

use super::choice::Choice;
use super::description::direction_of;
use core::f64::consts::{PI, TAU};
use snowgrain_math::{DVec3, trig};

/// A density over directions: rows between heights y (of the unit vector) from top to bottom, each divided
/// into cells of equal azimuth; constant over the solid angle of a cell.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct DirectionTable {
    /// Heights between which the rows lie, falling.
    heights: Vec<f64>,
    rows: Choice,
    cells: Vec<Choice>,
    columns: usize,
}

impl DirectionTable {
    /// The density in proportion to the weights of each row, finite and at least 0; as many in each as there
    /// are `columns`. Column 0 begins where the azimuth is -180 degrees; it grows clockwise.
    pub(super) fn new(
        heights: Vec<f64>,
        columns: usize,
        mut weights: impl FnMut(usize) -> Vec<f64>,
    ) -> Self {
        let rows = heights.len() - 1;
        let mut sums = Vec::with_capacity(rows);
        let cells = (0..rows)
            .map(|row| {
                let weights = weights(row);
                sums.push(weights.iter().sum::<f64>() * (heights[row] - heights[row + 1]));
                Choice::new(weights)
            })
            .collect();
        Self { heights, rows: Choice::new(sums), cells, columns }
    }

    /// A direction; `None` where all weights are 0.
    pub(super) fn sample(&self, u: [f64; 2]) -> Option<DVec3> {
        let (row, down) = self.rows.pick(u[0])?;
        let (column, along) = self.cells[row].pick(u[1])?;
        let [top, bottom] = [self.heights[row], self.heights[row + 1]];
        let turn = (column as f64 + along) / self.columns as f64;
        Some(direction_at(top + (bottom - top) * down, turn))
    }

    /// Density of [`Self::sample`], 1/sr.
    pub(super) fn density(&self, direction: DVec3) -> f64 {
        let [first, .., last] = self.heights[..] else { return 0.0 };
        if direction.y < last {
            return 0.0;
        }
        // What rounding has left above the first row or on the edge of the last belongs to them.
        let from_top = self.heights.partition_point(|&height| height >= direction.y.min(first));
        let row = from_top.min(self.heights.len() - 1) - 1;
        let column = ((turn_of(direction) * self.columns as f64) as usize).min(self.columns - 1);
        let cell = TAU / self.columns as f64 * (self.heights[row] - self.heights[row + 1]);
        self.rows.probability(row) * self.cells[row].probability(column) / cell
    }
}

/// The unit vector of this height and azimuth, in turns from -180 degrees.
pub(super) fn direction_at(height: f64, turn: f64) -> DVec3 {
    let across = (1.0 - height * height).max(0.0).sqrt();
    let level = direction_of(0.0, 360.0 * turn - 180.0);
    DVec3::new(across * level.x, height, across * level.z)
}

/// Azimuth of a direction in turns from -180 degrees, in [0, 1].
pub(super) fn turn_of(direction: DVec3) -> f64 {
    ((trig::atan2(direction.x, -direction.z) + PI) / TAU).clamp(0.0, 1.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn azimuths_run_clockwise_from_north() {
        assert!((direction_at(0.0, 0.5) - DVec3::NEG_Z).length() < 1e-15);
        assert!((direction_at(0.0, 0.75) - DVec3::X).length() < 1e-15);
        assert!((direction_of(30.0, 90.0) - DVec3::new(0.75f64.sqrt(), 0.5, 0.0)).length() < 1e-15);
        for (height, turn) in [(0.3, 0.1), (-0.9, 0.6), (0.0, 0.999)] {
            assert!((turn_of(direction_at(height, turn)) - turn).abs() < 1e-12);
        }
    }

    #[test]
    fn dark_cells_are_never_chosen_and_their_density_is_none() {
        let table = DirectionTable::new(vec![1.0, 0.5, 0.0], 4, |row| {
            if row == 1 { vec![0.0, 0.0, 1.0, 0.0] } else { vec![0.0; 4] }
        });
        let direction = table.sample([0.3, 0.5]).unwrap();
        assert!((0.0..0.5).contains(&direction.y));
        assert!((table.density(direction) - 4.0 / (TAU * 0.5)).abs() < 1e-12);
        assert_eq!(table.density(DVec3::Y), 0.0);
        assert_eq!(table.density(DVec3::NEG_Y), 0.0);
        assert_eq!(
            DirectionTable::new(vec![1.0, 0.0], 2, |_| vec![0.0; 2]).sample([0.5, 0.5]),
            None
        );
    }
}
