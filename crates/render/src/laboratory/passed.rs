//! Light that passed through one grain of any shape: where it came in, and where it left.

use super::scattering::told_of_met;
use crate::transport::PathEnd;
use snowgrain_accel::SimdLevel;
use snowgrain_geometry::Shape;
use snowgrain_math::DVec3;

/// One way through a grain. Lengths in radii of the sphere of equal volume, places from its centre.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Passed {
    /// Unit direction in which it came.
    pub(crate) incident: DVec3,
    /// Where it first met the grain.
    pub(crate) entry: DVec3,
    /// Where it last left it.
    pub(crate) exit: DVec3,
    /// Unit direction in which it left.
    pub(crate) direction: DVec3,
    /// Length in ice.
    pub(crate) length: f64,
    /// From where the line on which it came first meets the grain to where it last leaves it.
    pub(crate) across: f64,
}

impl Passed {
    /// The same way the other way round.
    pub(crate) fn reversed(&self, shape: &Shape) -> Self {
        let incident = -self.direction;
        Self {
            incident,
            entry: self.exit,
            exit: self.entry,
            direction: -self.incident,
            length: self.length,
            across: across(shape, self.exit, incident),
        }
    }
}

/// Light of an even field that met a grain in all its orientations alike, so many ways.
///
/// # Panics
/// If the machine does not have the level.
pub(crate) fn passed(
    shape: &Shape,
    eta: f64,
    paths: (usize, u64),
    level: SimdLevel,
) -> Vec<Passed> {
    told_of_met(shape, eta, paths, level, &|incident, path, radius| {
        let (PathEnd::Escaped(ray), Some(first)) = (path.end, path.first_hit) else { return None };
        let (entry, outside) = (first.position / radius, ray.origin / radius);
        // A ray that only grazes an edge may miss it by rounding.
        let [_, leaves] = shape.extent(outside, ray.direction)?;
        Some(Passed {
            incident,
            entry,
            exit: outside + ray.direction * leaves,
            direction: ray.direction,
            length: path.ice_length / radius,
            across: across(shape, entry, incident),
        })
    })
}

/// Distance along a line through a place on a grain over which the grain lies.
fn across(shape: &Shape, place: DVec3, direction: DVec3) -> f64 {
    shape.extent(place, direction).map_or(0.0, |[enters, leaves]| leaves - enters)
}

#[cfg(test)]
mod tests {
    use super::*;
    use snowgrain_geometry::ShapeKind;
    use snowgrain_optics::{Dielectric, sphere};

    /// Ways through a ball begin and end on it, and are as long and as turned as in closed form.
    #[test]
    fn ways_through_a_ball_are_those_of_the_sphere() {
        let (ice, ball) = (Dielectric { eta: 1.31 }, Shape::new(ShapeKind::Sphere).unwrap());
        let ways = passed(&ball, ice.eta, (20_000, 7), SimdLevel::detect());
        assert_eq!(ways.len(), 20_000);
        for way in &ways {
            for (place, direction) in [(way.entry, -way.incident), (way.exit, way.direction)] {
                assert!((place.length() - 1.0).abs() < 1e-3, "{way:?}");
                assert!(place.dot(direction) > -1e-3, "{way:?}");
            }
            assert!((way.across + 2.0 * way.entry.dot(way.incident)).abs() < 3e-3, "{way:?}");
            let back = way.reversed(&ball);
            assert!((back.across + 2.0 * back.entry.dot(back.incident)).abs() < 3e-3, "{way:?}");
        }
        let mean = |of: &dyn Fn(&Passed) -> f64| ways.iter().map(of).sum::<f64>() / 2e4;
        let cosine = mean(&|way| way.incident.dot(way.direction));
        let length = mean(&|way| way.length);
        // Five standard errors.
        assert!((cosine - sphere::asymmetry(ice)).abs() < 5.0 * 0.25 / 2e4f64.sqrt(), "{cosine}");
        let expected = 4.0 / 3.0 * sphere::absorption_enhancement(ice);
        assert!((length - expected).abs() < 5.0 * 0.8 / 2e4f64.sqrt(), "{length} {expected}");
    }
}
