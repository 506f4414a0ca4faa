//! The CIE standard clear sky, made for one place of the sun.

use super::direction_table::{DirectionTable, direction_at};
use core::f64::consts::{PI, TAU};
use snowgrain_math::DVec3;
use snowgrain_optics::clear_sky::relative_luminance;

/// Cells of the density that directions are drawn with: heights by azimuths.
const CELLS: [usize; 2] = [64, 128];

/// Heights by azimuths of the points that the light is summed at: irradiance to 1e-4.
const POINTS: [usize; 2] = [160, 256];

/// The clear sky such that a level plane receives pi.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct ClearSky {
    sun: DVec3,
    /// Radiance over the luminance of [`relative_luminance`].
    scale: f64,
    /// Radiance summed over the hemisphere.
    total: f64,
    table: DirectionTable,
}

impl ClearSky {
    /// With the sun in this direction.
    pub(super) fn new(sun: DVec3) -> Self {
        let luminance = |direction: DVec3| relative_luminance(direction.y, direction.dot(sun));
        let [heights, azimuths] = POINTS;
        let (mut sum, mut irradiance) = (0.0, 0.0);
        for row in 0..heights {
            let height = (row as f64 + 0.5) / heights as f64;
            let around = |column: usize| {
                luminance(direction_at(height, (column as f64 + 0.5) / azimuths as f64))
            };
            let ring = (0..azimuths).map(around).sum::<f64>();
            sum += ring;
            irradiance += ring * height;
        }
        let [rows, columns] = CELLS;
        let bounds = (0..=rows).map(|row| 1.0 - row as f64 / rows as f64).collect();
        let table = DirectionTable::new(bounds, columns, |row| {
            let height = 1.0 - (row as f64 + 0.5) / rows as f64;
            let at = |column| direction_at(height, (column as f64 + 0.5) / columns as f64);
            (0..columns).map(|column| luminance(at(column))).collect()
        });
        let point = TAU / (heights * azimuths) as f64;
        let scale = PI / (irradiance * point);
        Self { sun, scale, total: scale * sum * point, table }
    }

    pub(super) fn radiance(&self, direction: DVec3) -> f64 {
        if direction.y > 0.0 {
            self.scale * relative_luminance(direction.y, direction.dot(self.sun))
        } else {
            0.0
        }
    }

    pub(super) fn sample(&self, u: [f64; 2]) -> Option<DVec3> {
        self.table.sample(u)
    }

    pub(super) fn density(&self, direction: DVec3) -> f64 {
        self.table.density(direction)
    }

    pub(super) fn total(&self) -> f64 {
        self.total
    }

    /// Radiance around the sun, within a tenth of the greatest.
    pub(super) fn greatest(&self) -> f64 {
        self.radiance(self.sun)
    }
}
