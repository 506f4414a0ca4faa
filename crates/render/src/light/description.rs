//! Lights as plain data.

use super::environment::EnvironmentMap;
use snowgrain_math::{DVec3, trig};
use snowgrain_optics::Illuminant;
use std::sync::Arc;

/// A light: what it is, and how much of which light it gives to which group.
#[derive(Clone, Debug, PartialEq)]
pub struct LightDescription {
    /// Where its light comes from.
    pub kind: LightKind,
    /// How much light, linear sRGB, as a colour and brightness of the spectrum: what of it the kind says.
    pub strength: [f32; 3],
    /// Spectrum.
    pub spectrum: Illuminant,
    /// Whether a camera ray that meets nothing before sees it.
    pub visible_to_camera: bool,
    /// Name of the lights that a film keeps apart from others.
    pub group: String,
}

/// The closed set of lights.
#[derive(Clone, Debug, PartialEq)]
pub enum LightKind {
    /// The paper's diffuse hemisphere above y = 0 at infinity; `strength` is its radiance.
    Sky,
    /// The whole sphere at infinity; `strength` is its radiance.
    Uniform,
    /// The CIE standard overcast sky: `strength` is the radiance L_z of the zenith, and at an elevation
    /// gamma it is L_z (1 + 2 sin gamma) / 3 (Moon and Spencer 1942, Illum. Eng. 37, 707; CIE S 011, type 16).
    /// It gives a level plane an irradiance of 7 pi / 9 L_z.
    Overcast,
    /// The CIE standard clear sky without the disc of the sun
    /// ([`snowgrain_optics::clear_sky::relative_luminance`]); `strength` is pi times less than the irradiance
    /// that it gives a level plane: the radiance of the [`LightKind::Sky`] that does the same.
    ClearSky {
        /// Unit vector towards the sun, y > 0.
        sun: DVec3,
    },
    /// A uniform disc at infinity; `strength` is its radiance.
    Sun {
        /// Unit vector towards its middle.
        direction: DVec3,
        /// Angle across it, degrees, above 0 and at most 90.
        diameter_degrees: f64,
    },
    /// A picture of all directions; `strength` is a factor on its pixels.
    Environment {
        /// The picture.
        map: Arc<EnvironmentMap>,
        /// By how many degrees it is turned about y, counter-clockwise as seen from above.
        rotation_degrees: f64,
    },
    /// A luminous sphere; `strength` is its radiance.
    Sphere {
        /// Its middle, metres.
        center: DVec3,
        /// Metres, above 0.
        radius: f64,
    },
    /// A luminous parallelogram, of which one side shines: that from which the edges turn counter-clockwise
    /// (`edges[0] x edges[1]` points to where the light goes). `strength` is its radiance.
    Quad {
        /// A corner, metres.
        corner: DVec3,
        /// The edges from there, metres, not parallel.
        edges: [DVec3; 2],
    },
    /// An object of the scene, both of whose sides shine; `strength` is its radiance, and its albedo does not
    /// count. A plane shines but is never looked for.
    Object {
        /// Index of the object.
        object: usize,
    },
    /// A point; `strength` is its intensity: radiance times m^2. No path meets it, so that it lights only
    /// where light is looked for.
    Point {
        /// Where, metres.
        position: DVec3,
    },
    /// A point that shines into a cone; `strength` is its intensity along the axis: radiance times m^2. No
    /// path meets it, so that it lights only where light is looked for.
    Spot {
        /// Where, metres.
        position: DVec3,
        /// Along the axis.
        direction: DVec3,
        /// Angle from the axis, degrees, within which the intensity is whole.
        inner_degrees: f64,
        /// Angle from the axis, degrees, beyond which it is none; above the inner one and at most 180.
        outer_degrees: f64,
    },
}

impl LightKind {
    /// Whether it is a point, which no path meets.
    #[must_use]
    pub fn is_point(&self) -> bool {
        matches!(self, Self::Point { .. } | Self::Spot { .. })
    }

    /// The group of a light that names none.
    #[must_use]
    pub fn default_group(&self) -> &'static str {
        match self {
            Self::Sky | Self::Overcast | Self::ClearSky { .. } => "sky",
            Self::Uniform => "uniform",
            Self::Sun { .. } => "sun",
            Self::Environment { .. } => "environment",
            Self::Sphere { .. }
            | Self::Quad { .. }
            | Self::Object { .. }
            | Self::Point { .. }
            | Self::Spot { .. } => "lamps",
        }
    }
}

impl LightDescription {
    /// Whether it is the whole sky, which paths find by themselves.
    #[must_use]
    pub fn is_sky(&self) -> bool {
        match self.kind {
            LightKind::Sky
            | LightKind::Uniform
            | LightKind::Overcast
            | LightKind::ClearSky { .. } => true,
            LightKind::Sun { .. }
            | LightKind::Environment { .. }
            | LightKind::Sphere { .. }
            | LightKind::Quad { .. }
            | LightKind::Object { .. }
            | LightKind::Point { .. }
            | LightKind::Spot { .. } => false,
        }
    }

    /// A light of this kind and strength in the kind's own group, of D65, which the camera sees.
    #[must_use]
    pub fn new(kind: LightKind, strength: [f32; 3]) -> Self {
        let group = kind.default_group().to_owned();
        Self { kind, strength, spectrum: Illuminant::D65, visible_to_camera: true, group }
    }
}

/// Unit vector towards a place in the sky, from its elevation above the horizon and its azimuth from north
/// (-z) clockwise over east (+x), both in degrees.
#[must_use]
pub fn direction_of(elevation_degrees: f64, azimuth_degrees: f64) -> DVec3 {
    let (sin_elevation, cos_elevation) = trig::sin_cos(elevation_degrees.to_radians());
    let (east, north) = trig::sin_cos(azimuth_degrees.to_radians());
    DVec3::new(cos_elevation * east, sin_elevation, -cos_elevation * north).normalize()
}
