//! Pictures that lie on the plan: heights of snow, and masks.

use crate::GrainsError;
use snowgrain_accel::Extent;
use snowgrain_math::{Aabb, DVec3};

/// A picture of grey values that lies on a rectangle of the plan, its top at the least z: as seen from
/// above with x to the right. Between the middles of its pixels it is linear, towards its edges as at
/// the nearest middle, and 0 beside it.
#[derive(Clone, Debug, PartialEq)]
pub struct PlanImage {
    /// Columns and rows.
    size: [usize; 2],
    /// Row by row.
    values: Vec<f32>,
    /// `[x0, z0, x1, z1]`, metres.
    area: [f64; 4],
}

impl PlanImage {
    /// A picture over `area`, `[x0, z0, x1, z1]` metres.
    ///
    /// # Errors
    /// A picture without pixels, of another number of values, or with one that is not finite; an area that
    /// is none.
    pub fn new(size: [usize; 2], values: Vec<f32>, area: [f64; 4]) -> Result<Self, GrainsError> {
        let [x0, z0, x1, z1] = area;
        if !(x0 < x1 && z0 < z1 && area.iter().all(|c| c.is_finite())) {
            let reason =
                format!("[{x0}, {z0}, {x1}, {z1}] must be [x0, z0, x1, z1], x0 < x1, z0 < z1");
            return Err(GrainsError::setting("area", reason));
        }
        if values.is_empty() || values.len() != size[0] * size[1] {
            return Err(GrainsError::setting("file", "the picture has no pixels"));
        }
        if values.iter().any(|value| !value.is_finite()) {
            return Err(GrainsError::setting("file", "a pixel of the picture is not a number"));
        }
        Ok(Self { size, values, area })
    }

    /// The picture as parts of a density.
    ///
    /// # Errors
    /// A value below 0 or above 1.
    pub fn check_parts(self) -> Result<Self, GrainsError> {
        let Some(at) = self.values.iter().position(|value| !(0.0..=1.0).contains(value)) else {
            return Ok(self);
        };
        let (column, row) = (at % self.size[0], at / self.size[0]);
        let reason = format!(
            "the pixel in column {column}, row {row} (from 0) is {}; parts of a density are 0 (black) to 1 (white)",
            self.values[at]
        );
        Err(GrainsError::setting("density_map", reason))
    }

    /// The value at a point's place on the plan.
    #[must_use]
    pub fn at(&self, point: DVec3) -> f64 {
        let [x0, z0, x1, z1] = self.area;
        let (u, v) = ((point.x - x0) / (x1 - x0), (point.z - z0) / (z1 - z0));
        if !((0.0..=1.0).contains(&u) && (0.0..=1.0).contains(&v)) {
            return 0.0;
        }
        let split = |unit: f64, count: usize| {
            let at = (unit * count as f64 - 0.5).clamp(0.0, count as f64 - 1.0);
            let low = (at as usize).min(count - 1);
            (low, (low + 1).min(count - 1), at - low as f64)
        };
        let (left, right, across) = split(u, self.size[0]);
        let (top, bottom, down) = split(v, self.size[1]);
        let value = |column: usize, row: usize| f64::from(self.values[row * self.size[0] + column]);
        let mix = |a: f64, b: f64, part: f64| a + (b - a) * part;
        let upper = mix(value(left, top), value(right, top), across);
        let lower = mix(value(left, bottom), value(right, bottom), across);
        mix(upper, lower, down)
    }

    /// The least and the greatest value over a box, or wider bounds.
    fn range(&self, around: &Aabb) -> [f64; 2] {
        let [x0, z0, x1, z1] = self.area;
        let inside =
            around.min.x >= x0 && around.max.x <= x1 && around.min.z >= z0 && around.max.z <= z1;
        let pixels = |low: f64, high: f64, (from, to): (f64, f64), count: usize| {
            let at = |place: f64| {
                let pixel = (place - from) / (to - from) * count as f64 - 0.5;
                pixel.clamp(0.0, count as f64 - 1.0)
            };
            // One more on either side takes care of rounding.
            let first = (at(low) as usize).saturating_sub(1);
            first..(at(high) as usize + 3).min(count)
        };
        let columns = pixels(around.min.x, around.max.x, (x0, x1), self.size[0]);
        let rows = pixels(around.min.z, around.max.z, (z0, z1), self.size[1]);
        let beside = if inside { [f64::INFINITY, f64::NEG_INFINITY] } else { [0.0; 2] };
        rows.flat_map(|row| columns.clone().map(move |column| row * self.size[0] + column))
            .map(|at| f64::from(self.values[at]))
            .fold(beside, |[low, high], value| [low.min(value), high.max(value)])
    }

    fn greatest(&self) -> f64 {
        self.values.iter().copied().fold(0.0f32, f32::max).into()
    }
}

/// Snow between a level and the heights of a picture.
#[derive(Clone, Debug, PartialEq)]
pub struct HeightField {
    /// The picture, white is 1.
    pub image: PlanImage,
    /// Height of white over `base`, metres, > 0.
    pub height: f64,
    /// Height of the level that the snow lies on, metres.
    pub base: f64,
}

impl HeightField {
    pub(super) fn bounds(&self) -> Aabb {
        let [x0, z0, x1, z1] = self.image.area;
        let top = self.base + self.height * self.image.greatest();
        Aabb::new(DVec3::new(x0, self.base, z0), DVec3::new(x1, top, z1))
    }

    pub(super) fn volume(&self) -> f64 {
        let [x0, z0, x1, z1] = self.image.area;
        let sum: f64 = self.image.values.iter().map(|&value| f64::from(value.max(0.0))).sum();
        (x1 - x0) * (z1 - z0) * self.height * sum / self.image.values.len() as f64
    }

    /// What of a box lies under the surface, where it is sure.
    pub(super) fn extent(&self, around: &Aabb) -> Extent {
        // Far more than what is rounded between two values of the picture.
        let slack = 1e-9 * self.height.abs();
        let [low, high] = self.image.range(around).map(|value| self.base + self.height * value);
        if around.max.y < self.base || around.min.y > high + slack {
            Extent::Empty
        } else if around.min.y >= self.base && around.max.y < low - slack {
            Extent::Whole
        } else {
            Extent::Part
        }
    }

    pub(super) fn holds(&self, point: DVec3) -> bool {
        point.y >= self.base && point.y < self.base + self.height * self.image.at(point)
    }
}
