//! Albedos over wide bands, weighted with the light of a clear or an overcast day.

use super::{Albedo, Incidence};
use crate::measure::Estimate;
use snowgrain_optics::clear_sky;

/// Wavelengths whose albedos give those of bands, nm: every 10 from 300 to 2500.
#[must_use]
pub fn broadband_wavelengths_nm() -> Vec<f64> {
    (30..=250).map(|tens| 10.0 * f64::from(tens)).collect()
}

/// The closed set of bands.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Band {
    /// 300 to 2500 nm.
    Solar,
    /// 300 to 700 nm.
    Visible,
    /// 700 to 2500 nm.
    NearInfrared,
}

impl Band {
    /// All of them.
    pub const ALL: [Self; 3] = [Self::Solar, Self::Visible, Self::NearInfrared];

    /// First and last wavelength, nm.
    #[must_use]
    pub fn range_nm(self) -> [f64; 2] {
        match self {
            Self::Solar => [300.0, 2500.0],
            Self::Visible => [300.0, 700.0],
            Self::NearInfrared => [700.0, 2500.0],
        }
    }
}

/// Zenith angle of the sun whose light, spread by clouds, an overcast sky is taken to have, degrees.
const OVERCAST_ZENITH: f64 = 60.0;

/// Fractions of the light of a band that are reflected and let through, by those at the wavelengths
/// of [`broadband_wavelengths_nm`].
///
/// With the sun at a zenith angle, on a clear day: `parallel` of its light and `diffuse` of that of the
/// sky. Without, under an overcast sky: all light of a clear day with the sun at 60 degrees, `diffuse`.
/// Standard errors are those of the spectral values, as if they all were wrong together. `None` where
/// albedos and wavelengths are not as many.
#[must_use]
pub fn broadband(
    band: Band,
    incidence: Incidence,
    parallel: &[Albedo],
    diffuse: &[Albedo],
) -> Option<[Estimate; 2]> {
    let wavelengths = broadband_wavelengths_nm();
    if parallel.len() != wavelengths.len() || diffuse.len() != wavelengths.len() {
        return None;
    }
    let [first, last] = band.range_nm();
    let mut sums = [Estimate::default(); 2];
    let mut all = 0.0;
    for ((wavelength, parallel), diffuse) in wavelengths.into_iter().zip(parallel).zip(diffuse) {
        if !(first..=last).contains(&wavelength) {
            continue;
        }
        // The trapezium rule.
        let step = if wavelength == first || wavelength == last { 0.5 } else { 1.0 };
        let [sun, sky] = match incidence {
            Incidence::Sun { zenith_degrees } => clear_sky::irradiance(zenith_degrees, wavelength),
            Incidence::Diffuse => {
                let [sun, sky] = clear_sky::irradiance(OVERCAST_ZENITH, wavelength);
                [0.0, sun + sky]
            }
        };
        for (light, albedo) in [(sun, parallel), (sky, diffuse)] {
            all += step * light;
            for (sum, part) in sums.iter_mut().zip([albedo.reflectance, albedo.transmittance]) {
                sum.mean += step * light * part.mean;
                sum.standard_error += step * light * part.standard_error;
            }
        }
    }
    Some(
        sums.map(|sum| Estimate { mean: sum.mean / all, standard_error: sum.standard_error / all }),
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    fn albedos(reflectance: impl Fn(f64) -> f64) -> Vec<Albedo> {
        let albedo = |wavelength_nm: f64| {
            let estimate = |mean: f64| Estimate { mean, standard_error: 0.001 };
            let r = reflectance(wavelength_nm);
            Albedo {
                wavelength_nm,
                reflectance: estimate(r),
                transmittance: estimate(0.5 * (1.0 - r)),
                absorptance: 0.5 * (1.0 - r),
            }
        };
        broadband_wavelengths_nm().into_iter().map(albedo).collect()
    }

    #[test]
    fn bands_are_means_of_what_they_hold() {
        let (grey, red) = (albedos(|_| 0.4), albedos(|nm| if nm < 700.0 { 0.9 } else { 0.3 }));
        for incidence in [Incidence::Diffuse, Incidence::Sun { zenith_degrees: 40.0 }] {
            let of = |band: Band, albedos: &[Albedo]| {
                broadband(band, incidence, albedos, albedos).unwrap()[0]
            };
            for band in Band::ALL {
                let grey = of(band, &grey);
                assert!((grey.mean - 0.4).abs() < 1e-12);
                assert!((grey.standard_error - 0.001).abs() < 1e-12);
            }
            let [solar, visible, infrared] = Band::ALL.map(|band| of(band, &red).mean);
            assert!(visible > 0.88 && infrared < 0.31 && (infrared..visible).contains(&solar));
        }
        assert!(broadband(Band::Solar, Incidence::Diffuse, &grey[1..], &grey).is_none());
    }
}
