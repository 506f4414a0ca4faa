//! Volume, surface and shadow of a union of convex bodies.

use super::convex::{ConvexBody, Face, FlatFace, Interval, clipped};
use core::f64::consts::{PI, TAU};
use snowgrain_math::{DVec3, frame, trig};

/// Lines by which unions of several bodies are measured.
const LINES: u32 = 1 << 17;

pub(super) struct Measured {
    pub(super) volume: f64,
    pub(super) surface_area: f64,
    pub(super) mean_projected_area: f64,
}

/// Of the union, whose points are nearer to the origin than `size`.
pub(super) fn of_union(parts: &[ConvexBody], size: f64) -> Measured {
    match parts {
        [part] => {
            let measure = part.measure(size);
            Measured {
                volume: closed_volume(part).unwrap_or(measure.volume),
                surface_area: measure.surface_area,
                mean_projected_area: measure.surface_area / 4.0,
            }
        }
        parts => by_lines(parts, size),
    }
}

/// Area of the surface of a union of polyhedra that do not overlap: of all faces, less what pairs share, which lie on
/// planes with exactly opposite numbers.
pub(super) fn outer_area(parts: &[ConvexBody], size: f64) -> f64 {
    let area_of = |normal, corners: &[DVec3]| match corners.len() {
        0..3 => 0.0,
        _ => FlatFace::of(normal, corners).area,
    };
    let mut area = 0.0;
    for (index, part) in parts.iter().enumerate() {
        for (face, corners) in part.faces.iter().zip(part.polygons(size)) {
            area += area_of(face.normal, &corners);
            for other in parts.iter().enumerate().filter(|(at, _)| *at != index).map(|(_, o)| o) {
                let is_opposite =
                    |f: &&Face| f.normal == -face.normal && f.distance == -face.distance;
                let Some(opposite) = other.faces.iter().find(is_opposite) else { continue };
                let rest = other.faces.iter().filter(|face| *face != opposite);
                let shared = rest.fold(corners.clone(), |corners, face| clipped(&corners, face));
                area -= area_of(face.normal, &shared);
            }
        }
    }
    area
}

/// Volume of a body that is an ellipsoid and nothing else.
fn closed_volume(part: &ConvexBody) -> Option<f64> {
    let ellipsoid = part.ellipsoid.as_ref().filter(|_| part.faces.is_empty())?;
    Some(4.0 / 3.0 * PI / ellipsoid.to_unit.determinant())
}

/// By lines that are spread evenly over all that meet the ball of radius `size`: their mean length within is
/// V / (pi size^2), that they meet anything as likely as the shadow is large, and they cross the surface
/// S / (2 pi size^2) times (Santalo, "Integral Geometry and Geometric Probability", chapter 14).
fn by_lines(parts: &[ConvexBody], size: f64) -> Measured {
    let (mut length, mut met, mut crossings) = (0.0, 0u32, 0u32);
    for index in 0..LINES {
        let (origin, direction) = line(index, size);
        let mut stretches: Vec<Interval> =
            parts.iter().filter_map(|part| part.interval(origin, direction)).collect();
        stretches.sort_by(|a, b| a.enter.total_cmp(&b.enter));
        met += u32::from(!stretches.is_empty());
        let mut end = f64::NEG_INFINITY;
        for Interval { enter, leave, .. } in stretches {
            crossings += if enter > end { 2 } else { 0 };
            length += (leave - enter.max(end)).max(0.0);
            end = end.max(leave);
        }
    }
    let disc = PI * size * size / f64::from(LINES);
    Measured {
        volume: length * disc,
        surface_area: f64::from(crossings) * 2.0 * disc,
        mean_projected_area: f64::from(met) * disc,
    }
}

/// Line of an additive sequence in four dimensions (steps: powers of the root of x^5 = x + 1).
fn line(index: u32, size: f64) -> (DVec3, DVec3) {
    const STEPS: [f64; 4] = [
        0.856_674_883_854_502_9,
        0.733_891_856_627_126,
        0.628_706_721_037_893_9,
        0.538_597_257_202_138_9,
    ];
    let [a, b, c, d] = STEPS.map(|step| {
        let x = 0.5 + f64::from(index) * step;
        x - x.floor()
    });
    let y = 1.0 - 2.0 * a;
    let ring = (1.0 - y * y).max(0.0).sqrt();
    let (sin, cos) = trig::sin_cos(TAU * b);
    let direction = DVec3::new(ring * cos, y, ring * sin).normalize();
    let (s, t) = frame::tangents(direction);
    let (sin, cos) = trig::sin_cos(TAU * d);
    ((s * cos + t * sin) * (size * c.sqrt()), direction)
}
