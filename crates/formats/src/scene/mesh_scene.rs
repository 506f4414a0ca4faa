//! A scene for a mesh that comes alone: the first picture of somebody's model in the snow.
//!
//! The object stands on a dark slab that fills the foreground, under an overcast sky and before a
//! dark slate backdrop, so that snow stands out. The slab and the camera follow from the object's
//! bounding box; the snow is always a million grains.

use super::SceneError;
use snowgrain_math::{Aabb, DVec3, trig};

/// Units that a mesh file may be in.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum MeshUnits {
    /// Millimetres.
    Millimetres,
    /// Centimetres.
    Centimetres,
    /// Metres.
    Metres,
    /// Inches.
    Inches,
}

impl MeshUnits {
    /// The unit called `mm`, `cm`, `m` or `in`.
    #[must_use]
    pub fn from_name(name: &str) -> Option<Self> {
        Some(match name {
            "mm" => Self::Millimetres,
            "cm" => Self::Centimetres,
            "m" => Self::Metres,
            "in" => Self::Inches,
            _ => return None,
        })
    }

    fn metres(self) -> f64 {
        match self {
            Self::Millimetres => 0.001,
            Self::Centimetres => 0.01,
            Self::Metres => 1.0,
            Self::Inches => 0.0254,
        }
    }
}

/// Which axis of a mesh file points up.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum UpAxis {
    /// y, as in most OBJ files.
    #[default]
    Y,
    /// z, as CAD programs and scanners write.
    Z,
}

impl UpAxis {
    /// The axis called `y` or `z`.
    #[must_use]
    pub fn from_name(name: &str) -> Option<Self> {
        Some(match name {
            "y" => Self::Y,
            "z" => Self::Z,
            _ => return None,
        })
    }

    /// The value of `rotate` that turns this axis up.
    fn rotation_degrees(self) -> [f64; 3] {
        match self {
            Self::Y => [0.0; 3],
            Self::Z => [-90.0, 0.0, 0.0],
        }
    }

    fn turned(self, bounds: &Aabb) -> Aabb {
        match self {
            Self::Y => *bounds,
            Self::Z => Aabb::new(
                DVec3::new(bounds.min.x, bounds.min.z, -bounds.max.y),
                DVec3::new(bounds.max.x, bounds.max.z, -bounds.min.y),
            ),
        }
    }
}

/// What the user says of the mesh; `None` is assumed.
#[derive(Clone, Copy, Debug, PartialEq, Default)]
pub struct MeshSceneOptions {
    /// Units of the file.
    pub units: Option<MeshUnits>,
    /// Its up axis.
    pub up: Option<UpAxis>,
    /// Longest side that the object shall have, metres, above 0; wins over `units`.
    pub object_size: Option<f64>,
}

/// A scene made for a mesh.
#[derive(Clone, Debug, PartialEq)]
pub struct MeshScene {
    /// The scene file, to be read by [`super::SceneFile::parse`] and to start one's own from.
    pub toml: String,
    /// What was assumed, one line each, to be shown to the user.
    pub assumptions: Vec<String>,
}

/// Longest sides, in metres, that are believed where nobody says what unit a file is in.
const PLAUSIBLE_SIZE: std::ops::RangeInclusive<f64> = 0.02..=0.6;

/// Longest side that is assumed else: table-top size, where grains can be seen.
const ASSUMED_SIZE: f64 = 0.2;

/// Grains of the quick look: as many as the paper has.
const GRAINS: f64 = 1e6;

/// Solid fraction of the ray rule counted by grain volumes (overlaps twice), piles of 20-40 radii.
const NOMINAL_SOLID_FRACTION: f64 = 0.5;

/// Where the camera stands: degrees from +z towards +x, and above the horizon.
const AZIMUTH_DEGREES: f64 = 35.0;
const ELEVATION_DEGREES: f64 = 25.0;
const VERTICAL_FOV_DEGREES: f64 = 30.0;

/// The scene for the mesh in `file` with these bounds, in the file's own units and axes.
///
/// `file` is written into the scene as it stands: relative to the folder that the scene's origin is
/// said to lie in.
///
/// # Errors
/// `object_size` that is not a finite length above 0.
pub fn scene_for_mesh(
    file: &str,
    bounds: &Aabb,
    options: &MeshSceneOptions,
) -> Result<MeshScene, SceneError> {
    if let Some(size) = options.object_size.filter(|size| !(1e-6..=1e6).contains(size)) {
        return Err(SceneError::BadValue {
            place: file.escape_debug().to_string(),
            key: "--object-size".into(),
            value: size.to_string(),
            mend: "must be the longest side in metres, above 0, as \"20 cm\"".into(),
        });
    }
    let up = options.up.unwrap_or_default();
    let (scale, size_assumption) = choose_scale(bounds.size().max_element(), options);
    let turned = up.turned(bounds);
    let box_size = turned.size() * scale;
    let translate = -DVec3::new(turned.center().x, turned.min.y, turned.center().z) * scale;
    let view = View::around(box_size);
    let snow = Snow::over(view.slab_half * 2.0, box_size.max_element());

    let up_name = if up == UpAxis::Y { "y" } else { "z" };
    let assumptions = vec![
        size_assumption,
        match options.up {
            Some(_) => format!("{up_name} is up"),
            None => format!("{up_name} is up (--up says otherwise)"),
        },
        format!(
            "snow: 1 000 000 grains of {:.2} mm radius, about {:.1} mm deep, on a slab {:.2} m wide",
            snow.radius * 1e3,
            snow.depth * 1e3,
            view.slab_half * 2.0
        ),
    ];
    let toml = write_toml(file, up, scale, translate, &view, &snow);
    Ok(MeshScene { toml, assumptions })
}

/// Metres to a file unit, and what to tell the user of it.
fn choose_scale(longest: f64, options: &MeshSceneOptions) -> (f64, String) {
    let tell =
        |scale: f64, why: &str| (scale, format!("longest side {:.4} m ({why})", scale * longest));
    match (options.object_size, options.units) {
        (Some(size), _) => tell(size / longest, "as asked"),
        (None, Some(units)) => tell(units.metres(), "as the units say"),
        (None, None) if PLAUSIBLE_SIZE.contains(&longest) => {
            tell(1.0, "the file taken as metres; --units or --object-size says otherwise")
        }
        (None, None) => tell(
            ASSUMED_SIZE / longest,
            "assumed: as metres the file would be out of table-top size; --units or --object-size \
             says otherwise",
        ),
    }
}

/// Camera and ground, metres; the object stands at the origin.
struct View {
    from: DVec3,
    at: DVec3,
    /// Half the side of the square slab.
    slab_half: f64,
}

impl View {
    /// The view that holds the ball around a box of this size that stands on the ground, and a slab
    /// that reaches beyond the lower corners of the picture.
    fn around(size: DVec3) -> Self {
        let (sin_azimuth, cos_azimuth) = trig::sin_cos(AZIMUTH_DEGREES.to_radians());
        let (sin_elevation, cos_elevation) = trig::sin_cos(ELEVATION_DEGREES.to_radians());
        let half_fov = (VERTICAL_FOV_DEGREES * 0.5).to_radians();
        let (sin_half, tan_half) = (trig::sin_cos(half_fov).0, trig::tan(half_fov));

        let at = DVec3::new(0.0, size.y * 0.5, 0.0);
        let back =
            DVec3::new(sin_azimuth * cos_elevation, sin_elevation, cos_azimuth * cos_elevation);
        let from = at + back * (0.5 * size.length() / sin_half);
        let right = DVec3::new(cos_azimuth, 0.0, -sin_azimuth);
        let down = right.cross(back);
        let corner = |side: f64| {
            let ray = -back + (down + right * side) * tan_half;
            let hit = from + ray * (from.y / -ray.y);
            hit.x.abs().max(hit.z.abs())
        };
        let foreground = corner(-1.0).max(corner(1.0));
        let footprint = 0.5 * size.x.max(size.z);
        let slab_half = (1.03 * foreground).max(1.3 * footprint);
        Self { from, at, slab_half }
    }
}

/// Snow of [`GRAINS`] grains, metres.
struct Snow {
    depth: f64,
    radius: f64,
}

impl Snow {
    /// Snow a twentieth of the object deep on a square of this side.
    fn over(side: f64, object_size: f64) -> Self {
        let depth = 0.05 * object_size;
        let volume = side * side * depth * NOMINAL_SOLID_FRACTION / GRAINS;
        Self { depth, radius: cube_root(volume * 3.0 / (4.0 * std::f64::consts::PI)) }
    }
}

/// Cube root of a positive number.
fn cube_root(x: f64) -> f64 {
    trig::pow(x, 1.0 / 3.0)
}

fn write_toml(
    file: &str,
    up: UpAxis,
    scale: f64,
    translate: DVec3,
    view: &View,
    snow: &Snow,
) -> String {
    let file = toml::Value::from(file).to_string();
    let rotate = up.rotation_degrees();
    let translate = translate.to_array();
    let from = view.from.to_array().map(rounded);
    let at = view.at.to_array().map(rounded);
    let slab = rounded(view.slab_half);
    let thickness = rounded(view.slab_half * 0.1);
    let radius = rounded(snow.radius);
    let variation = rounded(snow.radius * 0.4);
    format!(
        r#"# Made for a mesh that came alone; change what you like. Lengths in metres or like "5 mm"; y is up.
version = 1

[film]
width = 512
height = 512
samples_per_pixel = 64
seed = 0

[camera]                         # three quarters from the front, from above
from = {from:?}
at = {at:?}
up = [0, 1, 0]
vertical_fov = {VERTICAL_FOV_DEGREES:?}
backdrop = [0.03, 0.035, 0.045]  # dark slate: white snow stands out

[ice]
ior = 1.31
absorption = 0.0

[[light]]                        # overcast; the camera sees the backdrop instead
kind = "sky"
radiance = 1.0
visible_to_camera = false

[[object]]
shape = "mesh"
file = {file}
albedo = [0.55, 0.06, 0.05]
scale = {scale:?}
rotate = {rotate:?}
translate = {translate:?}

[[object]]                       # the ground: a slab whose top is y = 0
name = "ground"
shape = "box"
albedo = 0.18
scale = [{slab:?}, {thickness:?}, {slab:?}]
translate = [0, {down:?}, 0]

[[snow]]
source = "deposit"
rule = "ray"
grains = 1_000_000
radius = {radius:?}
variation = {variation:?}
max_slope = 80.0
area = [{west:?}, {west:?}, {slab:?}, {slab:?}]

[integrator]
kind = "grains"
"#,
        down = -thickness,
        west = -slab,
    )
}

/// The number with five significant digits, so that the file can be read by people.
fn rounded(x: f64) -> f64 {
    format!("{x:.4e}").parse().unwrap_or(x)
}
