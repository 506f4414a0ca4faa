//! The colour of snow, seen from above and from below.

use super::Albedo;
use snowgrain_math::DVec3;
use snowgrain_optics::{Illuminant, Spectrum, colour};

/// Wavelengths whose albedos give colours, nm: every 10 over [`colour::VISIBLE_NM`].
#[must_use]
pub fn colour_wavelengths_nm() -> Vec<f64> {
    let [first, last] = colour::VISIBLE_NM;
    let steps = ((last - first) / 10.0) as u32;
    (0..=steps).map(|step| first + 10.0 * f64::from(step)).collect()
}

/// Tristimulus values of the light that is reflected and of that which is let through, where all of
/// the light has Y = 1; `None` where there are no albedos, or not in the order of their wavelengths.
#[must_use]
pub fn colours(albedos: &[Albedo], illuminant: Illuminant) -> Option<[DVec3; 2]> {
    let wavelengths = || albedos.iter().map(|albedo| albedo.wavelength_nm).collect();
    let spectrum =
        |part: fn(&Albedo) -> f64| Spectrum::new(wavelengths(), albedos.iter().map(part).collect());
    let reflected = spectrum(|albedo| albedo.reflectance.mean)?;
    let transmitted = spectrum(|albedo| albedo.transmittance.mean)?;
    let seen = |spectrum: Spectrum| colour::tristimulus(illuminant, |at| spectrum.at(at));
    Some([seen(reflected), seen(transmitted)])
}
