//! Colours that a screen cannot show.

use super::oklab;
use snowgrain_math::DVec3;

/// What becomes of colours out of the gamut of sRGB: deep ice is bluer, a lamp may be redder, and any
/// colour may be too bright.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Gamut {
    /// Each channel is cut off at 0 and 1.
    #[default]
    Clip,
    /// Chroma is drawn in at constant hue and lightness (of Oklab), smoothly: colours whose chroma is up to 80 %
    /// of the most that the screen shows of their hue and lightness stay, those beyond share the rest.
    Compress,
}

/// Part of the greatest chroma up to which colours stay.
const KNEE: f64 = 0.8;

/// Halvings that find the greatest chroma.
const STEPS: u32 = 30;

impl Gamut {
    /// Linear sRGB in [0, 1] but for rounding; channels are still to be cut off.
    pub(super) fn apply(self, colour: [f64; 3]) -> [f64; 3] {
        match self {
            Self::Clip => colour,
            Self::Compress => compress(colour.into()).to_array(),
        }
    }
}

fn compress(colour: DVec3) -> DVec3 {
    if !colour.is_finite() || colour == DVec3::splat(colour.x) {
        return colour;
    }
    let lab = oklab::from_srgb(colour);
    if lab.x >= 1.0 || lab.x <= 0.0 {
        return DVec3::splat(lab.x.clamp(0.0, 1.0));
    }
    // The chroma times this is shown.
    let with = |part: f64| oklab::to_srgb(DVec3::new(lab.x, lab.y * part, lab.z * part));
    if is_shown(with(1.0 / KNEE)) {
        return colour;
    }
    let (mut inside, mut outside) = (0.0, 1.0 / KNEE);
    for _ in 0..STEPS {
        let middle = 0.5 * (inside + outside);
        if is_shown(with(middle)) {
            inside = middle;
        } else {
            outside = middle;
        }
    }
    if inside == 0.0 {
        return with(0.0);
    }
    let over = (1.0 / inside - KNEE) / (1.0 - KNEE);
    // Continuous with its slope at the knee, and 1 for the purest colours.
    with(inside * (KNEE + (1.0 - KNEE) * over / (1.0 + over)))
}

fn is_shown(colour: DVec3) -> bool {
    colour.min_element() >= 0.0 && colour.max_element() <= 1.0
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    fn chroma_and_hue(lab: DVec3) -> (f64, DVec3) {
        let plane = DVec3::new(0.0, lab.y, lab.z);
        (plane.length(), plane.normalize())
    }

    #[test]
    fn muted_colours_stay_and_purer_ones_keep_their_order() {
        let blue = |chroma: f64| oklab::to_srgb(DVec3::new(0.6, -0.4 * chroma, -0.9 * chroma));
        let mut last = 0.0;
        for step in 1..200 {
            let chroma = 0.003 * f64::from(step);
            let shown = compress(blue(chroma));
            assert!(shown.min_element() > -1e-6 && shown.max_element() < 1.0 + 1e-6, "{shown}");
            if is_shown(blue(chroma / KNEE)) {
                assert_eq!(shown, blue(chroma));
            }
            let (shown, _) = chroma_and_hue(oklab::from_srgb(shown));
            assert!(shown > last, "{chroma}: {shown} {last}");
            last = shown;
        }
        assert!(!is_shown(blue(0.3)) && is_shown(blue(0.1)));
    }

    #[test]
    fn too_bright_is_white_and_light_below_nothing_black() {
        assert_eq!(compress(DVec3::new(1.1, 1.3, 1.6)), DVec3::ONE);
        assert_eq!(compress(DVec3::new(-0.3, -0.1, 0.01)), DVec3::ZERO);
        assert_eq!(compress(DVec3::splat(1.5)), DVec3::splat(1.5)); // cut off afterwards
    }

    proptest! {
        #[test]
        fn hue_and_lightness_stay(colour in prop::array::uniform3(-0.2..1.2f64)) {
            let (before, after) = (DVec3::from(colour), compress(colour.into()));
            let (old, new) = (oklab::from_srgb(before), oklab::from_srgb(after));
            prop_assume!((0.01..0.99).contains(&old.x));
            prop_assert!((old.x - new.x).abs() < 1e-6);
            let ((old, old_hue), (new, new_hue)) = (chroma_and_hue(old), chroma_and_hue(new));
            prop_assert!(new <= old + 1e-6);
            prop_assert!(new < 1e-3 || old_hue.dot(new_hue) > 1.0 - 1e-6);
            prop_assert!(after.min_element() > -1e-6 && after.max_element() < 1.0 + 1e-6);
        }
    }
}
