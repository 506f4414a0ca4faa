//! Bodies that pairs of parallel faces bound: prisms, plates, columns, cubes, spheroids, rounded or not.
//!
//! All of these have their faces along five axes, so a kernel follows many of them at once, each with numbers of its
//! own and the same steps.

use snowgrain_geometry::shape::{ConvexBody, Face};
use snowgrain_math::DVec3;

/// Axes along which faces may lie: y, the three of the hexagon across it, x.
pub(crate) const AXES: usize = 5;

/// Cosine of 30 degrees, sqrt(3)/2.
pub(crate) const COS_30: f64 = 0.866_025_403_784_438_6;

const NORMALS: [DVec3; AXES] =
    [DVec3::Y, DVec3::new(COS_30, 0.0, 0.5), DVec3::Z, DVec3::new(-COS_30, 0.0, 0.5), DVec3::X];

/// How far two unit normals of one face may differ in each number, by rounding.
const SAME: f64 = 4e-16;

/// The number of the ellipsoid, where faces are `axis + 1`, and negative on the lower side.
pub(crate) const ROUND: f64 = 6.0;

/// The numbers of such a body, in radii.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Slabs {
    /// From the centre to the faces along each axis; infinite where there are none.
    pub(crate) half: [f64; AXES],
    /// What makes a sphere of radius 1 of the ellipsoid: across the c axis and along it; 0 where there is none.
    pub(crate) shrink: [f64; 2],
    /// Which plane of the body the upper and the lower face along each axis is.
    faces: [[u16; 2]; AXES],
}

impl Slabs {
    /// The numbers of a body; `None` where it is none of this kind.
    pub(crate) fn of(body: &ConvexBody) -> Option<Self> {
        let mut slabs =
            Self { half: [f64::INFINITY; AXES], shrink: [0.0; 2], faces: [[0; 2]; AXES] };
        let mut known = [[false; 2]; AXES];
        for (index, &Face { normal, distance }) in body.faces.iter().enumerate() {
            let is_along = |&(axis, side): &(usize, usize)| {
                let outward = if side == 0 { NORMALS[axis] } else { -NORMALS[axis] };
                (outward - normal).abs().max_element() <= SAME
            };
            let all = (0..AXES).flat_map(|axis| [(axis, 0), (axis, 1)]);
            let (axis, side) = all.into_iter().find(is_along)?;
            if known[axis][side] || known[axis][1 - side] && slabs.half[axis] != distance {
                return None;
            }
            known[axis][side] = true;
            slabs.half[axis] = distance;
            slabs.faces[axis][side] = index as u16;
        }
        if known.iter().any(|[upper, lower]| upper != lower) {
            return None;
        }
        if let Some(ellipsoid) = &body.ellipsoid {
            let [x, y, z] = [0, 1, 2].map(|axis| ellipsoid.to_unit.col(axis)[axis]);
            let is_diagonal =
                ellipsoid.to_unit == snowgrain_math::DMat3::from_diagonal(DVec3::new(x, y, z));
            if !is_diagonal || x != z || ellipsoid.center != DVec3::ZERO {
                return None;
            }
            slabs.shrink = [x, y];
        }
        Some(slabs)
    }

    /// The numbers of the faces, and the plane of each.
    pub(crate) fn numbered(&self) -> impl Iterator<Item = (f64, usize)> {
        let exists = |&axis: &usize| self.half[axis] < f64::INFINITY;
        (0..AXES).filter(exists).flat_map(|axis| {
            let number = (axis + 1) as f64;
            let [upper, lower] = self.faces[axis].map(usize::from);
            [(number, upper), (-number, lower)]
        })
    }

    /// The plane of a face by its number.
    pub(crate) fn face(&self, number: f64) -> u16 {
        let axis = (number.abs() as usize).saturating_sub(1).min(AXES - 1);
        self.faces[axis][usize::from(number < 0.0)]
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use snowgrain_geometry::{Shape, ShapeKind};

    #[test]
    fn prisms_cubes_and_spheroids_are_between_parallel_faces_and_others_are_not() {
        let of = |kind| Slabs::of(&Shape::new(kind).expect("the shape is legal").parts()[0]);
        for aspect in [0.05, 0.2, 1.0, 2.5] {
            for rounding in [0.0, 0.3, 1.0] {
                assert!(of(ShapeKind::HexagonalPrism { aspect, rounding }).is_some());
                assert!(of(ShapeKind::Cube { rounding }).is_some());
            }
            assert!(of(ShapeKind::Spheroid { aspect }).is_some());
        }
        assert_eq!(of(ShapeKind::TruncatedOctahedron { rounding: 0.0 }), None);
        assert_eq!(of(ShapeKind::RandomPolyhedron { faces: 8, seed: 1, rounding: 0.0 }), None);
        let leaning = "polyhedron 6e-1 8e-1 0e0 1e0 -6e-1 -8e-1 0e0 1e0 0e0 0e0 1e0 1e0 0e0 0e0 -1e0 1e0 \
                       8e-1 -6e-1 0e0 1e0 -8e-1 6e-1 0e0 1e0";
        assert_eq!(Slabs::of(&Shape::of_name(leaning).expect("a cube").parts()[0]), None);
    }
}
