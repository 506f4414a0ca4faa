//! The keys of light deep in the snow.

use super::checks::Checks;
use crate::scene::SceneError;
use crate::scene::document::DeepName;
use snowgrain_render::transport::deep::DeepSettings;

/// Error that is allowed where none is told.
const DEFAULT_ERROR: f64 = 0.01;

/// What becomes of light deep in the snow; `None` where it is followed to its end.
pub(super) fn deep(checks: &Checks<'_>) -> Result<Option<DeepSettings>, SceneError> {
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
    let error = table.lod_error.unwrap_or(DEFAULT_ERROR);
    let mut settings = DeepSettings::for_error(error).filter(|_| error < 1.0).ok_or_else(|| {
        let mend = format!("must be from {} to 1", DeepSettings::LEAST_ERROR);
        checks.bad("integrator.lod_error", mend)
    })?;
    if let Some(depth) = table.deep_depth {
        if !(0.0..=20.0).contains(&depth) {
            return Err(checks.bad("integrator.deep_depth", "must be from 0 to 20"));
        }
        settings.depth = depth;
    }
    settings.after_grains = table.deep_after_grains.unwrap_or(settings.after_grains);
    settings.learning_paths = table.learning_paths.unwrap_or(settings.learning_paths);
    if !(1024..=1_000_000_000).contains(&settings.learning_paths) {
        let mend = "must be a whole number from 1024 to 1e9";
        return Err(checks.bad("integrator.learning_paths", mend));
    }
    Ok(Some(settings))
}
