//! How grains lie, where they do not lie in all orientations alike: by some of them.

use snowgrain_geometry::GrainShape;
use snowgrain_grains::Orientation;
use snowgrain_math::{DMat3, DVec3};

/// Grains that are looked at, at least, where there are so many; at most twice as many.
const LOOKED_AT: usize = 1 << 12;
/// Means of the axes of grains, and of their products less those of all orientations, from which on grains count as not
/// in all orientations alike; where few are looked at, and so many over the square root of their number.
const UNEVEN: [f64; 2] = [0.05, 4.0];

/// Some grains of a kind, evenly among all in their order.
#[derive(Clone, Debug)]
pub(super) struct Looked {
    /// Every so manieth.
    stride: u64,
    before: u64,
    shapes: Vec<GrainShape>,
}

/// Orientations of some grains of a kind that do not lie in all alike.
#[derive(Clone, Debug, PartialEq)]
pub(in super::super) struct Lying {
    /// From the shape's own space to the world.
    rotations: Vec<DMat3>,
    /// Whether what they are turned by about the vertical is as likely all ways.
    turned_alike: bool,
}

impl Looked {
    pub(super) fn new() -> Self {
        Self { stride: 1, before: 0, shapes: Vec::new() }
    }

    pub(super) fn add(&mut self, shape: GrainShape) {
        if self.before.is_multiple_of(self.stride) {
            self.shapes.push(shape);
            if self.shapes.len() == 2 * LOOKED_AT {
                let mut index = 0;
                self.shapes.retain(|_| {
                    index += 1;
                    index % 2 == 1
                });
                self.stride *= 2;
            }
        }
        self.before += 1;
    }

    /// How they lie; `None` where they do in all orientations alike.
    pub(super) fn lying(self) -> Option<Lying> {
        Lying::unless_even(self.shapes.iter().map(|shape| shape.rotation()).collect())
    }
}

impl Lying {
    /// Of these rotations; `None` where they are those of all orientations alike.
    fn unless_even(rotations: Vec<DMat3>) -> Option<Self> {
        let limit = UNEVEN[0] + UNEVEN[1] / (rotations.len() as f64).sqrt();
        let axes = |axis: usize| rotations.iter().map(move |rotation| rotation.col(axis));
        let mean = |of: &dyn Fn(DVec3) -> DVec3, axis: usize| {
            axes(axis).map(of).sum::<DVec3>() / rotations.len() as f64
        };
        let is_uneven = |axis: usize| {
            let squares = mean(&|v| v * v, axis) - DVec3::splat(1.0 / 3.0);
            let products = mean(&|v| DVec3::new(v.y * v.z, v.z * v.x, v.x * v.y), axis);
            [mean(&|v| v, axis), squares, products].iter().any(|moment| moment.length() > limit)
        };
        // About the vertical: by once and twice the angle.
        let is_aimed = |axis: usize| {
            let once = mean(&|v| DVec3::new(v.x, 0.0, v.z), axis);
            let twice = mean(&|v| DVec3::new(v.x * v.x - v.z * v.z, 0.0, 2.0 * v.x * v.z), axis);
            [once, twice].iter().any(|moment| moment.length() > limit)
        };
        let (uneven, turned_alike) = ((0..3).any(is_uneven), !(0..3).any(is_aimed));
        uneven.then_some(Self { rotations, turned_alike })
    }

    /// Of these rotations, which are not those of all orientations alike.
    #[cfg(test)]
    pub(in super::super) fn of(rotations: Vec<DMat3>) -> Self {
        Self::unless_even(rotations).expect("rotations are few")
    }

    /// The rotation of one of the grains.
    pub(in super::super) fn rotation(&self, number: usize) -> DMat3 {
        self.rotations[number % self.rotations.len()]
    }

    /// Whether what they are turned by about the vertical is as likely all ways.
    pub(in super::super) fn is_turned_alike(&self) -> bool {
        self.turned_alike
    }

    /// The rule that is most like it.
    pub(super) fn orientation(&self) -> Orientation {
        let sum: DVec3 = self.rotations.iter().map(|rotation| rotation.y_axis).sum();
        let axis = sum.try_normalize().unwrap_or(DVec3::Y);
        let cosine = |rotation: &DMat3| rotation.y_axis.dot(axis);
        let squares =
            self.rotations.iter().map(|rotation| 1.0 - cosine(rotation) * cosine(rotation));
        let variance = 0.5 * squares.sum::<f64>() / self.rotations.len() as f64;
        let spread_degrees = variance.sqrt().to_degrees();
        match self.turned_alike {
            true => Orientation::Horizontal { spread_degrees },
            false => Orientation::Aligned { axis, spread_degrees },
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use snowgrain_geometry::{QuantisedGrain, Shape, ShapeKind};
    use snowgrain_grains::{MixedShape, ShapeMix};
    use std::sync::Arc;

    fn lying(orientation: Orientation, grains: i32) -> Option<Lying> {
        let plate = Shape::new(ShapeKind::HexagonalPrism { aspect: 0.3, rounding: 0.0 }).unwrap();
        let mixed = MixedShape { shape: Arc::new(plate), orientation, fraction: 1.0 };
        let mix = ShapeMix::new(vec![mixed], 3).unwrap();
        let mut looked = Looked::new();
        for index in 0..grains {
            let grain = QuantisedGrain { center: [index, 3 * index, 1], radius: 10 };
            looked.add(GrainShape::new(0, mix.draw(grain).1));
        }
        looked.lying()
    }

    #[test]
    fn grains_tell_by_which_rule_they_lie() {
        for grains in [100, 5000, 50_000] {
            assert_eq!(lying(Orientation::Random, grains), None, "{grains}");
        }
        let level = lying(Orientation::Horizontal { spread_degrees: 10.0 }, 20_000).unwrap();
        assert!(level.is_turned_alike() && level.rotations.len() >= LOOKED_AT);
        let Orientation::Horizontal { spread_degrees } = level.orientation() else {
            unreachable!("grains are turned alike")
        };
        assert!((spread_degrees - 10.0).abs() < 0.5, "{spread_degrees}");
        let along = DVec3::new(1.0, 1.0, 0.0).normalize();
        let aligned = Orientation::Aligned { axis: along, spread_degrees: 5.0 };
        let aligned = lying(aligned, 20_000).unwrap();
        assert!(!aligned.is_turned_alike());
        let Orientation::Aligned { axis, spread_degrees } = aligned.orientation() else {
            unreachable!("grains are aimed")
        };
        assert!(axis.dot(along) > 0.999 && (spread_degrees - 5.0).abs() < 0.5, "{spread_degrees}");
    }
}
