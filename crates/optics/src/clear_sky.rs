//! Sun and sky on a clear day over snow, 300 to 2500 nm and beyond.
//!
//! Spectra: Bird and Riordan 1986, "Simple solar spectral model for direct and diffuse irradiance on
//! horizontal and tilted planes at the Earth's surface for cloudless atmospheres", J. Climate Appl. Meteor.
//! 25, 87: over a ground of albedo .8 at sea level, .5 cm of water, 310 DU of ozone, an aerosol depth of .05.
//!
//! Where in the sky the light comes from: the CIE standard clear sky of low turbidity, type 12 of the CIE
//! standard general sky (CIE S 011/E:2003, ISO 15469:2004).

use crate::colour::{VISIBLE_NM, observer};
use crate::{Spectrum, table};
use core::f64::consts::FRAC_PI_2;
use snowgrain_math::trig;
use std::sync::LazyLock;

const TABLE: &str = include_str!("../data/clear_sky_spectrl2_snow_ground.csv");

/// Zenith angles of the table, degrees.
const ZENITHS: [f64; 5] = [0.0, 30.0, 48.2, 60.0, 75.0];
/// Greatest zenith angle of the sun that is known, degrees.
pub const GREATEST_ZENITH: f64 = ZENITHS[4];

/// Angular diameter of the sun in the mean over the year, degrees (a radius of 959.63 arc seconds: Auwers
/// 1891, Astron. Nachr. 128, 361).
pub const SUN_DIAMETER_DEGREES: f64 = 0.533;

/// Luminous efficacy of light of 555 nm, lm/W (the definition of the candela, BIPM 2019).
const LUMENS_PER_WATT: f64 = 683.0;

/// Of each zenith angle the direct light on a plane across it and the diffuse light on a level plane.
static IRRADIANCES: LazyLock<[[Spectrum; 2]; 5]> = LazyLock::new(|| {
    ["0", "30", "48.2", "60", "75"].map(|zenith| {
        ["direct_normal_sza", "diffuse_horizontal_sza"]
            .map(|kind| table::column(TABLE, &format!("{kind}{zenith}")))
    })
});

/// Irradiance by the sun of a plane across its light, and of a level plane by the sky, W/m^2/nm, at a zenith
/// angle of the sun from 0 to [`GREATEST_ZENITH`] degrees (beyond, as there); straight between those of the
/// table.
#[must_use]
pub fn across_and_diffuse(zenith_degrees: f64, wavelength_nm: f64) -> [f64; 2] {
    let zenith = zenith_degrees.clamp(0.0, GREATEST_ZENITH);
    let above = ZENITHS.partition_point(|&known| known < zenith).clamp(1, ZENITHS.len() - 1);
    let (low, high) = (ZENITHS[above - 1], ZENITHS[above]);
    let part = (zenith - low) / (high - low);
    [0, 1].map(|kind: usize| {
        let [a, b] = [above - 1, above].map(|at| IRRADIANCES[at][kind].at(wavelength_nm));
        a + (b - a) * part
    })
}

/// Irradiance of a level plane by the sun and by the sky, W/m^2/nm, at a zenith angle of the sun from
/// 0 to [`GREATEST_ZENITH`] degrees (beyond, as there); straight between those of the table.
#[must_use]
pub fn irradiance(zenith_degrees: f64, wavelength_nm: f64) -> [f64; 2] {
    let [across, diffuse] = across_and_diffuse(zenith_degrees, wavelength_nm);
    let zenith = zenith_degrees.clamp(0.0, GREATEST_ZENITH);
    [across * trig::sin_cos(zenith.to_radians()).1, diffuse]
}

/// Illuminance by the sun of a plane across its light, and of a level plane by the sky, lux: 683 lm/W times
/// the irradiances weighted by the eye's sensitivity. Zenith angles as in [`across_and_diffuse`].
#[must_use]
pub fn illuminances(zenith_degrees: f64) -> [f64; 2] {
    let [first, last] = VISIBLE_NM;
    let wavelengths = (0..=(last - first) as u32).map(|step| first + f64::from(step));
    wavelengths.fold([0.0; 2], |[sun, sky], nm| {
        let [across, diffuse] = across_and_diffuse(zenith_degrees, nm);
        let lumens = LUMENS_PER_WATT * observer(nm).y;
        [sun + lumens * across, sky + lumens * diffuse]
    })
}

/// Luminance of the clear sky where the cosine of the zenith angle is `cos_zenith` (0 to 1) and that of the
/// angle to the sun `cos_to_sun`, in units of their own: only ratios count. The gradation is `1 - exp(-.32 /
/// cos Z)`, the indicatrix `1 + 10 (exp(-3 chi) - exp(-3 pi/2)) + .45 cos^2 chi`.
#[must_use]
pub fn relative_luminance(cos_zenith: f64, cos_to_sun: f64) -> f64 {
    let gradation = if cos_zenith > 0.0 { -trig::exp_m1(-0.32 / cos_zenith) } else { 1.0 };
    let chi = trig::acos(cos_to_sun.clamp(-1.0, 1.0));
    let indicatrix = 1.0
        + 10.0 * (trig::exp(-3.0 * chi) - trig::exp(-3.0 * FRAC_PI_2))
        + 0.45 * cos_to_sun * cos_to_sun;
    gradation * indicatrix
}

/// A zenith angle of the sun for which spectra are known, to a thousandth of a degree: from 0 to
/// [`GREATEST_ZENITH`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct SunZenith {
    millidegrees: u32,
}

impl SunZenith {
    /// The nearest one to an angle in degrees: 0 below 0, [`GREATEST_ZENITH`] beyond that.
    #[must_use]
    pub fn new(degrees: f64) -> Self {
        Self { millidegrees: (degrees.clamp(0.0, GREATEST_ZENITH) * 1000.0).round() as u32 }
    }

    /// The angle.
    #[must_use]
    pub fn degrees(self) -> f64 {
        f64::from(self.millidegrees) / 1000.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_sun_gives_what_the_table_says_and_less_when_it_sinks() {
        let total = |zenith: f64| -> [f64; 2] {
            (300..2500).fold([0.0; 2], |[sun, sky], nm| {
                let [direct, diffuse] = irradiance(zenith, f64::from(nm));
                [sun + direct, sky + diffuse]
            })
        };
        let [sun, sky] = total(60.0);
        // W/m^2 of a clear day: about 860 across the sun, half of it on a level plane.
        assert!((350.0..500.0).contains(&sun) && (40.0..150.0).contains(&sky), "{sun} {sky}");
        let falls = [0.0, 20.0, 40.0, 55.0, 70.0, 75.0].map(|zenith| total(zenith)[0]);
        assert!(falls.windows(2).all(|pair| pair[0] > pair[1]), "{falls:?}");
        // Blue sky, and a sun that is redder than it.
        let [sun_blue, sky_blue] = irradiance(48.2, 450.0);
        let [sun_red, sky_red] = irradiance(48.2, 700.0);
        assert!(sky_blue / sky_red > 2.0 * sun_blue / sun_red);
        assert_eq!(irradiance(80.0, 500.0), irradiance(75.0, 500.0));
    }

    #[test]
    fn daylight_has_the_illuminance_of_a_clear_day() {
        // The sun across its light at sea level: about 100 000 lx when it is high.
        let [sun, sky] = illuminances(30.0);
        assert!((90_000.0..115_000.0).contains(&sun), "{sun}");
        assert!((8_000.0..25_000.0).contains(&sky), "{sky}");
    }

    #[test]
    fn open_shade_is_darker_than_sunlit_snow_by_the_stops_that_are_known() {
        // Stops under sun and sky at sun zenith 30, 48.2, 60 and 75 degrees, before light bleeds.
        for (zenith, stops) in [(30.0, 2.7), (48.2, 2.5), (60.0, 2.3), (75.0, 1.7)] {
            let [across, sky] = illuminances(zenith);
            let sun = across * trig::sin_cos(zenith.to_radians()).1;
            let found = trig::ln((sun + sky) / sky) * core::f64::consts::LOG2_E;
            assert!((found - stops).abs() < 0.1, "{zenith}: {found}");
        }
    }

    #[test]
    fn the_sky_is_brightest_around_the_sun_and_darkest_a_right_angle_from_it() {
        let (sun, elevation): (f64, f64) = (0.6, 40f64.to_radians());
        let at = |zenith: f64, to_sun: f64| {
            let cosine = |angle| trig::sin_cos(angle).1;
            relative_luminance(cosine(zenith), cosine(to_sun))
        };
        assert!(at(sun, 0.0) > 5.0 * at(sun, 1.0));
        assert!(at(sun, 1.0) > at(sun, 1.6));
        // Brighter at the horizon than above it, at the same angle to the sun.
        assert!(at(1.5, elevation) > at(0.9, elevation));
        assert!((relative_luminance(0.0, 0.0) - relative_luminance(1e-9, 0.0)).abs() < 1e-12);
    }

    #[test]
    fn zeniths_are_kept_to_a_thousandth_of_a_degree() {
        assert_eq!(SunZenith::new(48.2).degrees(), 48.2);
        assert_eq!(SunZenith::new(89.0).degrees(), GREATEST_ZENITH);
        assert_eq!(SunZenith::new(-1.0), SunZenith::new(0.0));
    }
}
