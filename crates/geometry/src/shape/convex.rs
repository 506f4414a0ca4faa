//! Convex bodies: what lies behind all of some planes, and within an ellipsoid if there is one.

use snowgrain_math::{DMat3, DVec3};

/// Sub-triangles along an edge, where a measure has to be summed numerically.
const FINENESS: u32 = 96;
/// Farther than any corner of a body, in distances of its farthest face.
const FARTHEST: f64 = 1e3;
/// Cut-off of polygons: vertices nearer than this part of the size are one.
const SAME_POINT: f64 = 1e-12;

/// A face: the plane `normal . x = distance`; the body lies where that is less.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Face {
    /// Outward unit normal.
    pub normal: DVec3,
    /// Of the plane from the origin, > 0 where the origin lies inside.
    pub distance: f64,
}

/// The ellipsoid `|to_unit (x - center)| = 1`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Ellipsoid {
    /// Its centre.
    pub center: DVec3,
    /// What makes it the unit sphere.
    pub to_unit: DMat3,
}

/// Which part of the surface of a [`ConvexBody`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum SurfacePart {
    /// The face of this index.
    Face(usize),
    /// The ellipsoid.
    Ellipsoid,
}

/// The stretch of a line within a body: `enter < leave`, with the parts of the surface that bound it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Interval {
    /// Where the line enters.
    pub enter: f64,
    /// Through which part.
    pub enter_part: SurfacePart,
    /// Where it leaves.
    pub leave: f64,
    /// Through which part.
    pub leave_part: SurfacePart,
}

/// A convex body. Polyhedra have faces alone, spheroids an ellipsoid alone, rounded polyhedra both.
#[derive(Clone, Debug, PartialEq)]
pub struct ConvexBody {
    /// Planes.
    pub faces: Vec<Face>,
    /// What rounds it.
    pub ellipsoid: Option<Ellipsoid>,
}

/// A face that shows: its outward normal, the middle of its corners' triangles by area, and its area.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FlatFace {
    /// Outward unit normal.
    pub normal: DVec3,
    /// Centre of its area.
    pub centroid: DVec3,
    /// Area.
    pub area: f64,
}

/// What integrals over the surface of a body give.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Measure {
    pub(super) volume: f64,
    pub(super) surface_area: f64,
    /// Integral of the position over the volume.
    pub(super) moment: DVec3,
}

impl ConvexBody {
    /// Whether a point lies strictly inside.
    #[must_use]
    pub fn contains(&self, point: DVec3) -> bool {
        self.faces.iter().all(|face| face.normal.dot(point) < face.distance)
            && self
                .ellipsoid
                .is_none_or(|e| (e.to_unit * (point - e.center)).length_squared() < 1.0)
    }

    /// Where the line `origin + t direction` lies inside; `None` where it does not.
    ///
    /// Reference intersection, in plain arithmetic: each plane cuts a half-line off, the ellipsoid leaves a
    /// chord, and what all have in common is the answer.
    #[must_use]
    pub fn interval(&self, origin: DVec3, direction: DVec3) -> Option<Interval> {
        let none = SurfacePart::Ellipsoid;
        let (mut enter, mut leave) = ((f64::NEG_INFINITY, none), (f64::INFINITY, none));
        for (index, face) in self.faces.iter().enumerate() {
            let (above, slope) =
                (face.normal.dot(origin) - face.distance, face.normal.dot(direction));
            let at = (-above / slope, SurfacePart::Face(index));
            if slope < 0.0 && at.0 > enter.0 {
                enter = at;
            } else if slope > 0.0 && at.0 < leave.0 {
                leave = at;
            } else if slope == 0.0 && above > 0.0 {
                return None;
            }
        }
        if let Some(ellipsoid) = &self.ellipsoid {
            let [near, far] = ellipsoid.chord(origin, direction)?;
            if near > enter.0 {
                enter = (near, SurfacePart::Ellipsoid);
            }
            if far < leave.0 {
                leave = (far, SurfacePart::Ellipsoid);
            }
        }
        (enter.0 < leave.0).then_some(Interval {
            enter: enter.0,
            enter_part: enter.1,
            leave: leave.0,
            leave_part: leave.1,
        })
    }

    /// Outward unit normal at a point of a part of the surface.
    #[must_use]
    pub fn normal(&self, part: SurfacePart, point: DVec3) -> DVec3 {
        match (part, &self.ellipsoid) {
            (SurfacePart::Face(index), _) => self.faces[index].normal,
            (SurfacePart::Ellipsoid, Some(e)) => {
                (e.to_unit.transpose() * (e.to_unit * (point - e.center))).normalize()
            }
            (SurfacePart::Ellipsoid, None) => DVec3::ZERO,
        }
    }

    /// The body turned, then made larger about the origin, then moved.
    #[must_use]
    pub(super) fn placed(&self, rotation: DMat3, scale: f64, offset: DVec3) -> Self {
        let face = |face: &Face| {
            let normal = (rotation * face.normal).normalize();
            Face { normal, distance: face.distance * scale + normal.dot(offset) }
        };
        let ellipsoid = |e: &Ellipsoid| Ellipsoid {
            center: rotation * e.center * scale + offset,
            to_unit: e.to_unit * rotation.transpose() * (1.0 / scale),
        };
        Self {
            faces: self.faces.iter().map(face).collect(),
            ellipsoid: self.ellipsoid.as_ref().map(ellipsoid),
        }
    }

    /// Corners of each face in order around it, seen from outside counter-clockwise; none for a face that
    /// others hide. `size` is larger than any coordinate of the body.
    pub(super) fn polygons(&self, size: f64) -> Vec<Vec<DVec3>> {
        (0..self.faces.len()).map(|index| polygon(&self.faces, index, size)).collect()
    }

    /// Corners of the polyhedron that its faces bound; a corner may be told several times. None of a body without faces.
    #[must_use]
    pub fn corners(&self) -> Vec<DVec3> {
        let far = self.faces.iter().map(|face| face.distance.abs()).fold(1.0, f64::max);
        let mut corners: Vec<DVec3> = Vec::new();
        for corner in self.polygons(FARTHEST * far).into_iter().flatten() {
            if !corners.iter().any(|known| (*known - corner).length() < 1e-9 * far) {
                corners.push(corner);
            }
        }
        corners
    }

    /// The faces that show of a body without an ellipsoid; none where one rounds it.
    #[must_use]
    pub fn flat_faces(&self) -> Vec<FlatFace> {
        if self.ellipsoid.is_some() {
            return Vec::new();
        }
        let far = self.faces.iter().map(|face| face.distance.abs()).fold(1.0, f64::max);
        let corners = self.polygons(FARTHEST * far);
        let shown = self.faces.iter().zip(&corners).filter(|(_, corners)| !corners.is_empty());
        shown.map(|(face, corners)| FlatFace::of(face.normal, corners)).collect()
    }

    /// Distance of the farthest point from the origin, or somewhat more.
    pub(super) fn bounding_radius(&self, size: f64) -> f64 {
        let corners = self.polygons(size);
        let farthest = corners.iter().flatten().map(|corner| corner.length()).fold(0.0, f64::max);
        let of_faces = if corners.iter().any(|p| !p.is_empty()) { farthest } else { f64::INFINITY };
        let of_ellipsoid = self
            .ellipsoid
            .as_ref()
            .map_or(f64::INFINITY, |e| e.center.length() + longest(&e.to_unit.inverse()));
        of_faces.min(of_ellipsoid)
    }

    /// Volume and surface. The origin must lie inside. Exact (to rounding) for polyhedra; where an
    /// ellipsoid rounds the body, summed over the directions of fine triangles, to about 1e-4.
    pub(super) fn measure(&self, size: f64) -> Measure {
        let seen: Vec<Face> = match &self.ellipsoid {
            // Directions are dealt to the faces of a box around it too.
            Some(e) => self.faces.iter().copied().chain(e.box_around(size)).collect(),
            None => self.faces.clone(),
        };
        let far = seen.iter().map(|face| face.distance).fold(size, f64::max);
        let mut sum = Measure { volume: 0.0, surface_area: 0.0, moment: DVec3::ZERO };
        for (index, face) in seen.iter().enumerate() {
            let corners = polygon(&seen, index, 2.0 * far);
            for pair in corners.windows(2).skip(1) {
                self.add_triangle(face, [corners[0], pair[0], pair[1]], &mut sum);
            }
        }
        sum
    }

    /// Adds the part of the body that is seen from the origin through a triangle of a face.
    fn add_triangle(&self, face: &Face, [a, b, c]: [DVec3; 3], sum: &mut Measure) {
        let fine = if self.ellipsoid.is_some() { FINENESS } else { 1 };
        let n = f64::from(fine);
        let (u, v) = ((b - a) / n, (c - a) / n);
        let area = 0.5 * u.cross(v).length();
        for i in 0..fine {
            for j in 0..fine - i {
                let corner = a + u * f64::from(i) + v * f64::from(j);
                self.add_direction(face, corner + (u + v) / 3.0, area, sum);
                if i + j + 1 < fine {
                    self.add_direction(face, corner + (u + v) * (2.0 / 3.0), area, sum);
                }
            }
        }
    }

    /// Adds what is seen through a small piece of a face around `point`.
    fn add_direction(&self, face: &Face, point: DVec3, area: f64, sum: &mut Measure) {
        let length = point.length();
        let direction = point / length;
        let solid_angle = area * face.distance / (length * length * length);
        let ellipsoid = self.ellipsoid.as_ref();
        let chord = ellipsoid.and_then(|e| e.chord(DVec3::ZERO, direction));
        let (reach, surface) = match chord {
            Some([_, far]) if far < length => {
                let normal = self.normal(SurfacePart::Ellipsoid, direction * far);
                (far, solid_angle * far * far / normal.dot(direction))
            }
            _ => (length, area),
        };
        let volume = solid_angle * reach * reach * reach / 3.0;
        sum.volume += volume;
        sum.surface_area += surface;
        sum.moment += direction * (0.75 * reach * volume);
    }
}

impl FlatFace {
    pub(super) fn of(normal: DVec3, corners: &[DVec3]) -> Self {
        let (mut area, mut moment) = (0.0, DVec3::ZERO);
        for pair in corners.windows(2).skip(1) {
            let [a, b, c] = [corners[0], pair[0], pair[1]];
            let part = 0.5 * (b - a).cross(c - a).length();
            area += part;
            moment += (a + b + c) * (part / 3.0);
        }
        Self { normal, centroid: moment / area, area }
    }
}

impl Ellipsoid {
    /// Where a line lies inside, told from the foot of the perpendicular, so that nothing cancels far from it.
    #[must_use]
    pub fn chord(&self, origin: DVec3, direction: DVec3) -> Option<[f64; 2]> {
        let (o, d) = (self.to_unit * (origin - self.center), self.to_unit * direction);
        let squared = d.length_squared();
        let middle = -o.dot(d) / squared;
        let inside = (1.0 - (o + d * middle).length_squared()) / squared;
        (inside > 0.0).then(|| {
            let half = inside.sqrt();
            [middle - half, middle + half]
        })
    }

    /// Faces around all that is nearer than `size`: a cube where the ellipsoid is the unit sphere.
    fn box_around(&self, size: f64) -> [Face; 6] {
        let rows = self.to_unit.transpose();
        let rows = [rows.x_axis, rows.y_axis, rows.z_axis];
        let reach = size * rows.iter().map(|row| row.length()).fold(0.0, f64::max);
        std::array::from_fn(|index| {
            let row = rows[index / 2] * if index % 2 == 0 { 1.0 } else { -1.0 };
            Face { normal: row.normalize(), distance: reach / row.length() }
        })
    }
}

/// The largest of the semi-axes that a matrix makes of the unit sphere, or somewhat more.
fn longest(matrix: &DMat3) -> f64 {
    // Of a diagonal matrix the largest entry; else the Frobenius norm bounds it.
    let rows = [matrix.x_axis, matrix.y_axis, matrix.z_axis];
    let off: f64 = (0..3).map(|i| rows[i].length_squared() - rows[i][i] * rows[i][i]).sum();
    if off == 0.0 {
        return (0..3).map(|i| rows[i][i].abs()).fold(0.0, f64::max);
    }
    rows.iter().map(|row| row.length_squared()).sum::<f64>().sqrt()
}

/// What the other planes leave of a plane.
fn polygon(faces: &[Face], index: usize, size: f64) -> Vec<DVec3> {
    let Face { normal, distance } = faces[index];
    let (s, t) = snowgrain_math::frame::tangents(normal);
    let (middle, far) = (normal * distance, 4.0 * size);
    let mut corners = vec![
        middle + (s + t) * far,
        middle + (t - s) * far,
        middle - (s + t) * far,
        middle + (s - t) * far,
    ];
    for (other, face) in faces.iter().enumerate() {
        let is_same = other != index && face.normal.dot(normal) > 1.0 - SAME_POINT;
        if other == index || (is_same && other > index) {
            continue;
        }
        corners = clipped(&corners, face);
        if corners.len() < 3 {
            return Vec::new();
        }
    }
    let near = |a: DVec3, b: DVec3| (a - b).length() < size * SAME_POINT;
    corners.dedup_by(|a, b| near(*a, *b));
    if corners.len() > 1 && near(corners[0], corners[corners.len() - 1]) {
        corners.pop();
    }
    if corners.len() < 3 { Vec::new() } else { corners }
}

/// The part of a convex polygon behind a plane (Sutherland and Hodgman 1974).
pub(super) fn clipped(corners: &[DVec3], face: &Face) -> Vec<DVec3> {
    let above = |p: DVec3| face.normal.dot(p) - face.distance;
    let mut kept = Vec::with_capacity(corners.len() + 1);
    for (index, &from) in corners.iter().enumerate() {
        let to = corners[(index + 1) % corners.len()];
        let (start, end) = (above(from), above(to));
        if start <= 0.0 {
            kept.push(from);
        }
        if (start < 0.0 && end > 0.0) || (start > 0.0 && end < 0.0) {
            kept.push(from + (to - from) * (start / (start - end)));
        }
    }
    kept
}
