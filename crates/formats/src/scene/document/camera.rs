//! `[camera]`, and `[import]`, which may bring one.

use super::super::focus::Focus;
use super::super::quantity::{Length, Triple};
use super::{nowhere, one};
use schemars::JsonSchema;
use serde::Deserialize;

/// A glTF 2.0 file whose objects are taken over, each with its base colour for albedo, before those of
/// `object`, and whose lights are, after those of `light`. All of it is scaled, then rotated, then translated.
#[derive(Clone, Debug, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ImportTable {
    /// The file (.gltf or .glb), relative to the scene file.
    pub file: String,
    /// Name of the camera that is taken where there is no `[camera]`: a string; default the first.
    #[serde(default)]
    pub camera: Option<String>,
    /// Factor on the lights of the file, whose lux and candela are taken for radiances in cd/m^2: one number
    /// or [r, g, b], at least 0; default 1.
    #[serde(default)]
    pub light_strength: Option<Triple>,
    /// Scale: one number or [x, y, z], none of them 0; default 1.
    #[serde(default = "one")]
    pub scale: Triple,
    /// Rotation in degrees about x, then y, then z: [x, y, z]; default [0, 0, 0].
    #[serde(default)]
    pub rotate: [f64; 3],
    /// Translation: [x, y, z], lengths; default [0, 0, 0].
    #[serde(default = "nowhere")]
    pub translate: [Length; 3],
}

/// A camera: a pinhole, to which all is sharp, a thin lens, or parallel rays.
#[derive(Clone, Debug, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct CameraTable {
    /// "perspective" (rays spread from a pinhole, or from a lens where there is `aperture` or
    /// `f_number`) or "orthographic" (parallel rays, which start in the plane through `from`: what
    /// lies behind it is not seen); default "perspective".
    #[serde(default)]
    pub kind: CameraKind,
    /// Where the camera is (the middle of its lens): [x, y, z], lengths.
    pub from: [Length; 3],
    /// The point in the middle of the picture: [x, y, z], lengths.
    pub at: [Length; 3],
    /// The direction that is up in the picture: [x, y, z]; default [0, 1, 0].
    #[serde(default = "up")]
    pub up: [f64; 3],
    /// Vertical field of view in degrees, above 0 and below 180, that of a lens focused at infinity;
    /// default 40; perspective.
    #[serde(default)]
    pub vertical_fov: Option<f64>,
    /// How much of the world the picture is high: a length above 0; orthographic.
    #[serde(default)]
    pub height: Option<Length>,
    /// Diameter of the lens (its entrance pupil): a length above 0, as "2 mm"; default none, a
    /// pinhole; perspective (this or `f_number`).
    #[serde(default)]
    pub aperture: Option<Length>,
    /// f-number of the lens, as 2.8: its diameter is its focal length, sensor_height / (2 tan
    /// (vertical_fov / 2)), divided by this; above 0; default none, a pinhole; perspective (this or
    /// `aperture`).
    #[serde(default)]
    pub f_number: Option<f64>,
    /// Height of the sensor, for `f_number`: a length above 0; default "24 mm"; perspective.
    #[serde(default)]
    pub sensor_height: Option<Length>,
    /// What is sharp: the plane at a distance along the view, as "30 cm", or through a point
    /// [x, y, z], or "surface", what the middle of the picture shows once all snow lies; default
    /// through `at`; perspective with a lens.
    #[serde(default)]
    pub focus: Option<Focus>,
    /// Blades of the diaphragm: 0 (a round opening) or 3 to 64 (a regular polygon with its corners on
    /// the circle of the diameter); default 0; perspective with a lens.
    #[serde(default)]
    pub blades: Option<u32>,
    /// Rotation of the polygon of the blades in degrees, counter-clockwise as blur behind the focus
    /// shows it; default 0, a corner up; perspective with blades.
    #[serde(default)]
    pub blade_rotation: Option<f64>,
    /// Exposure value at ISO 100, for lights in cd/m^2: PNG files show the luminance 1.2 * 2^ev100
    /// cd/m^2 as white, so sunlit snow is well exposed at about 15 and snow in open shade at 12; -30 to 50;
    /// default none: a radiance of 1 is white. EXR and film files hold the light as it is and carry the
    /// exposure beside it.
    #[serde(default)]
    pub ev100: Option<f64>,
    /// What the camera sees behind everything, where no visible light is: radiance, one number or
    /// [r, g, b], at least 0; default 0. It lights nothing.
    #[serde(default = "black")]
    pub backdrop: Triple,
}

/// Kinds of camera.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum CameraKind {
    /// Rays spread from a point or a lens.
    #[default]
    Perspective,
    /// Parallel rays.
    Orthographic,
}

fn up() -> [f64; 3] {
    [0.0, 1.0, 0.0]
}

fn black() -> Triple {
    Triple([0.0; 3])
}
