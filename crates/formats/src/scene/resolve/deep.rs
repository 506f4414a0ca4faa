//! The keys of light deep in the snow.

use super::checks::Checks;
use crate::scene::SceneError;
use crate::scene::document::DeepName;
use snowgrain_render::transport::deep::DeepSettings;
use snowgrain_render::transport::medium::ProxyStart;

/// Error that is allowed where none is told.
const DEFAULT_ERROR: f64 = 0.01;

/// What becomes of light deep in the snow; `None` where it is followed to its end. Where small lights are looked for it ends
/// farther down.
pub(super) fn deep(
    checks: &Checks<'_>,
    has_small_lights: bool,
) -> Result<Option<DeepSettings>, SceneError> {
    let table = &checks.document().integrator;
    if table.deep == DeepName::Exact {
        let given = [
            ("integrator.deep_after_grains", table.deep_after_grains.is_some()),
            ("integrator.deep_depth", table.deep_depth.is_some()),
            ("integrator.lod_error", table.lod_error.is_some()),
            ("integrator.learning_paths", table.learning_paths.is_some()),
        ];
        return match given.iter().find(|(_, given)| *given) {
            Some((key, _)) => Err(checks.misplaced(key, "needs integrator.deep = \"learnt\"")),
            None => Ok(None),
        };
    }
    if matches!(table.deep, DeepName::Proxy | DeepName::Shells) {
        return Ok(None);
    }
    let error = table.lod_error.unwrap_or(DEFAULT_ERROR);
    let mut settings = DeepSettings::for_error(error).filter(|_| error < 1.0).ok_or_else(|| {
        let mend = format!("must be from {} to 1", DeepSettings::LEAST_ERROR);
        checks.bad("integrator.lod_error", mend)
    })?;
    if has_small_lights {
        settings = settings.under_small_lights();
    }
    settings.depth = depth(checks)?.unwrap_or(settings.depth);
    settings.after_grains =
        table.deep_after_grains.map_or(settings.after_grains, |grains| [grains; 2]);
    settings.learning_paths = table.learning_paths.unwrap_or(settings.learning_paths);
    if !(1024..=1_000_000_000).contains(&settings.learning_paths) {
        let mend = "must be a whole number from 1024 to 1e9";
        return Err(checks.bad("integrator.learning_paths", mend));
    }
    Ok(Some(settings))
}

/// The depth that is told.
fn depth(checks: &Checks<'_>) -> Result<Option<f64>, SceneError> {
    let depth = checks.document().integrator.deep_depth;
    if depth.is_some_and(|depth| !(0.0..=20.0).contains(&depth)) {
        return Err(checks.bad("integrator.deep_depth", "must be from 0 to 20"));
    }
    Ok(depth)
}

/// Where light goes on as the proxy; `None` where it does not. Where small lights are looked for that is farther down.
pub(super) fn proxy(
    checks: &Checks<'_>,
    has_small_lights: bool,
) -> Result<Option<ProxyStart>, SceneError> {
    let table = &checks.document().integrator;
    let jumps = match table.deep {
        DeepName::Proxy => false,
        DeepName::Shells => true,
        DeepName::Exact | DeepName::Learnt => return Ok(None),
    };
    let learnt = [
        ("integrator.lod_error", table.lod_error.is_some()),
        ("integrator.learning_paths", table.learning_paths.is_some()),
    ];
    if let Some((key, _)) = learnt.iter().find(|(_, given)| *given) {
        return Err(checks.misplaced(key, "needs integrator.deep = \"learnt\""));
    }
    let known = DeepSettings::for_error(DEFAULT_ERROR);
    let known = if has_small_lights { known.map(DeepSettings::under_small_lights) } else { known };
    let [after_grains, deep] = known.map_or([0.0; 2], |s| [f64::from(s.after_grains[0]), s.depth]);
    Ok(Some(ProxyStart {
        after_grains: table.deep_after_grains.unwrap_or(after_grains as u32),
        depth: depth(checks)?.unwrap_or(deep),
        jumps,
    }))
}
