//! Grains as the bodies that they are, where they lie: spheres, or copies of prototypes.

use crate::{FieldShapes, GrainField};
use snowgrain_geometry::shape::ConvexBody;
use snowgrain_geometry::{GrainShape, QuantisedGrain, Shape};
use snowgrain_math::{DMat3, DVec3};
use std::sync::Arc;

/// What the grains of a field are, in an order of their own.
#[derive(Clone, Debug, Default)]
pub(crate) struct Bodies {
    /// None where all are spheres.
    shaped: Option<Shaped>,
}

#[derive(Clone, Debug)]
struct Shaped {
    prototypes: Arc<[Prototype]>,
    of_grains: Vec<GrainShape>,
}

/// A shape, and the corners of each of its parts.
#[derive(Clone, Debug)]
pub(crate) struct Prototype {
    pub(crate) shape: Shape,
    pub(crate) corners: Vec<Vec<DVec3>>,
}

/// A grain where it lies; `radius` is that of the sphere of equal volume.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Body<'a> {
    pub(crate) center: DVec3,
    pub(crate) radius: f64,
    /// What is no sphere: the prototype, and how it is turned.
    pub(crate) shape: Option<(&'a Prototype, DMat3)>,
}

impl Prototype {
    pub(crate) fn new(shape: &Shape) -> Self {
        let corners = shape.parts().iter().map(ConvexBody::corners).collect();
        Self { shape: shape.clone(), corners }
    }
}

impl Bodies {
    /// The grains of a field in its order.
    pub(crate) fn of(field: &GrainField) -> Self {
        let shaped = field.shapes().map(|FieldShapes { prototypes, of_grains }| Shaped {
            prototypes: prototypes.iter().map(Prototype::new).collect(),
            of_grains: of_grains.clone(),
        });
        Self { shaped }
    }

    /// The same grains in another order, of which each was the grain of that number.
    pub(crate) fn in_order(self, numbers: &[u32]) -> Self {
        let order = |shaped: Shaped| Shaped {
            of_grains: numbers.iter().map(|&at| shaped.of_grains[at as usize]).collect(),
            ..shaped
        };
        Self { shaped: self.shaped.map(order) }
    }

    /// Gives the grain of a number another shape.
    pub(crate) fn turn(&mut self, index: usize, shape: GrainShape) {
        if let Some(shaped) = &mut self.shaped {
            shaped.of_grains[index] = shape;
        }
    }

    /// What the grain of a number is, where not all are spheres.
    pub(crate) fn shape_of(&self, index: usize) -> Option<GrainShape> {
        self.shaped.as_ref().map(|shaped| shaped.of_grains[index])
    }

    /// Whether all are spheres.
    pub(crate) fn are_spheres(&self) -> bool {
        self.shaped.is_none()
    }

    /// How far the grain of a number reaches, in radii of the sphere of equal volume.
    pub(crate) fn reach(&self, index: usize) -> f64 {
        self.shaped.as_ref().map_or(1.0, |shaped| {
            shaped.prototypes[shaped.of_grains[index].prototype()].shape.bounding_radius()
        })
    }

    /// The grain of a number, at a place.
    pub(crate) fn body(&self, index: usize, center: DVec3, radius: f64) -> Body<'_> {
        match self.shape_of(index) {
            Some(shape) => self.body_as(shape, center, radius),
            None => Body { center, radius, shape: None },
        }
    }

    /// A grain of a shape of the field, at a place.
    pub(crate) fn body_as(&self, of: GrainShape, center: DVec3, radius: f64) -> Body<'_> {
        let shape = self.shaped.as_ref().and_then(|shaped| {
            let prototype = &shaped.prototypes[of.prototype()];
            (!prototype.shape.is_sphere()).then(|| (prototype, of.rotation()))
        });
        Body { center, radius, shape }
    }

    /// The largest reach of a grain from its centre, in the unit of the radii.
    pub(crate) fn largest_reach(&self, grains: impl Iterator<Item = QuantisedGrain>) -> f64 {
        let reach =
            |(index, grain): (usize, QuantisedGrain)| f64::from(grain.radius) * self.reach(index);
        grains.enumerate().map(reach).fold(0.0, f64::max)
    }
}

impl Body<'_> {
    /// No point lies farther from the centre.
    pub(crate) fn reach(&self) -> f64 {
        self.radius * self.shape.map_or(1.0, |(prototype, _)| prototype.shape.bounding_radius())
    }

    /// Whether a point lies in it.
    pub(crate) fn holds(&self, point: DVec3) -> bool {
        match self.shape {
            None => (self.center - point).length_squared() <= self.radius * self.radius,
            Some((prototype, turn)) => {
                prototype.shape.contains(turn.transpose() * (point - self.center) / self.radius)
            }
        }
    }

    /// The stretches of a line within it, told from `origin` along the unit vector `direction`, none overlapping
    /// another.
    pub(crate) fn stretches(&self, origin: DVec3, direction: DVec3) -> Vec<[f64; 2]> {
        let offset = origin - self.center;
        let Some((prototype, turn)) = self.shape else {
            let middle = -offset.dot(direction);
            let square = self.radius * self.radius - (offset + direction * middle).length_squared();
            let half = square.max(0.0).sqrt();
            return if half > 0.0 { vec![[middle - half, middle + half]] } else { Vec::new() };
        };
        let back = turn.transpose();
        let (at, along) = (back * offset / self.radius, back * direction);
        let parts = prototype.shape.parts().iter().filter_map(|part| part.interval(at, along));
        let mut all: Vec<[f64; 2]> =
            parts.map(|stretch| [stretch.enter, stretch.leave].map(|t| t * self.radius)).collect();
        all.sort_by(|a, b| a[0].total_cmp(&b[0]));
        united(all.into_iter())
    }

    /// Length, along the line through both centres, that lies in both: for spheres the depth of their overlap.
    pub(crate) fn depth_in(&self, other: &Self) -> f64 {
        let offset = other.center - self.center;
        let direction = offset.try_normalize().unwrap_or(DVec3::Y);
        let mut depth = 0.0;
        for [a, b] in self.stretches(self.center, direction) {
            for [c, d] in other.stretches(self.center, direction) {
                depth += (b.min(d) - a.max(c)).max(0.0);
            }
        }
        depth
    }
}

/// Stretches that come by their starts, those that overlap or touch as one.
pub(crate) fn united(stretches: impl Iterator<Item = [f64; 2]>) -> Vec<[f64; 2]> {
    let mut all: Vec<[f64; 2]> = Vec::with_capacity(stretches.size_hint().0);
    for [from, to] in stretches {
        match all.last_mut() {
            Some(last) if from <= last[1] => last[1] = last[1].max(to),
            _ => all.push([from, to]),
        }
    }
    all
}
