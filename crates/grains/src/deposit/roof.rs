//! How high surfaces reach over the plan, so that falls that end above them need not ask.

use rayon::prelude::*;
use snowgrain_accel::{PlanRectangle, Surfaces};
use snowgrain_geometry::Quantisation;
use snowgrain_math::{Aabb, DVec3};

/// Drops for each cell of a roof: so many pay for the search of its height.
const DROPS_PER_CELL: f64 = 256.0;
/// Most cells along an edge.
const LONGEST_EDGE: f64 = 64.0;
/// A length of the order of a grain, quanta: the first step of a search, which doubles.
const GRAIN: f64 = Quantisation::MAX_RADIUS_QUANTA as f64;
/// Halvings of the step that crossed the highest surface.
const HALVINGS: u32 = 4;
/// Quanta that roundings may move what is compared with a roof.
const SLACK: f64 = 4.0;

/// A height over each cell of a rectangle of the plan above which no surface passes, within a margin
/// around the cell. Quanta; x and z from the quantisation's origin.
#[derive(Debug)]
pub(super) struct Roof {
    min: [f64; 2],
    cells_per_quantum: [f64; 2],
    edge: usize,
    margin: f64,
    heights: Vec<f64>,
}

impl Roof {
    /// Over `plan`, for `drops` drops that ask for surfaces within `margin` quanta of a vertical.
    pub(super) fn over(
        surfaces: &Surfaces,
        quantisation: &Quantisation,
        plan: PlanRectangle,
        margin: f64,
        drops: f64,
    ) -> Self {
        let edge = (drops / DROPS_PER_CELL).sqrt().clamp(1.0, LONGEST_EDGE) as usize;
        let min = plan.min.map(f64::from);
        let sizes = [0, 1].map(|axis| (f64::from(plan.max[axis]) - min[axis]) / edge as f64);
        let reach = margin + SLACK;
        let column = |cell: usize| {
            let corner =
                |axis: usize| min[axis] + sizes[axis] * [cell % edge, cell / edge][axis] as f64;
            let [x, z] = [corner(0), corner(1)];
            Column {
                surfaces,
                quantisation,
                min: [x - reach, z - reach],
                max: [x + sizes[0] + reach, z + sizes[1] + reach],
            }
        };
        let heights = (0..edge * edge).into_par_iter().map(|cell| column(cell).height()).collect();
        Self { min, cells_per_quantum: sizes.map(|size| 1.0 / size), edge, margin, heights }
    }

    /// Whether no surface passes above `height` within `reach` quanta of the vertical at `x, z`; may
    /// say no too often, never yes wrongly.
    #[inline]
    pub(super) fn is_below(&self, [x, z]: [f64; 2], reach: f64, height: f64) -> bool {
        let cell = [
            (x - self.min[0]) * self.cells_per_quantum[0],
            (z - self.min[1]) * self.cells_per_quantum[1],
        ];
        let edge = self.edge as f64;
        if !cell.iter().all(|at| (0.0..edge).contains(at)) || reach > self.margin {
            return false;
        }
        self.heights[cell[1] as usize * self.edge + cell[0] as usize] + SLACK <= height
    }
}

/// A rectangle of the plan, quanta.
struct Column<'a> {
    surfaces: &'a Surfaces,
    quantisation: &'a Quantisation,
    min: [f64; 2],
    max: [f64; 2],
}

impl Column<'_> {
    /// A height above which no surface passes; at best the least.
    fn height(&self) -> f64 {
        let highest = f64::from(Quantisation::MAX_COORDINATE);
        // The range, from below, doubles until its end lies above all.
        let bounds = self.surfaces.bounds();
        let above_all = (bounds.max.y - self.quantisation.origin().y) / self.quantisation.quantum();
        let mut high = if above_all.is_finite() { above_all + SLACK } else { SLACK };
        let mut step = 2.0 * GRAIN;
        while self.may_cross(high, highest) {
            if high >= highest {
                return f64::INFINITY;
            }
            high = (high + step).min(highest);
            step *= 2.0;
        }
        let mut low = -highest;
        if !self.may_cross(low, high) {
            return f64::NEG_INFINITY;
        }
        // From above, in steps that grow, to below the highest surface; then by halves.
        let mut step = GRAIN;
        while high - step > low {
            if self.may_cross(high - step, high) {
                low = high - step;
                break;
            }
            high -= step;
            step *= 2.0;
        }
        for _ in 0..HALVINGS {
            let middle = 0.5 * (low + high);
            if self.may_cross(middle, high) {
                low = middle;
            } else {
                high = middle;
            }
        }
        high
    }

    fn may_cross(&self, low: f64, high: f64) -> bool {
        let point = |[x, z]: [f64; 2], y: f64| {
            self.quantisation.origin() + DVec3::new(x, y, z) * self.quantisation.quantum()
        };
        self.surfaces.may_cross(&Aabb::new(point(self.min, low), point(self.max, high)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use snowgrain_accel::SurfaceShape;
    use snowgrain_geometry::teapot;
    use snowgrain_math::DAffine3;
    use std::sync::Arc;

    const R: f64 = 0.5e-3;

    /// Heights of falls onto all kinds of surfaces against what the roof over them says: never yes
    /// where the fall ends higher, and yes for most that end a little lower.
    #[test]
    fn a_roof_is_above_everything_and_close_to_it() {
        let quantisation = Quantisation::for_grains(DVec3::new(3.0, -1.0, 2.0), R);
        let quantum = quantisation.quantum();
        let tilt = DAffine3::from_rotation_z(0.2);
        let place = |size: f64, x: f64| {
            let shift = quantisation.origin() + DVec3::new(x * R, 0.0, 0.0);
            DAffine3::from_translation(shift) * DAffine3::from_scale(DVec3::splat(size * R))
        };
        let objects = [
            (SurfaceShape::Sphere, place(20.0, -60.0)),
            (SurfaceShape::Mesh(Arc::new(teapot(8))), place(8.0, 0.0)),
            (SurfaceShape::Box, place(9.0, 50.0) * tilt),
            (SurfaceShape::Plane, place(1.0, 0.0) * tilt),
        ];
        for kinds in [0..3, 0..4, 3..4] {
            let surfaces = Surfaces::new(&objects[kinds]);
            let half = (100.0 * R / quantum) as i32;
            let plan = PlanRectangle { min: [-half; 2], max: [half; 2] };
            let radius = R / quantum;
            let roof = Roof::over(&surfaces, &quantisation, plan, radius, 400_000.0);
            let (mut close, mut all) = (0, 0);
            for i in 0..4000 {
                // A low-discrepancy sequence (Roberts 2018, the plastic number).
                let at =
                    [0.754_877_666, 0.569_840_291].map(|step: f64| (step * f64::from(i)).fract());
                let [x, z] = at.map(|u| (2.0 * u - 1.0) * f64::from(half));
                let origin = quantisation.origin();
                let [px, pz] = [origin.x + x * quantum, origin.z + z * quantum];
                let heights = [origin.y + 1.0, f64::NEG_INFINITY];
                let contact = surfaces.drop_sphere(px, pz, R, heights);
                let Some(contact) = contact else { continue };
                let top = (contact.center_y - origin.y) / quantum - radius;
                assert!(!roof.is_below([x, z], radius, top - 1.0), "{x} {z}");
                all += 1;
                close += u32::from(roof.is_below([x, z], radius, top + 8.0 * radius));
                assert!(!roof.is_below([x, z], 1.1 * radius, 1e9));
            }
            assert!(all > 200 && close * 10 > all * 8, "{close} of {all}");
            assert!(!roof.is_below([f64::from(2 * half), 0.0], 0.0, 1e9));
        }
    }
}
