//! Solid surfaces that grains fall on and light meets: analytic shapes and triangle meshes.

use snowgrain_geometry::TriangleMesh;
use snowgrain_math::{Aabb, DAffine3, DVec3, Ray};
use std::sync::Arc;

/// The closed set of shapes, each in its own space (metres), placed by an affine transform.
#[derive(Clone, Debug)]
pub enum SurfaceShape {
    /// Sphere of radius 1 at the origin.
    Sphere,
    /// The box [-1, 1]^3.
    Box,
    /// The infinite plane y = 0 (of the object's own space).
    Plane,
    /// Triangles, two-sided.
    Mesh(Arc<TriangleMesh>),
}

/// Names one smooth piece of surface (a triangle, a sphere, a plane, a face of a box), so that a
/// ray that starts on it can exclude it by identity instead of by an epsilon.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct SurfaceId {
    /// Index of the object, in the order given to [`Surfaces::new`].
    pub object: u32,
    /// Index of the triangle or face within it.
    pub piece: u32,
}

/// Where a ray meets a surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SurfaceHit {
    /// Distance along the ray, metres, > 0.
    pub t: f64,
    /// Unit geometric normal on the side from which the ray came.
    pub normal: DVec3,
    /// What was hit.
    pub id: SurfaceId,
}

/// First contact of a sphere with a surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SphereContact {
    /// Height of the sphere's centre at the contact, metres (falls), or its signed gap (queries).
    pub center_y: f64,
    /// The point touched, metres.
    pub point: DVec3,
    /// Unit normal from the touched point towards the sphere's centre.
    pub normal: DVec3,
    /// What is touched.
    pub id: SurfaceId,
}

/// All surfaces of a scene with the structure that finds them.
#[derive(Debug, Default)]
pub struct Surfaces {}

impl Surfaces {
    /// Builds the structure; objects are numbered in the order given.
    #[must_use]
    pub fn new(_objects: &[(SurfaceShape, DAffine3)]) -> Self {
        todo!()
    }

    /// The nearest surface with `0 < t <= t_max`, other than the piece `exclude`.
    #[must_use]
    pub fn intersect(
        &self,
        _ray: &Ray,
        _t_max: f64,
        _exclude: Option<SurfaceId>,
    ) -> Option<SurfaceHit> {
        todo!()
    }

    /// Whether any surface passes through the box (conservative: may say yes too often, never no
    /// wrongly). Marks the cells of the grain grid in which light must ask [`Self::intersect`].
    #[must_use]
    pub fn may_cross(&self, _bounds: &Aabb) -> bool {
        todo!()
    }

    /// The first contact of a sphere of `radius` that falls straight down along `x, z` from
    /// `start_y` (height of its centre); `None` where it falls past everything.
    #[must_use]
    pub fn drop_sphere(
        &self,
        _x: f64,
        _z: f64,
        _radius: f64,
        _start_y: f64,
    ) -> Option<SphereContact> {
        todo!()
    }

    /// All pieces nearer to `center` than `reach`, each with its closest point (`center_y` holds
    /// the distance from `center` to that point).
    pub fn near(&self, _center: DVec3, _reach: f64, _out: &mut Vec<SphereContact>) {
        todo!()
    }

    /// Box around all finite surfaces; empty where there are none (planes are infinite).
    #[must_use]
    pub fn bounds(&self) -> Aabb {
        todo!()
    }
}
