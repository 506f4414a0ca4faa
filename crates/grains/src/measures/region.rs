//! Where a pack is measured: away from its surface and from what it lies on.

use super::lines::{Lines, box_of};
use super::{Extent, mean_surface_height};
use crate::GrainField;
use snowgrain_math::{Aabb, DVec3};

/// A gap this many times the median gap ends the snow on a line: the next grain below lies under
/// something. Gaps are nearly exponential, so one in 4000 of those within snow is taken for such.
const GAP_MEDIANS: f64 = 12.0;
/// Gaps of fewer largest radii never end it.
const LEAST_GAP_RADII: f64 = 8.0;
/// Thinner snow, in largest radii, is not counted: it has no inside.
const LEAST_DEPTH_RADII: f64 = 8.0;
/// Snow is light and thin where the median gap exceeds two largest radii and a line meets fewer grains than
/// this: then lines are put together to patches ...
const FEW_CHORDS: f64 = 24.0;
/// ... that meet about so many: wide enough that the hollows between clumps of grains, which are open to the sky, count as
/// snow.
const CHORDS_OF_PATCH: f64 = 4000.0;
/// Part of the lines of a patch of thin snow that must meet it.
const LEAST_MET: f64 = 0.3;

/// From where to where snow reaches on a line, metres.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Body {
    pub(super) bottom: f64,
    pub(super) top: f64,
}

impl Body {
    /// The part that is measured: between 20 and 80 % of the depth.
    pub(super) fn inside(&self) -> [f64; 2] {
        let depth = self.top - self.bottom;
        [self.bottom + 0.2 * depth, self.bottom + 0.8 * depth]
    }
}

/// The bodies of snow over each square of the plan.
#[derive(Clone, Debug)]
pub(super) struct Columns {
    corner: DVec3,
    edge: f64,
    counts: [usize; 2],
    bodies: Vec<Vec<Body>>,
}

/// Where a pack is measured.
#[derive(Clone, Debug)]
pub(super) enum Region {
    /// In a box, metres.
    Box(Aabb),
    /// In the middle of the snow over each square of the plan.
    Columns(Columns),
}

impl Region {
    pub(super) fn of(field: &GrainField, extent: Extent, vertical: &Lines) -> Self {
        let mut bounds = field.bounds();
        match extent {
            _ if bounds.is_empty() => Self::Box(Aabb::new(DVec3::ZERO, DVec3::ZERO)),
            Extent::Draped => Self::Columns(Columns::new(field, vertical)),
            Extent::Block => {
                let size = bounds.size();
                Self::Box(Aabb::new(bounds.min + 0.2 * size, bounds.min + 0.8 * size))
            }
            Extent::Periodic(period) => {
                bounds.max.y = mean_surface_height(field, period);
                let depth = bounds.size().y;
                let mut whole = box_of(field, Some(period));
                whole.min.y = bounds.min.y + 0.2 * depth;
                whole.max.y = bounds.min.y + 0.8 * depth;
                Self::Box(whole)
            }
        }
    }

    /// Cubic metres.
    pub(super) fn volume(&self) -> f64 {
        match self {
            Self::Box(bounds) => {
                let size = bounds.size();
                size.x * size.y * size.z
            }
            Self::Columns(columns) => {
                let depth = |body: &Body| 0.6 * (body.top - body.bottom);
                columns.edge
                    * columns.edge
                    * columns.bodies.iter().flatten().map(depth).sum::<f64>()
            }
        }
    }

    pub(super) fn holds(&self, point: DVec3) -> bool {
        match self {
            Self::Box(bounds) => point.cmpge(bounds.min).all() && point.cmplt(bounds.max).all(),
            Self::Columns(columns) => columns.at(point).iter().any(|body| {
                let [low, high] = body.inside();
                (low..high).contains(&point.y)
            }),
        }
    }

    /// The stretches inside of a line along `axis` through `place`, between `low` and `high`, upwards.
    pub(super) fn stretches(
        &self,
        axis: usize,
        place: DVec3,
        [low, high]: [f64; 2],
    ) -> Vec<[f64; 2]> {
        match self {
            Self::Box(bounds) => {
                let beside = |other: &usize| {
                    !(bounds.min[*other]..bounds.max[*other]).contains(&place[*other])
                };
                if (0..3).filter(|other| *other != axis).any(|other| beside(&other)) {
                    return Vec::new();
                }
                vec![[bounds.min[axis], bounds.max[axis]]]
            }
            Self::Columns(columns) if axis == 1 => {
                columns.at(place).iter().map(Body::inside).collect()
            }
            Self::Columns(columns) => columns.along(axis, place, [low, high]),
        }
    }

    /// From the bottom to the top of each body of snow about the vertical line through `place`.
    pub(super) fn whole(&self, place: DVec3) -> Vec<[f64; 2]> {
        match self {
            Self::Box(bounds) => {
                // The box holds the middle 60 % of the depth.
                let beyond = bounds.size().y / 3.0;
                let middle = self.stretches(1, place, [bounds.min.y, bounds.max.y]);
                middle.iter().map(|[low, high]| [low - beyond, high + beyond]).collect()
            }
            Self::Columns(columns) => {
                // Its own line begins and ends in a grain, wherever the surface is: that of the square
                // beside it does not.
                let beside = columns.at(place + DVec3::X * columns.edge);
                beside.iter().map(|body| [body.bottom, body.top]).collect()
            }
        }
    }
}

impl Columns {
    /// Bodies met by vertical lines; where snow is so light that lines pass much of it without a grain,
    /// those that several lines beside each other find together.
    pub(super) fn new(field: &GrainField, vertical: &Lines) -> Self {
        let largest = f64::from(field.largest_radius_quanta()) * field.quantisation.quantum();
        let gap = vertical.median_gap();
        let widest_gap = (GAP_MEDIANS * gap).max(LEAST_GAP_RADII * largest);
        let bounds = field.bounds();
        let edge = vertical.edge();
        let size = bounds.size() / edge;
        let counts = [size.x.ceil() as usize + 1, size.z.ceil() as usize + 1];
        let mut bodies = vec![Vec::new(); counts[0] * counts[1]];
        for (line, chords) in vertical.each() {
            let [column, row] = vertical.square(line).map(|at| at as usize);
            let body = &mut bodies[row * counts[0] + column];
            let (mut bottom, mut top) = (chords[0].low, chords[0].high);
            for chord in chords {
                if chord.low - top > widest_gap {
                    body.push(Body { bottom, top });
                    (bottom, top) = (chord.low, chord.high);
                }
                top = top.max(chord.high);
            }
            body.push(Body { bottom, top });
        }
        let mut columns = Self { corner: bounds.min, edge, counts, bodies };
        let met = vertical.each().count().max(1) as f64;
        let chords_a_line = vertical.chords.len() as f64 / met;
        if gap > 2.0 * largest && chords_a_line < FEW_CHORDS {
            columns.merge((CHORDS_OF_PATCH / chords_a_line).sqrt().ceil() as usize);
        }
        let deep = |body: &Body| {
            let depth = body.top - body.bottom;
            depth >= LEAST_DEPTH_RADII * largest && depth.is_finite()
        };
        columns.bodies.iter_mut().for_each(|bodies| bodies.retain(deep));
        columns
    }

    /// Gives all lines of each patch of so many lines a side the same bodies. Patches at the edge
    /// of the snow, part of which is beside it, are left out where there are others.
    fn merge(&mut self, lines: usize) {
        let patches = self.counts.map(|count| count.div_ceil(lines));
        let squares = |patch: usize| {
            let from = [patch % patches[0] * lines, patch / patches[0] * lines];
            let to = [0, 1].map(|axis| (from[axis] + lines).min(self.counts[axis]));
            let counts = self.counts;
            (from[1]..to[1])
                .flat_map(move |row| (from[0]..to[0]).map(move |at| row * counts[0] + at))
        };
        let all = patches[0] * patches[1];
        let merged: Vec<Vec<Body>> =
            (0..all).map(|patch| self.merged(&squares(patch).collect::<Vec<_>>())).collect();
        let is_inner = |patch: usize| {
            let [x, z] = [patch % patches[0], patch / patches[0]];
            let apart = x > 0 && z > 0 && x + 1 < patches[0] && z + 1 < patches[1];
            apart
                && [patch - 1, patch + 1, patch - patches[0], patch + patches[0]]
                    .iter()
                    .all(|&other| !merged[other].is_empty())
        };
        let has_inner = (0..all).any(|patch| is_inner(patch) && !merged[patch].is_empty());
        let mut bodies = vec![Vec::new(); self.bodies.len()];
        for patch in (0..all).filter(|&patch| is_inner(patch) || !has_inner) {
            squares(patch).for_each(|square| bodies[square].clone_from(&merged[patch]));
        }
        self.bodies = bodies;
    }

    /// Each body that many of these lines meet.
    fn merged(&self, squares: &[usize]) -> Vec<Body> {
        let mut all: Vec<Body> =
            squares.iter().flat_map(|&square| self.bodies[square].iter().copied()).collect();
        all.sort_by(|a, b| a.bottom.total_cmp(&b.bottom));
        let mut merged = Vec::new();
        let mut from = 0;
        while from < all.len() {
            let mut top = all[from].top;
            let apart = |body: &Body| {
                let is_apart = body.bottom > top;
                top = top.max(body.top);
                is_apart
            };
            let until = all[from..].iter().position(apart).map_or(all.len(), |at| from + at);
            let met = &all[from..until];
            let lines = squares.len() as f64;
            if met.len() as f64 >= LEAST_MET * lines {
                // As of snow that repeats: from its lowest point to the mean height at which lines from
                // above meet it, or, where they do not, its lowest point.
                let bottom = all[from].bottom;
                let above = met.iter().map(|body| body.top - bottom).sum::<f64>();
                merged.push(Body { bottom, top: bottom + above / lines });
            }
            from = until;
        }
        merged
    }

    /// The inside of each body, with the number of the line of its square.
    pub(super) fn inside<'a>(
        &'a self,
        vertical: &'a Lines,
    ) -> impl Iterator<Item = (u32, [f64; 2])> + 'a {
        self.bodies.iter().enumerate().flat_map(move |(square, bodies)| {
            let at = [square % self.counts[0], square / self.counts[0]];
            let line = vertical.line(at.map(|at| at as u32));
            bodies.iter().map(move |body| (line, body.inside()))
        })
    }

    /// The bodies over a point's square of the plan.
    pub(super) fn at(&self, point: DVec3) -> &[Body] {
        let [x, z] = [point.x - self.corner.x, point.z - self.corner.z].map(|at| at / self.edge);
        let within = |at: f64, count: usize| at >= 0.0 && at < count as f64;
        if !(within(x, self.counts[0]) && within(z, self.counts[1])) {
            return &[];
        }
        &self.bodies[z as usize * self.counts[0] + x as usize]
    }

    /// The stretches of a level line along `axis` that lie in the middle of some body.
    fn along(&self, axis: usize, place: DVec3, [low, high]: [f64; 2]) -> Vec<[f64; 2]> {
        let corner = self.corner[axis];
        let count = self.counts[axis / 2];
        let mut stretches: Vec<[f64; 2]> = Vec::new();
        for square in 0..count {
            let from = corner + square as f64 * self.edge;
            let to = from + self.edge;
            let mut middle = place;
            middle[axis] = from + 0.5 * self.edge;
            let inside = |body: &Body| {
                let [low, high] = body.inside();
                (low..high).contains(&place.y)
            };
            if to < low || from > high || !self.at(middle).iter().any(inside) {
                continue;
            }
            match stretches.last_mut() {
                Some(last) if last[1] >= from - 1e-6 * self.edge => last[1] = to,
                _ => stretches.push([from, to]),
            }
        }
        stretches
    }
}
