//! Snow as a medium with its calibration, which is measured where it is not known, and kept.

use super::{BuildStage, SnowReport};
use crate::RenderError;
use crate::description::SnowDescription;
use crate::measure::{CALIBRATION_PATHS, calibrate_proxy};
use crate::transport::deep::LearntStore;
use crate::transport::medium::{Calibration, Medium};
use snowgrain_grains::DepositSettings;

/// The medium of bodies of snow with the calibration that its grains need: from a store where it is there, else measured and put
/// there.
pub(super) fn calibrated(
    medium: Medium,
    bodies: (&[SnowDescription], &[SnowReport]),
    mut store: Option<&mut LearntStore<'_>>,
    stage: &mut dyn FnMut(BuildStage),
) -> Result<Medium, RenderError> {
    let because = |source| RenderError::Calibration { source };
    let snow = medium.inner_snow(fell(bodies)).map_err(because)?;
    let Some(snow) = snow.filter(|snow| !snow.is_known()) else { return Ok(medium) };
    stage(BuildStage::Deep);
    // What Debug writes of a number reads back as that number.
    let mut hasher = blake3::Hasher::new_derive_key("snowgrain calibration of the proxy 1");
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

/// How the body of most grains fell, if it fell by a rule and not to a density, as packs are made.
fn fell((bodies, reports): (&[SnowDescription], &[SnowReport])) -> Option<DepositSettings> {
    let grains = |report: &SnowReport| match report {
        SnowReport::Fell(report) => report.accepted,
        SnowReport::Filled(report) => report.grains,
        SnowReport::Placed => 0,
    };
    let most = bodies.iter().zip(reports).max_by_key(|(_, report)| grains(report))?;
    match most.0 {
        SnowDescription::Deposit(settings) if settings.density.is_none() => Some(settings.clone()),
        _ => None,
    }
}
