//! Sun and sky on a clear day over snow, 300 to 2500 nm and beyond.
//!
//! Bird and Riordan 1986, "Simple solar spectral model for direct and diffuse irradiance on horizontal
//! and tilted planes at the Earth's surface for cloudless atmospheres", J. Climate Appl. Meteor. 25, 87:
//! over a ground of albedo .8 at sea level, .5 cm of water, 310 DU of ozone, an aerosol depth of .05.

use crate::{Spectrum, table};
use std::sync::LazyLock;

const TABLE: &str = include_str!("../data/clear_sky_spectrl2_snow_ground.csv");

/// Zenith angles of the table, degrees.
const ZENITHS: [f64; 5] = [0.0, 30.0, 48.2, 60.0, 75.0];
/// Greatest zenith angle of the sun that is known, degrees.
pub const GREATEST_ZENITH: f64 = ZENITHS[4];

/// Of each zenith angle the direct light on a plane across it and the diffuse light on a level plane.
static IRRADIANCES: LazyLock<[[Spectrum; 2]; 5]> = LazyLock::new(|| {
    ["0", "30", "48.2", "60", "75"].map(|zenith| {
        ["direct_normal_sza", "diffuse_horizontal_sza"]
            .map(|kind| table::column(TABLE, &format!("{kind}{zenith}")))
    })
});

/// Irradiance of a level plane by the sun and by the sky, W/m^2/nm, at a zenith angle of the sun from
/// 0 to [`GREATEST_ZENITH`] degrees (beyond, as there); straight between those of the table.
#[must_use]
pub fn irradiance(zenith_degrees: f64, wavelength_nm: f64) -> [f64; 2] {
    let zenith = zenith_degrees.clamp(0.0, GREATEST_ZENITH);
    let above = ZENITHS.partition_point(|&known| known < zenith).clamp(1, ZENITHS.len() - 1);
    let (low, high) = (ZENITHS[above - 1], ZENITHS[above]);
    let part = (zenith - low) / (high - low);
    let [direct, diffuse] = [0, 1].map(|kind: usize| {
        let [a, b] = [above - 1, above].map(|at| IRRADIANCES[at][kind].at(wavelength_nm));
        a + (b - a) * part
    });
    let cosine = snowgrain_math::trig::sin_cos(zenith.to_radians()).1;
    [direct * cosine, diffuse]
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
}
