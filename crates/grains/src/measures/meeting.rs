//! Whether two bodies have a point in common.
//!
//! A convex body is what lies behind some planes and within an ellipsoid, so two of them meet where all of those
//! leave something. A plane or a direction that keeps them apart is looked for first; what is left is decided by
//! projecting a point onto one after another (Bregman 1965, "The method of successive projection for finding a
//! common point of convex sets"), which comes to a common point if there is one.

use super::bodies::{Body, Prototype};
use snowgrain_geometry::shape::ConvexBody;
use snowgrain_math::{DMat3, DVec3};

/// Most rounds of projections, and how often it is looked whether they still come nearer: bodies that are apart end
/// in a circle. Those that overlap by less than about a hundredth of their radius may be taken for such.
const ROUNDS: u32 = 512;
const LOOK: u32 = 16;
const NEARER: f64 = 0.98;
/// Distance from all that bounds them, in radii, at which a point counts as common.
const NEAR: f64 = 1e-6;

/// What bounds two bodies, relative to the centre of the first.
struct Bounds {
    /// Outward normals and distances.
    planes: Vec<(DVec3, f64)>,
    /// Centres, and what makes them unit spheres.
    ellipsoids: Vec<(DVec3, DMat3)>,
}

/// Whether two grains have a point in common once the surface of each is moved out by `slack`, which is small beside
/// them.
pub(crate) fn meet(one: &Body<'_>, other: &Body<'_>, slack: f64) -> bool {
    if one.shape.is_none() && other.shape.is_none() {
        let widest = one.radius + other.radius + 2.0 * slack;
        return (one.center - other.center).length_squared() <= widest * widest;
    }
    let origin = one.center;
    each_part(one, |a| each_part(other, |b| parts_meet((one, a), (other, b), origin, slack)))
}

/// Whether any part of a body, `None` for a sphere, is such.
fn each_part<'a>(body: &Body<'a>, mut is: impl FnMut(Convex<'a>) -> bool) -> bool {
    match body.shape {
        None => is(None),
        Some((Prototype { shape, corners }, _)) => {
            shape.parts().iter().zip(corners).any(|part| is(Some(part)))
        }
    }
}

/// A convex part of a shape, and its corners; `None` for a sphere.
type Convex<'a> = Option<(&'a ConvexBody, &'a Vec<DVec3>)>;
type Part<'a, 'b> = (&'a Body<'b>, Convex<'b>);

fn parts_meet(one: Part<'_, '_>, other: Part<'_, '_>, origin: DVec3, slack: f64) -> bool {
    let mut bounds = Bounds { planes: Vec::new(), ellipsoids: Vec::new() };
    bounds.add(one, origin, slack);
    let own = bounds.planes.len();
    bounds.add(other, origin, slack);
    let (of_one, of_other) = bounds.planes.split_at(own);
    // What lies wholly beyond a plane of the other, or beyond a plane across the line of centres.
    let apart = |of: &[(DVec3, f64)], from: Part<'_, '_>| {
        of.iter().any(|(normal, distance)| -reach(from, origin, -*normal) - slack > *distance)
    };
    let across = (other.0.center - one.0.center).normalize_or_zero();
    if apart(of_one, other)
        || apart(of_other, one)
        || reach(one, origin, across) + reach(other, origin, -across) + 2.0 * slack < 0.0
    {
        return false;
    }
    bounds.have_a_common_point(0.5 * (other.0.center - one.0.center), one.0.radius)
}

/// How far a part reaches along a direction from `origin`, or somewhat less far than that bound.
fn reach((body, part): Part<'_, '_>, origin: DVec3, direction: DVec3) -> f64 {
    let center = (body.center - origin).dot(direction);
    let (Some((part, corners)), Some((_, turn))) = (part, body.shape) else {
        return center + body.radius;
    };
    let own = turn.transpose() * direction;
    let of_ellipsoid = part.ellipsoid.as_ref().map_or(f64::INFINITY, |e| {
        e.center.dot(own) + (e.to_unit.inverse().transpose() * own).length()
    });
    let of_corners = corners.iter().map(|corner| corner.dot(own)).fold(f64::NEG_INFINITY, f64::max);
    let of_corners = if corners.is_empty() { f64::INFINITY } else { of_corners };
    center + body.radius * of_ellipsoid.min(of_corners)
}

impl Bounds {
    fn add(&mut self, (body, part): Part<'_, '_>, origin: DVec3, slack: f64) {
        let center = body.center - origin;
        let larger = 1.0 + slack / body.radius;
        let (Some((part, _)), Some((_, turn))) = (part, body.shape) else {
            let unit = DMat3::IDENTITY * (1.0 / (body.radius * larger));
            return self.ellipsoids.push((center, unit));
        };
        for face in &part.faces {
            let normal = turn * face.normal;
            self.planes.push((normal, normal.dot(center) + body.radius * face.distance + slack));
        }
        if let Some(e) = &part.ellipsoid {
            let unit = e.to_unit * turn.transpose() * (1.0 / (body.radius * larger));
            self.ellipsoids.push((center + turn * e.center * body.radius, unit));
        }
    }

    /// Projects `point` onto one bound after another until all hold it; `scale` is the size of the bodies.
    fn have_a_common_point(&self, mut point: DVec3, scale: f64) -> bool {
        let near = NEAR * scale;
        let mut before = f64::INFINITY;
        for round in 0..ROUNDS {
            let mut farthest = 0.0f64;
            for (normal, distance) in &self.planes {
                let above = normal.dot(point) - distance;
                if above > near {
                    point -= *normal * above;
                    farthest = farthest.max(above);
                }
            }
            for (center, to_unit) in &self.ellipsoids {
                let at = *to_unit * (point - *center);
                let beyond = at.length_squared() - 1.0;
                if beyond > NEAR {
                    // Towards the tangent plane of the level of the squared distance: never past the body.
                    let slope = to_unit.transpose() * at * 2.0;
                    let step = slope * (beyond / slope.length_squared());
                    point -= step;
                    farthest = farthest.max(step.length());
                }
            }
            if farthest <= near {
                return true;
            }
            if round % LOOK == 0 {
                if farthest > NEARER * before {
                    return false;
                }
                before = farthest;
            }
        }
        false
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use snowgrain_geometry::{GrainShape, Shape, ShapeKind};
    use snowgrain_math::sampler::{PathKey, numbers};

    fn shape(kind: ShapeKind) -> Shape {
        Shape::new(kind).unwrap()
    }

    /// Edge of the cube with the volume of the unit ball.
    fn edge() -> f64 {
        snowgrain_math::trig::cbrt(4.0 / 3.0 * core::f64::consts::PI)
    }

    #[test]
    fn upright_cubes_meet_where_their_sides_say() {
        let cube = Prototype::new(&shape(ShapeKind::Cube { rounding: 0.0 }));
        let body = |center, radius| Body { center, radius, shape: Some((&cube, DMat3::IDENTITY)) };
        let (mut met, mut apart) = (0, 0);
        for index in 0..2000 {
            let at = numbers(PathKey::new(1, index, 0), 0).map(|u| 3.4 * f64::from(u) - 1.7);
            // Edges of 1 and 1.5 times that of the unit cube.
            let gap =
                at.iter().map(|part| part.abs()).fold(0.0, f64::max) * 2.0 - 2.5 * edge() * 0.5;
            if gap.abs() < 5e-3 {
                continue;
            }
            let one = body(DVec3::ONE, 0.5);
            let other = body(DVec3::ONE + DVec3::from_array(at), 0.75);
            assert_eq!(meet(&one, &other, 0.0), gap < 0.0, "{at:?}");
            assert_eq!(meet(&other, &one, 0.0), gap < 0.0, "{at:?}");
            (met, apart) = if gap < 0.0 { (met + 1, apart) } else { (met, apart + 1) };
        }
        assert!(met > 200 && apart > 200, "{met} {apart}");
    }

    /// Turned plates, columns, rounded polyhedra and spheroids meet where lines have a stretch in both.
    #[test]
    fn bodies_meet_where_lines_have_a_stretch_in_both() {
        let shapes = [
            shape(ShapeKind::HexagonalPrism { aspect: 0.1, rounding: 0.0 }),
            shape(ShapeKind::HexagonalPrism { aspect: 3.0, rounding: 0.0 }),
            shape(ShapeKind::RandomPolyhedron { faces: 14, seed: 1, rounding: 0.7 }),
            shape(ShapeKind::Spheroid { aspect: 0.5 }),
            shape(ShapeKind::Rosette { arms: 4, aspect: 3.0, rounding: 0.0 }),
        ];
        let shapes = shapes.map(|shape| Prototype::new(&shape));
        let mut met = [0; 2];
        for index in 0..400 {
            let key = PathKey::new(2, index, 0);
            let random = |event| numbers(key, event).map(|u| 2.0 * f64::from(u) - 1.0);
            let body = |which: u64, center, event| {
                let [a, b, c] = random(event);
                let turn = GrainShape::new(0, [a, b, c, 0.3]).rotation();
                Body { center, radius: 1.0, shape: Some((&shapes[(which % 5) as usize], turn)) }
            };
            let one = body(index, DVec3::ZERO, 1);
            let other = body(index / 5, DVec3::from_array(random(0)) * 3.0, 2);
            let found = meet(&one, &other, 0.0);
            // A line near both has some length in what they have in common.
            let common = (0..600).any(|line| {
                let [x, y, z] = numbers(PathKey::new(3, index, line), 0).map(f64::from);
                let spread = DVec3::new(x, y, z) * 2.0 - DVec3::ONE;
                let aim = other.center * 0.5 + spread;
                let along = DVec3::from_array(random(4 + line as u32)).normalize();
                let stretches = other.stretches(aim, along);
                one.stretches(aim, along)
                    .iter()
                    .any(|a| stretches.iter().any(|b| a[1].min(b[1]) - a[0].max(b[0]) > 0.03))
            });
            assert!(found || !common, "{index}: lines found what they have in common");
            // Lines miss what is thin; moved apart by a part of their radius, they are surely apart where none was.
            if found && !common {
                assert!(!meet(&one, &other, -0.1), "{index}");
            }
            met[usize::from(found)] += 1;
        }
        assert!(met[0] > 50 && met[1] > 50, "{met:?}");
    }
}
