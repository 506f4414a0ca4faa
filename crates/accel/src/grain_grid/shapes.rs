//! Shapes of grains, as the kernels want them.
//!
//! Blocks hold bounding spheres, which tell the sizes of grains; beside each block lies a word a slot with prototype,
//! orientation, and the faces that other ice may reach.

use super::reached_faces::ReachedFaces;
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
pub(crate) const SLACK: u16 = 2;

/// A [`GrainShape`] and, above it, the [`ReachedFaces`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) struct ShapeWord(u64);

const _: () = assert!(GrainShape::BITS + ReachedFaces::BITS <= u64::BITS);

impl ShapeWord {
    pub(super) fn new(shape: GrainShape, reached: ReachedFaces) -> Self {
        Self(shape.to_bits() | u64::from(reached.to_bits()) << GrainShape::BITS)
    }

    #[inline(always)]
    pub(crate) fn of_slot(word: u64) -> Self {
        Self(word)
    }

    pub(super) fn to_slot(self) -> u64 {
        self.0
    }

    #[inline(always)]
    pub(crate) fn shape(self) -> GrainShape {
        GrainShape::from_low_bits(self.0)
    }

    #[inline(always)]
    pub(crate) fn reached(self) -> ReachedFaces {
        ReachedFaces::from_bits((self.0 >> GrainShape::BITS) as u16)
    }
}

/// How far the grains of a prototype reach, in radii. Of these spheres are made that hold the grains, and the spheres are what
/// is kept: they tell the radii.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Reach {
    radii: f64,
    pub(crate) inverse: f64,
}

impl Reach {
    /// More than rounding takes of a radius, and less than what makes it another whole number.
    pub(crate) const ROUNDING: f64 = 1e-6;

    pub(super) fn of(shape: &Shape) -> Self {
        // No body reaches less far than the sphere of its volume. One that reaches as far, but for rounding, is it; what
        // reaches farther does so by enough that two radii differ by more than rounding.
        let radii = match shape.bounding_radius() {
            ball if ball < 1.0 + 1e-9 => 1.0,
            radii => radii.max(1.001),
        };
        Self { radii, inverse: 1.0 / radii }
    }

    /// Radius of the sphere around a grain, quanta.
    fn bounding(self, radius: u16) -> f64 {
        (f64::from(radius) * self.radii).ceil() + f64::from(SLACK)
    }

    /// Radius of the grain in such a sphere, of which flags are told too: of the sphere of its volume, quanta.
    #[inline(always)]
    pub(crate) fn radius(self, bounding: u16) -> f64 {
        let reach = f64::from(bounding & RADIUS_MASK) - f64::from(SLACK);
        (reach * self.inverse + Self::ROUNDING).floor()
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

    /// How a grain is placed, by its word and the radius of its sphere, of which flags are told too.
    #[inline(always)]
    pub(crate) fn placement(&self, word: u64, bounding: u16) -> Placement {
        let shape = ShapeWord::of_slot(word).shape();
        let radius = self.prototypes[shape.prototype()].reach.radius(bounding);
        Placement::new(shape, radius)
    }
}

/// A prototype as the kernels want it.
#[derive(Clone, Debug)]
pub(crate) struct Prototype {
    pub(crate) parts: Vec<Part>,
    pub(crate) reach: Reach,
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
        Self {
            parts: shape.parts().iter().map(Part::new).collect(),
            reach: Reach::of(shape),
            slabs,
        }
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
    let reaches: Vec<Reach> = shapes.prototypes.iter().map(Reach::of).collect();
    let mut spheres = Vec::with_capacity(grains.len());
    let mut words = Vec::with_capacity(grains.len());
    for (grain, &shape) in grains.iter().zip(shapes.of_grains) {
        let bounding = reaches[shape.prototype()].bounding(grain.radius);
        if bounding > f64::from(RADIUS_MASK) {
            return Err(GridError::LongShape {
                shape: shapes.prototypes[shape.prototype()].name().into(),
            });
        }
        spheres.push(QuantisedGrain { radius: bounding as u16, ..*grain });
        words.push(ShapeWord::new(shape, ReachedFaces::NONE).0);
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
    /// Of a grain of this radius, quanta.
    #[inline(always)]
    pub(crate) fn new(shape: GrainShape, radius: f64) -> Self {
        Self { rotation: shape.rotation(), radius, prototype: shape.prototype() }
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

#[cfg(test)]
mod tests {
    use super::super::OVERLAPS;
    use super::*;
    use snowgrain_geometry::ShapeKind;

    #[test]
    fn spheres_around_grains_tell_their_radii() {
        for kind in [
            ShapeKind::Spheroid { aspect: 1.0 },
            ShapeKind::Spheroid { aspect: 1.0 + 1e-7 },
            ShapeKind::Spheroid { aspect: 1.01 },
            ShapeKind::Cube { rounding: 1.0 },
            ShapeKind::HexagonalPrism { aspect: 0.1, rounding: 0.0 },
            ShapeKind::HexagonalPrism { aspect: 5.0, rounding: 0.3 },
            ShapeKind::Rosette { arms: 3, aspect: 1.5, rounding: 0.0 },
        ] {
            let shape = Shape::new(kind).expect("the shape is legal");
            let reach = Reach::of(&shape);
            assert!(reach.radii >= shape.bounding_radius() * (1.0 - 1e-9));
            let fits = |radius: &u16| reach.bounding(*radius) <= f64::from(RADIUS_MASK);
            let mut seen = 0;
            for radius in (1..=RADIUS_MASK).take_while(fits) {
                let told = reach.radius(reach.bounding(radius) as u16 | OVERLAPS);
                assert_eq!(told, f64::from(radius), "{kind:?}");
                seen += 1;
            }
            assert!(seen > 3000, "{kind:?}");
        }
    }
}
