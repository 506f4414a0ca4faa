//! A scene for a shot that comes with its camera: the objects stay where they are, snow falls on all of
//! them, and the shot's first camera looks on. The shot's lights shine at a strength that suits the
//! picture; without any, the sky is overcast.

use super::document::SnowKindName;
use super::kind_scene::KindSnow;
use super::mesh_scene::{MeshScene, SNOW_DEPTH_TO_SIZE, grain_radius, plain_snow, rounded};
use crate::gltf::{
    ImportedCamera, ImportedLight, ImportedLightKind, ImportedProjection, ImportedScene,
};
use snowgrain_math::{Aabb, DVec3};
use std::f64::consts::PI;

/// Pixels down of the picture.
const HEIGHT: f64 = 512.0;

/// The scene file for the shot in `file`, relative to where the scene file will be said to lie; `None`
/// where it has no camera. Snow is of this kind, if of any.
#[must_use]
pub fn scene_for_shot(
    file: &str,
    shot: &ImportedScene,
    kind: Option<SnowKindName>,
) -> Option<MeshScene> {
    let camera = shot.cameras.first()?;
    let bounds = shot.bounds();
    let size = bounds.size();
    let depth = SNOW_DEPTH_TO_SIZE * size.max_element();
    let volume = size.x.max(depth) * size.z.max(depth) * depth;
    let (snow, told, changes) = match kind {
        Some(kind) => {
            let snow = KindSnow::new(kind, volume);
            (snow.keys(), snow.told(depth), "snow.grains=... says")
        }
        None => {
            let (keys, told) = plain_snow(rounded(grain_radius(volume) * 1e3) * 1e-3, depth);
            (keys, told, "snow.radius=... and snow.grains=... say")
        }
    };
    let mut assumptions = vec![
        format!(
            "camera {:?} of the file; {:.4} x {:.4} x {:.4} m",
            camera.name, size.x, size.y, size.z
        ),
        format!("snow: {told}, on all objects; --set {changes} otherwise"),
    ];
    let file = toml::Value::from(file).to_string();
    let factor = light_strength(&shot.lights, &bounds);
    let (strength, sky) = match factor {
        None => (String::new(), SKY),
        Some(factor) => {
            assumptions.push(format!(
                "light: {} lights of the file, times {factor:.3e}, so that white in the middle has \
                 radiance 1; --set import.light_strength=... says otherwise, and --set \
                 'light+={{kind=\"sky\"}}' adds a sky",
                shot.lights.len()
            ));
            (format!("light_strength = {factor:e}\n"), "")
        }
    };
    let width = (HEIGHT * camera.aspect.unwrap_or(1.0)).round().clamp(1.0, 65_536.0);
    let toml = format!(
        r#"# Made for a shot that came alone; change what you like. Lengths in metres or like "5 mm"; y is up.
version = 1

[film]
width = {width}
height = {HEIGHT}
samples_per_pixel = 32
seed = 0

[import]
file = {file}
{strength}
{camera}
{sky}[[snow]]
source = "deposit"
{snow}"#,
        camera = write_camera(camera, bounds.center()),
    );
    Some(MeshScene { toml, assumptions })
}

/// Where the shot has no light.
const SKY: &str = r#"[[light]]                        # overcast; the camera sees the backdrop instead
kind = "sky"
radiance = 1.25
visible_to_camera = false

"#;

/// The factor with which all lights together give white that faces each of them in the middle of the objects
/// the radiance 1; points are taken to be at least half as far as the objects reach. `None` where nothing
/// shines.
fn light_strength(lights: &[ImportedLight], objects: &Aabb) -> Option<f64> {
    let nearest = 0.5 * objects.size().length();
    let illuminance = |light: &ImportedLight| {
        let of_point = |position: DVec3, candela: f64| {
            let distance = position.distance(objects.center()).max(nearest);
            candela / (distance * distance)
        };
        let lux = match light.kind {
            ImportedLightKind::Directional { lux, .. } => lux,
            ImportedLightKind::Point { position, candela }
            | ImportedLightKind::Spot { position, candela, .. } => of_point(position, candela),
        };
        lux * f64::from(light.colour.into_iter().fold(0.0, f32::max))
    };
    let factor = PI / lights.iter().map(illuminance).sum::<f64>();
    (factor > 0.0 && factor.is_finite()).then_some(factor)
}

/// The camera, looking at where the middle of the objects is nearest to its line of sight.
fn write_camera(camera: &ImportedCamera, middle: DVec3) -> String {
    let ahead = (middle - camera.from).dot(camera.gaze);
    let at = camera.from + camera.gaze * if ahead > 1e-6 { ahead } else { 1.0 };
    let name = camera.name.escape_debug();
    let projection = match camera.projection {
        ImportedProjection::Perspective { vertical_fov_degrees } => {
            format!("vertical_fov = {vertical_fov_degrees:?}")
        }
        ImportedProjection::Orthographic { height } => {
            format!("kind = \"orthographic\"\nheight = {height:?}")
        }
    };
    format!(
        "[camera]                         # {name} of the file\n\
         from = {:?}\nat = {:?}\nup = {:?}\n{projection}\n\
         backdrop = [0.03, 0.035, 0.045]  # dark slate: white snow stands out\n",
        camera.from.to_array(),
        at.to_array(),
        camera.up.to_array(),
    )
}
