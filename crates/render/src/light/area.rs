//! Points on luminous surfaces, drawn from somewhere.

use super::choice::Choice;
use core::f64::consts::{PI, TAU};
use snowgrain_accel::SurfaceShape;
use snowgrain_geometry::TriangleMesh;
use snowgrain_math::{Aabb, DAffine3, DMat3, DVec3, frame, trig};
use std::sync::Arc;

/// Heights by azimuths of the points that the area of an ellipsoid is summed at.
const ELLIPSOID_POINTS: [u32; 2] = [64, 64];

/// How unlike the lengths of the columns of a matrix may be that makes a sphere of a sphere.
const ROUND: f64 = 1e-12;

/// A surface of which points are drawn.
#[derive(Clone, Debug)]
pub(super) enum Area {
    /// A sphere; points are uniform in the solid angle that it fills.
    Sphere { center: DVec3, radius: f64 },
    /// The image of the unit sphere; points are images of uniform ones.
    Ellipsoid(Ellipsoid),
    /// Triangles; points are uniform in area.
    Triangles(Triangles),
}

#[derive(Clone, Debug)]
pub(super) struct Ellipsoid {
    center: DVec3,
    matrix: DMat3,
    inverse: DMat3,
}

#[derive(Clone, Debug)]
pub(super) struct Triangles {
    mesh: Arc<TriangleMesh>,
    transform: DAffine3,
    choice: Choice,
    area: f64,
    /// Triangles of the mesh that are one piece of its surface.
    per_piece: usize,
}

/// A point of a surface as seen from somewhere.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct AreaPoint {
    pub(super) position: DVec3,
    /// A unit normal, outwards where that has a meaning.
    pub(super) normal: DVec3,
    /// Unit vector towards it.
    pub(super) direction: DVec3,
    /// Metres.
    pub(super) distance: f64,
    /// Density of the direction, 1/sr.
    pub(super) density: f64,
    /// Piece of the surface ([`snowgrain_accel::SurfaceId`]).
    pub(super) piece: u32,
}

impl Area {
    /// Of a shape where it is placed; `None` of a plane, which has no end.
    pub(super) fn new(shape: &SurfaceShape, transform: &DAffine3) -> Option<Self> {
        let matrix = transform.matrix3;
        Some(match shape {
            SurfaceShape::Sphere => match round(&matrix) {
                Some(radius) => Self::Sphere { center: transform.translation, radius },
                None => Self::Ellipsoid(Ellipsoid {
                    center: transform.translation,
                    matrix,
                    inverse: matrix.inverse(),
                }),
            },
            SurfaceShape::Box => Self::Triangles(Triangles::new(Arc::new(cuboid()), transform, 2)),
            SurfaceShape::Mesh(mesh) => {
                Self::Triangles(Triangles::new(Arc::clone(mesh), transform, 1))
            }
            SurfaceShape::Plane => return None,
        })
    }

    /// A point that can be seen from `from`, or is hidden by other parts of the surface only; `None` where
    /// the numbers `u` in [0, 1) give one that is turned away.
    pub(super) fn sample(&self, from: DVec3, u: [f64; 3]) -> Option<AreaPoint> {
        match self {
            Self::Sphere { center, radius } => sample_sphere(*center, *radius, from, [u[1], u[2]]),
            Self::Ellipsoid(ellipsoid) => ellipsoid.sample(from, [u[1], u[2]]),
            Self::Triangles(triangles) => triangles.sample(from, u),
        }
    }

    /// Density with which [`Self::sample`] gives a point of the surface, 1/sr as seen from `from`.
    pub(super) fn density(&self, from: DVec3, point: DVec3, normal: DVec3) -> f64 {
        let offset = point - from;
        let per_area = match self {
            Self::Sphere { center, radius } => {
                return sphere_density(center.distance_squared(from), radius * radius);
            }
            Self::Ellipsoid(ellipsoid) => ellipsoid.per_area(point),
            Self::Triangles(triangles) => 1.0 / triangles.area,
        };
        per_solid_angle(per_area, offset, normal)
    }

    /// The mean area of its shadow, m^2.
    pub(super) fn shadow(&self) -> f64 {
        match self {
            Self::Sphere { radius, .. } => PI * radius * radius,
            Self::Ellipsoid(ellipsoid) => 0.25 * ellipsoid.area(),
            // Of a flat piece half its area; a closed surface hides half of itself.
            Self::Triangles(triangles) => 0.5 * triangles.area,
        }
    }

    /// Its middle.
    pub(super) fn center(&self) -> DVec3 {
        match self {
            Self::Sphere { center, .. } => *center,
            Self::Ellipsoid(ellipsoid) => ellipsoid.center,
            Self::Triangles(triangles) => {
                let bounds: Aabb = triangles.mesh.bounds();
                triangles.transform.transform_point3(bounds.center())
            }
        }
    }
}

/// Density for each steradian of what has this one for each square metre of a surface.
fn per_solid_angle(per_area: f64, offset: DVec3, normal: DVec3) -> f64 {
    let square = offset.length_squared();
    let cosine = offset.dot(normal).abs() / square.sqrt();
    if cosine > 0.0 { per_area * square / cosine } else { 0.0 }
}

fn sample_sphere(center: DVec3, radius: f64, from: DVec3, u: [f64; 2]) -> Option<AreaPoint> {
    let offset = center - from;
    let (distance, squares) = (offset.length_squared(), radius * radius);
    let density = sphere_density(distance, squares);
    let turn = trig::sin_cos(TAU * u[1]);
    let (direction, length) = if distance > squares {
        let axis = offset / distance.sqrt();
        let versine = cone_versine(squares / distance) * u[0];
        let direction = tilted(axis, versine, turn);
        // From the foot of the perpendicular on the ray back to the near side.
        let foot = offset.dot(direction);
        let apart = (offset - direction * foot).length_squared();
        (direction, foot - (squares - apart).max(0.0).sqrt())
    } else {
        let direction = tilted(DVec3::Y, 2.0 * u[0], turn);
        let foot = offset.dot(direction);
        let apart = (offset - direction * foot).length_squared();
        (direction, foot + (squares - apart).max(0.0).sqrt())
    };
    let position = from + direction * length;
    let normal = (position - center).normalize();
    let seen = length > 0.0;
    seen.then_some(AreaPoint { position, normal, direction, distance: length, density, piece: 0 })
}

/// The unit vector at this versine from an axis, turned about it by an angle of this sine and cosine.
fn tilted(axis: DVec3, versine: f64, (sin, cos): (f64, f64)) -> DVec3 {
    let (s, t) = frame::tangents(axis);
    let across = (versine * (2.0 - versine)).max(0.0).sqrt();
    (axis * (1.0 - versine) + s * (across * cos) + t * (across * sin)).normalize()
}

/// One less the cosine of half the angle that a sphere fills, of which the sine has this square.
fn cone_versine(sine_squared: f64) -> f64 {
    sine_squared / (1.0 + (1.0 - sine_squared).sqrt())
}

/// Density of directions towards a sphere, by the squares of the distance of its middle and of its radius: the
/// same all over the solid angle that it fills, which is that of all directions from within.
fn sphere_density(distance_squared: f64, radius_squared: f64) -> f64 {
    if distance_squared > radius_squared {
        1.0 / (TAU * cone_versine(radius_squared / distance_squared))
    } else {
        0.5 / TAU
    }
}

impl Ellipsoid {
    fn sample(&self, from: DVec3, u: [f64; 2]) -> Option<AreaPoint> {
        let local = tilted(DVec3::Y, 2.0 * u[0], trig::sin_cos(TAU * u[1]));
        let position = self.center + self.matrix * local;
        let normal = (self.inverse.transpose() * local).normalize();
        let offset = position - from;
        let outside = (self.inverse * (from - self.center)).length_squared() > 1.0;
        if outside && offset.dot(normal) >= 0.0 {
            return None;
        }
        let density = per_solid_angle(self.per_area(position), offset, normal);
        let distance = offset.length();
        let point = AreaPoint {
            position,
            normal,
            direction: offset / distance,
            distance,
            density,
            piece: 0,
        };
        (density > 0.0).then_some(point)
    }

    /// By how much the image of a surface around this point of the unit sphere is larger than it.
    fn stretch(&self, local: DVec3) -> f64 {
        self.matrix.determinant().abs() * (self.inverse.transpose() * local).length()
    }

    /// Density of the image of uniform points, 1/m^2.
    fn per_area(&self, point: DVec3) -> f64 {
        let local = (self.inverse * (point - self.center)).normalize();
        0.5 / (TAU * self.stretch(local))
    }

    fn area(&self) -> f64 {
        let [heights, azimuths] = ELLIPSOID_POINTS;
        let at = |i: u32, count: u32| (f64::from(i) + 0.5) / f64::from(count);
        let stretches = (0..heights).flat_map(|row| {
            let around = move |column| trig::sin_cos(TAU * at(column, azimuths));
            (0..azimuths)
                .map(move |column| tilted(DVec3::Y, 2.0 * at(row, heights), around(column)))
        });
        let sum: f64 = stretches.map(|local| self.stretch(local)).sum();
        2.0 * TAU * sum / f64::from(heights * azimuths)
    }
}

impl Triangles {
    fn new(mesh: Arc<TriangleMesh>, transform: &DAffine3, per_piece: usize) -> Self {
        let mut all =
            Self { mesh, transform: *transform, choice: Choice::new([]), area: 0.0, per_piece };
        let areas: Vec<f64> = (0..all.mesh.triangles.len())
            .map(|triangle| 0.5 * all.cross(triangle).length())
            .collect();
        all.area = areas.iter().sum();
        all.choice = Choice::new(areas);
        all
    }

    fn corners(&self, triangle: usize) -> [DVec3; 3] {
        self.mesh.corners(triangle).map(|corner| self.transform.transform_point3(corner))
    }

    /// The normal, twice as long as the area is large.
    fn cross(&self, triangle: usize) -> DVec3 {
        let [a, b, c] = self.corners(triangle);
        (b - a).cross(c - a)
    }

    fn sample(&self, from: DVec3, u: [f64; 3]) -> Option<AreaPoint> {
        let (triangle, _) = self.choice.pick(u[0])?;
        let [a, b, c] = self.corners(triangle);
        // Uniform over the triangle (Turk 1990, "Generating random points in triangles").
        let root = u[1].sqrt();
        let position = a + (b - a) * (root * (1.0 - u[2])) + (c - a) * (root * u[2]);
        let normal = self.cross(triangle).normalize();
        let offset = position - from;
        let density = per_solid_angle(1.0 / self.area, offset, normal);
        let distance = offset.length();
        let piece = (triangle / self.per_piece) as u32;
        let direction = offset / distance;
        let point = AreaPoint { position, normal, direction, distance, density, piece };
        (density > 0.0).then_some(point)
    }
}

/// The radius of the sphere that a matrix makes of the unit sphere, if it makes one.
fn round(matrix: &DMat3) -> Option<f64> {
    let square = matrix.transpose() * *matrix;
    let radius_squared = square.x_axis.x;
    let off = square - DMat3::from_diagonal(DVec3::splat(radius_squared));
    let greatest =
        off.to_cols_array().into_iter().fold(0.0, |greatest: f64, x| greatest.max(x.abs()));
    (greatest <= ROUND * radius_squared).then(|| radius_squared.sqrt())
}

/// The box [-1, 1]^3: two triangles for each of the faces -x, +x, -y, +y, -z, +z.
fn cuboid() -> TriangleMesh {
    let positions = (0..8).map(|corner: u32| {
        DVec3::from([0, 1, 2].map(|axis| if corner >> axis & 1 == 1 { 1.0 } else { -1.0 }))
    });
    let faces = (0..6u32).flat_map(|face| {
        let (axis, side) = (face / 2, (face % 2) << (face / 2));
        let (i, j) = (1 << ((axis + 1) % 3), 1 << ((axis + 2) % 3));
        [[side, side + i, side + i + j], [side, side + i + j, side + j]]
    });
    TriangleMesh {
        positions: positions.collect(),
        triangles: faces.collect(),
        coordinates: Vec::new(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use snowgrain_accel::Surfaces;
    use snowgrain_math::Ray;
    use snowgrain_math::sampler::{PathKey, numbers};

    fn shapes() -> Vec<(SurfaceShape, DAffine3)> {
        let move_to =
            |matrix: DMat3| DAffine3::from_mat3_translation(matrix, DVec3::new(0.5, 1.0, -0.3));
        let stretched = DMat3::from_diagonal(DVec3::new(0.3, 0.8, 0.5));
        let turned = DMat3::from_axis_angle(DVec3::ONE.normalize(), 0.7) * stretched;
        let quad = TriangleMesh::new(
            vec![DVec3::ZERO, DVec3::X, DVec3::X + DVec3::Z, DVec3::Z * 2.0],
            vec![[0, 1, 2], [0, 2, 3]],
        )
        .unwrap();
        vec![
            (SurfaceShape::Sphere, move_to(DMat3::from_diagonal(DVec3::splat(0.7)))),
            (SurfaceShape::Sphere, move_to(turned)),
            (SurfaceShape::Box, move_to(turned)),
            (SurfaceShape::Mesh(Arc::new(quad)), move_to(turned)),
        ]
    }

    fn uniform(stream: u64, index: u32) -> [f64; 3] {
        numbers(PathKey::new(3, stream, u64::from(index)), 0).map(f64::from)
    }

    #[test]
    fn points_lie_on_the_surface_and_what_is_in_front_is_found_by_a_ray() {
        for (stream, shape) in shapes().into_iter().enumerate() {
            let surfaces = Surfaces::new(std::slice::from_ref(&shape));
            let area = Area::new(&shape.0, &shape.1).unwrap();
            for from in [DVec3::new(2.0, 3.0, 1.0), DVec3::new(0.5, 1.01, -0.3)] {
                let mut found = 0;
                for index in 0..2000 {
                    let Some(point) = area.sample(from, uniform(stream as u64, index)) else {
                        continue;
                    };
                    let length =
                        (point.position - from - point.direction * point.distance).length();
                    assert!(length < 1e-12);
                    let density = area.density(from, point.position, point.normal);
                    assert!((density / point.density - 1.0).abs() < 1e-9, "{density} {point:?}");
                    let ray = Ray::new(from, point.direction);
                    let hit = surfaces.intersect(&ray, f64::INFINITY, None).unwrap();
                    let same = (hit.t - point.distance).abs() < 1e-9;
                    assert!(same || hit.t < point.distance);
                    if same {
                        assert_eq!(hit.id.piece, point.piece, "{shape:?}");
                        assert!(hit.normal.cross(point.normal).length() < 1e-6);
                        found += 1;
                    }
                }
                assert!(found > 400, "{shape:?}: {found}");
            }
        }
    }

    #[test]
    fn the_solid_angle_that_is_seen_is_that_of_rays_that_meet_the_surface() {
        // The mean of 1 / density over samples that are seen is the solid angle; so is 4 pi times the share of
        // uniform directions that meet the surface. 4.5 standard errors of both: a false alarm in 10^5.
        for (stream, shape) in shapes().into_iter().enumerate() {
            let surfaces = Surfaces::new(std::slice::from_ref(&shape));
            let area = Area::new(&shape.0, &shape.1).unwrap();
            for from in [DVec3::new(1.5, 2.0, 0.5), DVec3::new(0.5, 1.01, -0.3)] {
                let samples = 20_000u32;
                let (mut sum, mut square, mut met) = (0.0, 0.0, 0u32);
                for index in 0..samples {
                    let u = uniform(10 + stream as u64, index);
                    if let Some(point) = area.sample(from, u) {
                        let ray = Ray::new(from, point.direction);
                        let hit = surfaces.intersect(&ray, f64::INFINITY, None).unwrap();
                        if (hit.t - point.distance).abs() < 1e-9 {
                            sum += 1.0 / point.density;
                            square += 1.0 / (point.density * point.density);
                        }
                    }
                    let ray =
                        Ray::new(from, tilted(DVec3::Z, 2.0 * u[0], trig::sin_cos(TAU * u[1])));
                    met += u32::from(surfaces.intersect(&ray, f64::INFINITY, None).is_some());
                }
                let count = f64::from(samples);
                let (mean, share) = (sum / count, f64::from(met) / count);
                let variance = (square / count - mean * mean).max(0.0)
                    + (2.0 * TAU) * (2.0 * TAU) * share * (1.0 - share);
                let error = (variance / count).sqrt();
                let expected = 2.0 * TAU * share;
                assert!(
                    (mean - expected).abs() < 4.5 * error + 1e-9,
                    "{shape:?}: {mean} {expected}"
                );
            }
        }
    }

    #[test]
    fn areas_are_known() {
        let ball = Area::new(&shapes()[0].0, &shapes()[0].1).unwrap();
        assert!((ball.shadow() - PI * 0.49).abs() < 1e-12);
        let scaled = DAffine3::from_scale(DVec3::new(2.0, 2.0, 1.0));
        let spheroid = Area::new(&SurfaceShape::Sphere, &scaled).unwrap();
        // An oblate spheroid: 2 pi a^2 (1 + (1 - e^2) / e artanh e), e^2 = 1 - c^2 / a^2.
        let e = 0.75f64.sqrt();
        let expected =
            TAU * 4.0 * (1.0 + (1.0 - e * e) / e * 0.5 * trig::ln((1.0 + e) / (1.0 - e)));
        assert!((spheroid.shadow() * 4.0 / expected - 1.0).abs() < 1e-3);
        let cube = Area::new(&SurfaceShape::Box, &DAffine3::IDENTITY).unwrap();
        assert!((cube.shadow() - 12.0).abs() < 1e-12);
        assert!(Area::new(&SurfaceShape::Plane, &DAffine3::IDENTITY).is_none());
    }
}
