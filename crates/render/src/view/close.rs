//! A macro picture of the snow.

use super::{deposited_depth, framed, towards};
use crate::camera::Camera;
use crate::description::{
    CameraDescription, Focus, Lens, Projection, SceneDescription, SnowDescription,
};
use crate::scene::surfaces_of;
use snowgrain_accel::Surfaces;
use snowgrain_math::{DVec3, Ray, trig};

/// Vertical field of view, degrees: a long lens.
const FOV_DEGREES: f64 = 12.0;

/// Mean diameters of grains that fit into the height of the picture.
pub(super) const GRAINS: f64 = 60.0;

/// Elevation of the camera, degrees above the horizon: low, so that grains stand out by their shades, and
/// high enough that the picture is filled by snow.
const ELEVATION_DEGREES: f64 = 22.0;

/// Where the camera may stand, degrees east of south, the first one first.
const AZIMUTHS_DEGREES: [f64; 4] = [20.0, -20.0, 70.0, -70.0];

/// Diameter of the lens, in distances to what it shows: at half a picture height before and behind the focus,
/// points spread over 1/33 of the height.
const LENS: f64 = 0.03;

/// Columns and rows of the plan in which places are tried.
const PLACES: u32 = 32;

/// Columns and rows of the picture that are asked what they would show.
const PROBES: u32 = 8;

/// Least upward part of a normal where snow lies thick.
const LEVEL: f64 = 0.5;

/// How much the highest place is worth against the lowest: a third of a picture full of snow.
const HIGH: f64 = 0.33;

/// The camera that shows most snow within its depth of field, of those that look at the surface of the snow as
/// far as it follows the objects; of cameras that show as much, a high one.
pub(super) fn close(scene: &SceneDescription) -> Option<CameraDescription> {
    let radius = scene.snow.iter().map(mean_radius).reduce(f64::max)?;
    let frame = framed(scene)?;
    let (depth, surfaces) = (deposited_depth(scene), surfaces_of(scene));
    let height = GRAINS * 2.0 * radius;
    let aim = |at: DVec3, azimuth| looking_at(scene, at, height, azimuth);
    let top = DVec3::new(frame.center().x, frame.max.y, frame.center().z);
    let mut best: (f64, CameraDescription) = (0.0, aim(top, AZIMUTHS_DEGREES[0]));
    for place in 0..PLACES * PLACES {
        let of = |place: u32| (f64::from(place) + 0.5) / f64::from(PLACES);
        let (x, z) = (of(place % PLACES) * frame.size().x, of(place / PLACES) * frame.size().z);
        let above = DVec3::new(frame.min.x + x, frame.max.y + frame.size().y, frame.min.z + z);
        let down = Ray::new(above, DVec3::NEG_Y);
        let Some(hit) = surfaces.intersect(&down, f64::INFINITY, None) else { continue };
        let point = down.at(hit.t);
        let high = HIGH * (point.y - frame.min.y) / frame.size().y.max(f64::MIN_POSITIVE);
        if hit.normal.y < LEVEL || high < 0.0 {
            continue;
        }
        for azimuth in AZIMUTHS_DEGREES {
            let bare = aim(point, azimuth);
            let worth = high + filled(scene, &surfaces, &bare, height);
            if worth > best.0 + 1e-9 {
                let lifted = DVec3::Y * depth;
                let camera =
                    CameraDescription { from: bare.from + lifted, at: bare.at + lifted, ..bare };
                best = (worth, camera);
            }
        }
    }
    Some(best.1)
}

/// The camera that looks at a point from there, at a picture so high.
fn looking_at(
    scene: &SceneDescription,
    at: DVec3,
    height: f64,
    azimuth_degrees: f64,
) -> CameraDescription {
    let distance = 0.5 * height / trig::tan(FOV_DEGREES.to_radians() * 0.5);
    let lens = Lens {
        diameter: LENS * distance,
        focus: Focus::Surface,
        blades: 0,
        blade_rotation_degrees: 0.0,
    };
    CameraDescription {
        from: at + towards(azimuth_degrees, ELEVATION_DEGREES) * distance,
        at,
        up: DVec3::Y,
        projection: Projection::Perspective { vertical_fov_degrees: FOV_DEGREES, lens: Some(lens) },
        backdrop: scene.camera.backdrop,
    }
}

/// The part of a picture, 0 to 1, that shows surfaces on which snow lies thick, less where they are far out of
/// focus.
fn filled(
    scene: &SceneDescription,
    surfaces: &Surfaces,
    description: &CameraDescription,
    height: f64,
) -> f64 {
    let camera = Camera::new(description, &scene.film);
    let focus = camera.depth(description.at);
    let at = |size: u32, probe: u32| f64::from(size) * (f64::from(probe) + 0.5) / f64::from(PROBES);
    let shown = (0..PROBES * PROBES).map(|probe| {
        let x = at(scene.film.width, probe % PROBES);
        let y = at(scene.film.height, probe / PROBES);
        let ray = camera.ray(x, y, [0.5; 2]);
        let Some(hit) = surfaces.intersect(&ray, f64::INFINITY, None) else { return 0.0 };
        let out_of_focus = (camera.depth(ray.at(hit.t)) - focus).abs() / height;
        if hit.normal.y >= LEVEL { (2.0 - out_of_focus).clamp(0.0, 1.0) } else { 0.0 }
    });
    shown.sum::<f64>() / f64::from(PROBES * PROBES)
}

/// Mean radius of the grains of some snow, metres.
fn mean_radius(snow: &SnowDescription) -> f64 {
    match snow {
        SnowDescription::Deposit(settings) => settings.radii.mean,
        SnowDescription::Lattice(settings) => settings.radius,
        SnowDescription::Grains(field) => {
            let sum: f64 = field.iter().map(|grain| grain.radius).sum();
            if field.is_empty() { 0.0 } else { sum / field.len() as f64 }
        }
    }
}
