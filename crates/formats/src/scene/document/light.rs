//! `[[light]]` as written.

use super::super::quantity::{Length, Triple};
use schemars::JsonSchema;
use serde::Deserialize;

/// A light. Which keys may be used depends on `kind`.
#[derive(Clone, Debug, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct LightTable {
    /// "sky" (a diffuse hemisphere above, at infinity; black below), "uniform" (the whole sphere),
    /// "overcast" (the CIE standard overcast sky, three times as bright at the zenith as at the
    /// horizon), "clear-sky" (the CIE standard clear sky with the spectrum of a clear day over snow), "sun"
    /// (its disc), "sun-sky" (both, as two lights), "environment" (a picture of all directions, from
    /// `file`), or a lamp: "sphere", "quad" (one side of a parallelogram), "point" or "spot". Objects with
    /// `emission` are lamps, too.
    pub kind: LightKindName,
    /// Radiance, of an overcast sky that of the zenith: one number or [r, g, b], at least 0; default 1; sky,
    /// uniform, overcast, sphere, quad.
    #[serde(default)]
    pub radiance: Option<Triple>,
    /// Factor on the light: one number or [r, g, b], at least 0; default 1; clear-sky, sun, sun-sky,
    /// environment.
    #[serde(default)]
    pub strength: Option<Triple>,
    /// What a strength of 1 is: "relative" (white ground under this sun and its clear sky together has
    /// radiance 1, whatever part of them the light is) or "cd/m2" (radiances are luminances in cd/m^2 as on a
    /// real day); default "relative"; clear-sky, sun, sun-sky.
    #[serde(default)]
    pub units: Option<UnitsName>,
    /// How high the sun stands above the horizon in degrees, above 0 and at most 90; clear-sky, sun, sun-sky
    /// (this or `time`).
    #[serde(default)]
    pub elevation: Option<f64>,
    /// Where the sun stands in degrees from north (-z) clockwise over east (+x): any finite number; default
    /// 0; clear-sky, sun, sun-sky.
    #[serde(default)]
    pub azimuth: Option<f64>,
    /// When, for a sun that stands where it then does: text like "2026-01-15T14:30:00+01:00" (RFC 3339, with
    /// the offset from UTC), of the years 1950 to 2050; with `latitude` and `longitude`; clear-sky, sun,
    /// sun-sky (this or `elevation`).
    #[serde(default)]
    pub time: Option<String>,
    /// Latitude in degrees, north above 0: -90 to 90; with `time`.
    #[serde(default)]
    pub latitude: Option<f64>,
    /// Longitude in degrees, east above 0: -180 to 180; with `time`.
    #[serde(default)]
    pub longitude: Option<f64>,
    /// Angle across the sun in degrees, 0.001 to 90; its light stays the same; default 0.533; sun,
    /// sun-sky.
    #[serde(default)]
    pub angular_diameter: Option<f64>,
    /// Map of all directions: an equirectangular picture (.hdr or .exr), twice as wide as high, relative to
    /// the scene file. Its middle is north (-z), a quarter to the right is east (+x); environment.
    #[serde(default)]
    pub file: Option<String>,
    /// By how many degrees the map is turned about y, counter-clockwise as seen from above, as objects are:
    /// any finite number; default 0; environment.
    #[serde(default)]
    pub rotation: Option<f64>,
    /// The middle of a sphere: [x, y, z], lengths; sphere.
    #[serde(default)]
    pub center: Option<[Length; 3]>,
    /// Radius of a sphere: a length above 0; sphere.
    #[serde(default)]
    pub radius: Option<Length>,
    /// A corner of a quad: [x, y, z], lengths; quad.
    #[serde(default)]
    pub corner: Option<[Length; 3]>,
    /// The two edges of a quad from its corner: [[x, y, z], [x, y, z]], lengths, not parallel. Light goes
    /// to the side from which the first turns counter-clockwise into the second (first x second points
    /// there); the other side is black; quad.
    #[serde(default)]
    pub edges: Option<[[Length; 3]; 2]>,
    /// Where a point stands: [x, y, z], lengths; point, spot.
    #[serde(default)]
    pub position: Option<[Length; 3]>,
    /// Intensity, of a spot along its axis: radiance times square metres (candela, where radiances are in
    /// cd/m^2), one number or [r, g, b], at least 0; default 1; point, spot.
    #[serde(default)]
    pub intensity: Option<Triple>,
    /// Along the axis of a spot: [x, y, z], any length above 0; default [0, -1, 0]; spot.
    #[serde(default)]
    pub direction: Option<[f64; 3]>,
    /// Angle from the axis within which a spot has its whole intensity, degrees, at least 0 and below 180; default
    /// 20; spot.
    #[serde(default)]
    pub inner_angle: Option<f64>,
    /// Angle from the axis beyond which a spot gives no light, degrees, above `inner_angle` and at most 180;
    /// default 30; spot.
    #[serde(default)]
    pub outer_angle: Option<f64>,
    /// Spectrum, of which `radiance` is the brightness and tint: "d65" (daylight), "d55" (mid-morning
    /// daylight), "a" (an incandescent lamp) or "equal-energy"; default "d65", the white of pictures, and of
    /// sun and clear sky what they have on a clear day.
    #[serde(default)]
    pub spectrum: Option<SpectrumName>,
    /// Whether the camera sees it: a light at infinity behind everything (else it sees camera.backdrop), a
    /// lamp where it is (else it sees what is behind): true or false; default true; all but point and spot.
    #[serde(default = "yes")]
    pub visible_to_camera: bool,
    /// Name of the lights whose light films keep together: a string that is not empty; default "sky" (sky,
    /// overcast, clear-sky), "uniform", "sun", "environment" or "lamps" (all others).
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
    /// A picture of all directions.
    Environment,
    /// A luminous sphere.
    Sphere,
    /// One side of a luminous parallelogram.
    Quad,
    /// A point.
    Point,
    /// A point that shines into a cone.
    Spot,
}

impl LightKindName {
    /// All of them.
    pub const ALL: [Self; 11] = [
        Self::Sky,
        Self::Uniform,
        Self::Overcast,
        Self::ClearSky,
        Self::Sun,
        Self::SunSky,
        Self::Environment,
        Self::Sphere,
        Self::Quad,
        Self::Point,
        Self::Spot,
    ];

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
            Self::Environment => "environment",
            Self::Sphere => "sphere",
            Self::Quad => "quad",
            Self::Point => "point",
            Self::Spot => "spot",
        }
    }
}
