//! Passages of light through grains of one shape, by samples of it.
//!
//! The kernel that traces snow follows an even field of light through the grain alone. Each way is kept, and its reversal: so uniform
//! light stays uniform. A way is told in the plane of the directions in which it comes and leaves.

mod kinds;
mod lying;
mod turned;

use super::composition::Lying;
use super::scattering::{Azimuths, Passage};
use crate::laboratory::{Passed, passed};
pub(super) use kinds::ShapeKinds;
use lying::LyingPassages;
use snowgrain_accel::SimdLevel;
use snowgrain_geometry::Shape;
use snowgrain_math::{DVec3, frame};
use turned::TurnedPassages;

/// Seed of the ways.
const SEED: u64 = 0x0000_9a55_a9e5;
/// Less the cosine of the angle within which light counts as not turned: what faces that are parallel let through.
const STRAIGHT: f64 = 1e-9;

/// Equally likely passages through grains of a kind.
#[derive(Clone, Debug)]
enum ShapePassages {
    /// In all orientations alike.
    Turned(TurnedPassages),
    /// As they lie.
    Lying(LyingPassages),
}

/// One way through a grain: along the direction in which light comes, aside towards that in which it leaves, and across both. Lengths
/// in radii of the sphere of equal volume.
#[derive(Clone, Copy, Debug, PartialEq)]
struct ShapePassage {
    /// Where it enters, from the centre.
    entry: [f32; 3],
    /// From where it enters to where it leaves.
    displacement: [f32; 3],
    /// Cosine and sine of the angle by which it is turned.
    turn: [f32; 2],
    /// Length in ice.
    length: f32,
    /// Straight on from where it enters to where the grain ends.
    across: f32,
}

/// An even field's ways through a grain: so many, and their reversals.
fn ways(shape: &Shape, eta: f64, wanted: usize) -> impl Iterator<Item = Passed> {
    let ways = passed(shape, eta, (wanted, SEED), SimdLevel::detect());
    ways.into_iter().flat_map(|way| [way, way.reversed(shape)])
}

/// The unit vector across a direction into which another is turned from it.
#[inline]
fn aside(direction: DVec3, turned: DVec3) -> DVec3 {
    let across = turned - direction * direction.dot(turned);
    across.try_normalize().unwrap_or_else(|| frame::tangents(direction).0)
}

impl ShapePassages {
    /// Of a shape of this refractive index, as its grains lie, if not in all orientations alike.
    fn new(shape: &Shape, lying: Option<&Lying>, eta: f64) -> Self {
        match lying {
            None => Self::Turned(TurnedPassages::new(shape, eta)),
            Some(lying) => Self::Lying(LyingPassages::new((shape, lying), eta)),
        }
    }

    /// Memory, bytes.
    fn memory_bytes(&self) -> u64 {
        match self {
            Self::Turned(passages) => passages.memory_bytes(),
            Self::Lying(passages) => passages.memory_bytes(),
        }
    }

    /// Area of the shadow of a grain that light of a direction meets, over the mean of all directions.
    #[inline]
    fn shadow(&self, direction: DVec3) -> f64 {
        match self {
            Self::Turned(_) => 1.0,
            Self::Lying(passages) => passages.shadow(direction),
        }
    }

    /// The largest of these.
    fn largest_shadow(&self) -> f64 {
        match self {
            Self::Turned(_) => 1.0,
            Self::Lying(passages) => passages.largest_shadow(),
        }
    }

    /// One of the passages of light that arrives along a direction, and whether it goes straight on. Two uniform numbers.
    #[inline]
    fn draw(
        &self,
        direction: DVec3,
        azimuths: &Azimuths,
        [way, turn]: [f64; 2],
    ) -> (Passage, bool) {
        match self {
            Self::Turned(passages) => {
                passages.draw(direction, azimuths.across(direction, turn), way)
            }
            Self::Lying(passages) => passages.draw(direction, way),
        }
    }

    /// The same where it is let straight through.
    #[inline]
    fn draw_straight(
        &self,
        direction: DVec3,
        azimuths: &Azimuths,
        [way, turn]: [f64; 2],
    ) -> Passage {
        match self {
            Self::Turned(passages) => {
                passages.draw_straight(direction, azimuths.across(direction, turn), way)
            }
            Self::Lying(passages) => passages.draw_straight(direction, way),
        }
    }

    /// Density of light from one direction into another, 1/sr, of light that is turned, and one of the passages that make it up; a uniform
    /// number. `None` where there is none.
    fn towards(&self, direction: DVec3, wanted: DVec3, random: f64) -> Option<(f64, Passage)> {
        match self {
            Self::Turned(passages) => passages.towards(direction, wanted, random),
            Self::Lying(passages) => passages.towards(direction, wanted, random),
        }
    }
}

impl ShapePassage {
    fn of(way: &Passed) -> Self {
        let cosine = way.incident.dot(way.direction).clamp(-1.0, 1.0);
        let aside = aside(way.incident, way.direction);
        let axes = [way.incident, aside, way.incident.cross(aside)];
        let told = |vector: DVec3| axes.map(|axis| vector.dot(axis) as f32);
        let is_straight = 1.0 - cosine <= STRAIGHT;
        // Of single precision the greatest cosine below 1.
        let turn =
            [(cosine as f32).min(1.0 - f32::EPSILON / 2.0), (1.0 - cosine * cosine).sqrt() as f32];
        Self {
            entry: told(way.entry),
            displacement: told(way.exit - way.entry),
            turn: if is_straight { [1.0, 0.0] } else { turn },
            length: way.length as f32,
            across: way.across as f32,
        }
    }

    /// What it does to light along a direction, aside of which is a unit vector.
    #[inline]
    fn along(&self, direction: DVec3, aside: DVec3) -> Passage {
        let across = direction.cross(aside);
        let vector = |[x, y, z]: [f32; 3]| {
            direction * f64::from(x) + aside * f64::from(y) + across * f64::from(z)
        };
        let [cosine, sine] = self.turn.map(f64::from);
        let turned = direction * cosine + aside * sine;
        Passage {
            // A step of Newton's towards unit length, which it has but for rounding.
            direction: turned * (1.5 - 0.5 * turned.length_squared()),
            turned_from: direction,
            displacement: vector(self.displacement),
            length: f64::from(self.length),
            entry: Some(vector(self.entry)),
            kind: 0,
        }
    }

    /// The same where it is let straight through.
    #[inline]
    fn straight_along(&self, direction: DVec3, aside: DVec3) -> Passage {
        let displacement = direction * f64::from(self.across);
        Passage { direction, displacement, ..self.along(direction, aside) }
    }

    /// The same where it is turned into this direction, almost its own.
    #[inline]
    fn turned_towards(&self, direction: DVec3, wanted: DVec3) -> Passage {
        Passage { direction: wanted, ..self.along(direction, aside(direction, wanted)) }
    }
}
