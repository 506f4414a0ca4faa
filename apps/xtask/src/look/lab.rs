//! CIELAB of screens (CIE 15:2004, section 8.2.1), under the white of sRGB.

use snowgrain_film::develop::linear_from_srgb;
use snowgrain_math::{DVec3, trig};
use snowgrain_optics::Primaries;

/// L*, a*, b* of 8-bit sRGB.
pub(super) fn of_codes(codes: [u8; 3]) -> [f64; 3] {
    let linear = codes.map(|code| linear_from_srgb(f64::from(code) / 255.0));
    let to_xyz = Primaries::Srgb.under_d65().inverse();
    let (xyz, white) = (to_xyz * DVec3::from(linear), to_xyz * DVec3::ONE);
    let [x, y, z] = (xyz / white).to_array().map(compressed);
    [116.0 * y - 16.0, 500.0 * (x - y), 200.0 * (y - z)]
}

/// The function f of CIELAB.
fn compressed(t: f64) -> f64 {
    const LINEAR_BELOW: f64 = (24.0 / 116.0) * (24.0 / 116.0) * (24.0 / 116.0);
    if t > LINEAR_BELOW { trig::cbrt(t) } else { (841.0 * t / 108.0) + 16.0 / 116.0 }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn white_grey_and_blue_of_screens_have_their_known_values() {
        let near = |codes, expected: [f64; 3]| {
            let found = of_codes(codes);
            let off = found.iter().zip(expected).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
            assert!(off < 0.05, "{codes:?}: {found:?}");
        };
        near([255, 255, 255], [100.0, 0.0, 0.0]);
        near([119, 119, 119], [50.03, 0.0, 0.0]);
        near([0, 0, 255], [32.30, 79.19, -107.86]);
        near([0, 0, 0], [0.0, 0.0, 0.0]);
    }
}
