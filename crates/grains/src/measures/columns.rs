//! The solid fraction of snow that lies on things: measured along vertical lines, each between 20
//! and 80 % of the depth that the snow has there.

use super::Estimate;
use crate::GrainField;
use snowgrain_math::sampler::{PathKey, numbers};

/// A gap this many times the median gap ends the snow on a line: the next grain below lies under
/// something. Gaps are nearly exponential, so one in 4000 of those within snow is taken for such.
const GAP_MEDIANS: f64 = 12.0;
/// Gaps of fewer largest radii never end it.
const LEAST_GAP_RADII: f64 = 8.0;
/// Thinner snow, in largest radii, is not counted: it has no inside.
const LEAST_DEPTH_RADII: f64 = 8.0;
/// Most lines along each side of the pack's box.
const MOST_LINES: f64 = 1024.0;

/// A stretch of a line inside a grain.
#[derive(Clone, Copy, PartialEq, PartialOrd)]
struct Chord {
    line: u32,
    low: f64,
    high: f64,
}

/// Solid fractions of snow that fell on things, `(union, nominal)`: along one vertical line at
/// a random place in each square of two largest radii, the part of the depth between 20 and 80 %
/// of the snow met there that lies in at least one grain, and the same with overlaps counted as
/// often as grains share them. Lines that meet no grain do not count, so this is not for crystals.
/// Both are 0 where no snow is eight largest radii deep.
#[must_use]
pub fn solid_fractions_along_lines(field: &GrainField, seed: u64) -> (Estimate, f64) {
    let chords = sorted_chords(field, seed);
    let quantum = field.quantisation.quantum();
    let largest = f64::from(field.largest_radius_quanta()) * quantum;
    let widest_gap = (GAP_MEDIANS * median_gap(&chords)).max(LEAST_GAP_RADII * largest);
    let mut bodies = Vec::new();
    let mut start = 0;
    let mut top = f64::NEG_INFINITY;
    for (index, chord) in chords.iter().enumerate() {
        let new_line = index > 0 && chords[index - 1].line != chord.line;
        if index > 0 && (new_line || chord.low - top > widest_gap) {
            bodies.push(inside(&chords[start..index], top, largest));
            (start, top) = (index, f64::NEG_INFINITY);
        }
        top = top.max(chord.high);
    }
    bodies.push(inside(&chords[start..], top, largest));
    ratio(&bodies)
}

/// Median of the gaps between grains along lines; 0 where there is none.
fn median_gap(chords: &[Chord]) -> f64 {
    let mut gaps = Vec::new();
    let mut top = f64::NEG_INFINITY;
    for (index, chord) in chords.iter().enumerate() {
        if index > 0 && chords[index - 1].line != chord.line {
            top = f64::NEG_INFINITY;
        }
        if chord.low > top && top.is_finite() {
            gaps.push(chord.low - top);
        }
        top = top.max(chord.high);
    }
    if gaps.is_empty() {
        return 0.0;
    }
    let middle = gaps.len() / 2;
    *gaps.select_nth_unstable_by(middle, f64::total_cmp).1
}

/// Lengths along the middle of the snow on one line: all, in ice, in ice counted by grains.
#[derive(Clone, Copy, Default)]
struct Lengths {
    all: f64,
    union: f64,
    nominal: f64,
}

/// The lengths within a body of snow, given by its chords from the lowest start upwards.
fn inside(chords: &[Chord], top: f64, largest: f64) -> Lengths {
    let bottom = chords.first().map_or(top, |chord| chord.low);
    let depth = top - bottom;
    if !(depth >= LEAST_DEPTH_RADII * largest && depth.is_finite()) {
        return Lengths::default();
    }
    let (low, high) = (bottom + 0.2 * depth, bottom + 0.8 * depth);
    let mut lengths = Lengths { all: high - low, ..Lengths::default() };
    let mut reached = low;
    for chord in chords {
        let end = chord.high.min(high);
        lengths.nominal += (end - chord.low.max(low)).max(0.0);
        lengths.union += (end - chord.low.max(reached)).max(0.0);
        reached = reached.max(end);
    }
    lengths
}

/// The ratio of sums and the standard error of a ratio estimate.
fn ratio(bodies: &[Lengths]) -> (Estimate, f64) {
    let sum = |part: fn(&Lengths) -> f64| bodies.iter().map(part).sum::<f64>();
    let all = sum(|body| body.all);
    if all == 0.0 {
        return (Estimate { mean: 0.0, standard_error: 0.0 }, 0.0);
    }
    let mean = sum(|body| body.union) / all;
    let squares: f64 = bodies
        .iter()
        .map(|body| body.union - mean * body.all)
        .map(|difference| difference * difference)
        .sum();
    (Estimate { mean, standard_error: squares.sqrt() / all }, sum(|body| body.nominal) / all)
}

/// Chords of all grains, by line and then from below.
fn sorted_chords(field: &GrainField, seed: u64) -> Vec<Chord> {
    let bounds = field.bounds();
    let mut chords = Vec::new();
    if bounds.is_empty() {
        return chords;
    }
    let size = bounds.size();
    let largest = f64::from(field.largest_radius_quanta()) * field.quantisation.quantum();
    let edge = (2.0 * largest).max(size.x.max(size.z) / MOST_LINES);
    let columns = (size.x / edge).ceil() as i64 + 1;
    for grain in field.iter() {
        let (x, z) = (grain.center.x - bounds.min.x, grain.center.z - bounds.min.z);
        let squares =
            |at: f64| ((at - grain.radius) / edge) as i64..=((at + grain.radius) / edge) as i64;
        for row in squares(z) {
            for column in squares(x) {
                let line = (row * columns + column) as u64;
                let [u, v, _] = numbers(PathKey::new(seed, line, 0), 0);
                let dx = (column as f64 + f64::from(u)) * edge - x;
                let dz = (row as f64 + f64::from(v)) * edge - z;
                let square = grain.radius * grain.radius - dx * dx - dz * dz;
                if square > 0.0 {
                    let half = square.sqrt();
                    let (low, high) = (grain.center.y - half, grain.center.y + half);
                    chords.push(Chord { line: line as u32, low, high });
                }
            }
        }
    }
    chords.sort_unstable_by(|a, b| {
        a.line.cmp(&b.line).then(a.low.total_cmp(&b.low)).then(a.high.total_cmp(&b.high))
    });
    chords
}
