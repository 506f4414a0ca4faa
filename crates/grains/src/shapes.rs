//! What shapes the grains of a body of snow have, and how they lie.
//!
//! Shape and orientation of a grain are a function of a seed and of the grain's place and size, so they are
//! the same however many threads let it fall, and need not be stored while it falls.

use crate::{GrainField, GrainsError};
use core::f64::consts::TAU;
use snowgrain_geometry::{GrainShape, QuantisedGrain, Shape};
use snowgrain_math::sampler::{PathKey, numbers, split_mix};
use snowgrain_math::{DVec3, trig};
use std::sync::Arc;

/// How grains lie.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Orientation {
    /// All orientations are equally likely.
    Random,
    /// The c axis is vertical, but for a spread; all turns about it are equally likely.
    Horizontal {
        /// Standard deviation of the c axis along x and along z, degrees.
        spread_degrees: f64,
    },
    /// All grains lie alike, their c axis along a direction, but for a spread.
    Aligned {
        /// Direction of the c axis, of any length but 0.
        axis: DVec3,
        /// Standard deviation of the c axis in two directions across it, degrees.
        spread_degrees: f64,
    },
}

/// One shape of a mixture.
#[derive(Clone, Debug, PartialEq)]
pub struct MixedShape {
    /// The shape.
    pub shape: Arc<Shape>,
    /// How its grains lie.
    pub orientation: Orientation,
    /// Its part of the grains, relative to the other shapes; as the radii of all are drawn alike, and are those
    /// of spheres of equal volume, its part of the mass too.
    pub fraction: f64,
}

/// The shapes of a body of snow.
#[derive(Clone, Debug, PartialEq)]
pub struct ShapeMix {
    shapes: Vec<MixedShape>,
    seed: u64,
}

impl ShapeMix {
    /// Of these shapes; `seed` chooses among the grains.
    ///
    /// # Errors
    /// No shape, or more than [`GrainShape::MOST_PROTOTYPES`]; a fraction that is not positive and finite, an axis or
    /// spread without meaning.
    pub fn new(shapes: Vec<MixedShape>, seed: u64) -> Result<Self, GrainsError> {
        if shapes.is_empty() {
            return Err(GrainsError::setting("shapes", "must name at least one shape"));
        }
        if shapes.len() > GrainShape::MOST_PROTOTYPES {
            let reason = format!("must be at most {}", GrainShape::MOST_PROTOTYPES);
            return Err(GrainsError::setting("shapes", reason));
        }
        for MixedShape { orientation, fraction, .. } in &shapes {
            if !(*fraction > 0.0 && fraction.is_finite()) {
                let reason = format!("{fraction} must be a finite number above 0");
                return Err(GrainsError::setting("fraction", reason));
            }
            orientation.check()?;
        }
        Ok(Self { shapes, seed })
    }

    /// The shapes.
    #[must_use]
    pub fn shapes(&self) -> &[MixedShape] {
        &self.shapes
    }

    /// Whether all grains are spheres.
    #[must_use]
    pub fn is_all_spheres(&self) -> bool {
        self.shapes.iter().all(|mixed| mixed.shape.is_sphere())
    }

    /// The largest reach of a grain, in radii.
    #[must_use]
    pub fn largest_reach(&self) -> f64 {
        self.shapes.iter().map(|mixed| mixed.shape.bounding_radius()).fold(1.0, f64::max)
    }

    /// The grains with the shapes that they are drawn.
    pub(crate) fn drawn(&self, field: GrainField) -> GrainField {
        let shape = |grain: QuantisedGrain| {
            let (which, quaternion) = self.draw(grain);
            GrainShape::new(which, quaternion)
        };
        let prototypes = self.shapes.iter().map(|mixed| Shape::clone(&mixed.shape)).collect();
        let of_grains = field.quantised().map(shape).collect();
        field.with_shapes(FieldShapes { prototypes, of_grains })
    }

    /// Which of the shapes a grain has, and the quaternion that turns it.
    #[must_use]
    pub fn draw(&self, grain: QuantisedGrain) -> (usize, [f64; 4]) {
        self.draw_again(grain, 0)
    }

    /// The same shape, turned for the so manieth time after the first.
    #[must_use]
    pub fn draw_again(&self, grain: QuantisedGrain, turn: u32) -> (usize, [f64; 4]) {
        let key = PathKey::new(self.seed, digest(grain), 0x5_4a9e5);
        let all: f64 = self.shapes.iter().map(|shape| shape.fraction).sum();
        let mut rest = f64::from(numbers(key, 0)[0]) * all;
        let mut index = 0;
        while index + 1 < self.shapes.len() && rest >= self.shapes[index].fraction {
            rest -= self.shapes[index].fraction;
            index += 1;
        }
        (index, self.shapes[index].orientation.draw(key, turn))
    }
}

impl Orientation {
    fn check(&self) -> Result<(), GrainsError> {
        let spread = match *self {
            Self::Random => 0.0,
            Self::Horizontal { spread_degrees } => spread_degrees,
            Self::Aligned { axis, spread_degrees } => {
                let length = axis.length();
                if !(length > 0.0 && length.is_finite()) {
                    return Err(GrainsError::setting("axis", "must be a direction, as [0, 1, 0]"));
                }
                spread_degrees
            }
        };
        if !(0.0..=90.0).contains(&spread) {
            return Err(GrainsError::setting(
                "spread",
                format!("{spread} must be 0 to 90 degrees"),
            ));
        }
        Ok(())
    }

    /// A quaternion, by event 1 of the key, and those after it for further turns.
    fn draw(&self, key: PathKey, turn: u32) -> [f64; 4] {
        let [a, b, c] = numbers(key, 1 + turn).map(f64::from);
        match *self {
            // Shoemake 1992, "Uniform Random Rotations", Graphics Gems III.
            Self::Random => {
                let ((s1, c1), (s2, c2)) = (trig::sin_cos(TAU * b), trig::sin_cos(TAU * c));
                let (r1, r2) = ((1.0 - a).sqrt(), a.sqrt());
                [s1 * r1, c1 * r1, s2 * r2, c2 * r2]
            }
            Self::Horizontal { spread_degrees } => {
                let (sin, cos) = trig::sin_cos(0.5 * TAU * a);
                product(tilt(spread_degrees, [b, c]), [0.0, sin, 0.0, cos])
            }
            Self::Aligned { axis, spread_degrees } => {
                product(from_up(axis.normalize()), tilt(spread_degrees, [b, c]))
            }
        }
    }
}

/// A turn about a horizontal axis that spreads the vertical by a normal distribution in two directions (Box
/// and Muller 1958).
fn tilt(spread_degrees: f64, [u, v]: [f64; 2]) -> [f64; 4] {
    let angle = spread_degrees.to_radians() * (-2.0 * trig::ln(1.0 - u)).sqrt();
    let ((sin, cos), (s, c)) = (trig::sin_cos(0.5 * angle), trig::sin_cos(TAU * v));
    [sin * c, 0.0, sin * s, cos]
}

/// The shortest turn from y to a unit vector.
fn from_up(axis: DVec3) -> [f64; 4] {
    // Half-way between the two: (1 + cos, y x axis), of any length; upside down about x.
    if axis.y < -1.0 + 1e-12 { [1.0, 0.0, 0.0, 0.0] } else { [axis.z, 0.0, -axis.x, 1.0 + axis.y] }
}

/// First the second turn, then the first.
fn product(p: [f64; 4], q: [f64; 4]) -> [f64; 4] {
    let (a, b) = (DVec3::new(p[0], p[1], p[2]), DVec3::new(q[0], q[1], q[2]));
    let v = b * p[3] + a * q[3] + a.cross(b);
    [v.x, v.y, v.z, p[3] * q[3] - a.dot(b)]
}

/// A word for a grain.
#[must_use]
pub fn digest(grain: QuantisedGrain) -> u64 {
    let [x, y, z] = grain.center.map(|c| u64::from(c.cast_unsigned()));
    split_mix(split_mix(x | y << 32) ^ (z | u64::from(grain.radius) << 32))
}

/// Shapes of the grains of a field.
#[derive(Clone, Debug, PartialEq)]
pub struct FieldShapes {
    /// The prototypes, at most [`GrainShape::MOST_PROTOTYPES`].
    pub prototypes: Arc<[Shape]>,
    /// Of each grain, in the order of the field.
    pub of_grains: Vec<GrainShape>,
}

impl FieldShapes {
    /// Memory held, bytes.
    #[must_use]
    pub fn bytes(&self) -> usize {
        self.of_grains.capacity() * size_of::<GrainShape>()
    }

    /// The largest reach of a grain, in radii.
    #[must_use]
    pub fn largest_reach(&self) -> f64 {
        self.prototypes.iter().map(Shape::bounding_radius).fold(1.0, f64::max)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use snowgrain_geometry::{Quantisation, ShapeKind};

    fn grain(index: i32) -> QuantisedGrain {
        QuantisedGrain { center: [index, 7 * index, -index], radius: 1000 }
    }

    fn mix(shapes: &[(ShapeKind, Orientation, f64)]) -> ShapeMix {
        let mixed = |&(kind, orientation, fraction): &(_, _, _)| {
            let shape = Arc::new(Shape::new(kind).expect("the shape is legal"));
            MixedShape { shape, orientation, fraction }
        };
        ShapeMix::new(shapes.iter().map(mixed).collect(), 5).expect("the mixture is legal")
    }

    #[test]
    fn a_shape_takes_eight_bytes_beside_its_grain() {
        let listed: Vec<_> = (0..1000).map(grain).collect();
        let field = GrainField::new(Quantisation::for_grains(DVec3::ZERO, 1.0), listed);
        let mut of_grains = Vec::with_capacity(3000);
        of_grains.resize(1000, GrainShape::upright(0));
        let cube = Shape::new(ShapeKind::Cube { rounding: 0.0 }).expect("the shape is legal");
        let spheres = field.bytes();
        let shaped = field.with_shapes(FieldShapes { prototypes: [cube].into(), of_grains });
        assert_eq!(shaped.bytes() - spheres, 8000);
    }

    fn axis(quaternion: [f64; 4]) -> DVec3 {
        GrainShape::new(0, quaternion).rotation() * DVec3::Y
    }

    /// 4 sigma: each of these fails once in 16 000 seeds.
    #[test]
    fn fractions_and_orientations_are_those_asked_for() {
        let plate = ShapeKind::HexagonalPrism { aspect: 0.2, rounding: 0.0 };
        let aim = DVec3::new(1.0, -2.0, 0.5);
        let mix = mix(&[
            (ShapeKind::Sphere, Orientation::Random, 2.0),
            (plate, Orientation::Horizontal { spread_degrees: 3.0 }, 1.0),
            (plate, Orientation::Aligned { axis: aim, spread_degrees: 0.0 }, 1.0),
        ]);
        let (mut counts, mut mean, mut squares, mut tilts) = ([0u32; 3], DVec3::ZERO, 0.0, 0.0);
        let n = 20_000;
        for index in 0..n {
            let (shape, quaternion) = mix.draw(grain(index));
            let axis = axis(quaternion);
            counts[shape] += 1;
            match shape {
                0 => {
                    mean += axis;
                    squares += axis.y * axis.y;
                }
                1 => tilts += axis.x * axis.x + axis.z * axis.z,
                _ => assert!((axis - aim.normalize()).length() < 3e-4),
            }
        }
        let of = |index: usize| f64::from(counts[index]);
        assert!((of(0) / f64::from(n) - 0.5).abs() < 4.0 * (0.25 / f64::from(n)).sqrt());
        assert!((of(1) - of(2)).abs() < 4.0 * (of(1) + of(2)).sqrt());
        assert!((mean / of(0)).abs().max_element() < 4.0 / (3.0 * of(0)).sqrt());
        assert!((squares / of(0) - 1.0 / 3.0).abs() < 4.0 * (4.0 / 45.0 / of(0)).sqrt());
        let spread = (0.5 * tilts / of(1)).sqrt().to_degrees();
        assert!((spread - 3.0).abs() < 4.0 * 3.0 / (4.0 * of(1)).sqrt() + 0.01, "{spread}");
    }

    #[test]
    fn the_turn_from_up_is_right_everywhere() {
        for aim in [DVec3::Y, DVec3::NEG_Y, DVec3::X, DVec3::NEG_Z, DVec3::new(1.0, -1.0, 2.0)] {
            let found = axis(from_up(aim.normalize()));
            assert!((found - aim.normalize()).length() < 3e-4, "{aim} {found}");
        }
        assert_eq!(axis(from_up(DVec3::Y)), DVec3::Y);
    }

    #[test]
    fn mixtures_without_meaning_are_refused() {
        let sphere = Arc::new(Shape::new(ShapeKind::Sphere).expect("a sphere is legal"));
        let refused = |orientation, fraction| {
            let shape = Arc::clone(&sphere);
            ShapeMix::new(vec![MixedShape { shape, orientation, fraction }], 0).is_err()
        };
        assert!(ShapeMix::new(Vec::new(), 0).is_err());
        assert!(refused(Orientation::Random, 0.0));
        let level = Orientation::Horizontal { spread_degrees: 100.0 };
        assert!(refused(level, 1.0));
        let aligned = Orientation::Aligned { axis: DVec3::ZERO, spread_degrees: 0.0 };
        assert!(refused(aligned, 1.0));
    }
}
