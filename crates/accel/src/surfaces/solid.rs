//! The analytic shapes, each placed by an affine transform.

use super::contact::{Drop, Touch};
use super::ellipsoid::Ellipsoid;
use super::instance::is_well_conditioned;
use super::triangle::{ROUNDING, Triangle};
use super::{SurfaceHit, SurfaceId};
use snowgrain_math::{Aabb, DAffine3, DMat3, DVec3, Ray};

/// A shape with its place.
#[derive(Clone, Debug)]
pub(super) struct Solid {
    object: u32,
    center: DVec3,
    matrix: DMat3,
    inverse: DMat3,
    shape: Shape,
}

#[derive(Clone, Debug)]
enum Shape {
    Sphere(Ellipsoid),
    /// The faces -x, +x, -y, +y, -z, +z, two triangles each (they touch what is convex about it).
    Box(Box<[Triangle; 12]>),
    /// The unit normal, upwards.
    Plane(DVec3),
}

impl Solid {
    pub(super) fn sphere(object: u32, transform: &DAffine3) -> Self {
        let ellipsoid = Ellipsoid::new(transform.matrix3, transform.translation);
        Self::new(object, transform, Shape::Sphere(ellipsoid))
    }

    pub(super) fn cuboid(object: u32, transform: &DAffine3) -> Self {
        let triangles = std::array::from_fn(|i| {
            let corners = face_corners(i / 2);
            let pick = if i % 2 == 0 { [0, 1, 2] } else { [0, 2, 3] };
            Triangle {
                corners: pick.map(|k| transform.transform_point3(corners[k])),
                id: SurfaceId { object, piece: i as u32 / 2 },
            }
        });
        Self::new(object, transform, Shape::Box(Box::new(triangles)))
    }

    pub(super) fn plane(object: u32, transform: &DAffine3) -> Self {
        let normal = transform.matrix3.z_axis.cross(transform.matrix3.x_axis).normalize();
        let upwards = if normal.y < 0.0 { -normal } else { normal };
        Self::new(object, transform, Shape::Plane(upwards))
    }

    fn new(object: u32, transform: &DAffine3, shape: Shape) -> Self {
        let matrix = transform.matrix3;
        Self { object, center: transform.translation, matrix, inverse: matrix.inverse(), shape }
    }

    /// The same solid turned about the origin.
    pub(super) fn turned(&self, turn: &DMat3) -> Self {
        let transform = DAffine3 { matrix3: *turn * self.matrix, translation: *turn * self.center };
        match self.shape {
            Shape::Sphere(_) => Self::sphere(self.object, &transform),
            Shape::Box(_) => Self::cuboid(self.object, &transform),
            Shape::Plane(_) => Self::plane(self.object, &transform),
        }
    }

    fn id(&self, piece: usize) -> SurfaceId {
        SurfaceId { object: self.object, piece: piece as u32 }
    }

    pub(super) fn is_infinite(&self) -> bool {
        matches!(self.shape, Shape::Plane(_))
    }

    /// Box around it; empty for a plane.
    pub(super) fn bounds(&self) -> Aabb {
        let half = match &self.shape {
            Shape::Sphere(ellipsoid) => ellipsoid.half_size(),
            Shape::Box(_) => {
                let m = &self.matrix;
                m.x_axis.abs() + m.y_axis.abs() + m.z_axis.abs()
            }
            Shape::Plane(_) => return Aabb::EMPTY,
        };
        Aabb::new(self.center - half, self.center + half)
    }

    /// The first hit with `t > 0`, as [`super::Surfaces::intersect`] defines it.
    pub(super) fn intersect(&self, ray: &Ray, exclude: Option<SurfaceId>) -> Option<SurfaceHit> {
        let excluded = exclude.filter(|id| id.object == self.object).map(|id| id.piece as usize);
        let (t, piece, outwards) = match &self.shape {
            Shape::Sphere(_) => self.intersect_sphere(ray, excluded.is_some())?,
            Shape::Box(_) => self.intersect_box(ray, excluded)?,
            Shape::Plane(normal) => {
                let t = normal.dot(self.center - ray.origin) / normal.dot(ray.direction);
                if excluded.is_some() || !(t > 0.0 && t < f64::INFINITY) {
                    return None;
                }
                (t, 0, *normal)
            }
        };
        let normal = if outwards.dot(ray.direction) > 0.0 { -outwards } else { outwards };
        Some(SurfaceHit { t, normal, id: self.id(piece) })
    }

    /// The ray in the shape's own space; its direction is not a unit vector, so distances along
    /// it stay those of the world.
    fn local(&self, ray: &Ray) -> (DVec3, DVec3) {
        (self.inverse * (ray.origin - self.center), self.inverse * ray.direction)
    }

    /// A normal of the shape's own space in the world.
    fn world_normal(&self, normal: DVec3) -> DVec3 {
        (self.inverse.transpose() * normal).normalize()
    }

    /// Distance, piece and outward normal. A ray that starts `on` the sphere goes either away from
    /// it (by convexity it never comes back) or through to the far side.
    fn intersect_sphere(&self, ray: &Ray, on: bool) -> Option<(f64, usize, DVec3)> {
        let (origin, direction) = self.local(ray);
        let length_squared = direction.length_squared();
        let middle = -origin.dot(direction) / length_squared;
        let across = origin + direction * middle;
        let half = ((1.0 - across.length_squared()) / length_squared).sqrt();
        if half.is_nan() || (on && middle <= 0.0) {
            return None;
        }
        let near = middle - half;
        let t = if near > 0.0 && !on { near } else { middle + half };
        (t > 0.0).then(|| (t, 0, self.world_normal(origin + direction * t)))
    }

    /// Distance, face and outward normal. A ray that starts on a face goes either away from the
    /// box or through to the far side.
    fn intersect_box(&self, ray: &Ray, on: Option<usize>) -> Option<(f64, usize, DVec3)> {
        let (origin, direction) = self.local(ray);
        let (mut near, mut far) = ((f64::NEG_INFINITY, 0), (f64::INFINITY, 0));
        for axis in 0..3 {
            let (o, d) = (origin[axis], direction[axis]);
            if d == 0.0 {
                if o.abs() > 1.0 {
                    return None;
                }
                continue;
            }
            let side = usize::from(d < 0.0);
            let to_face = |face: usize| (face_side(face) - o) / d;
            let (enter, leave) = (2 * axis + side, 2 * axis + 1 - side);
            if to_face(enter) > near.0 {
                near = (to_face(enter), enter);
            }
            if to_face(leave) < far.0 {
                far = (to_face(leave), leave);
            }
        }
        let leaving = on.is_some_and(|face| direction.dot(face_normal(face)) >= 0.0);
        if near.0 > far.0 || leaving {
            return None;
        }
        let (t, face) = if near.0 > 0.0 && on.is_none() { near } else { far };
        (t > 0.0 && t < f64::INFINITY && on != Some(face))
            .then(|| (t, face, self.world_normal(face_normal(face))))
    }

    /// Whether its surface may pass through the box; in doubt yes.
    pub(super) fn may_cross(&self, bounds: &Aabb) -> bool {
        let (center, half) = (bounds.center(), bounds.size() * 0.5);
        let size = center.abs().max(self.center.abs()).max_element() + half.max_element();
        let half = half + size * ROUNDING;
        match &self.shape {
            Shape::Sphere(_) => self.sphere_may_cross(center - self.center, half),
            Shape::Box(triangles) => triangles.iter().any(|t| t.overlaps(bounds)),
            Shape::Plane(normal) => {
                normal.dot(center - self.center).abs() <= normal.abs().dot(half)
            }
        }
    }

    /// Seen from the sphere's own space the box is a skewed one: its farthest corner decides
    /// whether it lies inside, the box around it whether it lies outside.
    fn sphere_may_cross(&self, center: DVec3, half: DVec3) -> bool {
        let m = &self.inverse;
        let center = *m * center;
        let edges = [m.x_axis * half.x, m.y_axis * half.y, m.z_axis * half.z];
        let reach = edges[0].abs() + edges[1].abs() + edges[2].abs();
        let nearest = (center.abs() - reach).max(DVec3::ZERO);
        let farthest = (0..8u32)
            .map(|corner| {
                let sign = |bit: u32| if corner >> bit & 1 == 0 { 1.0 } else { -1.0 };
                let p = center + edges[0] * sign(0) + edges[1] * sign(1) + edges[2] * sign(2);
                p.length_squared()
            })
            .fold(0.0, f64::max);
        nearest.length_squared() <= 1.0 + ROUNDING && farthest >= 1.0 - ROUNDING
    }

    /// Calls `found` with the first contact of the falling sphere with each piece it meets.
    pub(super) fn drop_sphere(&self, drop: &Drop, mut found: impl FnMut(f64, Touch, SurfaceId)) {
        match &self.shape {
            Shape::Sphere(ellipsoid) => {
                if let Some((y, touch)) = ellipsoid.drop_sphere(drop) {
                    found(y, touch, self.id(0));
                }
            }
            Shape::Box(triangles) => {
                for triangle in triangles.iter().filter(|t| t.has_area()) {
                    if let Some((y, touch)) = triangle.drop_sphere(drop) {
                        found(y, touch, triangle.id);
                    }
                }
            }
            Shape::Plane(normal) => {
                if let Some((y, touch)) = self.drop_on_plane(*normal, drop) {
                    found(y, touch, self.id(0));
                }
            }
        }
    }

    fn drop_on_plane(&self, normal: DVec3, drop: &Drop) -> Option<(f64, Touch)> {
        let (touch, distance) = self.touch_plane(normal, drop.start());
        if distance <= drop.radius {
            return Some((drop.start_y, touch));
        }
        let below = drop.center(self.center.y) - self.center;
        let y = self.center.y + (drop.radius - normal.dot(below)) / normal.y;
        (normal.y > 0.0 && y <= drop.start_y).then(|| {
            let point = drop.center(y) - normal * drop.radius;
            (y, Touch { point, normal })
        })
    }

    fn touch_plane(&self, normal: DVec3, center: DVec3) -> (Touch, f64) {
        let height = normal.dot(center - self.center);
        let side = if height < 0.0 { -normal } else { normal };
        (Touch { point: center - normal * height, normal: side }, height.abs())
    }

    /// Calls `found` with the nearest point of each piece and its distance.
    pub(super) fn near(&self, center: DVec3, mut found: impl FnMut(f64, Touch, SurfaceId)) {
        match &self.shape {
            Shape::Sphere(ellipsoid) => {
                let (touch, distance) = ellipsoid.touch(center);
                found(distance, touch, self.id(0));
            }
            Shape::Box(triangles) => {
                for face in triangles.chunks_exact(2) {
                    let touches = [face[0].touch(center), face[1].touch(center)];
                    let nearer = usize::from(touches[1].1 < touches[0].1);
                    found(touches[nearer].1, touches[nearer].0, face[0].id);
                }
            }
            Shape::Plane(normal) => {
                let (touch, distance) = self.touch_plane(*normal, center);
                found(distance, touch, self.id(0));
            }
        }
    }

    /// Whether the box around it holds all that its queries find: it has one, and its own space
    /// loses no more than a few digits.
    pub(super) fn is_bounded(&self) -> bool {
        !self.is_infinite() && is_well_conditioned(&self.matrix)
    }

    /// Memory beyond the value itself, bytes.
    pub(super) fn heap_bytes(&self) -> usize {
        match &self.shape {
            Shape::Box(_) => size_of::<[Triangle; 12]>(),
            Shape::Sphere(_) | Shape::Plane(_) => 0,
        }
    }
}

/// Coordinate of a face of [-1, 1]^3 along its axis.
fn face_side(face: usize) -> f64 {
    if face.is_multiple_of(2) { -1.0 } else { 1.0 }
}

/// Outward normal of a face of [-1, 1]^3.
fn face_normal(face: usize) -> DVec3 {
    let mut normal = DVec3::ZERO;
    normal[face / 2] = face_side(face);
    normal
}

/// Corners of a face of [-1, 1]^3, in order around it.
fn face_corners(face: usize) -> [DVec3; 4] {
    let mut corner = face_normal(face);
    let (i, j) = ((face / 2 + 1) % 3, (face / 2 + 2) % 3);
    [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)].map(|(u, v)| {
        corner[i] = u;
        corner[j] = v;
        corner
    })
}
