//! The light of groups in a picture.

use anyhow::{Context as _, Result};
use snowgrain_film::{GLINTS, Picture};
use snowgrain_math::DVec3;
use snowgrain_optics::Primaries;

/// Colours of the pixels of a picture (linear sRGB) as the light of one group makes them; none where the
/// picture has no such layer.
pub(super) fn of_group(picture: &Picture, group: &str) -> Option<Vec<DVec3>> {
    let layer = picture.light_layers.iter().find(|layer| layer.name == group)?;
    Some(colours(layer.values.each_ref().map(Vec::as_slice)))
}

/// Those of all light.
pub(super) fn of_all(picture: &Picture) -> Result<Vec<DVec3>> {
    Ok(colours(picture.colour()?))
}

fn colours([red, green, blue]: [&[f32]; 3]) -> Vec<DVec3> {
    let at = |pixel: usize| [red, green, blue].map(|channel| f64::from(channel[pixel]));
    (0..red.len()).map(|pixel| DVec3::from(at(pixel))).collect()
}

/// What the sun sends: that of its group, and glints.
pub(super) fn of_sun(picture: &Picture) -> Result<Vec<DVec3>> {
    let mut sun = of_group(picture, "sun").context("no layer of the sun")?;
    if let Some(glints) = of_group(picture, GLINTS) {
        sun.iter_mut().zip(glints).for_each(|(sun, glint)| *sun += glint);
    }
    Ok(sun)
}

/// Luminance of linear sRGB.
pub(super) fn luminance(colour: DVec3) -> f64 {
    (Primaries::Srgb.under_d65().inverse() * colour).y
}

/// CIE 1931 x and y of linear sRGB.
pub(super) fn chromaticity(colour: DVec3) -> [f64; 2] {
    snowgrain_optics::colour::chromaticity(Primaries::Srgb.under_d65().inverse() * colour)
}

pub(super) fn mean(colours: &[DVec3]) -> DVec3 {
    colours.iter().copied().sum::<DVec3>() / colours.len() as f64
}

/// The value under which this part of the values lies.
pub(super) fn quantile(values: &[f64], part: f64) -> f64 {
    let mut sorted = values.to_vec();
    sorted.sort_by(f64::total_cmp);
    sorted
        .get((part * (sorted.len().saturating_sub(1)) as f64) as usize)
        .copied()
        .unwrap_or(f64::NAN)
}
