//! Shapes of grains, as the kernels want them.
//!
//! Blocks hold bounding spheres; beside each block lies a word a slot with prototype, orientation and size.

use super::slabs::Slabs;
use super::{GRAINS_PER_BLOCK, GridError, RADIUS_MASK};
use snowgrain_geometry::shape::{ConvexBody, Ellipsoid, Face};
use snowgrain_geometry::{GrainShape, QuantisedGrain, Shape};
use snowgrain_math::{DMat3, DVec3};

/// What grains are beside their place and size.
#[derive(Clone, Copy, Debug)]
pub struct ShapedGrains<'a> {
    /// The prototypes.
    pub prototypes: &'a [Shape],
    /// Of each grain, in the order of the grains.
    pub of_grains: &'a [GrainShape],
}

/// The words of the grains of a block, slot by slot: [`ShapeWord`]s.
pub(crate) type BlockShapes = [u64; GRAINS_PER_BLOCK];

/// Quanta by which a bounding sphere is larger than the body: rounding up, and the tests of bounding spheres,
/// which are in single precision, take less; two grains whose spheres only touch do not overlap.
pub(super) const SLACK: u16 = 2;

/// A [`GrainShape`] and, above it, the radius in quanta.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct ShapeWord(u64);

impl ShapeWord {
    fn new(shape: GrainShape, radius: u16) -> Self {
        Self(shape.to_bits() | u64::from(radius) << GrainShape::BITS)
    }

    #[inline(always)]
    pub(crate) fn of_slot(word: u64) -> Self {
        Self(word)
    }

    /// Radius of the sphere of equal volume, quanta.
    #[inline(always)]
    pub(crate) fn radius(self) -> f64 {
        f64::from((self.0 >> GrainShape::BITS) as u32)
    }

    #[inline(always)]
    pub(crate) fn shape(self) -> GrainShape {
        GrainShape::from_low_bits(self.0)
    }
}

/// The shapes of a grid.
#[derive(Debug)]
pub(crate) struct GridShapes {
    pub(crate) prototypes: Vec<Prototype>,
    /// Whether two grains have one centre.
    pub(crate) concentric: bool,
    pub(crate) blocks: Vec<BlockShapes>,
}

impl GridShapes {
    /// The prototype of a grain.
    #[inline(always)]
    pub(crate) fn of(&self, placement: &Placement) -> &Prototype {
        &self.prototypes[placement.prototype]
    }
}

/// A prototype as the kernels want it.
#[derive(Clone, Debug)]
pub(crate) struct Prototype {
    pub(crate) parts: Vec<Part>,
    /// Of one body between parallel faces.
    pub(crate) slabs: Option<Slabs>,
}

/// A convex body, its planes by eight: a plane that fills up cuts nothing off.
#[derive(Clone, Debug)]
pub(crate) struct Part {
    pub(crate) planes: Vec<Planes>,
    pub(crate) ellipsoid: Option<Ellipsoid>,
}

/// Eight planes `normal . x = distance`.
#[derive(Clone, Copy, Debug)]
#[repr(align(64))]
pub(crate) struct Planes {
    pub(crate) x: [f64; 8],
    pub(crate) y: [f64; 8],
    pub(crate) z: [f64; 8],
    pub(crate) distance: [f64; 8],
}

impl Prototype {
    pub(crate) fn new(shape: &Shape) -> Self {
        let slabs = match shape.parts() {
            [body] => Slabs::of(body),
            _ => None,
        };
        Self { parts: shape.parts().iter().map(Part::new).collect(), slabs }
    }

    pub(crate) fn contains(&self, point: DVec3) -> bool {
        self.parts.iter().any(|part| part.contains(point))
    }
}

impl Part {
    fn new(body: &ConvexBody) -> Self {
        let planes = |faces: &[Face]| {
            let of =
                |index: usize, part: fn(&Face) -> f64, none| faces.get(index).map_or(none, part);
            Planes {
                x: std::array::from_fn(|i| of(i, |face| face.normal.x, 0.0)),
                y: std::array::from_fn(|i| of(i, |face| face.normal.y, 0.0)),
                z: std::array::from_fn(|i| of(i, |face| face.normal.z, 0.0)),
                distance: std::array::from_fn(|i| of(i, |face| face.distance, 1.0)),
            }
        };
        Self { planes: body.faces.chunks(8).map(planes).collect(), ellipsoid: body.ellipsoid }
    }

    fn contains(&self, point: DVec3) -> bool {
        let behind = |planes: &Planes| {
            (0..8).all(|i| {
                let normal = DVec3::new(planes.x[i], planes.y[i], planes.z[i]);
                normal.dot(point) < planes.distance[i]
            })
        };
        let within = |e: &Ellipsoid| (e.to_unit * (point - e.center)).length_squared() < 1.0;
        self.planes.iter().all(behind) && self.ellipsoid.as_ref().is_none_or(within)
    }
}

/// The bounding spheres of shaped grains, and their words.
///
/// # Errors
/// A shape so long that its bounding sphere is too large for a block.
///
/// # Panics
/// If there are not as many shapes as grains.
pub(super) fn bounding(
    grains: &[QuantisedGrain],
    shapes: ShapedGrains<'_>,
) -> Result<(Vec<QuantisedGrain>, Vec<u64>), GridError> {
    assert_eq!(grains.len(), shapes.of_grains.len(), "a shape for each grain");
    let reaches: Vec<f64> = shapes.prototypes.iter().map(Shape::bounding_radius).collect();
    let mut spheres = Vec::with_capacity(grains.len());
    let mut words = Vec::with_capacity(grains.len());
    for (grain, &shape) in grains.iter().zip(shapes.of_grains) {
        let reach = (f64::from(grain.radius) * reaches[shape.prototype()]).ceil();
        if reach > f64::from(RADIUS_MASK - SLACK) {
            return Err(GridError::LongShape {
                shape: shapes.prototypes[shape.prototype()].name().into(),
            });
        }
        spheres.push(QuantisedGrain { radius: reach as u16 + SLACK, ..*grain });
        words.push(ShapeWord::new(shape, grain.radius).0);
    }
    Ok((spheres, words))
}

/// Whether two grains have one centre, as those do that make up a star.
pub(super) fn any_concentric(grains: &[QuantisedGrain]) -> bool {
    let mut centers: Vec<[i32; 3]> = grains.iter().map(|grain| grain.center).collect();
    centers.sort_unstable();
    centers.windows(2).any(|pair| pair[0] == pair[1])
}

/// From a prototype's space to the grid's, of one grain.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Placement {
    pub(crate) rotation: DMat3,
    pub(crate) radius: f64,
    pub(crate) prototype: usize,
}

impl Placement {
    #[inline(always)]
    pub(crate) fn of(word: ShapeWord) -> Self {
        let shape = word.shape();
        Self { rotation: shape.rotation(), radius: word.radius(), prototype: shape.prototype() }
    }

    /// A vector from the grain's centre, quanta, in the prototype's space.
    #[inline(always)]
    pub(crate) fn to_prototype(self, from_center: DVec3) -> DVec3 {
        self.turned_back(from_center) * (1.0 / self.radius)
    }

    /// A direction in the prototype's space.
    #[inline(always)]
    pub(crate) fn turned_back(self, direction: DVec3) -> DVec3 {
        let r = &self.rotation;
        DVec3::new(r.x_axis.dot(direction), r.y_axis.dot(direction), r.z_axis.dot(direction))
    }
}
