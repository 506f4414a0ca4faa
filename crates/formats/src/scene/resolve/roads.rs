//! What the roads of comparison cannot do.

use super::checks::Checks;
use crate::scene::SceneError;
use snowgrain_render::description::{DirectView, IntegratorKind, SceneDescription};
use snowgrain_render::transport::medium::MediumKind;

/// Refuses what a scene asks of a road that it cannot do.
pub(super) fn refuse_beyond(
    checks: &Checks<'_>,
    scene: &SceneDescription,
) -> Result<(), SceneError> {
    let IntegratorKind::Medium(kind) = scene.integrator else { return Ok(()) };
    let catches = scene.objects.iter().any(|o| o.direct_view == DirectView::ShadowCatcher);
    let cases = [
        (scene.deep.is_some(), "follows all light to its end; leave integrator.deep out"),
        (scene.has_shapes(), "knows spheres alone, and some grains have shapes"),
        (!scene.strata.loads.is_empty(), "does not tell the impurities of one snow from another's"),
        (scene.ice.disperses, "knows no dispersion; leave material.dispersion out"),
        (catches, "shows no shadow catchers"),
        (
            kind == MediumKind::Volume && scene.ice.eta() <= 1.0,
            "refracts by grains that are denser than what is between them",
        ),
    ];
    match cases.into_iter().find(|(beyond, _)| *beyond) {
        None => Ok(()),
        Some((_, why)) => {
            Err(checks.bad("integrator.kind", format!("this road {why}; or use \"grains\"")))
        }
    }
}
