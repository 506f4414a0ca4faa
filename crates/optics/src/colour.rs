//! What the eye makes of a spectrum: CIE 1931 colour, and the primaries that pictures are in.

use crate::clear_sky::{self, GREATEST_ZENITH, SunZenith};
use crate::{Spectrum, table};
use snowgrain_math::{DMat3, DVec3};
use std::borrow::Cow;
use std::sync::LazyLock;

/// Wavelengths that colours are summed over, nm.
pub const VISIBLE_NM: [f64; 2] = [380.0, 780.0];

const OBSERVER: &str = include_str!("../data/cie1931_2deg_1nm.csv");

/// The colour matching functions of the CIE 1931 2-degree observer.
static MATCHING: LazyLock<[Spectrum; 3]> =
    LazyLock::new(|| ["xbar", "ybar", "zbar"].map(|name| table::column(OBSERVER, name)));
static D65: LazyLock<Spectrum> =
    LazyLock::new(|| table::column(include_str!("../data/cie_d65.csv"), "power"));
static D55: LazyLock<Spectrum> =
    LazyLock::new(|| table::column(include_str!("../data/cie_d55.csv"), "power"));
static A: LazyLock<Spectrum> =
    LazyLock::new(|| table::column(include_str!("../data/cie_a.csv"), "power"));

/// What names of lights of a clear day begin with; the zenith angle of the sun follows.
const SUN: &str = "sun-";
const CLEAR_SKY: &str = "clear-sky-";

/// The spectrum of a light.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Illuminant {
    /// CIE D65: average daylight, 6504 K.
    D65,
    /// CIE D55: mid-morning daylight, 5503 K.
    D55,
    /// CIE A: an incandescent lamp, 2856 K.
    A,
    /// The same power at every wavelength.
    EqualEnergy,
    /// The sun at this zenith angle, through clear air over snow ([`clear_sky`]).
    Sun(SunZenith),
    /// The clear sky over snow with the sun at this zenith angle ([`clear_sky`]).
    ClearSky(SunZenith),
}

impl Illuminant {
    /// Those of the CIE.
    pub const STANDARD: [Self; 4] = [Self::D65, Self::D55, Self::A, Self::EqualEnergy];

    /// The name by which users choose it; of sun and sky with the zenith angle of the sun in degrees, as in
    /// "sun-48.2" and "clear-sky-48.2".
    #[must_use]
    pub fn name(self) -> Cow<'static, str> {
        match self {
            Self::D65 => "d65".into(),
            Self::D55 => "d55".into(),
            Self::A => "a".into(),
            Self::EqualEnergy => "equal-energy".into(),
            Self::Sun(zenith) => format!("{SUN}{}", zenith.degrees()).into(),
            Self::ClearSky(zenith) => format!("{CLEAR_SKY}{}", zenith.degrees()).into(),
        }
    }

    /// The light of this name; `None` where there is none, or the sun stands where its spectrum is not known
    /// (zenith angles of 0 to 75 degrees are).
    #[must_use]
    pub fn from_name(name: &str) -> Option<Self> {
        if let Some(known) = Self::STANDARD.into_iter().find(|known| known.name() == name) {
            return Some(known);
        }
        let zenith = |degrees: &str| {
            let degrees = degrees.parse().ok()?;
            (0.0..=GREATEST_ZENITH).contains(&degrees).then(|| SunZenith::new(degrees))
        };
        match (name.strip_prefix(SUN), name.strip_prefix(CLEAR_SKY)) {
            (Some(degrees), _) => zenith(degrees).map(Self::Sun),
            (None, Some(degrees)) => zenith(degrees).map(Self::ClearSky),
            (None, None) => None,
        }
    }

    /// The mean of its power over [`VISIBLE_NM`], weighted with the eye's sensitivity.
    #[must_use]
    pub fn luminous_mean(self) -> f64 {
        let [first, last] = VISIBLE_NM;
        let wavelengths = (0..=(last - first) as u32).map(|step| first + f64::from(step));
        let (power, sensitivity) = wavelengths.fold((0.0, 0.0), |(power, sum), nm| {
            let sensitivity = observer(nm).y;
            (power + self.power(nm) * sensitivity, sum + sensitivity)
        });
        power / sensitivity
    }

    /// Power at a wavelength, relative to that at 560 nm in percent.
    #[must_use]
    pub fn power(self, wavelength_nm: f64) -> f64 {
        match self {
            Self::D65 => D65.at(wavelength_nm),
            Self::D55 => D55.at(wavelength_nm),
            Self::A => A.at(wavelength_nm),
            Self::EqualEnergy => 100.0,
            Self::Sun(zenith) => relative_to_560(wavelength_nm, |nm| {
                clear_sky::across_and_diffuse(zenith.degrees(), nm)[0]
            }),
            Self::ClearSky(zenith) => relative_to_560(wavelength_nm, |nm| {
                clear_sky::across_and_diffuse(zenith.degrees(), nm)[1]
            }),
        }
    }
}

/// Percent of the power at 560 nm.
fn relative_to_560(wavelength_nm: f64, power: impl Fn(f64) -> f64) -> f64 {
    100.0 * power(wavelength_nm) / power(560.0)
}

/// The colour matching functions of the CIE 1931 2-degree observer at a wavelength.
#[must_use]
pub fn observer(wavelength_nm: f64) -> DVec3 {
    DVec3::from([0, 1, 2].map(|i: usize| MATCHING[i].at(wavelength_nm)))
}

/// CIE 1931 tristimulus values of what `reflectance` leaves of the light, with Y = 1 for all of it.
///
/// Sums over [`VISIBLE_NM`] in whole nanometres.
#[must_use]
pub fn tristimulus(illuminant: Illuminant, reflectance: impl Fn(f64) -> f64) -> DVec3 {
    let [first, last] = VISIBLE_NM;
    let mut sum = DVec3::ZERO;
    let mut white = 0.0;
    for step in 0..=(last - first) as u32 {
        let at = first + f64::from(step);
        let power = illuminant.power(at);
        let matching = observer(at);
        sum += matching * (power * reflectance(at));
        white += matching.y * power;
    }
    sum / white
}

/// Chromaticity coordinates x, y.
#[must_use]
pub fn chromaticity(xyz: DVec3) -> [f64; 2] {
    let sum = xyz.x + xyz.y + xyz.z;
    [xyz.x / sum, xyz.y / sum]
}

/// Tristimulus values to the responses of Bradford's cones.
const BRADFORD: DMat3 = DMat3::from_cols(
    DVec3::new(0.8951, -0.7502, 0.0389),
    DVec3::new(0.2664, 1.7135, -0.0685),
    DVec3::new(-0.1614, 0.0367, 1.0296),
);

/// The matrix that adapts tristimulus values from one white to another, by the cones of Bradford (Lam 1985;
/// ICC.1:2022, annex E).
#[must_use]
pub fn bradford(from: DVec3, to: DVec3) -> DMat3 {
    let [from, to] = [from, to].map(|white| BRADFORD * white);
    BRADFORD.inverse() * DMat3::from_diagonal(to / from) * BRADFORD
}

/// Sets of primaries for pictures, linear.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Primaries {
    /// sRGB and Rec. 709, white D65 (IEC 61966-2-1).
    #[default]
    Srgb,
    /// ACEScg: AP1, white of ACES (Academy S-2014-004).
    AcesCg,
}

impl Primaries {
    /// All of them.
    pub const ALL: [Self; 2] = [Self::Srgb, Self::AcesCg];

    /// The name by which users choose it.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Srgb => "srgb",
            Self::AcesCg => "acescg",
        }
    }

    /// Chromaticities x, y of red, green, blue and white.
    #[must_use]
    pub fn chromaticities(self) -> [[f64; 2]; 4] {
        match self {
            Self::Srgb => [[0.64, 0.33], [0.30, 0.60], [0.15, 0.06], [0.3127, 0.3290]],
            Self::AcesCg => [[0.713, 0.293], [0.165, 0.830], [0.128, 0.044], [0.32168, 0.33767]],
        }
    }

    /// Amounts of the primaries that look like these tristimulus values; below 0 for colours out of
    /// their gamut. No adaptation to white: white of the primaries is 1, 1, 1.
    #[must_use]
    pub fn from_xyz(self, xyz: DVec3) -> DVec3 {
        self.to_xyz().inverse() * xyz
    }

    /// From tristimulus values of light of which D65 is white to amounts of the primaries, such that D65
    /// (as tabulated, over [`VISIBLE_NM`]) is 1, 1, 1: adapted to the white of the primaries, where that
    /// is another, by the matrix of Bradford (Lam 1985; ICC.1:2022, annex E).
    #[must_use]
    pub fn under_d65(self) -> DMat3 {
        let daylight = tristimulus(Illuminant::D65, |_| 1.0);
        match self {
            Self::Srgb => {
                let xyz = |[x, y]: [f64; 2]| DVec3::new(x / y, 1.0, (1.0 - x - y) / y);
                let [red, green, blue, _] = self.chromaticities().map(xyz);
                let columns = DMat3::from_cols(red, green, blue);
                let amounts = columns.inverse() * daylight;
                (columns * DMat3::from_diagonal(amounts)).inverse()
            }
            Self::AcesCg => {
                let white = self.to_xyz() * DVec3::ONE;
                self.to_xyz().inverse() * bradford(daylight, white)
            }
        }
    }

    /// The tristimulus values of each primary, in columns, such that all three give white of Y = 1
    /// (SMPTE RP 177).
    #[must_use]
    pub fn to_xyz(self) -> DMat3 {
        let xyz = |[x, y]: [f64; 2]| DVec3::new(x / y, 1.0, (1.0 - x - y) / y);
        let [red, green, blue, white] = self.chromaticities().map(xyz);
        let columns = DMat3::from_cols(red, green, blue);
        let amounts = columns.inverse() * white;
        columns * DMat3::from_diagonal(amounts)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use snowgrain_math::trig;

    #[test]
    fn white_light_has_the_chromaticity_of_its_name() {
        for (illuminant, x, y) in [
            (Illuminant::D65, 0.31272, 0.32903),
            (Illuminant::D55, 0.33242, 0.34743),
            (Illuminant::A, 0.44757, 0.40745),
            (Illuminant::EqualEnergy, 0.33333, 0.33333),
        ] {
            let white = tristimulus(illuminant, |_| 1.0);
            let [found_x, found_y] = chromaticity(white);
            assert!((white.y - 1.0).abs() < 1e-12);
            assert!((found_x - x).abs() < 1e-4 && (found_y - y).abs() < 1e-4, "{illuminant:?}");
        }
    }

    #[test]
    fn sun_and_clear_sky_have_their_colours() {
        // Sky about (.255, .265), sun and sky together about (.320, .332) at usual elevations.
        for zenith in [30.0, 48.2, 60.0] {
            let [across, diffuse] = clear_sky::illuminances(zenith);
            let sun = across * trig::sin_cos(zenith.to_radians()).1;
            let of = |light: Illuminant| tristimulus(light, |_| 1.0);
            let angle = SunZenith::new(zenith);
            let sky = of(Illuminant::ClearSky(angle));
            let both = of(Illuminant::Sun(angle)) * sun + sky * diffuse;
            println!("zenith {zenith}: sky {:?}, both {:?}", chromaticity(sky), chromaticity(both));
            for ([x, y], [expected_x, expected_y]) in
                [(chromaticity(sky), [0.255, 0.265]), (chromaticity(both), [0.320, 0.332])]
            {
                let near = (x - expected_x).abs() < 0.01 && (y - expected_y).abs() < 0.01;
                assert!(near, "{zenith}: {x} {y}");
            }
        }
    }

    #[test]
    fn lights_are_found_by_their_names() {
        let zenith = SunZenith::new(48.2);
        for light in Illuminant::STANDARD
            .into_iter()
            .chain([Illuminant::Sun(zenith), Illuminant::ClearSky(zenith)])
        {
            assert_eq!(Illuminant::from_name(&light.name()), Some(light));
        }
        assert_eq!(Illuminant::from_name("sun-48.2"), Some(Illuminant::Sun(zenith)));
        for unknown in ["sun", "sun-", "sun-80", "clear-sky--1", "sun-nan", "d50", ""] {
            assert_eq!(Illuminant::from_name(unknown), None, "{unknown}");
        }
    }

    #[test]
    fn primaries_make_white_and_the_matrices_of_their_standards() {
        let srgb = Primaries::Srgb.from_xyz(DVec3::new(0.95047, 1.0, 1.08883));
        assert!((srgb - DVec3::ONE).abs().max_element() < 5e-4, "{srgb}");
        // IEC 61966-2-1.
        let first = Primaries::Srgb.to_xyz().row(1);
        assert!((first - DVec3::new(0.2126, 0.7152, 0.0722)).abs().max_element() < 1e-4, "{first}");
        // Academy S-2014-004, AP1: the row of Y.
        let aces = Primaries::AcesCg.to_xyz().row(1);
        let standard = DVec3::new(0.272_228_7, 0.674_081_8, 0.053_689_5);
        assert!((aces - standard).abs().max_element() < 1e-6, "{aces}");
    }

    #[test]
    fn daylight_is_white_in_all_primaries() {
        for primaries in Primaries::ALL {
            let white = primaries.under_d65() * tristimulus(Illuminant::D65, |_| 1.0);
            assert!((white - DVec3::ONE).abs().max_element() < 1e-12, "{white}");
        }
        // The matrix from sRGB to ACEScg that the Academy's colour encoding gives with Bradford's.
        let to_aces = Primaries::AcesCg.under_d65() * Primaries::Srgb.under_d65().inverse();
        let first = DVec3::new(0.6131, 0.0702, 0.0206);
        assert!((to_aces.x_axis - first).abs().max_element() < 5e-4, "{}", to_aces.x_axis);
    }

    #[test]
    fn a_flat_reflectance_is_a_grey_and_deep_blue_leaves_the_gamut() {
        let grey = Primaries::Srgb.from_xyz(tristimulus(Illuminant::D65, |_| 0.25));
        assert!((grey - DVec3::splat(0.25)).abs().max_element() < 5e-4, "{grey}");
        let blue = |wavelength: f64| if wavelength < 480.0 { 1.0 } else { 0.0 };
        assert!(Primaries::Srgb.from_xyz(tristimulus(Illuminant::D65, blue)).min_element() < 0.0);
    }
}
