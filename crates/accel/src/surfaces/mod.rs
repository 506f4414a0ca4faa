//! Solid surfaces that grains fall on and light meets: analytic shapes and triangle meshes.
//!
//! Surfaces are shells: rays and grains meet them from inside as from outside. Each distinct mesh
//! has a bounding volume hierarchy in its own space, built in parallel; another one finds the
//! objects, so that a mesh may be placed many times and costs its triangles once. Planes, which
//! have no bounds, are tried one by one.
//!
//! Results are the same bits at every SIMD level and on any number of threads: boxes and rounded
//! triangles only exclude what the placed triangles, in `f64`, would exclude too.

mod beam;
mod block;
mod build;
mod contact;
mod cuboid;
mod ellipsoid;
mod instance;
mod mesh;
mod nearest;
mod places;
mod solid;
#[cfg(test)]
mod tests;
mod tree;
mod triangle;

use crate::SimdLevel;
use contact::{Drop, Touch};
use fearless_simd::{Level, dispatch};
use places::Places;
use snowgrain_geometry::TriangleMesh;
use snowgrain_math::{Aabb, DAffine3, DMat3, DVec3, Ray};
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
    /// Triangles, two-sided. Objects that share the `Arc` share the memory of the triangles and of
    /// what finds them.
    Mesh(Arc<TriangleMesh>),
}

/// Names one smooth piece of surface (a triangle, a sphere, a plane, a face of a box), so that a
/// ray that starts on it can exclude it by identity instead of by an epsilon.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub struct SurfaceId {
    /// Index of the object, in the order given to [`Surfaces::new`].
    pub object: u32,
    /// Index of the triangle in its mesh; 0..6 for the faces -x, +x, -y, +y, -z, +z of a box; 0 for
    /// a sphere or a plane.
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
///
/// ```
/// use snowgrain_accel::{SurfaceShape, Surfaces};
/// use snowgrain_math::{DAffine3, DVec3, Ray};
/// let surfaces = Surfaces::new(&[(SurfaceShape::Sphere, DAffine3::IDENTITY)]);
/// let ray = Ray::new(DVec3::new(0.0, 3.0, 0.0), DVec3::NEG_Y);
/// let hit = surfaces.intersect(&ray, f64::INFINITY, None).unwrap();
/// assert_eq!((hit.t, hit.normal), (2.0, DVec3::Y));
/// let contact = surfaces.drop_sphere(0.0, 0.0, 0.5, [3.0, f64::NEG_INFINITY]).unwrap();
/// assert!((contact.center_y - 1.5).abs() < 1e-15);
/// ```
#[derive(Debug)]
pub struct Surfaces {
    places: Places,
    level: Level,
}

impl Default for Surfaces {
    /// No surfaces.
    fn default() -> Self {
        Self::new(&[])
    }
}

impl Surfaces {
    /// Builds the structure, on the threads of the current pool; objects are numbered in the order
    /// given.
    ///
    /// Transforms must be invertible; what one flattens is not found by rays. Triangles that have
    /// no area are left out, and of those of a mesh that have the same three corners all but the
    /// first.
    ///
    /// # Panics
    /// Beyond 2^30 triangles in a mesh or 2^30 objects, and where a triangle names a vertex that its
    /// mesh has not.
    #[must_use]
    pub fn new(objects: &[(SurfaceShape, DAffine3)]) -> Self {
        Self { places: Places::new(objects), level: Level::new() }
    }

    /// The same surfaces, searched with the instructions of `level` (same results).
    ///
    /// # Panics
    /// If the machine does not have it.
    #[must_use]
    pub fn with_level(mut self, level: SimdLevel) -> Self {
        self.level = level.token().expect("the SIMD level was checked when it was chosen");
        self
    }

    /// The same surfaces turned about the origin by the rotation `turn`, with the same ids. What
    /// finds the triangles of the meshes is shared.
    #[must_use]
    pub fn turned(&self, turn: &DMat3) -> Self {
        Self { places: self.places.turned(turn), level: self.level }
    }

    /// The nearest surface with `0 < t <= t_max`, other than the piece `exclude`; of several at the
    /// same distance the one with the lowest id.
    ///
    /// `exclude` is the piece on which the ray starts. A sphere or a box is convex, so a ray that
    /// starts on it and points outwards never meets it again, and one that points inwards meets its
    /// far side, even though the far side of a sphere is the same piece.
    #[must_use]
    pub fn intersect(
        &self,
        ray: &Ray,
        t_max: f64,
        exclude: Option<SurfaceId>,
    ) -> Option<SurfaceHit> {
        dispatch!(self.level, simd => self.places.intersect(simd, ray, t_max, exclude))
    }

    /// Whether a ray that starts on the piece `id` meets the same solid again: it crosses a sphere or
    /// a box from within.
    #[must_use]
    pub fn is_met_again(&self, ray: &Ray, id: SurfaceId) -> bool {
        self.places.is_met_again(ray, id)
    }

    /// Whether any surface passes through the box (conservative: may say yes too often, never no
    /// wrongly). Marks the cells of the grain grid in which light must ask [`Self::intersect`].
    #[must_use]
    pub fn may_cross(&self, bounds: &Aabb) -> bool {
        dispatch!(self.level, simd => self.places.may_cross(simd, bounds))
    }

    /// The first contact of a sphere of `radius` that falls straight down along `x, z` from
    /// `start_y` (height of its centre) until it is at `down_to`, where contacts do not count any
    /// more (`-inf`: all count); `None` where it falls past everything. A sphere that overlaps a
    /// surface at the start is in contact there. `radius` 0 is a ray straight down, which meets what
    /// lies below the start.
    ///
    /// Exact to rounding for every shape. Of contacts at the same height the lowest id counts.
    #[must_use]
    pub fn drop_sphere(
        &self,
        x: f64,
        z: f64,
        radius: f64,
        [start_y, down_to]: [f64; 2],
    ) -> Option<SphereContact> {
        let drop = Drop { x, z, radius, start_y, down_to };
        if radius == 0.0 {
            let depth = start_y - down_to;
            let hit = self.intersect(&Ray::new(drop.start(), DVec3::NEG_Y), depth, None)?;
            let point = drop.center(start_y - hit.t);
            let (center_y, normal, id) = (point.y, hit.normal, hit.id);
            return Some(SphereContact { center_y, point, normal, id });
        }
        dispatch!(self.level, simd => self.places.drop_sphere(simd, &drop))
            .filter(|contact| contact.center_y > down_to)
    }

    /// All pieces nearer to `center` than `reach`, each with its closest point (`center_y` holds
    /// the distance from `center` to that point), in the order of their ids. `out` is cleared.
    pub fn near(&self, center: DVec3, reach: f64, out: &mut Vec<SphereContact>) {
        out.clear();
        let mut found = |distance: f64, touch: Touch, id: SurfaceId| {
            if distance < reach {
                out.push(SphereContact::new(distance, touch, id));
            }
        };
        dispatch!(self.level, simd => self.places.near(simd, center, reach, &mut found));
        out.sort_unstable_by_key(|contact| contact.id);
    }

    /// Box around all finite surfaces; empty where there are none (planes are infinite).
    #[must_use]
    pub fn bounds(&self) -> Aabb {
        self.places.bounds()
    }

    /// Whether there is no surface at all.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        self.places.is_empty()
    }

    /// Whether one of the surfaces is a plane.
    #[must_use]
    pub fn has_infinite(&self) -> bool {
        self.places.has_infinite()
    }

    /// Memory held, bytes, with that of the meshes, each counted once.
    #[must_use]
    pub fn memory_bytes(&self) -> usize {
        size_of::<Self>() + self.places.heap_bytes()
    }
}

impl SphereContact {
    fn new(center_y: f64, touch: Touch, id: SurfaceId) -> Self {
        Self { center_y, point: touch.point, normal: touch.normal, id }
    }
}

/// Replaces `first` by a contact that a falling sphere meets before it; returns whether it did.
fn keep_higher(first: &mut Option<SphereContact>, contact: SphereContact) -> bool {
    let earlier = first.is_none_or(|held| {
        contact.center_y > held.center_y
            || (contact.center_y == held.center_y && contact.id < held.id)
    });
    if earlier {
        *first = Some(contact);
    }
    earlier
}
