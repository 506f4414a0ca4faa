//! The surface of snow as that of its smoothed density: where it has half of what the snow has within.

use super::density::Density;
use snowgrain_math::{DVec3, Ray};

/// Part of the snow's own density at which its surface is put.
pub(super) const SURFACE_LEVEL: f64 = 0.5;

/// Tetrahedra into which a cell is cut, around its diagonal: corners by the bits of their numbers (x lowest).
const TETRAHEDRA: [[usize; 4]; 6] =
    [[0, 1, 3, 7], [0, 3, 2, 7], [0, 2, 6, 7], [0, 6, 4, 7], [0, 4, 5, 7], [0, 5, 1, 7]];
/// Halvings by which a place on the surface is found between two steps of half a cell.
const HALVINGS: u32 = 10;

/// A piece of the surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Piece {
    /// Centre of its area, metres.
    pub(super) position: DVec3,
    /// Outward unit normal.
    pub(super) normal: DVec3,
    /// Square metres.
    pub(super) area: f64,
}

impl Density {
    /// Where a ray comes to a density of `level` discs' area by volume, before `far`, metres; at once where it begins in
    /// it.
    pub(super) fn surface_on(&self, ray: &Ray, far: f64, level: f64) -> Option<f64> {
        let (start, end) = self.bounds.intersect(ray)?;
        let end = end.min(far);
        let step = 0.5 * self.shortest_edge();
        let is_within = |t: f64| self.at(ray.at(t)).area >= level;
        let (mut before, mut t) = (start, start);
        while t < end {
            if is_within(t) {
                let (mut low, mut high) = (before, t);
                for _ in 0..HALVINGS {
                    let middle = 0.5 * (low + high);
                    if is_within(middle) { high = middle } else { low = middle }
                }
                return Some(high);
            }
            before = t;
            t += step;
        }
        None
    }

    /// The surface, one piece for each cell that it crosses (marching tetrahedra: Doi and Koide 1991).
    pub(super) fn surface(&self, level: f64) -> Vec<Piece> {
        self.cells().filter_map(|corners| self.piece(corners, level)).collect()
    }

    fn piece(&self, corners: [(DVec3, f64); 8], level: f64) -> Option<Piece> {
        let within = corners.iter().filter(|(_, area)| *area >= level).count();
        if within == 0 || within == 8 {
            return None;
        }
        let (mut area, mut moment) = (0.0, DVec3::ZERO);
        for tetrahedron in TETRAHEDRA {
            let points = cut(tetrahedron.map(|corner| corners[corner]), level);
            for index in 2..points.len() {
                let [a, b, c] = [points[0], points[index - 1], points[index]];
                let part = 0.5 * (b - a).cross(c - a).length();
                area += part;
                moment += (a + b + c) * (part / 3.0);
            }
        }
        if area <= 0.0 {
            return None;
        }
        let position = moment / area;
        let normal = self.outwards(position).try_normalize()?;
        Some(Piece { position, normal, area })
    }
}

/// The polygon in which a surface cuts a tetrahedron, its corners in turn.
fn cut(corners: [(DVec3, f64); 4], level: f64) -> Vec<DVec3> {
    let (within, without): (Vec<_>, Vec<_>) =
        corners.into_iter().partition(|&(_, area)| area >= level);
    let between =
        |a: (DVec3, f64), b: (DVec3, f64)| a.0 + (b.0 - a.0) * ((level - a.1) / (b.1 - a.1));
    match (within.as_slice(), without.as_slice()) {
        ([one], others) | (others, [one]) => others.iter().map(|&o| between(*one, o)).collect(),
        ([a, b], [c, d]) => {
            vec![between(*a, *c), between(*a, *d), between(*b, *d), between(*b, *c)]
        }
        _ => Vec::new(),
    }
}
