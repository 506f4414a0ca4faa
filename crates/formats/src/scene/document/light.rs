//! `[[light]]` as written.

use super::super::quantity::Triple;
use schemars::JsonSchema;
use serde::Deserialize;

/// A light. Which keys may be used depends on `kind`.
#[derive(Clone, Debug, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct LightTable {
    /// "sky" (a diffuse hemisphere above, at infinity; black below), "uniform" (the whole sphere),
    /// "overcast" (the CIE standard overcast sky, three times as bright at the zenith as at the
    /// horizon), "clear-sky" (the CIE standard clear sky with the spectrum of a clear day over snow), "sun"
    /// (its disc), or "sun-sky" (both, as two lights).
    pub kind: LightKindName,
    /// Radiance, of an overcast sky that of the zenith: one number or [r, g, b], at least 0; default 1; sky,
    /// uniform, overcast.
    #[serde(default)]
    pub radiance: Option<Triple>,
    /// Factor on the light: one number or [r, g, b], at least 0; default 1; clear-sky, sun, sun-sky.
    #[serde(default)]
    pub strength: Option<Triple>,
    /// What a strength of 1 is: "relative" (white ground under this sun and its clear sky together has
    /// radiance 1, whatever part of them the light is) or "cd/m2" (radiances are luminances in cd/m^2 as on a
    /// real day); default "relative"; clear-sky, sun, sun-sky.
    #[serde(default)]
    pub units: Option<UnitsName>,
    /// How high the sun stands above the horizon in degrees, above 0 and at most 90; clear-sky, sun, sun-sky.
    #[serde(default)]
    pub elevation: Option<f64>,
    /// Where the sun stands in degrees from north (-z) clockwise over east (+x): any finite number; default
    /// 0; clear-sky, sun, sun-sky.
    #[serde(default)]
    pub azimuth: Option<f64>,
    /// Angle across the sun in degrees, above 0 and at most 90; its light stays the same; default 0.533; sun,
    /// sun-sky.
    #[serde(default)]
    pub angular_diameter: Option<f64>,
    /// Spectrum, of which `radiance` is the brightness and tint: "d65" (daylight), "d55" (mid-morning
    /// daylight), "a" (an incandescent lamp) or "equal-energy"; default "d65", the white of pictures, and of
    /// sun and clear sky what they have on a clear day.
    #[serde(default)]
    pub spectrum: Option<SpectrumName>,
    /// Whether the camera sees it behind everything (else it sees camera.backdrop): true or false;
    /// default true.
    #[serde(default = "yes")]
    pub visible_to_camera: bool,
    /// Name of the lights whose light films keep together: a string that is not empty; default "sky" (sky,
    /// overcast, clear-sky), "uniform" or "sun".
    #[serde(default)]
    pub group: Option<String>,
}

fn yes() -> bool {
    true
}

/// Spectra of lights.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum SpectrumName {
    /// CIE D65.
    D65,
    /// CIE D55.
    D55,
    /// CIE A.
    A,
    /// The same power at every wavelength.
    EqualEnergy,
}

/// What a strength of 1 is.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, JsonSchema)]
pub enum UnitsName {
    /// White ground has radiance 1.
    #[default]
    #[serde(rename = "relative")]
    Relative,
    /// As on a real day.
    #[serde(rename = "cd/m2")]
    CandelaPerSquareMetre,
}

/// Kinds of light.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum LightKindName {
    /// A diffuse hemisphere above y = 0 at infinity.
    Sky,
    /// The whole sphere at infinity.
    Uniform,
    /// The CIE standard overcast sky.
    Overcast,
    /// The CIE standard clear sky without the sun.
    ClearSky,
    /// The sun alone.
    Sun,
    /// Sun and clear sky.
    SunSky,
}

impl LightKindName {
    /// All of them.
    pub const ALL: [Self; 6] =
        [Self::Sky, Self::Uniform, Self::Overcast, Self::ClearSky, Self::Sun, Self::SunSky];

    /// Its name.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Sky => "sky",
            Self::Uniform => "uniform",
            Self::Overcast => "overcast",
            Self::ClearSky => "clear-sky",
            Self::Sun => "sun",
            Self::SunSky => "sun-sky",
        }
    }
}
