//! A ray and one convex body, in the body's own space and in radii.
//!
//! A ray that stands on a part of the surface is kept from meeting that part by identity: no distance of 0
//! has to be told from one of 1e-16.

use crate::grain_grid::{Part, Planes};
use snowgrain_geometry::shape::Ellipsoid;
use snowgrain_math::DVec3;

/// The ellipsoid, where other numbers are those of planes.
pub(super) const ELLIPSOID: u16 = u16::MAX;
/// No part of a surface: the ray begins inside.
pub(super) const NOWHERE: u16 = u16::MAX - 1;

/// A ray in a prototype's space.
#[derive(Clone, Copy, Debug)]
pub(super) struct LocalRay {
    pub(super) origin: DVec3,
    /// Of unit length, so that distances are in radii.
    pub(super) direction: DVec3,
}

/// How far a ray is above each of eight planes, and how fast it rises.
#[derive(Clone, Copy)]
struct Heights {
    above: [f64; 8],
    slope: [f64; 8],
}

impl Heights {
    #[inline(always)]
    fn of(planes: &Planes, ray: &LocalRay) -> Self {
        let (o, d) = (ray.origin, ray.direction);
        let (mut above, mut slope) = ([0.0; 8], [0.0; 8]);
        for i in 0..8 {
            let (x, y, z) = (planes.x[i], planes.y[i], planes.z[i]);
            above[i] = x * o.x + y * o.y + z * o.z - planes.distance[i];
            slope[i] = x * d.x + y * d.y + z * d.z;
        }
        Self { above, slope }
    }

    /// Where each plane is crossed.
    #[inline(always)]
    fn crossings(&self) -> [f64; 8] {
        std::array::from_fn(|i| -self.above[i] / self.slope[i])
    }
}

#[inline(always)]
fn greater(a: f64, b: f64) -> f64 {
    if a > b { a } else { b }
}

#[inline(always)]
fn lesser(a: f64, b: f64) -> f64 {
    if a < b { a } else { b }
}

#[inline(always)]
fn reduced(values: [f64; 8], better: impl Fn(f64, f64) -> f64) -> f64 {
    let mut four = [0.0; 4];
    for i in 0..4 {
        four[i] = better(values[i], values[i + 4]);
    }
    better(better(four[0], four[2]), better(four[1], four[3]))
}

/// Where the line lies within the body: one interval decides entering and leaving. A line within a plane lies
/// behind it where it is not above.
#[inline(always)]
pub(super) fn interval(part: &Part, ray: &LocalRay) -> Option<[f64; 2]> {
    let (mut enter, mut leave) = (f64::NEG_INFINITY, f64::INFINITY);
    for planes in &part.planes {
        let heights = Heights::of(planes, ray);
        let at = heights.crossings();
        let (mut enters, mut leaves) = ([0.0; 8], [0.0; 8]);
        for i in 0..8 {
            let (slope, above) = (heights.slope[i], heights.above[i]);
            let missed = if above > 0.0 { f64::NEG_INFINITY } else { f64::INFINITY };
            enters[i] = if slope < 0.0 { at[i] } else { f64::NEG_INFINITY };
            leaves[i] = if slope > 0.0 {
                at[i]
            } else if slope < 0.0 {
                f64::INFINITY
            } else {
                missed
            };
        }
        enter = greater(enter, reduced(enters, greater));
        leave = lesser(leave, reduced(leaves, lesser));
    }
    if enter >= leave {
        return None;
    }
    if let Some(ellipsoid) = &part.ellipsoid {
        let Chord { middle, half } = Chord::of(ellipsoid, ray)?;
        enter = greater(enter, middle - half);
        leave = lesser(leave, middle + half);
    }
    (enter < leave).then_some([enter, leave])
}

/// Whether a path in air, `travelled` far on its line, is to meet a body that the line is in from `enter` to `leave`. One
/// that stands on ice is in other ice by rounding alone, as where faces of two grains lie in one plane: it enters there, or
/// has just left both. Met in the latter case, the two would pass it to and fro for ever.
#[inline(always)]
pub(super) fn is_met([enter, leave]: [f64; 2], travelled: f64, stands_on_ice: bool) -> bool {
    let last = if stands_on_ice { 0.5 * (enter + leave) } else { leave };
    last > travelled
}

/// Whether a point may lie in the body, as its interval would say: it does not where it is farther outside than
/// any rounding takes it, 1e-6 radii.
#[inline(always)]
pub(super) fn may_hold(part: &Part, point: DVec3) -> bool {
    const ROUNDING: f64 = 1e-6;
    for planes in &part.planes {
        let mut above = [0.0; 8];
        for (i, above) in above.iter_mut().enumerate() {
            let height = planes.x[i] * point.x + planes.y[i] * point.y + planes.z[i] * point.z;
            *above = height - planes.distance[i];
        }
        if reduced(above, greater) > ROUNDING {
            return false;
        }
    }
    part.ellipsoid
        .as_ref()
        .is_none_or(|e| (e.to_unit * (point - e.center)).length_squared() < 1.0 + 100.0 * ROUNDING)
}

/// The part of the surface at which the line enters the body, at `enter` of [`interval`].
#[inline(always)]
pub(super) fn entered(part: &Part, ray: &LocalRay, enter: f64) -> u16 {
    for (octet, planes) in part.planes.iter().enumerate() {
        let heights = Heights::of(planes, ray);
        let at = heights.crossings();
        for (i, at) in at.into_iter().enumerate() {
            if heights.slope[i] < 0.0 && at == enter {
                return (8 * octet + i) as u16;
            }
        }
    }
    ELLIPSOID
}

/// Where a ray inside, that stands on the part `on` of the surface, leaves, and through which part.
#[inline(always)]
pub(super) fn left(part: &Part, ray: &LocalRay, on: u16) -> (f64, u16) {
    let mut best = (f64::INFINITY, NOWHERE);
    for (octet, planes) in part.planes.iter().enumerate() {
        let heights = Heights::of(planes, ray);
        let mut at = heights.crossings();
        for (at, slope) in at.iter_mut().zip(heights.slope) {
            *at = if slope > 0.0 { *at } else { f64::INFINITY };
        }
        let standing = usize::from(on).wrapping_sub(8 * octet);
        if let Some(at) = at.get_mut(standing) {
            *at = f64::INFINITY;
        }
        let least = reduced(at, lesser);
        if least < best.0 {
            let first = at.iter().position(|&at| at == least).unwrap_or(0);
            best = (least, (8 * octet + first) as u16);
        }
    }
    if let Some(ellipsoid) = &part.ellipsoid {
        let far = match Chord::of(ellipsoid, ray) {
            // From one end of its chord to the other.
            Some(chord) if on == ELLIPSOID => 2.0 * chord.middle,
            Some(chord) => chord.middle + chord.half,
            None => Chord::middle_of(ellipsoid, ray),
        };
        if far < best.0 {
            best = (far, ELLIPSOID);
        }
    }
    (greater(best.0, 0.0), best.1)
}

/// Outward unit normal at a point of the part `on` of the surface.
#[inline(always)]
pub(super) fn normal(part: &Part, on: u16, point: DVec3) -> DVec3 {
    match &part.ellipsoid {
        Some(ellipsoid) if on == ELLIPSOID => {
            let m = &ellipsoid.to_unit;
            let gradient = m.transpose() * (*m * (point - ellipsoid.center));
            // The square root of `normalize` is no vector instruction, which among such costs hundreds of cycles.
            gradient * (1.0 / gradient.dot(gradient).sqrt())
        }
        _ => {
            let planes = &part.planes[usize::from(on) / 8];
            let i = usize::from(on) % 8;
            DVec3::new(planes.x[i], planes.y[i], planes.z[i])
        }
    }
}

/// What of a line lies within an ellipsoid.
struct Chord {
    middle: f64,
    half: f64,
}

impl Chord {
    #[inline(always)]
    fn of(ellipsoid: &Ellipsoid, ray: &LocalRay) -> Option<Self> {
        let o = ellipsoid.to_unit * (ray.origin - ellipsoid.center);
        let d = ellipsoid.to_unit * ray.direction;
        let inverse = 1.0 / d.dot(d);
        let middle = -o.dot(d) * inverse;
        let foot = o + d * middle;
        let inside = (1.0 - foot.dot(foot)) * inverse;
        (inside > 0.0).then(|| Self { middle, half: inside.sqrt() })
    }

    #[inline(always)]
    fn middle_of(ellipsoid: &Ellipsoid, ray: &LocalRay) -> f64 {
        let o = ellipsoid.to_unit * (ray.origin - ellipsoid.center);
        let d = ellipsoid.to_unit * ray.direction;
        -o.dot(d) / d.dot(d)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::grain_grid::Prototype;
    use snowgrain_geometry::shape::SurfacePart;
    use snowgrain_geometry::{Shape, ShapeKind};
    use snowgrain_math::sampler::{PathKey, numbers};

    /// The kernel and the reference intersection of `snowgrain-geometry`, to rounding.
    #[test]
    fn intervals_and_parts_are_those_of_the_reference() {
        for kind in [
            ShapeKind::Cube { rounding: 0.4 },
            ShapeKind::HexagonalPrism { aspect: 0.2, rounding: 0.0 },
            ShapeKind::HexagonalPrism { aspect: 2.0, rounding: 0.6 },
            ShapeKind::RandomPolyhedron { faces: 20, seed: 1, rounding: 0.0 },
            ShapeKind::Spheroid { aspect: 3.0 },
        ] {
            let shape = Shape::new(kind).expect("the shape is legal");
            let (body, prototype) = (&shape.parts()[0], Prototype::new(&shape));
            let part = &prototype.parts[0];
            for index in 0..3000 {
                let vector = |event| {
                    DVec3::from_array(numbers(PathKey::new(1, index, 0), event).map(f64::from))
                        - 0.5
                };
                let ray = LocalRay { origin: vector(0) * 6.0, direction: vector(1).normalize() };
                let expected = body.interval(ray.origin, ray.direction);
                let found = interval(part, &ray);
                assert_eq!(found.is_some(), expected.is_some());
                let (Some([enter, leave]), Some(expected)) = (found, expected) else { continue };
                assert!((enter - expected.enter).abs() < 1e-12);
                assert!((leave - expected.leave).abs() < 1e-12);
                let number = |part| match part {
                    SurfacePart::Face(index) => index as u16,
                    SurfacePart::Ellipsoid => ELLIPSOID,
                };
                let on = entered(part, &ray, enter);
                assert_eq!(on, number(expected.enter_part));
                let inside = LocalRay { origin: ray.origin + ray.direction * enter, ..ray };
                let (far, through) = left(part, &inside, on);
                assert_eq!(through, number(expected.leave_part));
                assert!((enter + far - expected.leave).abs() < 1e-11);
                let end = ray.origin + ray.direction * leave;
                let normals = (normal(part, through, end), body.normal(expected.leave_part, end));
                assert!((normals.0 - normals.1).length() < 1e-12);
            }
        }
    }
}
