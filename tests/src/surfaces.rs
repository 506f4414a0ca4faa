//! Diffuse surfaces of the oracle: every piece is tested every time.

use snowgrain_geometry::TriangleMesh;
use snowgrain_math::{Aabb, DVec3, Ray};

/// A diffuse object.
#[derive(Clone, Debug)]
pub struct OracleSurface {
    /// Its shape.
    pub shape: OracleShape,
    /// Diffuse albedo, linear RGB.
    pub albedo: DVec3,
}

/// The closed set of shapes, in world space; light meets both sides.
#[derive(Clone, Debug)]
pub enum OracleShape {
    /// Triangles, by their corners.
    Triangles(Vec<[DVec3; 3]>),
    /// A sphere.
    Sphere {
        /// Centre.
        center: DVec3,
        /// Radius.
        radius: f64,
    },
    /// An infinite plane.
    Plane {
        /// A point of it.
        point: DVec3,
        /// Its unit normal.
        normal: DVec3,
    },
}

/// One smooth piece of one object.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct Piece {
    pub(crate) object: usize,
    pub(crate) piece: usize,
}

/// Where a ray meets a surface.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Hit {
    pub(crate) t: f64,
    /// Unit normal on the side from which the ray came.
    pub(crate) normal: DVec3,
    pub(crate) piece: Piece,
}

/// All surfaces of a scene.
pub(crate) struct SurfaceSearch {
    surfaces: Vec<OracleSurface>,
    bounds: Vec<Aabb>,
}

impl SurfaceSearch {
    pub(crate) fn new(surfaces: &[OracleSurface]) -> Self {
        let bounds = surfaces.iter().map(|surface| bounds(&surface.shape)).collect();
        Self { surfaces: surfaces.to_vec(), bounds }
    }

    pub(crate) fn albedo(&self, piece: Piece) -> DVec3 {
        self.surfaces[piece.object].albedo
    }

    /// The nearest piece at a distance of at most `limit`, other than the one that the ray leaves.
    pub(crate) fn nearest(
        &self,
        origin: DVec3,
        direction: DVec3,
        limit: f64,
        leaving: Option<Piece>,
    ) -> Option<Hit> {
        let mut best: Option<Hit> = None;
        for (object, surface) in self.surfaces.iter().enumerate() {
            if self.bounds[object].intersect(&Ray::new(origin, direction)).is_none() {
                continue;
            }
            for piece in 0..surface.shape.pieces() {
                let piece = Piece { object, piece };
                let left = leaving == Some(piece);
                let Some((t, normal)) = surface.shape.hit(piece.piece, origin, direction, left)
                else {
                    continue;
                };
                if t <= best.map_or(limit, |hit| hit.t) {
                    let normal = if normal.dot(direction) > 0.0 { -normal } else { normal };
                    best = Some(Hit { t, normal, piece });
                }
            }
        }
        best
    }
}

/// A box with room for rounding around a shape.
fn bounds(shape: &OracleShape) -> Aabb {
    let tight = match shape {
        OracleShape::Triangles(triangles) => {
            triangles.iter().flatten().fold(Aabb::EMPTY, |b, &corner| b.including(corner))
        }
        OracleShape::Sphere { center, radius } => Aabb::new(*center - *radius, *center + *radius),
        OracleShape::Plane { .. } => {
            Aabb::new(DVec3::splat(f64::NEG_INFINITY), DVec3::splat(f64::INFINITY))
        }
    };
    if tight.size().is_finite() { tight.expanded(1e-6 * tight.size().max_element()) } else { tight }
}

impl OracleShape {
    /// The triangles of a mesh.
    #[must_use]
    pub fn mesh(mesh: &TriangleMesh) -> Self {
        Self::Triangles((0..mesh.triangles.len()).map(|index| mesh.corners(index)).collect())
    }

    /// The twelve triangles of an axis-aligned cube of side 2 `half`.
    #[must_use]
    pub fn cube(center: DVec3, half: f64) -> Self {
        const QUADS: [[usize; 4]; 6] =
            [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
        let corner = |index: usize| {
            let side = |bit: usize| if index & bit == 0 { -half } else { half };
            center + DVec3::new(side(1), side(2), side(4))
        };
        let triangles = QUADS.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]);
        Self::Triangles(triangles.map(|corners| corners.map(corner)).collect())
    }

    fn pieces(&self) -> usize {
        match self {
            Self::Triangles(triangles) => triangles.len(),
            Self::Sphere { .. } | Self::Plane { .. } => 1,
        }
    }

    /// Distance > 0 to a piece and its unit normal. A ray that leaves (`left`) a flat piece never
    /// meets it again; one that leaves a sphere inwards meets it at the far end of its chord.
    fn hit(
        &self,
        piece: usize,
        origin: DVec3,
        direction: DVec3,
        left: bool,
    ) -> Option<(f64, DVec3)> {
        match self {
            Self::Triangles(_) | Self::Plane { .. } if left => None,
            Self::Triangles(triangles) => triangle(triangles[piece], origin, direction),
            Self::Sphere { center, radius } => sphere(*center, *radius, origin, direction, left),
            Self::Plane { point, normal } => {
                let t = (*point - origin).dot(*normal) / direction.dot(*normal);
                (t > 0.0 && t.is_finite()).then_some((t, *normal))
            }
        }
    }
}

/// Signed volumes of the tetrahedra that the ray spans with the edges: all of one sign inside.
fn triangle(corners: [DVec3; 3], origin: DVec3, direction: DVec3) -> Option<(f64, DVec3)> {
    let [a, b, c] = corners.map(|corner| corner - origin);
    let volumes = [b.cross(c).dot(direction), c.cross(a).dot(direction), a.cross(b).dot(direction)];
    let inside = volumes.iter().all(|&v| v >= 0.0) || volumes.iter().all(|&v| v <= 0.0);
    let normal = (b - a).cross(c - a);
    let t = a.dot(normal) / direction.dot(normal);
    (inside && t > 0.0 && t.is_finite()).then(|| (t, normal.normalize()))
}

fn sphere(
    center: DVec3,
    radius: f64,
    origin: DVec3,
    direction: DVec3,
    left: bool,
) -> Option<(f64, DVec3)> {
    let from_center = origin - center;
    let along = from_center.dot(direction);
    let t = if left {
        -2.0 * along
    } else {
        let perpendicular = from_center - direction * along;
        let half = (radius * radius - perpendicular.length_squared()).sqrt();
        if -along - half > 0.0 { -along - half } else { -along + half }
    };
    (t > 0.0).then(|| (t, (from_center + direction * t).normalize()))
}
