//! `[[snow.shapes]]` as written.

use schemars::JsonSchema;
use serde::Deserialize;
use snowgrain_geometry::ShapeKind;

/// A shape of grains. Which keys may be used depends on `shape`.
#[derive(Clone, Debug, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ShapeTable {
    /// "sphere", "spheroid", "cube", "hexagonal-plate", "hexagonal-column", "hexagonal-prism",
    /// "truncated-octahedron", "random-polyhedron", "rosette" (columns that grow from one point) or
    /// "mesh" (from `file`). The radius of a grain is that of the sphere of equal volume; its c axis is y
    /// where it is not turned.
    pub shape: ShapeName,
    /// Part of the grains of this shape, relative to the other shapes of this snow: a number above 0; by number
    /// and by mass alike, as all shapes have the radii of their snow; default 1.
    #[serde(default)]
    pub fraction: Option<f64>,
    /// Length along the c axis by width across it (of hexagons from corner to corner), 0.02 to 50; default
    /// 0.2 for "hexagonal-plate" (at most 1), 2 for "hexagonal-column" (at least 1) and "rosette" (its arms),
    /// else 1; spheroid, hexagonal-plate, hexagonal-column, hexagonal-prism, rosette.
    #[serde(default)]
    pub aspect: Option<f64>,
    /// How round edges and corners are, 0 (sharp) to 1 (an ellipsoid that the faces only touch); default 0; all
    /// but sphere, spheroid and mesh.
    #[serde(default)]
    pub rounding: Option<f64>,
    /// Faces of a random polyhedron: 6 to 32; default 14; random-polyhedron.
    #[serde(default)]
    pub faces: Option<u32>,
    /// Which random polyhedron: a whole number; default 0; random-polyhedron.
    #[serde(default)]
    pub seed: Option<u64>,
    /// Columns of a rosette: 2 to 12; default 6; rosette.
    #[serde(default)]
    pub arms: Option<u32>,
    /// Mesh file (.obj, .ply, .gltf or .glb) of any size, relative to the scene file: closed, with at most
    /// 256 faces; one that is not convex is cut into at most 64 cells by the planes of its faces; mesh.
    #[serde(default)]
    pub file: Option<String>,
    /// How grains lie: "random", "horizontal" (the c axis vertical, turned about it at random) or "aligned" (all
    /// alike, the c axis along `axis`); default "random".
    #[serde(default)]
    pub orientation: OrientationName,
    /// Spread of the c axis, degrees: the standard deviation in each of two directions, 0 to 90; default 0;
    /// horizontal, aligned.
    #[serde(default)]
    pub spread: Option<f64>,
    /// Direction of the c axis: [x, y, z], three numbers of any length; default [0, 1, 0]; aligned.
    #[serde(default)]
    pub axis: Option<[f64; 3]>,
}

impl ShapeTable {
    /// A shape of which nothing else is said.
    #[must_use]
    pub fn of(shape: ShapeName) -> Self {
        Self {
            shape,
            fraction: None,
            aspect: None,
            rounding: None,
            faces: None,
            seed: None,
            arms: None,
            file: None,
            orientation: OrientationName::Random,
            spread: None,
            axis: None,
        }
    }

    /// The shape that its keys mean, with their defaults; `None` for a mesh, which its file tells.
    ///
    /// # Errors
    /// The key whose value does not suit the name of the shape, and what to do.
    pub fn kind(&self) -> Result<Option<ShapeKind>, (&'static str, &'static str)> {
        let rounding = self.rounding.unwrap_or(0.0);
        let aspect = |default: f64| self.aspect.unwrap_or(default);
        Ok(Some(match self.shape {
            ShapeName::Sphere => ShapeKind::Sphere,
            ShapeName::Spheroid => ShapeKind::Spheroid { aspect: aspect(1.0) },
            ShapeName::Cube => ShapeKind::Cube { rounding },
            ShapeName::HexagonalPlate if aspect(0.2) > 1.0 => {
                return Err(("aspect", "a plate's is at most 1; use shape = \"hexagonal-column\""));
            }
            ShapeName::HexagonalColumn if aspect(2.0) < 1.0 => {
                return Err((
                    "aspect",
                    "a column's is at least 1; use shape = \"hexagonal-plate\"",
                ));
            }
            ShapeName::HexagonalPlate => {
                ShapeKind::HexagonalPrism { aspect: aspect(0.2), rounding }
            }
            ShapeName::HexagonalColumn => {
                ShapeKind::HexagonalPrism { aspect: aspect(2.0), rounding }
            }
            ShapeName::HexagonalPrism => {
                ShapeKind::HexagonalPrism { aspect: aspect(1.0), rounding }
            }
            ShapeName::TruncatedOctahedron => ShapeKind::TruncatedOctahedron { rounding },
            ShapeName::RandomPolyhedron => ShapeKind::RandomPolyhedron {
                faces: self.faces.unwrap_or(14),
                seed: self.seed.unwrap_or(0),
                rounding,
            },
            ShapeName::Rosette => {
                ShapeKind::Rosette { arms: self.arms.unwrap_or(6), aspect: aspect(2.0), rounding }
            }
            ShapeName::Mesh => return Ok(None),
        }))
    }
}

/// Shapes of grains.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum ShapeName {
    /// A ball.
    Sphere,
    /// An ellipsoid of revolution.
    Spheroid,
    /// A cube.
    Cube,
    /// A flat hexagonal prism.
    HexagonalPlate,
    /// A long hexagonal prism.
    HexagonalColumn,
    /// A hexagonal prism.
    HexagonalPrism,
    /// 8 hexagons and 6 squares.
    TruncatedOctahedron,
    /// Faces in random directions.
    RandomPolyhedron,
    /// Columns that grow from one point.
    Rosette,
    /// From a file.
    Mesh,
}

impl ShapeName {
    /// All that need no file.
    pub const OF_NUMBERS: [Self; 9] = [
        Self::Sphere,
        Self::Spheroid,
        Self::Cube,
        Self::HexagonalPlate,
        Self::HexagonalColumn,
        Self::HexagonalPrism,
        Self::TruncatedOctahedron,
        Self::RandomPolyhedron,
        Self::Rosette,
    ];

    /// The name as written.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Sphere => "sphere",
            Self::Spheroid => "spheroid",
            Self::Cube => "cube",
            Self::HexagonalPlate => "hexagonal-plate",
            Self::HexagonalColumn => "hexagonal-column",
            Self::HexagonalPrism => "hexagonal-prism",
            Self::TruncatedOctahedron => "truncated-octahedron",
            Self::RandomPolyhedron => "random-polyhedron",
            Self::Rosette => "rosette",
            Self::Mesh => "mesh",
        }
    }

    /// Keys that it takes beside `shape`, `fraction` and those of the orientation.
    #[must_use]
    pub fn keys(self) -> &'static [&'static str] {
        match self {
            Self::Sphere => &[],
            Self::Spheroid => &["aspect"],
            Self::Cube | Self::TruncatedOctahedron => &["rounding"],
            Self::HexagonalPlate | Self::HexagonalColumn | Self::HexagonalPrism => {
                &["aspect", "rounding"]
            }
            Self::RandomPolyhedron => &["faces", "seed", "rounding"],
            Self::Rosette => &["arms", "aspect", "rounding"],
            Self::Mesh => &["file"],
        }
    }
}

/// How grains lie.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum OrientationName {
    /// In all ways.
    #[default]
    Random,
    /// The c axis vertical.
    Horizontal,
    /// All alike.
    Aligned,
}

impl OrientationName {
    /// Keys that it takes.
    #[must_use]
    pub fn keys(self) -> &'static [&'static str] {
        match self {
            Self::Random => &[],
            Self::Horizontal => &["spread"],
            Self::Aligned => &["spread", "axis"],
        }
    }
}
