//! A sphere that falls straight down onto a triangle.

use super::SphereContact;
use super::triangle::Triangle;
use snowgrain_math::DVec3;

/// A point touched and the unit normal from it towards the centre of what touches.
#[derive(Clone, Copy, Debug)]
pub(super) struct Touch {
    pub(super) point: DVec3,
    pub(super) normal: DVec3,
}

/// A sphere falling along a vertical line. Metres.
#[derive(Clone, Copy, Debug)]
pub(super) struct Drop {
    pub(super) x: f64,
    pub(super) z: f64,
    /// Radius, > 0.
    pub(super) radius: f64,
    /// Height of the centre at the start.
    pub(super) start_y: f64,
    /// Contacts at or below this height of the centre do not count, and need not be found.
    pub(super) down_to: f64,
}

impl Drop {
    pub(super) fn center(&self, y: f64) -> DVec3 {
        DVec3::new(self.x, y, self.z)
    }

    pub(super) fn start(&self) -> DVec3 {
        self.center(self.start_y)
    }

    /// Height of the centre below which nothing matters once `first` is known.
    pub(super) fn floor(&self, first: Option<&SphereContact>) -> f64 {
        first.map_or(self.down_to, |held| held.center_y.max(self.down_to))
    }
}

impl Triangle {
    /// Whether a sphere whose centre stays above `least_y` clearly falls past.
    pub(super) fn is_beside(&self, drop: &Drop, least_y: f64) -> bool {
        let [a, b, c] = self.corners;
        let (min, max) = (a.min(b).min(c), a.max(b).max(c));
        drop.x - max.x > drop.radius
            || min.x - drop.x > drop.radius
            || drop.z - max.z > drop.radius
            || min.z - drop.z > drop.radius
            || least_y - max.y > drop.radius
    }

    /// Height of the centre at the first contact, and what is touched.
    ///
    /// The centres at which the sphere overlaps the triangle are the triangle grown by the radius:
    /// a convex body, whose top over the line is the highest of the tops of its parts (a plate over
    /// the face, a cylinder around each edge, a ball around each vertex). A start above the top
    /// falls to it, a start inside overlaps, a start below never meets it.
    pub(super) fn drop_sphere(&self, drop: &Drop) -> Option<(f64, Touch)> {
        let top = self.highest_contact(drop)?;
        if top.0 <= drop.start_y {
            return Some(top);
        }
        let (touch, distance) = self.touch(drop.start());
        (distance <= drop.radius).then_some((drop.start_y, touch))
    }

    /// The highest position of the falling sphere's centre at which it touches.
    fn highest_contact(&self, drop: &Drop) -> Option<(f64, Touch)> {
        let [a, b, c] = self.corners;
        let face = self.face_contact(drop);
        let parts = [
            edge_contact(a, b, drop),
            edge_contact(b, c, drop),
            edge_contact(c, a, drop),
            vertex_contact(a, drop),
            vertex_contact(b, drop),
            vertex_contact(c, drop),
        ];
        let mut best: Option<(f64, DVec3)> = None;
        for part in parts.into_iter().flatten() {
            if best.is_none_or(|(y, _)| part.0 > y) {
                best = Some(part);
            }
        }
        match (face, best) {
            (Some(face), best) if best.is_none_or(|(y, _)| face.0 >= y) => Some(face),
            (_, best) => best.map(|(y, point)| {
                let normal = (drop.center(y) - point).normalize();
                (y, Touch { point, normal })
            }),
        }
    }

    fn face_contact(&self, drop: &Drop) -> Option<(f64, Touch)> {
        let winding = self.normal();
        let normal = if winding.y < 0.0 { -winding } else { winding };
        if normal.y <= 0.0 {
            return None;
        }
        let [a, b, c] = self.corners;
        let y =
            a.y + (drop.radius - normal.x * (drop.x - a.x) - normal.z * (drop.z - a.z)) / normal.y;
        let point = drop.center(y) - normal * drop.radius;
        let inside = [(a, b), (b, c), (c, a)]
            .iter()
            .all(|&(from, to)| winding.cross(to - from).dot(point - from) >= 0.0);
        inside.then_some((y, Touch { point, normal }))
    }
}

/// Top of the cylinder of the sphere's radius around the edge, and the point touched there.
fn edge_contact(from: DVec3, to: DVec3, drop: &Drop) -> Option<(f64, DVec3)> {
    let edge = to - from;
    let (dx, dz) = (drop.x - from.x, drop.z - from.z);
    let flat = edge.x * edge.x + edge.z * edge.z;
    let across = dx * edge.z - dz * edge.x;
    let inside = flat * drop.radius * drop.radius - across * across;
    if flat <= 0.0 || inside < 0.0 {
        return None;
    }
    let length_squared = edge.length_squared();
    let along = dx * edge.x + dz * edge.z;
    let rise = (along * edge.y + (length_squared * inside).sqrt()) / flat;
    let s = (along + rise * edge.y) / length_squared;
    (0.0..=1.0).contains(&s).then(|| (from.y + rise, from + edge * s))
}

/// Top of the ball of the sphere's radius around the vertex, and the vertex.
fn vertex_contact(vertex: DVec3, drop: &Drop) -> Option<(f64, DVec3)> {
    let (dx, dz) = (drop.x - vertex.x, drop.z - vertex.z);
    let squared = drop.radius * drop.radius - dx * dx - dz * dz;
    (squared >= 0.0).then(|| (vertex.y + squared.sqrt(), vertex))
}
