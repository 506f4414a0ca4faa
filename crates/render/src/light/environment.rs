//! Light from a picture of all directions.

use super::direction_table::{DirectionTable, turn_of};
use super::luminance;
use crate::RenderError;
use core::f64::consts::{FRAC_1_PI, PI, TAU};
use snowgrain_math::{DVec3, trig};
use std::sync::Arc;

/// Most pixels across a map.
pub const LARGEST_MAP: usize = 16_384;

/// Radiance of all directions: an equirectangular picture, twice as wide as high, with straight up along its
/// upper edge. Its middle is north (-z), azimuths run clockwise to the right: a quarter to the right of the
/// middle is east (+x). Radiance is interpolated between the middles of pixels.
#[derive(Clone, Debug, PartialEq)]
pub struct EnvironmentMap {
    width: usize,
    height: usize,
    /// Linear sRGB, row by row from the top.
    pixels: Vec<[f32; 3]>,
}

impl EnvironmentMap {
    /// The map of these pixels, row by row from the top.
    ///
    /// # Errors
    /// A picture that is not twice as wide as high, or more than [`LARGEST_MAP`] wide; a number of pixels
    /// that is another; a value below 0, infinite or not a number.
    pub fn new(width: usize, height: usize, pixels: Vec<[f32; 3]>) -> Result<Self, RenderError> {
        check_map_size(width, height)?;
        if pixels.len() != width * height {
            return Err(RenderError::MapPixels { width, height, pixels: pixels.len() });
        }
        let good = |value: &f32| value.is_finite() && *value >= 0.0;
        let bad = pixels.iter().enumerate().find_map(|(at, pixel)| {
            let value = pixel.iter().find(|value| !good(value))?;
            Some(RenderError::MapValue { x: at % width, y: at / width, value: *value })
        });
        bad.map_or(Ok(Self { width, height, pixels }), Err)
    }

    /// Pixels across.
    #[must_use]
    pub fn width(&self) -> usize {
        self.width
    }

    /// Pixels down.
    #[must_use]
    pub fn height(&self) -> usize {
        self.height
    }

    /// Linear sRGB, row by row from the top.
    #[must_use]
    pub fn pixels(&self) -> &[[f32; 3]] {
        &self.pixels
    }

    /// Radiance of a direction of the map.
    #[must_use]
    pub fn radiance(&self, direction: DVec3) -> [f32; 3] {
        let polar = trig::acos(direction.y.clamp(-1.0, 1.0));
        let x = turn_of(direction) * self.width as f64 - 0.5;
        let y = polar * FRAC_1_PI * self.height as f64 - 0.5;
        let (left, top) = (x.floor(), y.floor());
        let (right, bottom) = ((x - left) as f32, (y - top) as f32);
        let row = |below: f64| ((top + below).max(0.0) as usize).min(self.height - 1) * self.width;
        let column = |beside: f64| (left + beside).rem_euclid(self.width as f64) as usize;
        let columns = [column(0.0), column(1.0)];
        let [above, below] = [row(0.0), row(1.0)].map(|row| {
            let [a, b] = columns.map(|column| self.pixels[row + column]);
            mix(a, b, right)
        });
        mix(above, below, bottom)
    }

    /// The mean luminance over each pixel of what lies between the middles of pixels: an eighth of what each
    /// neighbour has in a row and in a column, and three quarters of its own.
    fn smoothed_row(&self, row: usize) -> Vec<f64> {
        let rows = [row.saturating_sub(1), row, (row + 1).min(self.height - 1)];
        let columns: Vec<f64> = (0..self.width)
            .map(|column| {
                let at = |row: usize| luminance(self.pixels[row * self.width + column]);
                eighths(rows.map(at))
            })
            .collect();
        let last = self.width - 1;
        (0..self.width)
            .map(|x| {
                let left = if x == 0 { last } else { x - 1 };
                let right = if x == last { 0 } else { x + 1 };
                eighths([columns[left], columns[x], columns[right]])
            })
            .collect()
    }
}

/// Refuses sizes that no map has; to be asked before memory is taken for pixels.
///
/// # Errors
/// A picture that is not twice as wide as high, or more than [`LARGEST_MAP`] wide.
pub fn check_map_size(width: usize, height: usize) -> Result<(), RenderError> {
    let fits = (2..=LARGEST_MAP).contains(&width) && width == height.saturating_mul(2);
    if fits { Ok(()) } else { Err(RenderError::MapSize { width, height }) }
}

fn mix(a: [f32; 3], b: [f32; 3], part: f32) -> [f32; 3] {
    std::array::from_fn(|channel| a[channel] * (1.0 - part) + b[channel] * part)
}

fn eighths([before, here, after]: [f64; 3]) -> f64 {
    (before + after) * 0.125 + here * 0.75
}

/// A map that is turned, and what directions are drawn with.
#[derive(Debug)]
pub(super) struct Environment {
    map: Arc<EnvironmentMap>,
    /// Sine and cosine of the turn about y.
    turn: (f64, f64),
    table: DirectionTable,
    /// Luminance summed over all directions.
    total: f64,
}

impl Environment {
    /// Turned about y as objects are: counter-clockwise as seen from above.
    pub(super) fn new(map: &Arc<EnvironmentMap>, rotation_degrees: f64) -> Self {
        let height = map.height as f64;
        let bounds = (0..=map.height).map(|row| trig::sin_cos(PI * row as f64 / height).1);
        let heights: Vec<f64> = bounds.collect();
        let mut total = 0.0;
        let table = DirectionTable::new(heights.clone(), map.width, |row| {
            let weights = map.smoothed_row(row);
            let cell = (heights[row] - heights[row + 1]) * TAU / map.width as f64;
            total += weights.iter().sum::<f64>() * cell;
            weights
        });
        let turn = trig::sin_cos(rotation_degrees.rem_euclid(360.0).to_radians());
        Self { map: Arc::clone(map), turn, table, total }
    }

    pub(super) fn radiance(&self, direction: DVec3) -> [f32; 3] {
        self.map.radiance(self.turned(direction, -1.0))
    }

    pub(super) fn sample(&self, u: [f64; 2]) -> Option<DVec3> {
        self.table.sample(u).map(|direction| self.turned(direction, 1.0))
    }

    pub(super) fn density(&self, direction: DVec3) -> f64 {
        self.table.density(self.turned(direction, -1.0))
    }

    /// Luminance summed over all directions.
    pub(super) fn total(&self) -> f64 {
        self.total
    }

    /// The greatest component of any radiance.
    pub(super) fn greatest(&self) -> f32 {
        self.map.pixels.iter().flatten().copied().fold(0.0, f32::max)
    }

    fn turned(&self, direction: DVec3, sense: f64) -> DVec3 {
        let (sin, cos) = (self.turn.0 * sense, self.turn.1);
        let DVec3 { x, y, z } = direction;
        DVec3::new(cos * x + sin * z, y, cos * z - sin * x)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::light::direction_of;
    use crate::light::direction_table::direction_at;

    /// A dim sky with one bright pixel and a dark half.
    fn map(width: usize) -> EnvironmentMap {
        let height = width / 2;
        let mut pixels = vec![[0.0; 3]; width * height];
        for (at, pixel) in pixels.iter_mut().enumerate().take(width * height / 2) {
            let level = (at % 7) as f32 * 0.1;
            *pixel = [level, 0.5 * level, 0.25];
        }
        pixels[width * (height / 4) + width * 3 / 4] = [900.0, 800.0, 700.0];
        EnvironmentMap::new(width, height, pixels).unwrap()
    }

    #[test]
    fn the_middle_is_north_and_azimuths_run_to_the_right() {
        let mut pixels = vec![[0.0; 3]; 8 * 4];
        for y in 0..4 {
            pixels[8 * y + 6] = [1.0; 3]; // azimuths 90 to 135 degrees
        }
        let map = Arc::new(EnvironmentMap::new(8, 4, pixels).unwrap());
        assert_eq!(map.radiance(direction_of(10.0, 112.5)), [1.0; 3]);
        assert_eq!(map.radiance(direction_of(10.0, 0.0)), [0.0; 3]);
        // Turned by a quarter, counter-clockwise as seen from above: from east to north.
        let turned = Environment::new(&map, 90.0);
        let [r, ..] = turned.radiance(direction_of(10.0, 22.5));
        assert!((r - 1.0).abs() < 1e-6);
    }

    #[test]
    fn densities_are_above_zero_wherever_there_is_light_and_sum_to_one() {
        let map = Arc::new(map(32));
        let environment = Environment::new(&map, 30.0);
        let (rows, columns) = (512, 1024);
        let solid_angle = 4.0 * PI / f64::from(rows * columns);
        let (mut density, mut total) = (0.0, 0.0);
        for row in 0..rows {
            for column in 0..columns {
                let height = 1.0 - 2.0 * (f64::from(row) + 0.5) / f64::from(rows);
                let direction =
                    direction_at(height, (f64::from(column) + 0.5) / f64::from(columns));
                let found = environment.density(direction);
                let light = luminance(environment.radiance(direction));
                assert!(found > 0.0 || light == 0.0);
                density += found * solid_angle;
                total += light * solid_angle;
            }
        }
        assert!((density - 1.0).abs() < 5e-3, "{density}");
        assert!(
            (total / environment.total() - 1.0).abs() < 0.02,
            "{total} {}",
            environment.total()
        );
    }

    #[test]
    fn pictures_that_are_no_maps_are_refused() {
        let refusal = |width, height, pixels| {
            EnvironmentMap::new(width, height, pixels).unwrap_err().to_string()
        };
        assert!(refusal(4, 4, vec![[0.0; 3]; 16]).contains("4x4"));
        assert!(refusal(4, 2, vec![[0.0; 3]; 7]).contains('7'));
        for (value, name) in [(f32::NAN, "NaN"), (-1.0, "-1"), (f32::INFINITY, "inf")] {
            let mut pixels = vec![[0.0; 3]; 8];
            pixels[6][1] = value;
            let message = refusal(4, 2, pixels);
            assert!(message.contains(name) && message.contains("(2, 1)"), "{message}");
        }
        assert!(check_map_size(60_000, 30_000).is_err());
        assert!(check_map_size(usize::MAX, usize::MAX).is_err());
    }
}
