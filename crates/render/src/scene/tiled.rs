//! Bodies of snow so large that their grains are never listed.

use super::{BuildReport, BuildStage, SnowReport};
use crate::RenderError;
use crate::description::{SceneDescription, SnowDescription};
use crate::scene_hash::GrainDigest;
use snowgrain_accel::{GrainGrid, Surfaces};
use snowgrain_geometry::Quantisation;
use snowgrain_grains::{FillSettings, TiledFill};

/// Grains from which snow is made of shared tiles where the scene does not say.
const MANY: f64 = 4e6;

/// The bodies of a scene whose snow is to be made of tiles that are kept once; `None` where all grains are listed.
pub(crate) fn tiled_bodies(description: &SceneDescription) -> Option<Vec<&FillSettings>> {
    if description.tiled == Some(false)
        || description.has_shapes()
        || !description.strata.loads.is_empty()
    {
        return None;
    }
    let mut bodies: Vec<&FillSettings> = Vec::new();
    for snow in &description.snow {
        let SnowDescription::Filled(settings) = snow else { return None };
        bodies.push(settings);
    }
    let grains: f64 = bodies.iter().map(|body| body.expected_grains()).sum();
    let many = description.tiled == Some(true) || grains >= MANY;
    (many && TiledFill::fits(&bodies)).then_some(bodies)
}

impl SceneDescription {
    /// Whether snow that is to be made of tiles in any case can be.
    #[must_use]
    pub fn can_be_tiled_as_told(&self) -> bool {
        self.tiled != Some(true) || tiled_bodies(self).is_some()
    }
}

/// Makes the tiles and packs the snow by them.
pub(super) fn tiled_grid(
    description: &SceneDescription,
    bodies: &[&FillSettings],
    (quantisation, surfaces): (Quantisation, &Surfaces),
    report: &mut BuildReport,
    stage: &mut dyn FnMut(BuildStage),
) -> Result<(GrainGrid, GrainDigest), RenderError> {
    stage(BuildStage::Snow { index: 0 });
    let failed = |source| RenderError::Snow { index: 0, source };
    let fill = TiledFill::new(bodies, quantisation).map_err(failed)?;
    stage(BuildStage::Packing);
    let packing = description.packing.unwrap_or_default();
    let (grid, reports) = fill.pack(surfaces, packing)?;
    if let Some(fault) = fill.fault() {
        return Err(failed(fault));
    }
    if grid.grains() == 0 {
        let reason =
            "holds no grain: it is smaller than a few of them, or lies beside its pictures";
        let source = snowgrain_grains::GrainsError::Setting { key: "body", reason: reason.into() };
        return Err(failed(source));
    }
    report.snow.extend(reports.into_iter().map(SnowReport::Filled));
    let digest = GrainDigest::of_tiles(quantisation, packing, fill.variants(), bodies);
    Ok((grid, digest))
}
