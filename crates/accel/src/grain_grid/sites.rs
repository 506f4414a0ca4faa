//! Perfect lattices of grains that do not overlap: no memory at all.
//!
//! Space is divided into the Voronoi cells of the lattice's sites, one grain in the middle of each.
//! Light that leaves a grain crosses the faces of its cell and of the next ones until it meets the
//! grain of the cell that it is in; positions are relative to that cell's site.

use super::build::overlaps;
use super::{GridPosition, LatticeCell};
use snowgrain_math::{Aabb, DVec3};

/// The lattices whose sites are all alike.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum SiteKind {
    /// One site a conventional cell.
    SimpleCubic,
    /// Two.
    BodyCentred,
    /// Four.
    FaceCentred,
}

/// A block of crystal. Sites have whole coordinates in half edges of the conventional cell, 0 for
/// the lowest ones.
#[derive(Clone, Debug)]
pub(crate) struct LatticeSites {
    pub(crate) kind: SiteKind,
    /// Half the edge of the conventional cell, quanta.
    pub(crate) half_edge: f32,
    /// Radius of every grain, quanta.
    pub(crate) radius: f32,
    /// Middle of the crystal, in site coordinates.
    pub(crate) middle: [f32; 3],
    /// From there to the outermost sites; infinite along axes that repeat.
    pub(crate) reach: [f32; 3],
    /// Conventional cells along each axis.
    counts: [u32; 3],
    periodic: [bool; 3],
    /// Lattice coordinates of the site (0, 0, 0), quanta.
    origin: [i64; 3],
}

impl LatticeSites {
    /// The crystal of `counts` conventional cells from `first`, where it has this form.
    pub(crate) fn new(
        cell: &LatticeCell,
        counts: [u32; 3],
        first: [i32; 3],
        periodic: [bool; 3],
    ) -> Option<Self> {
        let kind = kind_of(cell)?;
        // The farthest site lies half a cell from the corner of the next cell, but for the simple
        // cubic lattice, which has a site at each corner only.
        let last = if kind == SiteKind::SimpleCubic { 2.0 } else { 1.0 };
        let span: [f32; 3] = counts.map(|count| 2.0 * count as f32 - last);
        Some(Self {
            kind,
            half_edge: cell.side_quanta[0] as f32 * 0.5,
            radius: f32::from(cell.radius_quanta),
            middle: span.map(|span| 0.5 * span),
            reach: std::array::from_fn(|axis| {
                if periodic[axis] { f32::INFINITY } else { 0.5 * span[axis] }
            }),
            counts,
            periodic,
            origin: std::array::from_fn(|axis| i64::from(first[axis] + cell.basis[0][axis])),
        })
    }

    /// The box of all Voronoi cells that hold a grain, quanta; infinite along axes that repeat.
    pub(super) fn bounds(&self) -> Aabb {
        let side = |sign: f32| {
            DVec3::from_array(std::array::from_fn(|axis| {
                let sites = self.middle[axis] + sign * (self.reach[axis] + 1.0);
                self.origin[axis] as f64 + f64::from(sites) * f64::from(self.half_edge)
            }))
        };
        Aabb::new(side(-1.0), side(1.0))
    }

    /// The nearest site to a point in quanta, and the place relative to it.
    pub(super) fn locate(&self, quanta: DVec3) -> GridPosition {
        let half_edge = f64::from(self.half_edge);
        let origin = DVec3::from_array(self.origin.map(|c| c as f64));
        let point = (quanta - origin) / half_edge;
        // Never a site beyond the box: a point on its face is as near to one there.
        let (middle, reach) = (self.middle.map(f64::from), self.reach.map(f64::from));
        let (low, high) = (
            DVec3::from_array(middle) - DVec3::from_array(reach) - 1.0,
            DVec3::from_array(middle) + DVec3::from_array(reach) + 1.0,
        );
        let nearest = |offset: DVec3| {
            let site = ((point - offset) * 0.5).round() * 2.0 + offset;
            let site = DVec3::select(site.cmplt(low), site + 2.0, site);
            DVec3::select(site.cmpgt(high), site - 2.0, site)
        };
        let sites = self.kind.offsets().iter().map(|&offset| nearest(DVec3::from_array(offset)));
        let distance = |site: &DVec3| (*site - point).length_squared();
        let site = sites
            .min_by(|a, b| distance(a).total_cmp(&distance(b)))
            .expect("every lattice has a site");
        let local = (point - site) * half_edge;
        let cell = site.to_array().map(|c| c as i32);
        GridPosition { cell: self.wrapped(cell), local: local.to_array().map(|c| c as f32) }
    }

    /// A place in quanta, in the first period where the crystal repeats.
    pub(super) fn world(&self, place: GridPosition) -> DVec3 {
        let cell = self.wrapped(place.cell);
        DVec3::from_array(std::array::from_fn(|axis| {
            self.origin[axis] as f64
                + f64::from(cell[axis]) * f64::from(self.half_edge)
                + f64::from(place.local[axis])
        }))
    }

    /// From a site in the first period to this one, quanta.
    pub(crate) fn beyond_first_period(&self, site: [i32; 3]) -> DVec3 {
        let first = self.wrapped(site);
        DVec3::from_array(std::array::from_fn(|axis| {
            f64::from(site[axis] - first[axis]) * f64::from(self.half_edge)
        }))
    }

    /// Whether a point in quanta lies inside a grain.
    pub(super) fn is_inside_grain(&self, quanta: DVec3) -> bool {
        let place = self.locate(quanta);
        let local = DVec3::from_array(place.local.map(f64::from));
        self.is_occupied(place.cell) && local.length() < f64::from(self.radius)
    }

    /// Whether a site lies within the crystal.
    fn is_occupied(&self, site: [i32; 3]) -> bool {
        (0..3).all(|axis| (site[axis] as f32 - self.middle[axis]).abs() <= self.reach[axis])
    }

    fn wrapped(&self, site: [i32; 3]) -> [i32; 3] {
        std::array::from_fn(|axis| {
            let period = 2 * self.counts[axis].cast_signed();
            if self.periodic[axis] { site[axis].rem_euclid(period) } else { site[axis] }
        })
    }
}

impl SiteKind {
    /// The sites of a conventional cell, in half edges.
    fn offsets(self) -> &'static [[f64; 3]] {
        match self {
            Self::SimpleCubic => &[[0.0; 3]],
            Self::BodyCentred => &[[0.0; 3], [1.0; 3]],
            Self::FaceCentred => &[[0.0; 3], [1.0, 1.0, 0.0], [1.0, 0.0, 1.0], [0.0, 1.0, 1.0]],
        }
    }
}

/// The kind of a cubic cell whose grains do not overlap.
fn kind_of(cell: &LatticeCell) -> Option<SiteKind> {
    let [side, ..] = cell.side_quanta;
    if cell.side_quanta != [side; 3] {
        return None;
    }
    let kinds = [SiteKind::SimpleCubic, SiteKind::BodyCentred, SiteKind::FaceCentred];
    let kind = kinds.into_iter().find(|kind| {
        let offsets = kind.offsets();
        offsets.len() == cell.basis.len()
            && offsets.iter().all(|offset| {
                let center: [f64; 3] = std::array::from_fn(|axis| {
                    f64::from(cell.basis[0][axis]) + offset[axis] * 0.5 * f64::from(side)
                });
                cell.basis.iter().any(|basis| basis.map(f64::from) == center)
            })
    })?;
    let [a, b] = match kind {
        SiteKind::SimpleCubic => [[0; 3], [side, 0, 0]],
        SiteKind::BodyCentred | SiteKind::FaceCentred => [cell.basis[0], cell.basis[1]],
    };
    let radius = cell.radius_quanta;
    (!overlaps(a, radius, b, radius)).then_some(kind)
}
