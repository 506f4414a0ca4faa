//! The lights of a shot (KHR_lights_punctual of glTF).
//!
//! The format counts in lux and candela, so radiances are luminances in cd/m^2, times `light_strength`:
//! light of E lux gives white ground across it the radiance E / pi.

use super::super::super::SceneError;
use super::super::super::document::ImportTable;
use super::super::super::quantity::Triple;
use super::super::checks::{Checks, LARGEST};
use crate::gltf::{ImportedLight, ImportedLightKind};
use snowgrain_math::{DAffine3, DVec3};
use snowgrain_optics::clear_sky::SUN_DIAMETER_DEGREES;
use snowgrain_render::description::{LightDescription, LightKind};
use snowgrain_render::light::irradiance_of_disc;

/// All lights of the shot, moved as the table says.
pub(super) fn lights(
    checks: &Checks<'_>,
    table: &ImportTable,
    lights: &[ImportedLight],
    moved: &DAffine3,
) -> Result<Vec<LightDescription>, SceneError> {
    let factor = table.light_strength.unwrap_or(Triple([1.0; 3]));
    let factor = checks.radiance("import.light_strength", factor)?;
    lights.iter().map(|light| describe(checks, light, factor, moved)).collect()
}

fn describe(
    checks: &Checks<'_>,
    light: &ImportedLight,
    factor: [f32; 3],
    moved: &DAffine3,
) -> Result<LightDescription, SceneError> {
    let unusable = || {
        let mend = format!("the light {:?} is too far or too bright to be used", light.name);
        checks.bad("import.file", mend)
    };
    let place = |position: DVec3| {
        let position = moved.transform_point3(position);
        let reached = position.is_finite() && position.abs().max_element() <= LARGEST;
        if reached { Ok(position) } else { Err(unusable()) }
    };
    let along =
        |direction: DVec3| moved.transform_vector3(direction).try_normalize().ok_or_else(unusable);
    let (kind, strength) = match light.kind {
        ImportedLightKind::Directional { direction, lux } => {
            let kind = LightKind::Sun {
                direction: -along(direction)?,
                diameter_degrees: SUN_DIAMETER_DEGREES,
            };
            (kind, lux / irradiance_of_disc(SUN_DIAMETER_DEGREES))
        }
        ImportedLightKind::Point { position, candela } => {
            (LightKind::Point { position: place(position)? }, candela)
        }
        ImportedLightKind::Spot { position, direction, candela, inner_radians, outer_radians } => {
            let kind = LightKind::Spot {
                position: place(position)?,
                direction: along(direction)?,
                inner_degrees: inner_radians.to_degrees(),
                outer_degrees: outer_radians.to_degrees(),
            };
            (kind, candela)
        }
    };
    let channel = |c: usize| (strength * f64::from(light.colour[c]) * f64::from(factor[c])) as f32;
    let strength: [f32; 3] = std::array::from_fn(channel);
    if !strength.iter().all(|x| x.is_finite()) {
        return Err(unusable());
    }
    // Parallel light comes from no body that a camera could see.
    Ok(LightDescription { visible_to_camera: false, ..LightDescription::new(kind, strength) })
}
