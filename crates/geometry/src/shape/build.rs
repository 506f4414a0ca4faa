//! From the numbers of a kind to its convex bodies.

use super::convex::{ConvexBody, Ellipsoid, Face};
use super::measure::{self, Measured};
use super::{Shape, ShapeKind};
use crate::GeometryError;
use snowgrain_math::sampler::{PathKey, numbers};
use snowgrain_math::{DMat3, DVec3, frame, trig};

/// Least and largest ratio of the lengths of a shape.
const ASPECTS: [f64; 2] = [0.02, 50.0];
/// Faces of random polyhedra, arms of rosettes.
const FACES: [u32; 2] = [6, 32];
const ARMS: [u32; 2] = [2, 12];
/// Draws of directions after which random faces that close no body are given up.
const MOST_DRAWS: u64 = 1000;
/// Longest a random polyhedron may be, in distances of its faces.
const MOST_REACH: f64 = 2.5;

/// The convex bodies of a kind, of any size.
pub(super) fn parts(kind: ShapeKind) -> Result<Vec<ConvexBody>, GeometryError> {
    Ok(vec![match kind {
        ShapeKind::Sphere => spheroid(1.0),
        ShapeKind::Spheroid { aspect } => {
            check("aspect", aspect, ASPECTS)?;
            spheroid(aspect)
        }
        ShapeKind::Cube { rounding } => rounded(cube(), DVec3::ONE, rounding)?,
        ShapeKind::HexagonalPrism { aspect, rounding } => hexagonal_prism(aspect, rounding)?,
        ShapeKind::TruncatedOctahedron { rounding } => {
            rounded(truncated_octahedron(), DVec3::ONE, rounding)?
        }
        ShapeKind::RandomPolyhedron { faces, seed, rounding } => {
            check("faces", f64::from(faces), FACES.map(f64::from))?;
            rounded(random_polyhedron(faces, seed)?, DVec3::ONE, rounding)?
        }
        ShapeKind::Rosette { arms, aspect, rounding } => {
            check("arms", f64::from(arms), ARMS.map(f64::from))?;
            return rosette(arms, aspect, rounding);
        }
    }])
}

fn check(key: &'static str, value: f64, [least, most]: [f64; 2]) -> Result<(), GeometryError> {
    if (least..=most).contains(&value) {
        return Ok(());
    }
    Err(GeometryError::BadShape { key, reason: format!("{value} must be {least} to {most}") })
}

/// The prototype made of parts: as large as the unit ball.
pub(super) fn normalised(name: String, parts: Vec<ConvexBody>) -> Shape {
    let size = 2.0 * parts.iter().map(|part| part.bounding_radius(FAR)).fold(0.0, f64::max);
    let measured = measure::of_union(&parts, size);
    scaled(name, parts, &measured)
}

/// The same of parts whose union has these measures.
pub(super) fn scaled(name: String, parts: Vec<ConvexBody>, measured: &Measured) -> Shape {
    let Measured { volume, surface_area, mean_projected_area } = *measured;
    let scale = trig::cbrt(Shape::VOLUME / volume);
    let place = |part: &ConvexBody| part.placed(DMat3::IDENTITY, scale, DVec3::ZERO);
    let parts: Vec<ConvexBody> =
        if scale == 1.0 { parts } else { parts.iter().map(place).collect() };
    let bounding_radius = parts.iter().map(|part| part.bounding_radius(FAR)).fold(0.0, f64::max);
    Shape {
        name,
        parts,
        surface_area: surface_area * scale * scale,
        mean_projected_area: mean_projected_area * scale * scale,
        bounding_radius: bounding_radius * (1.0 + 1e-12),
    }
}

/// Farther than any point of a body.
const FAR: f64 = 1e3;

/// About y.
fn spheroid(aspect: f64) -> ConvexBody {
    // Of the volume of the unit ball.
    let across = trig::cbrt(1.0 / aspect);
    let along = across * aspect;
    let to_unit = DMat3::from_diagonal(DVec3::new(1.0 / across, 1.0 / along, 1.0 / across));
    ConvexBody { faces: Vec::new(), ellipsoid: Some(Ellipsoid { center: DVec3::ZERO, to_unit }) }
}

fn cube() -> Vec<Face> {
    [DVec3::X, DVec3::NEG_X, DVec3::Y, DVec3::NEG_Y, DVec3::Z, DVec3::NEG_Z]
        .map(|normal| Face { normal, distance: 1.0 })
        .to_vec()
}

/// Edge of the hexagon 1, so that it is 2 wide from corner to corner.
fn hexagonal_prism(aspect: f64, rounding: f64) -> Result<ConvexBody, GeometryError> {
    check("aspect", aspect, ASPECTS)?;
    let apothem = 0.75f64.sqrt();
    let mut faces = vec![
        Face { normal: DVec3::Y, distance: aspect },
        Face { normal: DVec3::NEG_Y, distance: aspect },
    ];
    // Exact signs and zeros, and opposite normals that are exactly opposite.
    for (x, z) in [(apothem, 0.5), (0.0, 1.0), (-apothem, 0.5)] {
        let normal = DVec3::new(x, 0.0, z);
        faces.push(Face { normal, distance: apothem });
        faces.push(Face { normal: -normal, distance: apothem });
    }
    rounded(faces, DVec3::new(apothem, aspect, apothem), rounding)
}

fn truncated_octahedron() -> Vec<Face> {
    let mut faces = cube();
    faces.iter_mut().for_each(|face| face.distance = 2.0);
    let third = (1.0f64 / 3.0).sqrt();
    for signs in 0..8u32 {
        let sign = |bit: u32| if signs >> bit & 1 == 0 { third } else { -third };
        let normal = DVec3::new(sign(0), sign(1), sign(2));
        faces.push(Face { normal, distance: 3.0 * third });
    }
    faces
}

/// The first set of random directions, mutually repelling a little as the best of some candidates, whose
/// planes close a body that is not too long.
fn random_polyhedron(count: u32, seed: u64) -> Result<Vec<Face>, GeometryError> {
    for draw in 0..MOST_DRAWS {
        let key = PathKey::new(seed, 0x5f4e, draw);
        let mut normals: Vec<DVec3> = Vec::new();
        for index in 0..count {
            let nearest =
                |normal: DVec3| normals.iter().map(|n| n.dot(normal)).fold(-1.0, f64::max);
            let candidate = |trial: u32| on_sphere(numbers(key, 4 * index + trial));
            let best = (1..4).map(candidate).fold(candidate(0), |best, other| {
                if nearest(other) < nearest(best) { other } else { best }
            });
            normals.push(best);
        }
        let faces: Vec<Face> =
            normals.into_iter().map(|normal| Face { normal, distance: 1.0 }).collect();
        let body = ConvexBody { faces, ellipsoid: None };
        if body.bounding_radius(FAR) < MOST_REACH {
            return Ok(centred(body)?.faces);
        }
    }
    let reason = format!("no body of {count} faces is closed by them; use more faces");
    Err(GeometryError::BadShape { key: "faces", reason })
}

fn on_sphere([u, v, _]: [f32; 3]) -> DVec3 {
    let y = 1.0 - 2.0 * f64::from(u);
    let ring = (1.0 - y * y).max(0.0).sqrt();
    let (sin, cos) = trig::sin_cos(core::f64::consts::TAU * f64::from(v));
    DVec3::new(ring * cos, y, ring * sin).normalize()
}

/// The body with its centre of mass at the origin, which must lie inside.
///
/// # Errors
/// A body that is not closed.
pub(super) fn centred(body: ConvexBody) -> Result<ConvexBody, GeometryError> {
    let reach = body.bounding_radius(FAR);
    let inside = body.faces.iter().all(|face| face.distance > 0.0);
    if body.faces.len() < 4 || !inside || reach.is_nan() || reach > 0.5 * FAR {
        let reason = "its faces do not close a body around the origin".into();
        return Err(GeometryError::BadShape { key: "faces", reason });
    }
    let measure = body.measure(2.0 * reach);
    let center = measure.moment / measure.volume;
    Ok(body.placed(DMat3::IDENTITY, 1.0, -center))
}

/// Columns from the origin, as evenly in all directions as few points on a sphere can be.
fn rosette(arms: u32, aspect: f64, rounding: f64) -> Result<Vec<ConvexBody>, GeometryError> {
    let column = hexagonal_prism(aspect, rounding)?;
    let body = |direction: DVec3| {
        let (s, t) = frame::tangents(direction);
        // From the prototype's y to the direction; its foot at the origin.
        let rotation = DMat3::from_cols(t, direction, s);
        column.placed(rotation, 1.0, direction * (0.95 * aspect))
    };
    Ok(directions(arms).into_iter().map(body).collect())
}

/// Directions of the arms: opposite, at the corners of the regular bodies, else on a spiral.
fn directions(arms: u32) -> Vec<DVec3> {
    let axes = [DVec3::X, DVec3::NEG_X, DVec3::Y, DVec3::NEG_Y, DVec3::Z, DVec3::NEG_Z];
    let third = (1.0f64 / 3.0).sqrt();
    let tetrahedron = [[1.0, 1.0, 1.0], [1.0, -1.0, -1.0], [-1.0, 1.0, -1.0], [-1.0, -1.0, 1.0]]
        .map(|corner| DVec3::from_array(corner) * third);
    match arms {
        2 => axes[..2].to_vec(),
        4 => tetrahedron.to_vec(),
        6 => axes.to_vec(),
        8 => tetrahedron.iter().flat_map(|&d| [d, -d]).collect(),
        _ => {
            let golden = core::f64::consts::PI * (3.0 - 5.0f64.sqrt());
            let at = |index: u32| {
                let y = 1.0 - (2.0 * f64::from(index) + 1.0) / f64::from(arms);
                let (sin, cos) = trig::sin_cos(golden * f64::from(index));
                let ring = (1.0 - y * y).sqrt();
                DVec3::new(ring * cos, y, ring * sin).normalize()
            };
            (0..arms).map(at).collect()
        }
    }
}

/// A polyhedron around the origin, cut by an ellipsoid with axes in the ratio of `axes`: from the one
/// through its farthest corner (sharp) to the largest within all faces.
fn rounded(faces: Vec<Face>, axes: DVec3, rounding: f64) -> Result<ConvexBody, GeometryError> {
    check("rounding", rounding, [0.0, 1.0])?;
    let mut body = ConvexBody { faces, ellipsoid: None };
    if rounding > 0.0 {
        let to_unit = DMat3::from_diagonal(axes.recip());
        let corners = body.polygons(FAR);
        let outer = corners.iter().flatten().map(|&c| (to_unit * c).length()).fold(0.0, f64::max);
        let reach = |face: &Face| face.distance / (axes * face.normal).length();
        let inner = body.faces.iter().map(reach).fold(f64::INFINITY, f64::min);
        let size = outer + (inner - outer) * rounding;
        let to_unit = to_unit * (1.0 / size);
        body.ellipsoid = Some(Ellipsoid { center: DVec3::ZERO, to_unit });
    }
    Ok(body)
}
