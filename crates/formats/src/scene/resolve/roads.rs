//! What the roads of comparison cannot do.

use super::checks::Checks;
use crate::scene::SceneError;
use crate::scene::document::DeepName;
use snowgrain_render::description::{IntegratorKind, SceneDescription, SnowDescription};
use snowgrain_render::transport::medium::MediumKind;

/// Refuses what a scene asks of a road that it cannot do.
pub(super) fn refuse_beyond(
    checks: &Checks<'_>,
    scene: &SceneDescription,
) -> Result<(), SceneError> {
    let (kind, volume) = match scene.integrator {
        IntegratorKind::Grains => return Ok(()),
        IntegratorKind::ProxyInDepth(start) => return refuse_proxy(checks, scene, start.jumps),
        IntegratorKind::Medium(kind) => (kind, kind == MediumKind::Volume),
    };
    let deep = checks.document().integrator.deep != DeepName::Exact;
    let proxy = kind == MediumKind::Proxy;
    let cases = [
        (deep, "follows all light to its end; leave integrator.deep out"),
        (!proxy && scene.has_shapes(), "knows spheres alone, and some grains have shapes"),
        (
            !proxy && !scene.strata.loads.is_empty(),
            "does not tell the impurities of one snow from another's",
        ),
        (scene.ice.disperses, "knows no dispersion; leave material.dispersion out"),
        (proxy && has_lattices(scene), LATTICES),
        (
            volume && scene.ice.eta() <= 1.0,
            "refracts by grains that are denser than what is between them",
        ),
        (
            kind == MediumKind::Dipole && scene.film.keep_ice_paths,
            "knows no lengths in ice; leave \"ice-paths\" out of film.keep",
        ),
    ];
    let why = cases.into_iter().find(|(beyond, _)| *beyond);
    let name = match kind {
        MediumKind::Volume => "volume",
        MediumKind::Proxy => "proxy",
        MediumKind::Dipole => "dipole",
    };
    why.map_or(Ok(()), |(_, why)| {
        Err(checks.bad("integrator.kind", format!("\"{name}\" {why}; or use \"grains\"")))
    })
}

const LATTICES: &str = "takes grains to lie at random, and some snow is a lattice";

fn has_lattices(scene: &SceneDescription) -> bool {
    scene.snow.iter().any(|snow| matches!(snow, SnowDescription::Lattice(_)))
}

/// Refuses what light that goes on as the proxy cannot do.
fn refuse_proxy(
    checks: &Checks<'_>,
    scene: &SceneDescription,
    jumps: bool,
) -> Result<(), SceneError> {
    if !has_lattices(scene) {
        return Ok(());
    }
    let name = if jumps { "shells" } else { "proxy" };
    Err(checks.bad("integrator.deep", format!("\"{name}\" {LATTICES}")))
}
