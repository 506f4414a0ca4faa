//! Straight lines along an axis through a pack, and the stretches of them that lie in grains.

use super::bodies::{Bodies, Body};
use crate::GrainField;
use core::f64::consts::{LN_2, LN_10};
use snowgrain_math::sampler::{PathKey, numbers};
use snowgrain_math::{Aabb, DVec3};

/// Times the median of all gaps from which the one that a tenth of the gaps tell says that grains are in clumps.
const CLUMPED: f64 = 2.0;
/// Most lines along each side of the pack's box.
const MOST_LINES: f64 = 1024.0;

/// A stretch of a line inside a grain.
#[derive(Clone, Copy, Debug, PartialEq, PartialOrd)]
pub(super) struct Chord {
    pub(super) line: u32,
    pub(super) low: f64,
    pub(super) high: f64,
}

/// Lines along an axis, one at a random place in each square of two largest radii across it.
#[derive(Clone, Debug)]
pub(super) struct Lines {
    axis: usize,
    /// The two other axes.
    across: [usize; 2],
    corner: DVec3,
    edge: f64,
    columns: u32,
    seed: u64,
    /// By line, then from below.
    pub(super) chords: Vec<Chord>,
}

impl Lines {
    /// Lines through all of `field`, which repeats with `period` (metres along x and z) where that is
    /// given.
    pub(super) fn along(
        axis: usize,
        field: &GrainField,
        period: Option<[f64; 2]>,
        seed: u64,
    ) -> Self {
        let across = [[1, 2], [0, 2], [0, 1]][axis];
        let bounds = box_of(field, period);
        let mut lines = Self {
            axis,
            across,
            corner: bounds.min,
            edge: 1.0,
            columns: 1,
            seed,
            chords: Vec::new(),
        };
        if bounds.is_empty() {
            return lines;
        }
        let size = across.map(|axis| bounds.size()[axis]);
        let largest = f64::from(field.largest_radius_quanta()) * field.quantisation.quantum();
        lines.edge = (2.0 * largest).max(size[0].max(size[1]) / MOST_LINES);
        lines.columns = (size[0] / lines.edge).ceil() as u32 + 1;
        let bodies = Bodies::of(field);
        for (index, grain) in field.iter().enumerate() {
            let body = bodies.body(index, grain.center, grain.radius);
            each_image(&body, &bounds, period, |image| lines.add(&image));
        }
        lines.chords.sort_unstable_by(|a, b| {
            a.line.cmp(&b.line).then(a.low.total_cmp(&b.low)).then(a.high.total_cmp(&b.high))
        });
        lines
    }

    fn add(&mut self, grain: &Body<'_>) {
        let [x, z] = self.across.map(|axis| grain.center[axis] - self.corner[axis]);
        let reach = grain.reach();
        let squares = |at: f64| {
            let low = ((at - reach) / self.edge).max(0.0);
            low as u32..=((at + reach) / self.edge).max(0.0) as u32
        };
        for row in squares(z) {
            for column in squares(x).filter(|&column| column < self.columns) {
                let line = self.line([column, row]);
                let [u, v] = self.offset(line);
                let dx = (f64::from(column) + u) * self.edge - x;
                let dz = (f64::from(row) + v) * self.edge - z;
                let square = reach * reach - dx * dx - dz * dz;
                if square <= 0.0 {
                    continue;
                }
                let (at, half) = (grain.center[self.axis], square.sqrt());
                if grain.shape.is_none() {
                    self.chords.push(Chord { line, low: at - half, high: at + half });
                    continue;
                }
                let mut origin = grain.center;
                origin[self.across[0]] += dx;
                origin[self.across[1]] += dz;
                let stretches = grain.stretches(origin, DVec3::AXES[self.axis]);
                let chord = |[low, high]: [f64; 2]| Chord { line, low: at + low, high: at + high };
                self.chords.extend(stretches.into_iter().map(chord));
            }
        }
    }

    /// Where in its square a line is.
    fn offset(&self, line: u32) -> [f64; 2] {
        // Those of vertical lines belong to the seed alone.
        let stream = [1, 0, 2][self.axis];
        let [u, v, _] = numbers(PathKey::new(self.seed, line.into(), stream), 0);
        [u, v].map(f64::from)
    }

    /// Edge of the squares, metres.
    pub(super) fn edge(&self) -> f64 {
        self.edge
    }

    /// Column and row of a line.
    pub(super) fn square(&self, line: u32) -> [u32; 2] {
        [line % self.columns, line / self.columns]
    }

    /// The line of a square.
    pub(super) fn line(&self, [column, row]: [u32; 2]) -> u32 {
        row * self.columns + column
    }

    /// Where a line crosses the plane through 0.
    pub(super) fn place(&self, line: u32) -> DVec3 {
        let mut at = DVec3::ZERO;
        let offset = self.offset(line);
        for ((axis, square), part) in self.across.into_iter().zip(self.square(line)).zip(offset) {
            at[axis] = self.corner[axis] + (f64::from(square) + part) * self.edge;
        }
        at
    }

    /// The chords of each line that meets a grain, with its number.
    pub(super) fn each(&self) -> impl Iterator<Item = (u32, &[Chord])> {
        self.chords.chunk_by(|a, b| a.line == b.line).map(|chords| (chords[0].line, chords))
    }

    /// Median of the gaps between grains along lines; 0 where there is none.
    ///
    /// Where grains hang together in clumps most gaps are within those. Then it is the median of gaps that are distributed
    /// exponentially, as among grains at random places, and of which a tenth are as long as a tenth of these.
    pub(super) fn median_gap(&self) -> f64 {
        let mut gaps = Vec::new();
        for (_, chords) in self.each() {
            let mut top = f64::NEG_INFINITY;
            for chord in chords {
                if chord.low > top && top.is_finite() {
                    gaps.push(chord.low - top);
                }
                top = top.max(chord.high);
            }
        }
        if gaps.is_empty() {
            return 0.0;
        }
        let mut quantile = |part: f64| {
            let index = (part * gaps.len() as f64) as usize;
            *gaps.select_nth_unstable_by(index, f64::total_cmp).1
        };
        let (median, long) = (quantile(0.5), quantile(0.9));
        let of_clumps = long * LN_2 / LN_10;
        if of_clumps > CLUMPED * median { of_clumps } else { median }
    }
}

/// The box of a pack; of one that repeats, a whole period.
pub(super) fn box_of(field: &GrainField, period: Option<[f64; 2]>) -> Aabb {
    let mut bounds = field.bounds();
    if let Some([x, z]) = period
        && !bounds.is_empty()
    {
        let origin = field.quantisation.origin();
        (bounds.min.x, bounds.max.x) = (origin.x, origin.x + x);
        (bounds.min.z, bounds.max.z) = (origin.z, origin.z + z);
    }
    bounds
}

/// Shows a grain and its images that reach into the box of a pack that repeats.
fn each_image<'a>(
    grain: &Body<'a>,
    bounds: &Aabb,
    period: Option<[f64; 2]>,
    mut show: impl FnMut(Body<'a>),
) {
    let Some([x, z]) = period else { return show(*grain) };
    let reach = grain.reach();
    let shifts = |axis: usize, period: f64| {
        let at = grain.center[axis];
        let high = at + reach > bounds.max[axis];
        let low = at - reach < bounds.min[axis];
        [Some(0.0), high.then_some(-period), low.then_some(period)].into_iter().flatten()
    };
    for dx in shifts(0, x) {
        for dz in shifts(2, z) {
            show(Body { center: grain.center + DVec3::new(dx, 0.0, dz), ..*grain });
        }
    }
}
