//! Oklab, a space in which lines of constant hue are straight (B. Ottosson, "A perceptual color space for
//! image processing", 2020; the matrices are his for linear sRGB).

use snowgrain_math::{DMat3, DVec3, trig};

const CONES: DMat3 = DMat3::from_cols(
    DVec3::new(0.412_221_470_8, 0.211_903_498_2, 0.088_302_461_9),
    DVec3::new(0.536_332_536_3, 0.680_699_545_1, 0.281_718_837_6),
    DVec3::new(0.051_445_992_9, 0.107_396_956_6, 0.629_978_700_5),
);
const LAB: DMat3 = DMat3::from_cols(
    DVec3::new(0.210_454_255_3, 1.977_998_495_1, 0.025_904_037_1),
    DVec3::new(0.793_617_785_0, -2.428_592_205_0, 0.782_771_766_2),
    DVec3::new(-0.004_072_046_8, 0.450_593_709_9, -0.808_675_766_0),
);
const FROM_LAB: DMat3 = DMat3::from_cols(
    DVec3::ONE,
    DVec3::new(0.396_337_777_4, -0.105_561_345_8, -0.089_484_177_5),
    DVec3::new(0.215_803_757_3, -0.063_854_172_8, -1.291_485_548_0),
);
const FROM_CONES: DMat3 = DMat3::from_cols(
    DVec3::new(4.076_741_662_1, -1.268_438_004_6, -0.004_196_086_3),
    DVec3::new(-3.307_711_591_3, 2.609_757_401_1, -0.703_418_614_7),
    DVec3::new(0.230_969_929_2, -0.341_319_396_5, 1.707_614_701_0),
);

/// Lightness, a and b of linear sRGB, in or out of the gamut.
pub(super) fn from_srgb(colour: DVec3) -> DVec3 {
    let cones = CONES * colour;
    LAB * DVec3::from(cones.to_array().map(trig::cbrt))
}

/// The inverse.
pub(super) fn to_srgb(lab: DVec3) -> DVec3 {
    let roots = FROM_LAB * lab;
    FROM_CONES * (roots * roots * roots)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn colours_have_the_coordinates_that_their_author_gives() {
        // White is (1, 0, 0); the blue of sRGB is (.452, -.032, -.312).
        let near = |colour: [f64; 3], lab: [f64; 3]| {
            let found = from_srgb(colour.into());
            assert!((found - DVec3::from(lab)).abs().max_element() < 1e-3, "{found}");
            assert!((to_srgb(found) - DVec3::from(colour)).abs().max_element() < 1e-6);
        };
        near([1.0; 3], [1.0, 0.0, 0.0]);
        near([0.0, 0.0, 1.0], [0.452, -0.032, -0.312]);
        near([-0.1, 0.2, 0.9], from_srgb(DVec3::new(-0.1, 0.2, 0.9)).to_array());
    }
}
