//! Tone curves: from scene-linear light to the linear light of a screen.

use super::transfer::srgb_from_linear;
use snowgrain_math::{DMat3, DVec3, trig};
use snowgrain_optics::Primaries;
use std::sync::LazyLock;

/// How light of any brightness becomes light of a screen.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Curve {
    /// As it is; light over 1 is lost.
    #[default]
    Plain,
    /// As it is up to a shoulder in [0, 1), from which highlights roll off to 1 without reaching it:
    /// `s + (1 - s) (1 - exp(-(x - s) / (1 - s)))`, in each channel.
    RollOff {
        /// Where the shoulder begins, of the screen's white.
        shoulder: f64,
    },
    /// The film-like rendering of ACES 1 (reference and output transform for a screen of 100 cd/m^2), as S.
    /// Hill fitted it (2016, for "Baking Lab"): rational in each channel of a space a little wider than
    /// sRGB, steep, with a long shoulder and highlights that turn white.
    Filmic,
    /// The base look of AgX (T. Sobotka, 2022; primaries of the version of Blender 4 by E. Chow): 16.5
    /// stops, log-encoded in a wide space of inset primaries, by a sigmoid. Bright colours turn pale as on
    /// film, without twisting their hue; softer than [`Curve::Filmic`].
    AgX,
}

/// Rows of the fit's matrices: sRGB into the space of the fit and back.
const ACES_IN: DMat3 = DMat3::from_cols(
    DVec3::new(0.59719, 0.07600, 0.02840),
    DVec3::new(0.35458, 0.90834, 0.13383),
    DVec3::new(0.04823, 0.01566, 0.83777),
);
const ACES_OUT: DMat3 = DMat3::from_cols(
    DVec3::new(1.60475, -0.10208, -0.00327),
    DVec3::new(-0.53108, 1.10813, -0.07276),
    DVec3::new(-0.07367, -0.00605, 1.07602),
);

/// Inset and outset of the primaries of Rec. 2020 in AgX.
const AGX_INSET: DMat3 = DMat3::from_cols(
    DVec3::new(0.856_627_153_315_983, 0.137_318_972_929_847, 0.111_898_212_999_95),
    DVec3::new(0.095_121_240_538_158_8, 0.761_241_990_602_591, 0.076_799_418_603_190_3),
    DVec3::new(0.048_251_606_145_858_3, 0.101_439_036_467_562, 0.811_302_368_396_859),
);
const AGX_OUTSET: DMat3 = DMat3::from_cols(
    DVec3::new(1.127_100_581_814_436_8, -0.141_329_763_498_438_3, -0.141_329_763_498_438_3),
    DVec3::new(-0.110_606_643_096_603_2, 1.157_823_702_216_272, -0.110_606_643_096_603),
    DVec3::new(-0.016_493_938_717_834_6, -0.016_493_938_717_834_3, 1.251_936_406_595_041),
);
/// Least and greatest light that AgX encodes, log2: 10 stops under and 6.5 over .18.
const AGX_STOPS: [f64; 2] = [-12.473_931_188_332_413, 4.026_068_811_667_588];

/// From linear sRGB to Rec. 2020 (ITU-R BT.2020), both of white D65.
static REC2020: LazyLock<DMat3> = LazyLock::new(|| {
    let xyz = |[x, y]: [f64; 2]| DVec3::new(x / y, 1.0, (1.0 - x - y) / y);
    let [red, green, blue] = [[0.708, 0.292], [0.170, 0.797], [0.131, 0.046]].map(xyz);
    let columns = DMat3::from_cols(red, green, blue);
    let to_xyz = Primaries::Srgb.to_xyz();
    let amounts = columns.inverse() * (to_xyz * DVec3::ONE);
    (columns * DMat3::from_diagonal(amounts)).inverse() * to_xyz
});

impl Curve {
    /// The names by which users choose them ([`Curve::RollOff`] is `plain` with a shoulder).
    pub const NAMES: [&'static str; 3] = ["plain", "filmic", "agx"];

    /// Linear sRGB of a screen, of which 1 is white; what is below 0 or above 1 it cannot show.
    pub(super) fn apply(self, colour: [f64; 3]) -> [f64; 3] {
        match self {
            Self::Plain => colour,
            Self::RollOff { shoulder } => colour.map(|x| roll_off(x, shoulder)),
            Self::Filmic => {
                let inner = (ACES_IN * DVec3::from(colour)).to_array().map(aces);
                (ACES_OUT * DVec3::from(inner)).to_array()
            }
            Self::AgX => {
                let wide = AGX_INSET * (*REC2020 * DVec3::from(colour));
                let [least, greatest] = AGX_STOPS;
                let encoded = wide.to_array().map(|x| {
                    let log2 = trig::ln(x.max(1e-10)) * core::f64::consts::LOG2_E;
                    sigmoid(((log2 - least) / (greatest - least)).clamp(0.0, 1.0))
                });
                let shown = (AGX_OUTSET * DVec3::from(encoded)).to_array();
                let linear = shown.map(|x| trig::pow(x.max(0.0), 2.2));
                (REC2020.inverse() * DVec3::from(linear)).to_array()
            }
        }
    }

    /// The grey light that is shown as `code`, sRGB-encoded, in (0, 1).
    pub(super) fn light_shown_as(self, code: f64) -> f64 {
        let (mut low, mut high) = (-20.0, 20.0); // stops
        for _ in 0..60 {
            let middle = 0.5 * (low + high);
            let [_, shown, _] = self.apply([trig::pow(2.0, middle); 3]);
            if srgb_from_linear(shown) < code {
                low = middle;
            } else {
                high = middle;
            }
        }
        trig::pow(2.0, high)
    }
}

fn roll_off(x: f64, shoulder: f64) -> f64 {
    if x <= shoulder {
        return x;
    }
    let room = 1.0 - shoulder;
    shoulder + room * (1.0 - trig::exp(-(x - shoulder) / room))
}

/// Hill's rational fit of the two transforms; 0 where it would be below.
fn aces(x: f64) -> f64 {
    if x <= 0.0 {
        return 0.0;
    }
    let fit =
        (x * (x + 0.024_578_6) - 0.000_090_537) / (x * (0.983_729 * x + 0.432_951_0) + 0.238_081);
    fit.max(0.0)
}

/// The contrast of AgX: a sigmoid of [0, 1] through the pivot (10/16.5, 1/2) with slope 2 there, of power 3
/// in the toe and 3.25 in the shoulder (Sobotka's settings; the form is J. Smith's).
fn sigmoid(x: f64) -> f64 {
    const PIVOT: [f64; 2] = [10.0 / 16.5, 0.5];
    const SLOPE: f64 = 2.0;
    let [pivot, level] = PIVOT;
    // From the pivot, distance and room in both directions.
    let half = |distance: f64, reach: f64, room: f64, power: f64| {
        let rise = SLOPE * reach;
        let scale = trig::pow(
            (trig::pow(rise / room, power) - 1.0) * trig::pow(rise, -power),
            -1.0 / power,
        );
        let term = SLOPE * distance / scale;
        scale * term / trig::pow(1.0 + trig::pow(term, power), 1.0 / power)
    };
    if x < pivot {
        level - half(pivot - x, pivot, level, 3.0)
    } else {
        level + half(x - pivot, 1.0 - pivot, 1.0 - level, 3.25)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const ALL: [Curve; 4] =
        [Curve::Plain, Curve::RollOff { shoulder: 0.8 }, Curve::Filmic, Curve::AgX];

    fn grey(curve: Curve, x: f64) -> f64 {
        let [red, green, blue] = curve.apply([x; 3]);
        assert!((red - green).abs() < 2e-4 && (blue - green).abs() < 2e-4, "{red} {green} {blue}");
        green
    }

    #[test]
    fn black_stays_black_and_more_light_is_never_darker() {
        for curve in ALL {
            assert!(grey(curve, 0.0).abs() < 1e-12, "{curve:?}");
            let mut last = 0.0;
            for step in 0..2000 {
                let shown = grey(curve, 1e-5 * trig::pow(1.01, f64::from(step)));
                assert!(shown >= last, "{curve:?}");
                last = shown;
            }
        }
    }

    #[test]
    fn shoulders_meet_their_lines_and_end_at_white() {
        let soft = Curve::RollOff { shoulder: 0.8 };
        assert_eq!(grey(soft, 0.8), 0.8);
        let slope = (grey(soft, 0.8 + 1e-6) - 0.8) / 1e-6;
        assert!((slope - 1.0).abs() < 1e-4, "{slope}");
        assert!(grey(soft, 3.0) < 1.0 && grey(soft, 3.0) > 0.999);
        assert!((grey(Curve::AgX, 16.3) - 1.0).abs() < 2e-3);
        assert!(grey(Curve::AgX, 1e9) < 1.0 + 1e-3);
        assert!((grey(Curve::Filmic, 1e9) - 1.0 / 0.983_729).abs() < 1e-3);
    }

    #[test]
    fn curves_have_their_published_values() {
        // Hill's fit by hand at .18 and 1.
        let by_hand = |x: f64| {
            (x * (x + 0.024_578_6) - 0.000_090_537) / (x * (0.983_729 * x + 0.432_951) + 0.238_081)
        };
        for x in [0.18, 1.0] {
            assert!((grey(Curve::Filmic, x) - by_hand(x)).abs() < 2e-4);
        }
        assert!((by_hand(1.0) - 0.619_1).abs() < 1e-3);
        // The polynomial that B. Wrensch fitted to the sigmoid ("Minimal AgX Implementation", 2023).
        for step in 0..=100 {
            let x = f64::from(step) / 100.0;
            let polynomial = [-0.002_32, 0.119_1, 0.429_8, -6.868, 31.96, -40.14, 15.5]
                .into_iter()
                .rev()
                .fold(0.0, |sum, c| sum * x + c);
            let own = sigmoid(x);
            assert!((own - polynomial).abs() < 6e-3, "{x}: {own} {polynomial}");
        }
        // Middle grey is the pivot of AgX.
        assert!((grey(Curve::AgX, 0.18) - trig::pow(0.5, 2.2)).abs() < 1e-4);
    }

    #[test]
    fn rec_2020_has_the_matrix_of_its_standard() {
        // ITU-R BT.2087, from BT.709.
        let first = DVec3::new(0.6274, 0.0691, 0.0164);
        assert!((REC2020.x_axis - first).abs().max_element() < 1e-4, "{}", REC2020.x_axis);
    }

    #[test]
    fn light_is_found_for_a_code() {
        for curve in ALL {
            for code in [0.1, 0.5, 220.0 / 255.0] {
                let light = curve.light_shown_as(code);
                assert!((srgb_from_linear(grey(curve, light)) - code).abs() < 1e-4, "{curve:?}");
            }
        }
    }

    #[test]
    fn colours_out_of_gamut_are_numbers() {
        for curve in ALL {
            let shown = curve.apply([-0.2, 0.3, 1.5]);
            assert!(shown.iter().all(|x| x.is_finite()), "{curve:?}");
        }
    }
}
