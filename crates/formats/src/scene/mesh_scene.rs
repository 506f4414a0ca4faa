//! A scene for a mesh that comes alone: the first picture of somebody's model in the snow.
//!
//! The object stands on a dark slab that fills the foreground, under an overcast sky and before a
//! dark slate backdrop, so that snow stands out. It is turned by three quarters and the camera looks
//! along -z, so that the slab's far edge is level and its other edges lie outside the picture. Slab
//! and camera follow from the object's bounding box; the snow is always a million grains.

use super::SceneError;
use super::document::SnowKindName;
use super::kind_scene::KindSnow;
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

    /// Its name.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Millimetres => "mm",
            Self::Centimetres => "cm",
            Self::Metres => "m",
            Self::Inches => "in",
        }
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

    /// Its name.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Y => "y",
            Self::Z => "z",
        }
    }

    /// Degrees about x that turn this axis up.
    fn rotation_about_x(self) -> f64 {
        match self {
            Self::Y => 0.0,
            Self::Z => -90.0,
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
    /// Kind of snow that falls.
    pub kind: Option<SnowKindName>,
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

/// How far the object is turned about y, which shows its front and its right side.
const TURN_DEGREES: f64 = -35.0;

/// How far the camera stands above the horizon.
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
    let upright = up.turned(bounds);
    let placed = Placed::new(&upright, scale);
    let depth = SNOW_DEPTH_TO_SIZE * upright.size().max_element() * scale;
    let view = View::of(&placed, depth);
    let [width, length] = view.slab.size();
    let volume = width * length * depth;
    let (snow, told) = match options.kind {
        Some(kind) => {
            let snow = KindSnow::new(kind, volume);
            (snow.keys(), snow.told(depth))
        }
        None => plain_snow(grain_radius(volume), depth),
    };

    let up_name = if up == UpAxis::Y { "y" } else { "z" };
    let assumptions = vec![
        size_assumption,
        match options.up {
            Some(_) => format!("{up_name} is up"),
            None => format!("{up_name} is up (--up says otherwise)"),
        },
        format!("snow: {told}, on a slab of {width:.2} x {length:.2} m"),
    ];
    let toml = write_toml(file, up, scale, &placed, &view, &snow);
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

/// The object in the world, metres: turned by [`TURN_DEGREES`], its middle over the origin, standing
/// on y = 0.
struct Placed {
    translate: DVec3,
    /// Height, and half the extent along x and z once turned.
    height: f64,
    half_width: f64,
    half_length: f64,
    /// Diameter of the ball around it.
    diameter: f64,
}

impl Placed {
    fn new(upright: &Aabb, scale: f64) -> Self {
        let (sin, cos) = trig::sin_cos(TURN_DEGREES.to_radians());
        let (center, size) = (upright.center() * scale, upright.size() * scale);
        let turned_center = DVec3::new(
            center.x * cos + center.z * sin,
            upright.min.y * scale,
            center.z * cos - center.x * sin,
        );
        Self {
            translate: -turned_center,
            height: size.y,
            half_width: 0.5 * (size.x * cos + size.z * sin.abs()),
            half_length: 0.5 * (size.x * sin.abs() + size.z * cos),
            diameter: size.length(),
        }
    }
}

/// The rectangle of ground that carries snow, metres: x from `-half_width` to `half_width`, z from
/// `far` (behind the object) to `near`.
struct Slab {
    half_width: f64,
    far: f64,
    near: f64,
}

impl Slab {
    /// Extent along x and z.
    fn size(&self) -> [f64; 2] {
        [2.0 * self.half_width, self.near - self.far]
    }
}

/// Camera and ground, metres.
struct View {
    from: DVec3,
    at: DVec3,
    slab: Slab,
}

impl View {
    /// The square view that just holds the ball around the object and its snow, and a slab whose
    /// snow leaves the picture on the left, on the right and below.
    fn of(object: &Placed, depth: f64) -> Self {
        let (sin, cos) = trig::sin_cos(ELEVATION_DEGREES.to_radians());
        let half_fov = (VERTICAL_FOV_DEGREES * 0.5).to_radians();
        let (sin_half, tan_half) = (trig::sin_cos(half_fov).0, trig::tan(half_fov));
        let back = DVec3::new(0.0, sin, cos);
        let at = DVec3::new(0.0, 0.5 * (object.height + depth), 0.0);
        let from = at + back * (0.5 * (object.diameter + depth) / sin_half);

        // The lower edge of the picture meets the top of the snow on one line of constant z.
        let lowest = -back - DVec3::new(0.0, cos, -sin) * tan_half;
        let foreground = from.z + lowest.z * ((from.y - depth) / -lowest.y);
        let near = foreground.max(1.2 * object.half_length) + depth;
        let far = -(object.half_length + 0.4 * object.diameter);
        let distance = back.dot(from - DVec3::new(0.0, 0.0, far));
        let half_width = (distance * tan_half).max(1.2 * object.half_width) + depth;
        Self { from, at, slab: Slab { half_width, far, near } }
    }
}

/// Variation of the grains' radii, in radii.
const VARIATION_TO_RADIUS: f64 = 0.4;

/// Depth of the snow, in longest sides of the object.
pub(super) const SNOW_DEPTH_TO_SIZE: f64 = 0.05;

/// Radius, metres, of the grains of which [`GRAINS`] fill this volume of snow, cubic metres.
pub(super) fn grain_radius(volume: f64) -> f64 {
    let grain = volume * NOMINAL_SOLID_FRACTION / GRAINS;
    // Radii uniform in r (1 -+ v) have the mean cube r^3 (1 + v^2).
    let mean_cube = grain * 3.0 / (4.0 * std::f64::consts::PI);
    cube_root(mean_cube / (1.0 + VARIATION_TO_RADIUS * VARIATION_TO_RADIUS))
}

/// Keys of snow that looks like snow from afar, and what to tell the user of it; metres.
pub(super) fn plain_snow(radius: f64, depth: f64) -> (String, String) {
    let millimetres = rounded(radius * 1e3);
    let variation = rounded(radius * 1e3 * VARIATION_TO_RADIUS);
    let keys = format!(
        "rule = \"ray\"\ngrains = 1_000_000\nradius = \"{millimetres:?} mm\"\nvariation = \
         \"{variation:?} mm\"\nmax_slope = 80.0\n"
    );
    let told = format!(
        "1 000 000 grains of {:.2} mm radius, about {:.1} mm deep",
        radius * 1e3,
        depth * 1e3
    );
    (keys, told)
}

/// Cube root of a positive number.
fn cube_root(x: f64) -> f64 {
    trig::pow(x, 1.0 / 3.0)
}

fn write_toml(
    file: &str,
    up: UpAxis,
    scale: f64,
    placed: &Placed,
    view: &View,
    snow: &str,
) -> String {
    let rotate_x = up.rotation_about_x();
    // Adding zero turns -0.0 into 0.0.
    let translate = placed.translate.to_array().map(|t| t + 0.0);
    let object = write_object(
        file,
        &format!(
            "scale = {scale:?}\nrotate = [{rotate_x:?}, {TURN_DEGREES:?}, 0]\n\
             translate = {translate:?}\n"
        ),
    );
    let from = view.from.to_array().map(rounded);
    let at = view.at.to_array().map(rounded);
    let [east, south, north] = [view.slab.half_width, view.slab.near, view.slab.far].map(rounded);
    let thickness = rounded(east * 0.1);
    let (half_length, middle) = (rounded((south - north) * 0.5), rounded((south + north) * 0.5));
    format!(
        r#"# Made for a mesh that came alone; change what you like. Lengths in metres or like "5 mm"; y is up.
version = 1

[film]
width = 512
height = 512
samples_per_pixel = 32
seed = 0

[camera]                         # from above, along -z
from = {from:?}
at = {at:?}
up = [0, 1, 0]
vertical_fov = {VERTICAL_FOV_DEGREES:?}
backdrop = [0.03, 0.035, 0.045]  # dark slate: white snow stands out

[ice]
ior = 1.31
absorption = "picard-2016"

[[light]]                        # overcast; the camera sees the backdrop instead
kind = "sky"
radiance = 1.25
visible_to_camera = false

{object}
[[object]]                       # the ground: a slab whose top is y = 0; only its far edge is seen
name = "ground"
shape = "box"
albedo = 0.35
scale = [{east:?}, {thickness:?}, {half_length:?}]
translate = [0, {down:?}, {middle:?}]

[[snow]]
source = "deposit"
{snow}area = [{west:?}, {north:?}, {east:?}, {south:?}]

[integrator]
kind = "grains"
"#,
        down = -thickness,
        west = -east,
    )
}

/// The object: a mesh in one colour, or a shot that brings its own.
fn write_object(file: &str, placement: &str) -> String {
    let quoted = toml::Value::from(file).to_string();
    if is_gltf(file) {
        return format!(
            "[import]                         # turned by three quarters, standing on y = 0\n\
             file = {quoted}\n{placement}"
        );
    }
    format!(
        "[[object]]                       # turned by three quarters, standing on y = 0\n\
         shape = \"mesh\"\nfile = {quoted}\nalbedo = [0.55, 0.06, 0.05]\n{placement}"
    )
}

/// Whether a file is of glTF, by its name.
pub(super) fn is_gltf(file: &str) -> bool {
    let extension = std::path::Path::new(file).extension().unwrap_or_default();
    ["gltf", "glb"].iter().any(|known| extension.eq_ignore_ascii_case(known))
}

/// The number with five significant digits, so that the file can be read by people.
pub(super) fn rounded(x: f64) -> f64 {
    format!("{x:.4e}").parse().unwrap_or(x)
}
