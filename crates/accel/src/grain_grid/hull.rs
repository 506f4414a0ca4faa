//! Whether two grains of any shape are apart, by a plane between them.
//!
//! Planes along the faces of either and across the line of their centres are tried; of two bodies that only a plane
//! along two edges parts it is not told. So what is told to be apart is, and what is not may be.

use super::Placement;
use snowgrain_geometry::Shape;
use snowgrain_geometry::shape::ConvexBody;
use snowgrain_math::{DMat3, DVec3};

/// Quanta by which grains must be apart: more than rounding takes, and less than shows.
const GAP: f64 = 1e-3;

/// The convex hull of a prototype, as far as it is asked.
#[derive(Clone, Debug)]
pub(super) struct Hull {
    /// Outward unit normals of faces.
    normals: Vec<DVec3>,
    parts: Vec<Part>,
    /// Whether it is the ball of radius 1.
    is_ball: bool,
}

#[derive(Clone, Debug)]
struct Part {
    /// Of a body with faces.
    corners: Vec<DVec3>,
    /// Centre of the ellipsoid, and what makes it of the unit sphere, transposed.
    ellipsoid: Option<(DVec3, DMat3)>,
}

/// A grain where it lies.
#[derive(Clone, Copy)]
pub(super) struct Placed<'a> {
    pub(super) hull: &'a Hull,
    pub(super) placement: Placement,
}

impl Hull {
    pub(super) fn new(shape: &Shape) -> Self {
        let faces = shape.parts().iter().flat_map(|part| &part.faces);
        Self {
            normals: faces.map(|face| face.normal).collect(),
            parts: shape.parts().iter().map(Part::new).collect(),
            is_ball: match shape.parts() {
                [ConvexBody { faces, ellipsoid: Some(e) }] => {
                    faces.is_empty() && e.center == DVec3::ZERO && e.to_unit == DMat3::IDENTITY
                }
                _ => false,
            },
        }
    }

    pub(super) fn is_ball(&self) -> bool {
        self.is_ball
    }

    /// How far it reaches along a unit vector, or somewhat more.
    fn reach(&self, along: DVec3) -> f64 {
        self.parts.iter().map(|part| part.reach(along)).fold(f64::NEG_INFINITY, f64::max)
    }
}

impl Part {
    fn new(body: &ConvexBody) -> Self {
        let ellipsoid =
            |e: &snowgrain_geometry::shape::Ellipsoid| (e.center, e.to_unit.inverse().transpose());
        Self { corners: body.corners(), ellipsoid: body.ellipsoid.as_ref().map(ellipsoid) }
    }

    fn reach(&self, along: DVec3) -> f64 {
        let round = self.ellipsoid.as_ref().map_or(f64::INFINITY, |(center, from_unit)| {
            center.dot(along) + (*from_unit * along).length()
        });
        let corners = self.corners.iter().map(|corner| corner.dot(along));
        match corners.fold(f64::NEG_INFINITY, f64::max) {
            f64::NEG_INFINITY => round,
            sharp => sharp.min(round),
        }
    }
}

impl Placed<'_> {
    /// Whether a plane is known between this grain and the other, whose centre lies `between` (quanta) from its own.
    pub(super) fn is_apart_from(&self, other: &Self, between: DVec3) -> bool {
        let is_between =
            |along: DVec3| along.dot(between) - self.reach(along) - other.reach(-along) > GAP;
        let Some(along) = between.try_normalize() else { return false };
        let own = self.hull.normals.iter().map(|&normal| self.placement.rotation * normal);
        let others = other.hull.normals.iter().map(|&normal| -(other.placement.rotation * normal));
        is_between(along)
            || own.chain(others).any(|along| along.dot(between) > 0.0 && is_between(along))
    }

    /// How far it reaches from its centre along a unit vector, quanta.
    fn reach(&self, along: DVec3) -> f64 {
        self.hull.reach(self.placement.turned_back(along)) * self.placement.radius
    }
}

#[cfg(test)]
mod tests {
    use super::super::{Prototype, ShapeWord};
    use super::*;
    use snowgrain_geometry::{GrainShape, ShapeKind};
    use snowgrain_math::sampler::{PathKey, numbers};

    fn vector(index: u64, event: u32) -> DVec3 {
        DVec3::from_array(numbers(PathKey::new(8, index, 0), event).map(f64::from)) - 0.5
    }

    /// Of grains that are told to be apart no point of one lies in the other; most that share no point are told.
    #[test]
    fn grains_that_are_apart_share_no_point() {
        for kind in [
            ShapeKind::HexagonalPrism { aspect: 0.2, rounding: 0.0 },
            ShapeKind::HexagonalPrism { aspect: 2.0, rounding: 0.4 },
            ShapeKind::Spheroid { aspect: 0.5 },
            ShapeKind::RandomPolyhedron { faces: 12, seed: 3, rounding: 0.0 },
            ShapeKind::Rosette { arms: 3, aspect: 1.5, rounding: 0.0 },
        ] {
            let shape = Shape::new(kind).expect("the shape is legal");
            let (hull, prototype) = (Hull::new(&shape), Prototype::new(&shape));
            let placed = |index: u64, event: u32| {
                let [q, w] = [vector(index, event), vector(index, event + 1)];
                let turned = GrainShape::new(0, [q.x, q.y, q.z, w.x]);
                let word = ShapeWord::of_slot(turned.to_bits() | 1000 << GrainShape::BITS);
                Placed { hull: &hull, placement: Placement::of(word) }
            };
            let (mut apart, mut free) = (0u32, 0u32);
            for index in 0..150 {
                let (a, b) = (placed(index, 0), placed(index, 2));
                let between = vector(index, 4).normalize() * (600.0 + 16.0 * index as f64);
                let shared = (0..2000u64).filter(|&i| {
                    let point = vector(i, 5) * (2.0 * shape.bounding_radius());
                    let from_b = a.placement.rotation * point * 1000.0 - between;
                    prototype.contains(point)
                        && prototype.contains(b.placement.to_prototype(from_b))
                });
                let shares = shared.count() > 0;
                let is_apart = a.is_apart_from(&b, between);
                assert_eq!(is_apart, b.is_apart_from(&a, -between), "{kind:?} {index}");
                assert!(!(shares && is_apart), "{kind:?} {index}");
                apart += u32::from(is_apart);
                free += u32::from(!shares);
            }
            // A rosette reaches less far than its hull, of which alone the planes tell.
            let told = if shape.parts().len() == 1 { 6 } else { 2 };
            assert!(10 * apart > told * free, "{kind:?} {apart} of {free}");
        }
    }
}
