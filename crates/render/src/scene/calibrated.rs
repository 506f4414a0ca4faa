//! Snow as a medium with its calibration, which is measured where it is not known, and kept.

use super::{BuildStage, SnowReport};
use crate::RenderError;
use crate::description::{SceneDescription, SnowDescription};
use crate::measure::{CALIBRATION_PATHS, calibrate_proxy};
use crate::transport::deep::LearntStore;
use crate::transport::medium::{Calibration, InnerSnow, Medium};
use snowgrain_grains::DepositSettings;

/// The medium of a scene's snow with the calibration that its grains need: from a store where it is there, else measured and put
/// there.
pub(super) fn calibrated(
    medium: Medium,
    (description, reports): (&SceneDescription, &[SnowReport]),
    mut store: Option<&mut LearntStore<'_>>,
    stage: &mut dyn FnMut(BuildStage),
) -> Result<Medium, RenderError> {
    let because = |source| RenderError::Calibration { source };
    let main = main_body(reports);
    let snow = medium.inner_snow(main.and_then(|body| fell(&description.snow[body])));
    let Some(snow) = snow.map_err(because)?.filter(|snow| !snow.is_known()) else {
        return Ok(medium);
    };
    // With how its grains lie, as it is asked for.
    let mix = main.and_then(|body| description.shapes_of(body)).cloned();
    let snow = InnerSnow { mix: mix.or(snow.mix), ..snow };
    stage(BuildStage::Deep);
    // What Debug writes of a number reads back as that number.
    let mut hasher = blake3::Hasher::new_derive_key("snowgrain calibration of the proxy 2");
    let key = *hasher.update(format!("{snow:?}").as_bytes()).finalize().as_bytes();
    let mut measured = None;
    if let Some(store) = &mut store {
        measured = (store.load)(&key).and_then(|bytes| Calibration::from_bytes(&key, &bytes));
    }
    let measured = match measured {
        Some(measured) => measured,
        None => {
            let measured = calibrate_proxy(&snow, CALIBRATION_PATHS).map_err(because)?;
            if let Some(store) = store {
                (store.save)(&key, &measured.to_bytes(&key));
            }
            measured
        }
    };
    Ok(medium.calibrated(&Calibration::table_through(measured)))
}

/// The body of snow of most grains.
fn main_body(reports: &[SnowReport]) -> Option<usize> {
    let grains = |body: &usize| match &reports[*body] {
        SnowReport::Fell(report) => report.accepted,
        SnowReport::Filled(report) => report.grains,
        SnowReport::Placed => 0,
    };
    (0..reports.len()).max_by_key(grains)
}

/// How a body fell, if it fell by a rule and not to a density, as packs are made.
fn fell(body: &SnowDescription) -> Option<DepositSettings> {
    match body {
        SnowDescription::Deposit(settings) if settings.density.is_none() => Some(settings.clone()),
        _ => None,
    }
}
