//! What `[camera]` means.

use super::super::SceneError;
use super::super::document::{CameraKind, CameraTable};
use super::checks::Checks;
use snowgrain_math::{DVec3, trig};
use snowgrain_render::description::{CameraDescription, Focus, Lens, Projection};

/// Vertical field of view where none is given, degrees.
const VERTICAL_FOV_DEGREES: f64 = 40.0;

/// Height of the sensor where none is given, metres: that of 24 x 36 mm film.
const SENSOR_HEIGHT: f64 = 0.024;

/// Most blades.
const MOST_BLADES: u32 = 64;

/// The camera as written, if it is.
pub(super) fn camera(checks: &Checks<'_>) -> Result<Option<CameraDescription>, SceneError> {
    let Some(table) = &checks.document().camera else { return Ok(None) };
    let from = checks.position("camera.from", table.from)?;
    let at = checks.position("camera.at", table.at)?;
    let up = DVec3::from(checks.finite("camera.up", table.up)?);
    let gaze = (at - from).try_normalize();
    let Some(gaze) = gaze else {
        return Err(checks.bad("camera.at", "must differ from camera.from"));
    };
    let Some(upward) = (up / up.abs().max_element()).try_normalize() else {
        return Err(checks.bad("camera.up", "must not be zero; [0, 1, 0] is usual"));
    };
    if gaze.cross(upward).length() < 1e-6 {
        let mend = "must not point along the line of sight; to look straight down use [0, 0, -1]";
        return Err(checks.bad("camera.up", mend));
    }
    let projection = match table.kind {
        CameraKind::Perspective => perspective(checks, table, (from, gaze, at))?,
        CameraKind::Orthographic => orthographic(checks, table)?,
    };
    let backdrop = checks.radiance("camera.backdrop", table.backdrop)?;
    Ok(Some(CameraDescription { from, at, up, projection, backdrop }))
}

/// log2 of 1.2 cd/m^2: what saturates a camera at an exposure value of 0, 78 / (100 * 0.65) by ISO
/// 12232 with a lens that lets 0.65 through (Lagarde and de Rousiers 2014, "Moving Frostbite to
/// Physically Based Rendering", section 5.1.2).
const LOG2_SATURATION: f64 = 0.263_034_405_833_793_8;

/// The exposure that makes the luminance white which saturates a camera set to `camera.ev100`.
pub(super) fn exposure_stops(checks: &Checks<'_>) -> Result<f64, SceneError> {
    match checks.document().camera.as_ref().and_then(|camera| camera.ev100) {
        None => Ok(0.0),
        Some(ev100) if (-30.0..=50.0).contains(&ev100) => Ok(-(ev100 + LOG2_SATURATION)),
        Some(_) => Err(checks.bad("camera.ev100", "must be -30 to 50 (sunlit snow has 15)")),
    }
}

fn orthographic(checks: &Checks<'_>, table: &CameraTable) -> Result<Projection, SceneError> {
    let foreign = [
        ("vertical_fov", table.vertical_fov.is_some()),
        ("aperture", table.aperture.is_some()),
        ("f_number", table.f_number.is_some()),
        ("sensor_height", table.sensor_height.is_some()),
        ("focus", table.focus.is_some()),
        ("blades", table.blades.is_some()),
        ("blade_rotation", table.blade_rotation.is_some()),
    ];
    if let Some((name, _)) = foreign.iter().find(|(_, written)| *written) {
        let mend = "parallel rays have neither angle nor lens; remove it, or write kind = \
                    \"perspective\"";
        return Err(checks.misplaced(&format!("camera.{name}"), mend));
    }
    let mend = "say how much of the world the picture is high, as height = \"10 cm\"";
    let height = table.height.ok_or_else(|| checks.missing("camera.height", mend))?;
    Ok(Projection::Orthographic { height: checks.size("camera.height", height)? })
}

/// `view`: where the camera is, where it looks, and at which point.
fn perspective(
    checks: &Checks<'_>,
    table: &CameraTable,
    view: (DVec3, DVec3, DVec3),
) -> Result<Projection, SceneError> {
    if table.height.is_some() {
        let mend = "is for kind = \"orthographic\"; a perspective camera has vertical_fov";
        return Err(checks.misplaced("camera.height", mend));
    }
    let vertical_fov_degrees = table.vertical_fov.unwrap_or(VERTICAL_FOV_DEGREES);
    if !(vertical_fov_degrees > 0.0 && vertical_fov_degrees < 180.0) {
        return Err(checks.bad("camera.vertical_fov", "must be above 0 and below 180 degrees"));
    }
    let Some(diameter) = pupil(checks, table, vertical_fov_degrees)? else {
        refuse_without_lens(checks, table)?;
        return Ok(Projection::pinhole(vertical_fov_degrees));
    };
    let lens = Lens {
        diameter,
        focus: self::focus(checks, table.focus, view)?,
        blades: blades(checks, table.blades)?,
        blade_rotation_degrees: blade_rotation(checks, table)?,
    };
    Ok(Projection::Perspective { vertical_fov_degrees, lens: Some(lens) })
}

/// Diameter of the entrance pupil, metres; `None` for a pinhole.
fn pupil(
    checks: &Checks<'_>,
    table: &CameraTable,
    vertical_fov_degrees: f64,
) -> Result<Option<f64>, SceneError> {
    let sensor_height = match table.sensor_height {
        Some(_) if table.f_number.is_none() => {
            let mend = "only an f-number needs the sensor; add f_number = 2.8, or remove it";
            return Err(checks.misplaced("camera.sensor_height", mend));
        }
        Some(height) => checks.size("camera.sensor_height", height)?,
        None => SENSOR_HEIGHT,
    };
    match (table.aperture, table.f_number) {
        (Some(_), Some(_)) => {
            let mend = "camera.aperture says how wide the lens is already; remove one of them";
            Err(checks.misplaced("camera.f_number", mend))
        }
        (Some(diameter), None) => checks.size("camera.aperture", diameter).map(Some),
        (None, Some(f_number)) => {
            if !(1e-3..=1e6).contains(&f_number) {
                return Err(checks.bad("camera.f_number", "must be above 0, as 2.8"));
            }
            let half_fov = (vertical_fov_degrees * 0.5).to_radians();
            let focal_length = sensor_height * 0.5 / trig::tan(half_fov);
            Ok(Some(focal_length / f_number))
        }
        (None, None) => Ok(None),
    }
}

fn refuse_without_lens(checks: &Checks<'_>, table: &CameraTable) -> Result<(), SceneError> {
    let lens_alone = [
        ("focus", table.focus.is_some()),
        ("blades", table.blades.is_some()),
        ("blade_rotation", table.blade_rotation.is_some()),
    ];
    if let Some((name, _)) = lens_alone.iter().find(|(_, written)| *written) {
        let mend = "a pinhole has no lens; add aperture = \"2 mm\" or f_number = 2.8, or remove it";
        return Err(checks.misplaced(&format!("camera.{name}"), mend));
    }
    Ok(())
}

fn focus(
    checks: &Checks<'_>,
    written: Option<super::super::Focus>,
    (from, gaze, at): (DVec3, DVec3, DVec3),
) -> Result<Focus, SceneError> {
    use super::super::Focus as Written;
    let point = match written {
        Some(Written::Surface) => return Ok(Focus::Surface),
        Some(Written::Distance(distance)) => {
            return checks.size("camera.focus", distance).map(Focus::Distance);
        }
        Some(Written::Point(point)) => checks.position("camera.focus", point)?,
        None => at,
    };
    let distance = (point - from).dot(gaze);
    if distance >= super::checks::SMALLEST {
        return Ok(Focus::Distance(distance));
    }
    Err(checks.bad("camera.focus", "the point must lie before the camera"))
}

fn blades(checks: &Checks<'_>, blades: Option<u32>) -> Result<u32, SceneError> {
    match blades {
        None => Ok(0),
        Some(blades) if blades == 0 || (3..=MOST_BLADES).contains(&blades) => Ok(blades),
        Some(_) => {
            Err(checks.bad("camera.blades", format!("must be 0 (round) or 3 to {MOST_BLADES}")))
        }
    }
}

fn blade_rotation(checks: &Checks<'_>, table: &CameraTable) -> Result<f64, SceneError> {
    let Some(rotation) = table.blade_rotation else { return Ok(0.0) };
    if table.blades.unwrap_or(0) == 0 {
        let mend =
            "a round opening looks the same however it is turned; add blades = 7, or remove it";
        return Err(checks.misplaced("camera.blade_rotation", mend));
    }
    let [rotation] = checks.finite("camera.blade_rotation", [rotation])?;
    Ok(rotation)
}
