//! Cameras that frame a scene: quick looks from chosen sides.
//!
//! What is framed is the finite objects with the snow that will lie on them, as far as boxes tell; what
//! merely carries others (a table, a slab of ground) is left out. Where there are no objects, the snow
//! is framed.

mod close;

use crate::description::{CameraDescription, Projection, SceneDescription, SnowDescription};
use crate::estimate::{bounds_of, fallen, lattice_box};
use snowgrain_grains::Amount;
use snowgrain_math::{Aabb, DVec3, trig};
use std::collections::HashMap;

/// The closed set of quick looks.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum View {
    /// From the front (+z), slightly from above.
    Front,
    /// From the front and the right, from above.
    ThreeQuarter,
    /// Straight from above; north (-z) is up.
    Top,
    /// A macro view of the snow where it fills the picture best, with a shallow depth of field: the picture
    /// is 60 grains high.
    Close,
}

/// Vertical field of view of the looks at everything, degrees.
const FOV_DEGREES: f64 = 28.0;

impl View {
    /// All of them.
    pub const ALL: [Self; 4] = [Self::Front, Self::ThreeQuarter, Self::Top, Self::Close];

    /// The name on the command line.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Front => "front",
            Self::ThreeQuarter => "three-quarter",
            Self::Top => "top",
            Self::Close => "close",
        }
    }

    /// The camera of this look at the scene, with the scene's backdrop; `None` where there is nothing
    /// finite to look at, or for a close look no snow.
    #[must_use]
    pub fn camera(self, scene: &SceneDescription) -> Option<CameraDescription> {
        match self {
            Self::Front => framing(scene, 0.0, 10.0, DVec3::Y),
            Self::ThreeQuarter => framing(scene, 35.0, 25.0, DVec3::Y),
            Self::Top => framing(scene, 0.0, 90.0, DVec3::NEG_Z),
            Self::Close => close::close(scene),
        }
    }
}

/// The unit vector towards a camera at these degrees east of south and above the horizon.
fn towards(azimuth_degrees: f64, elevation_degrees: f64) -> DVec3 {
    let (sin_a, cos_a) = trig::sin_cos(azimuth_degrees.to_radians());
    let (sin_e, cos_e) = trig::sin_cos(elevation_degrees.to_radians());
    DVec3::new(sin_a * cos_e, sin_e, cos_a * cos_e)
}

/// A pinhole whose picture just holds the ball around what is framed.
fn framing(
    scene: &SceneDescription,
    azimuth_degrees: f64,
    elevation_degrees: f64,
    up: DVec3,
) -> Option<CameraDescription> {
    let frame = framed(scene)?;
    let at = frame.center();
    let half_height = trig::tan(FOV_DEGREES.to_radians() * 0.5);
    let aspect = f64::from(scene.film.width) / f64::from(scene.film.height);
    let half_angle = trig::atan2(half_height * aspect.min(1.0), 1.0);
    let distance = 0.5 * frame.size().length() / trig::sin_cos(half_angle).0;
    Some(CameraDescription {
        from: at + towards(azimuth_degrees, elevation_degrees) * distance,
        at,
        up,
        projection: Projection::pinhole(FOV_DEGREES),
        backdrop: scene.camera.backdrop,
    })
}

/// How deep fallen snow will lie on level ground, metres.
fn deposited_depth(scene: &SceneDescription) -> f64 {
    let objects = object_boxes(scene).into_iter().fold(Aabb::EMPTY, |all, one| all.union(&one));
    let depth = |snow: &SnowDescription| match snow {
        SnowDescription::Deposit(settings) => match settings.amount {
            Amount::Depth(depth) => depth,
            Amount::Grains(_) => {
                let below = if objects.is_empty() { 0.0 } else { objects.max.y };
                (fallen(settings, &objects).1.max.y - below - 2.0 * settings.radii.largest())
                    .max(0.0)
            }
        },
        SnowDescription::Lattice(_) | SnowDescription::Grains(_) => 0.0,
    };
    scene.snow.iter().map(depth).sum()
}

/// What a look shows, metres.
fn framed(scene: &SceneDescription) -> Option<Aabb> {
    let boxes = object_boxes(scene);
    let carries = |one: &Aabb| boxes.iter().any(|other| carries(one, other));
    let mut frame = Aabb::EMPTY;
    for one in boxes.iter().filter(|one| !carries(one)) {
        frame = frame.union(one);
    }
    if !frame.is_empty() {
        frame.max.y += deposited_depth(scene);
        return Some(frame);
    }
    for snow in &scene.snow {
        frame = frame.union(&match snow {
            SnowDescription::Deposit(settings) => fallen(settings, &frame).1,
            SnowDescription::Lattice(settings) => lattice_box(settings),
            SnowDescription::Grains(field) => field.bounds(),
        });
    }
    (!frame.is_empty() && frame.size().length() > 0.0).then_some(frame)
}

/// The boxes of the finite objects, in their order.
fn object_boxes(scene: &SceneDescription) -> Vec<Aabb> {
    let mut meshes = HashMap::new();
    let boxes = scene.objects.iter().map(|object| bounds_of(object, &mut meshes));
    boxes.filter(|bounds| !bounds.is_empty()).collect()
}

/// Whether `other` stands on the top of `one`, which is wider in both directions.
fn carries(one: &Aabb, other: &Aabb) -> bool {
    let slack = 0.05 * other.size().y;
    let stands = (other.min.y - one.max.y).abs() <= slack;
    let within = one.min.x < other.min.x
        && one.max.x > other.max.x
        && one.min.z < other.min.z
        && one.max.z > other.max.z;
    stands && within
}

#[cfg(test)]
mod tests;
