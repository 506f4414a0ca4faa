//! Shapes of grains: prototypes that grains of any size and orientation are copies of.
//!
//! A [`Shape`] is a union of convex bodies ([`ConvexBody`]) that has the volume of the ball of radius 1, so
//! that the radius of a shaped grain is that of the sphere of equal volume. Its own space has the c axis
//! along y: plates lie level as they are.
//!
//! Polyhedra are rounded by an ellipsoid that cuts their edges and corners off: a line meets it in one more
//! interval, which costs one square root and is as exact as the planes are. (The sum with a ball, which
//! rounds as dissolving does, would need an edge and a corner each a test of its own.)

mod build;
mod cells;
mod convex;
mod hull;
mod measure;
mod orientation;

pub use convex::{ConvexBody, Ellipsoid, Face, FlatFace, Interval, SurfacePart};
pub use orientation::GrainShape;

use crate::GeometryError;
use snowgrain_math::DVec3;

/// The closed set of shapes. `rounding` goes from 0 (sharp) to 1 (nothing is left of the faces but the
/// points where they touch the ellipsoid within).
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ShapeKind {
    /// A ball.
    Sphere,
    /// An ellipsoid of revolution.
    Spheroid {
        /// Length along the c axis by that across it.
        aspect: f64,
    },
    /// A cube, its edges along the axes.
    Cube {
        /// See [`ShapeKind`].
        rounding: f64,
    },
    /// A regular hexagonal prism about the c axis, its corners towards +-x.
    HexagonalPrism {
        /// Height by width from corner to corner: plates below 1, columns above.
        aspect: f64,
        /// See [`ShapeKind`].
        rounding: f64,
    },
    /// A truncated octahedron: 8 hexagons and 6 squares.
    TruncatedOctahedron {
        /// See [`ShapeKind`].
        rounding: f64,
    },
    /// Faces in random directions, all equally far from the centre.
    RandomPolyhedron {
        /// Faces asked for, 6 to 32; a few may be hidden by others.
        faces: u32,
        /// Which of all such polyhedra.
        seed: u64,
        /// See [`ShapeKind`].
        rounding: f64,
    },
    /// A rosette: hexagonal columns that grow from one centre in different directions and overlap there.
    Rosette {
        /// Columns, 2 to 12.
        arms: u32,
        /// Length of a column by its width from corner to corner.
        aspect: f64,
        /// Of each column, see [`ShapeKind`].
        rounding: f64,
    },
}

/// A prototype. Lengths in radii of the ball of equal volume.
#[derive(Clone, Debug, PartialEq)]
pub struct Shape {
    name: String,
    parts: Vec<ConvexBody>,
    surface_area: f64,
    mean_projected_area: f64,
    bounding_radius: f64,
}

impl Shape {
    /// Volume of every prototype, that of the unit ball.
    pub const VOLUME: f64 = 4.0 / 3.0 * core::f64::consts::PI;

    /// The prototype of this kind.
    ///
    /// # Errors
    /// [`GeometryError::BadShape`] for a number out of range.
    pub fn new(kind: ShapeKind) -> Result<Self, GeometryError> {
        let parts = build::parts(kind)?;
        Ok(build::normalised(kind.name(), parts))
    }

    /// The prototype of this name, the same to the last bit.
    ///
    /// # Errors
    /// [`GeometryError::BadShape`] for a name that no prototype has.
    pub fn of_name(name: &str) -> Result<Self, GeometryError> {
        let words: Vec<&str> = name.split_whitespace().collect();
        if let Some(kind) = ShapeKind::parse(&words) {
            return Self::new(kind);
        }
        let unknown = || {
            let reason = format!("\"{name}\" is no shape that this version knows");
            GeometryError::BadShape { key: "shape", reason }
        };
        let [kind @ ("polyhedron" | "cells"), numbers @ ..] = words.as_slice() else {
            return Err(unknown());
        };
        let numbers: Result<Vec<f64>, _> = numbers.iter().map(|word| word.parse()).collect();
        let numbers = numbers.map_err(|_| unknown())?;
        if numbers.iter().any(|x| !x.is_finite()) {
            return Err(unknown());
        }
        if *kind == "cells" {
            return Self::of_cell_numbers(&numbers).unwrap_or_else(|| Err(unknown()));
        }
        let (faces, rest) = numbers.as_chunks::<4>();
        if !rest.is_empty() {
            return Err(unknown());
        }
        let face = |&[x, y, z, distance]: &[f64; 4]| Face { normal: DVec3::new(x, y, z), distance };
        Self::of_faces(faces.iter().map(face).collect())
    }

    /// What the kind and its numbers are called; the same for equal prototypes only.
    #[must_use]
    pub fn name(&self) -> &str {
        &self.name
    }

    /// The convex bodies whose union it is.
    #[must_use]
    pub fn parts(&self) -> &[ConvexBody] {
        &self.parts
    }

    /// Whether it is the sphere.
    #[must_use]
    pub fn is_sphere(&self) -> bool {
        self.name == "sphere"
    }

    /// Area of the surface of the union, to 1e-4, or 5e-3 where parts overlap.
    #[must_use]
    pub fn surface_area(&self) -> f64 {
        self.surface_area
    }

    /// Area of the shadow, averaged over all directions: a quarter of the surface for convex bodies
    /// (Cauchy 1841).
    #[must_use]
    pub fn mean_projected_area(&self) -> f64 {
        self.mean_projected_area
    }

    /// No point lies farther from the origin.
    #[must_use]
    pub fn bounding_radius(&self) -> f64 {
        self.bounding_radius
    }

    /// Whether a point lies strictly inside.
    #[must_use]
    pub fn contains(&self, point: DVec3) -> bool {
        self.parts.iter().any(|part| part.contains(point))
    }

    /// From where the line `origin + t direction` first meets the shape to where it last leaves it; `None` where it does not.
    #[must_use]
    pub fn extent(&self, origin: DVec3, direction: DVec3) -> Option<[f64; 2]> {
        let intervals = self.parts.iter().filter_map(|part| part.interval(origin, direction));
        let ends = intervals.map(|interval| [interval.enter, interval.leave]);
        ends.reduce(|[a, b], [c, d]| [a.min(c), b.max(d)])
    }
}

impl ShapeKind {
    /// Name and numbers in words that [`ShapeKind::parse`] takes.
    #[must_use]
    pub fn name(&self) -> String {
        match self {
            Self::Sphere => "sphere".into(),
            Self::Spheroid { aspect } => format!("spheroid aspect {aspect}"),
            Self::Cube { rounding } => format!("cube rounding {rounding}"),
            Self::HexagonalPrism { aspect, rounding } => {
                format!("hexagonal-prism aspect {aspect} rounding {rounding}")
            }
            Self::TruncatedOctahedron { rounding } => {
                format!("truncated-octahedron rounding {rounding}")
            }
            Self::RandomPolyhedron { faces, seed, rounding } => {
                format!("random-polyhedron faces {faces} seed {seed} rounding {rounding}")
            }
            Self::Rosette { arms, aspect, rounding } => {
                format!("rosette arms {arms} aspect {aspect} rounding {rounding}")
            }
        }
    }

    /// The kind that [`ShapeKind::name`] tells of; `None` for other words.
    #[must_use]
    pub fn parse(words: &[&str]) -> Option<Self> {
        let real = |text: &str| text.parse().ok();
        Some(match words {
            ["sphere"] => Self::Sphere,
            ["spheroid", "aspect", aspect] => Self::Spheroid { aspect: real(aspect)? },
            ["cube", "rounding", rounding] => Self::Cube { rounding: real(rounding)? },
            ["hexagonal-prism", "aspect", aspect, "rounding", rounding] => {
                Self::HexagonalPrism { aspect: real(aspect)?, rounding: real(rounding)? }
            }
            ["truncated-octahedron", "rounding", rounding] => {
                Self::TruncatedOctahedron { rounding: real(rounding)? }
            }
            ["random-polyhedron", "faces", faces, "seed", seed, "rounding", rounding] => {
                Self::RandomPolyhedron {
                    faces: faces.parse().ok()?,
                    seed: seed.parse().ok()?,
                    rounding: real(rounding)?,
                }
            }
            ["rosette", "arms", arms, "aspect", aspect, "rounding", rounding] => Self::Rosette {
                arms: arms.parse().ok()?,
                aspect: real(aspect)?,
                rounding: real(rounding)?,
            },
            _ => return None,
        })
    }
}

#[cfg(test)]
mod tests;
