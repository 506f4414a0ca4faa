//! The solid fraction of snow that lies on things: measured along vertical lines, each between 20
//! and 80 % of the depth that the snow has there.

use super::Estimate;
use super::lines::Lines;
use super::region::Columns;
use crate::GrainField;

/// Solid fractions of snow that fell on things, `(union, nominal)`: along one vertical line at
/// a random place in each square of two largest radii, the part of the depth between 20 and 80 %
/// of the snow met there that lies in at least one grain, and the same with overlaps counted as
/// often as grains share them. Where grains are farther apart than squares are wide, the depth is that
/// which several lines find together. Squares without snow do not count, so this is not for crystals.
/// Both are 0 where no snow is eight largest radii deep.
#[must_use]
pub fn solid_fractions_along_lines(field: &GrainField, seed: u64) -> (Estimate, f64) {
    let lines = Lines::along(1, field, None, seed);
    let columns = Columns::new(field, &lines);
    let mut chords = lines.each().peekable();
    let mut bodies = Vec::new();
    for (line, inside) in columns.inside(&lines) {
        while chords.next_if(|(other, _)| *other < line).is_some() {}
        let own = chords.peek().filter(|(other, _)| *other == line).map_or(&[][..], |at| at.1);
        bodies.push(lengths(own, inside));
    }
    ratio(&bodies)
}

/// Lengths along the middle of the snow on one line: all, in ice, in ice counted by grains.
#[derive(Clone, Copy, Default)]
struct Lengths {
    all: f64,
    union: f64,
    nominal: f64,
}

/// The lengths between two heights, of the chords of a line from the lowest start upwards.
fn lengths(chords: &[super::lines::Chord], [low, high]: [f64; 2]) -> Lengths {
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
