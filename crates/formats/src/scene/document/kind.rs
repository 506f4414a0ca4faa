//! `kind` of `[[snow]]`: kinds of snow as they are named on the ground.
//!
//! Codes are those of Fierz et al. 2009, International Classification for Seasonal Snow on the Ground (IHP-VII
//! Technical Documents in Hydrology 83, UNESCO). Which values have a source, and which are a choice, says
//! `docs/snows.md`.

use super::super::quantity::Length;
use super::{ShapeName, ShapeTable, SnowTable};
use schemars::JsonSchema;
use serde::Deserialize;

/// Kinds of snow, each of which stands for sizes, a density and shapes of grains.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum SnowKindName {
    /// Precipitation particles (PP).
    Fresh,
    /// Wind packed rounded grains (RGwp).
    WindSlab,
    /// Settled rounded grains (RG).
    Old,
    /// Clustered rounded melt forms (MFcl).
    Corn,
    /// Melt-freeze crust (MFcr).
    MeltFreezeCrust,
    /// Snow that has outlasted a summer.
    Firn,
    /// Faceted crystals that are being rounded (FCxr).
    Faceted,
    /// Depth hoar (DH).
    DepthHoar,
    /// Surface hoar (SH).
    SurfaceHoar,
    /// Graupel (PPgp).
    Graupel,
}

impl SnowKindName {
    /// All kinds.
    pub const ALL: [Self; 10] = [
        Self::Fresh,
        Self::WindSlab,
        Self::Old,
        Self::Corn,
        Self::MeltFreezeCrust,
        Self::Firn,
        Self::Faceted,
        Self::DepthHoar,
        Self::SurfaceHoar,
        Self::Graupel,
    ];

    /// The name as written.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Fresh => "fresh",
            Self::WindSlab => "wind-slab",
            Self::Old => "old",
            Self::Corn => "corn",
            Self::MeltFreezeCrust => "melt-freeze-crust",
            Self::Firn => "firn",
            Self::Faceted => "faceted",
            Self::DepthHoar => "depth-hoar",
            Self::SurfaceHoar => "surface-hoar",
            Self::Graupel => "graupel",
        }
    }

    /// The kind of this name.
    #[must_use]
    pub fn from_name(name: &str) -> Option<Self> {
        Self::ALL.into_iter().find(|kind| kind.name() == name)
    }

    /// Median radius, metres, of spheres of equal volume.
    #[must_use]
    pub fn radius_metres(self) -> f64 {
        match self {
            Self::Fresh | Self::Faceted => 0.2e-3,
            Self::WindSlab => 0.12e-3,
            Self::Old => 0.25e-3,
            Self::Corn => 0.7e-3,
            Self::MeltFreezeCrust | Self::Firn => 0.5e-3,
            Self::DepthHoar => 0.9e-3,
            Self::SurfaceHoar => 1e-3,
            // Of the drops that froze to a pellet, which make it white.
            Self::Graupel => 0.1e-3,
        }
    }

    /// Geometric standard deviation of the radii, which are log-normal.
    #[must_use]
    pub fn spread(self) -> f64 {
        match self {
            Self::Fresh | Self::WindSlab | Self::SurfaceHoar | Self::Graupel => 1.4,
            Self::Old | Self::MeltFreezeCrust | Self::Faceted | Self::DepthHoar => 1.3,
            Self::Corn | Self::Firn => 1.25,
        }
    }

    /// Density, kg/m^3.
    #[must_use]
    pub fn density(self) -> f64 {
        match self {
            Self::Fresh => 65.0,
            Self::WindSlab => 370.0,
            Self::Old => 260.0,
            Self::Corn => 450.0,
            Self::MeltFreezeCrust => 550.0,
            Self::Firn => 600.0,
            Self::DepthHoar => 240.0,
            Self::SurfaceHoar => 100.0,
            Self::Faceted | Self::Graupel => 250.0,
        }
    }

    /// Shapes of the grains.
    pub(crate) fn shapes(self) -> Vec<ShapeTable> {
        use ShapeName::{HexagonalColumn, HexagonalPlate, HexagonalPrism, Rosette, Spheroid};
        let polyhedron = |fraction, rounding| ShapeTable {
            rounding: Some(rounding),
            ..shape(ShapeName::RandomPolyhedron, fraction)
        };
        let long =
            |name, fraction, aspect| ShapeTable { aspect: Some(aspect), ..shape(name, fraction) };
        match self {
            Self::Fresh => vec![
                long(HexagonalPlate, 0.6, 0.1),
                long(HexagonalColumn, 0.25, 3.0),
                long(Rosette, 0.15, 3.0),
            ],
            Self::WindSlab => vec![polyhedron(0.6, 0.7), long(Spheroid, 0.4, 1.4)],
            Self::Old => vec![long(Spheroid, 0.6, 1.4), polyhedron(0.4, 0.8)],
            Self::Corn => vec![shape(ShapeName::Sphere, 0.5), long(Spheroid, 0.5, 1.2)],
            Self::MeltFreezeCrust => vec![long(Spheroid, 0.6, 1.3), polyhedron(0.4, 0.9)],
            Self::Firn => vec![long(Spheroid, 0.7, 1.2), polyhedron(0.3, 0.9)],
            Self::Faceted => faceted(),
            Self::DepthHoar => vec![
                long(HexagonalColumn, 0.4, 1.8),
                long(HexagonalPrism, 0.3, 0.9),
                long(HexagonalPlate, 0.3, 0.4),
            ],
            Self::SurfaceHoar => {
                vec![long(HexagonalPlate, 0.8, 0.08), long(HexagonalColumn, 0.2, 4.0)]
            }
            Self::Graupel => vec![shape(ShapeName::Sphere, 0.5), long(Spheroid, 0.5, 1.2)],
        }
    }

    /// Says what a body of snow of this kind leaves unsaid. Keys that say the same in other words count: `sizes` for
    /// the radii, `variation` for their spread, a `rule` for the density.
    pub(in super::super) fn complete(self, table: &mut SnowTable) {
        if table.sizes.is_none() {
            if table.variation.is_none() {
                table.spread.get_or_insert(self.spread());
            }
            table.radius.get_or_insert(Length { metres: self.radius_metres() });
        }
        if table.rule.is_none() {
            table.density.get_or_insert(self.density());
        }
        if table.shapes.is_empty() {
            table.shapes = self.shapes();
        }
    }
}

/// The grains whose light is that of natural snow (`docs/snows.md`): four polyhedra rounded by .7, so that no one
/// of them shows, and flat and long spheroids.
fn faceted() -> Vec<ShapeTable> {
    let polyhedron = |seed| ShapeTable {
        rounding: Some(0.7),
        seed: Some(seed),
        ..shape(ShapeName::RandomPolyhedron, 0.15)
    };
    let spheroid = |aspect| ShapeTable { aspect: Some(aspect), ..shape(ShapeName::Spheroid, 0.2) };
    let polyhedra = (0..4).map(polyhedron);
    polyhedra.chain([0.5, 1.6].map(spheroid)).collect()
}

/// A shape with the defaults of its keys.
fn shape(shape: ShapeName, fraction: f64) -> ShapeTable {
    ShapeTable { fraction: Some(fraction), ..ShapeTable::of(shape) }
}
