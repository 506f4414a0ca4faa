//! Whether two grains of any shape are apart, by a plane between them, and which faces of one the other may reach.
//!
//! Planes along the faces of either and across the line of their centres are tried; of two bodies that only a plane
//! along two edges parts it is not told. So what is told to be apart is, and what is not may be.

use super::{Placement, Reach, ReachedFaces, Slabs};
use snowgrain_geometry::shape::{ConvexBody, Face};
use snowgrain_geometry::{GrainShape, Shape};
use snowgrain_math::{DMat3, DVec3};

/// Quanta by which grains must be apart: more than rounding takes, and less than shows.
const GAP: f64 = 1e-3;

/// How far corners may be from the plane of their face by rounding, radii.
const ON_FACE: f64 = 1e-7;

/// The convex hull of a prototype, as far as it is asked.
#[derive(Clone, Debug)]
pub(super) struct Hull {
    /// Outward unit normals of faces, and how far it reaches along each.
    normals: Vec<(DVec3, f64)>,
    parts: Vec<Part>,
    /// Of a body between parallel faces.
    faces: Vec<FlatFace>,
    size: Reach,
    /// Whether it is the ball of radius 1.
    is_ball: bool,
}

#[derive(Clone, Debug)]
struct Part {
    /// Of a body with faces.
    corners: Corners,
    /// Centre of the ellipsoid, and what makes it of the unit sphere, transposed.
    ellipsoid: Option<(DVec3, DMat3)>,
}

/// A face of a prototype.
#[derive(Clone, Debug)]
struct FlatFace {
    /// Its number, as in [`Slabs`].
    number: f64,
    normal: DVec3,
    distance: f64,
    corners: Corners,
}

/// Corners by four, x, y and z of each; the last ones more than once.
#[derive(Clone, Debug)]
struct Corners(Vec<[[f64; 4]; 3]>);

impl Corners {
    fn new(corners: &[DVec3]) -> Self {
        let four = |some: &[DVec3]| {
            [0, 1, 2].map(|axis| std::array::from_fn(|i| some[i.min(some.len() - 1)][axis]))
        };
        Self(corners.chunks(4).map(four).collect())
    }

    /// How far they reach along a vector; `None` if there are none.
    #[inline(always)]
    fn reach(&self, along: DVec3) -> Option<f64> {
        let greater = |a: f64, b: f64| if a > b { a } else { b };
        let mut most = [f64::NEG_INFINITY; 4];
        for [x, y, z] in &self.0 {
            for i in 0..4 {
                most[i] = greater(most[i], x[i] * along.x + y[i] * along.y + z[i] * along.z);
            }
        }
        let [a, b, c, d] = most;
        (!self.0.is_empty()).then(|| greater(greater(a, c), greater(b, d)))
    }
}

/// A grain where it lies.
#[derive(Clone, Copy)]
pub(super) struct Placed<'a> {
    pub(super) hull: &'a Hull,
    pub(super) placement: Placement,
}

impl Hull {
    pub(super) fn new(shape: &Shape) -> Self {
        let mut hull = Self {
            normals: Vec::new(),
            parts: shape.parts().iter().map(Part::new).collect(),
            faces: match shape.parts() {
                [body] => FlatFace::all(body),
                _ => Vec::new(),
            },
            size: Reach::of(shape),
            is_ball: match shape.parts() {
                [ConvexBody { faces, ellipsoid: Some(e) }] => {
                    faces.is_empty() && e.center == DVec3::ZERO && e.to_unit == DMat3::IDENTITY
                }
                _ => false,
            },
        };
        let faces = shape.parts().iter().flat_map(|part| &part.faces);
        hull.normals = faces.map(|face| (face.normal, hull.reach(face.normal))).collect();
        hull
    }

    /// A grain of this shape, in a sphere of this radius.
    pub(super) fn placed(&self, shape: GrainShape, bounding: u16) -> Placed<'_> {
        Placed { hull: self, placement: Placement::new(shape, self.size.radius(bounding)) }
    }

    /// How far it reaches along a unit vector, or somewhat more.
    fn reach(&self, along: DVec3) -> f64 {
        self.parts.iter().map(|part| part.reach(along)).fold(f64::NEG_INFINITY, f64::max)
    }
}

impl FlatFace {
    fn all(body: &ConvexBody) -> Vec<Self> {
        let Some(slabs) = Slabs::of(body) else { return Vec::new() };
        let corners = body.corners();
        let of = |(number, plane): (f64, usize)| {
            let Face { normal, distance } = body.faces[plane];
            let is_on = |corner: &DVec3| (corner.dot(normal) - distance).abs() < ON_FACE;
            let corners: Vec<DVec3> = corners.iter().copied().filter(is_on).collect();
            Self { number, normal, distance, corners: Corners::new(&corners) }
        };
        slabs.numbered().map(of).collect()
    }

    /// How far it reaches along a vector; without end, where its corners are not known.
    fn reach(&self, along: DVec3) -> f64 {
        self.corners.reach(along).unwrap_or(f64::INFINITY)
    }
}

impl Part {
    fn new(body: &ConvexBody) -> Self {
        let ellipsoid =
            |e: &snowgrain_geometry::shape::Ellipsoid| (e.center, e.to_unit.inverse().transpose());
        Self {
            corners: Corners::new(&body.corners()),
            ellipsoid: body.ellipsoid.as_ref().map(ellipsoid),
        }
    }

    fn reach(&self, along: DVec3) -> f64 {
        let round = self
            .ellipsoid
            .as_ref()
            .map(|(center, from_unit)| center.dot(along) + (*from_unit * along).length());
        match (self.corners.reach(along), round) {
            (Some(sharp), Some(round)) => sharp.min(round),
            (Some(reach), None) | (None, Some(reach)) => reach,
            (None, None) => f64::INFINITY,
        }
    }
}

impl Placed<'_> {
    pub(super) fn is_ball(&self) -> bool {
        self.hull.is_ball
    }

    /// Whether a plane is known between this grain and the other, whose centre lies `between` (quanta) from its own.
    pub(super) fn is_apart_from(&self, other: &Self, between: DVec3) -> bool {
        let Some(along) = between.try_normalize() else { return false };
        let mut own = self.normals();
        along.dot(between) - self.reach(along) - other.reach(-along) > GAP
            || own.any(|(along, reach)| along.dot(between) - reach - other.reach(-along) > GAP)
            || other
                .normals()
                .any(|(along, reach)| -along.dot(between) - reach - self.reach(-along) > GAP)
    }

    /// The faces that the other grain, whose centre lies `between` (quanta) from its own, may reach.
    pub(super) fn faces_reached_by(&self, other: &Self, between: DVec3) -> ReachedFaces {
        if self.hull.faces.is_empty() {
            return ReachedFaces::ALL;
        }
        let radius = self.placement.radius;
        let is_reached = |face: &&FlatFace| {
            let outward = self.placement.rotation * face.normal;
            let beyond = outward.dot(between) + other.reach(outward) - face.distance * radius;
            beyond > -GAP
                && !other.normals().any(|(along, reach)| {
                    let back = face.reach(self.placement.turned_back(-along)) * radius;
                    -along.dot(between) - reach - back > GAP
                })
        };
        let reached = self.hull.faces.iter().filter(is_reached);
        reached.fold(ReachedFaces::NOT_FLAT, |all, face| all.with(ReachedFaces::only(face.number)))
    }

    /// Normals of faces in the world, and how far the grain reaches along each, quanta.
    fn normals(&self) -> impl Iterator<Item = (DVec3, f64)> {
        let Placement { rotation, radius, .. } = self.placement;
        self.hull.normals.iter().map(move |&(normal, reach)| (rotation * normal, reach * radius))
    }

    /// How far it reaches from its centre along a unit vector, quanta.
    fn reach(&self, along: DVec3) -> f64 {
        self.hull.reach(self.placement.turned_back(along)) * self.placement.radius
    }
}

#[cfg(test)]
mod tests {
    use super::super::Prototype;
    use super::*;
    use snowgrain_geometry::ShapeKind;
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
                Placed { hull: &hull, placement: Placement::new(turned, 1000.0) }
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
