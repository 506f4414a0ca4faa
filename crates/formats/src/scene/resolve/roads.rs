//! What the roads of comparison cannot do.

use super::checks::Checks;
use super::deep::KNOWN_INDICES;
use crate::scene::SceneError;
use crate::scene::document::DeepName;
use snowgrain_render::description::{
    DirectView, IntegratorKind, LightFinding, SceneDescription, SnowDescription,
};
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
    let catches = scene.objects.iter().any(|o| o.direct_view == DirectView::ShadowCatcher);
    let measured = KNOWN_INDICES.contains(&scene.ice.eta());
    let cases = [
        (deep, "follows all light to its end; leave integrator.deep out"),
        (scene.has_shapes(), SPHERES),
        (!scene.strata.loads.is_empty(), STRATA),
        (scene.ice.disperses, "knows no dispersion; leave material.dispersion out"),
        (catches, "shows no shadow catchers"),
        (kind == MediumKind::Proxy && !measured, UNMEASURED),
        (kind == MediumKind::Proxy && has_lattices(scene), LATTICES),
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

const SPHERES: &str = "knows spheres alone, and some grains have shapes";
const UNMEASURED: &str = "was measured for ice in air alone (a relative index from 1.29 to 1.34)";
const STRATA: &str = "does not tell the impurities of one snow from another's";

const LATTICES: &str = "was measured for packs at random alone, and some snow is a lattice";

fn has_lattices(scene: &SceneDescription) -> bool {
    scene.snow.iter().any(|snow| matches!(snow, SnowDescription::Lattice(_)))
}

/// Refuses what light that goes on as the proxy cannot do.
fn refuse_proxy(
    checks: &Checks<'_>,
    scene: &SceneDescription,
    jumps: bool,
) -> Result<(), SceneError> {
    let cases = [
        (
            scene.light_finding != LightFinding::Exact,
            "looks for no light: suns, lamps and maps need \"learnt\" or \"exact\"",
        ),
        (scene.has_shapes(), SPHERES),
        (!scene.strata.loads.is_empty(), STRATA),
        (scene.ice.disperses, "knows no dispersion; leave material.dispersion out"),
        (!KNOWN_INDICES.contains(&scene.ice.eta()), UNMEASURED),
        (has_lattices(scene), LATTICES),
    ];
    let why = cases.into_iter().find(|(beyond, _)| *beyond);
    let name = if jumps { "shells" } else { "proxy" };
    why.map_or(Ok(()), |(_, why)| Err(checks.bad("integrator.deep", format!("\"{name}\" {why}"))))
}
