//! A path through ice, water and air.

use super::coated::{Coated, InWater, Meeting};
use snowgrain_math::sampler::{PathKey, numbers};
use snowgrain_math::{DVec3, Ray};
use snowgrain_optics::fresnel;

/// Refractive indices.
#[derive(Clone, Copy, Debug)]
pub(super) struct Indices {
    pub(super) ice: f64,
    pub(super) water: f64,
}

/// Where a path ended, and what it crossed.
#[derive(Clone, Copy, Debug)]
pub(super) struct WetPath {
    /// Out of the top.
    pub(super) reflected: bool,
    /// Metres.
    pub(super) ice_length: f64,
    pub(super) water_length: f64,
}

/// Where a path is.
#[derive(Clone, Copy)]
enum Place {
    /// In air, having left this grain or its film.
    Air { left: Option<u32> },
    /// In water, in the film of a grain; having left a grain.
    Water { within: u32, left: Option<u32> },
    /// In a grain.
    Ice { grain: u32 },
}

/// Follows a path from air until it leaves the layer. At each interface its `event`-th random number
/// decides between reflection and refraction by Fresnel's mean reflectance.
pub(super) fn follow(
    pack: &Coated,
    indices: Indices,
    mut ray: Ray,
    key: PathKey,
    mut event: u32,
) -> WetPath {
    let mut path = WetPath { reflected: false, ice_length: 0.0, water_length: 0.0 };
    let dry = pack.film == 0.0;
    let mut place = Place::Air { left: None };
    loop {
        let from = index(place, indices);
        // The surface that is met, the media beyond it and before it, and whether it is met from inside.
        let (meeting, beyond, here, from_inside) = match place {
            Place::Air { left } => {
                let Some(meeting) = pack.meet_in_air(&ray, left) else {
                    path.reflected = ray.direction.y > 0.0;
                    return path;
                };
                let grain = meeting.grain;
                let beyond = if dry {
                    Place::Ice { grain }
                } else {
                    Place::Water { within: grain, left: None }
                };
                (meeting, beyond, Place::Air { left: Some(grain) }, false)
            }
            Place::Water { within, left } => match pack.meet_in_water(&ray, within, left) {
                InWater::Grain(meeting) => {
                    path.water_length += meeting.distance;
                    let grain = meeting.grain;
                    let here = Place::Water { within: grain, left: Some(grain) };
                    (meeting, Place::Ice { grain }, here, false)
                }
                InWater::Air(meeting) => {
                    path.water_length += meeting.distance;
                    let grain = meeting.grain;
                    let here = Place::Water { within: grain, left: None };
                    (meeting, Place::Air { left: Some(grain) }, here, true)
                }
            },
            Place::Ice { grain } => {
                let meeting = pack.meet_in_ice(&ray, grain);
                path.ice_length += meeting.distance;
                let beyond = if dry {
                    Place::Air { left: Some(grain) }
                } else {
                    Place::Water { within: grain, left: Some(grain) }
                };
                (meeting, beyond, place, true)
            }
        };
        let relative_index = index(beyond, indices) / from;
        let [u, ..] = numbers(key, event);
        event += 1;
        let (next, through) = interface(&ray, &meeting, from_inside, relative_index, u);
        ray = next;
        place = if through { beyond } else { here };
    }
}

fn index(place: Place, indices: Indices) -> f64 {
    match place {
        Place::Air { .. } => 1.0,
        Place::Water { .. } => indices.water,
        Place::Ice { .. } => indices.ice,
    }
}

/// The ray after an interface, and whether it went through.
fn interface(
    ray: &Ray,
    meeting: &Meeting,
    from_inside: bool,
    relative_index: f64,
    u: f32,
) -> (Ray, bool) {
    let normal: DVec3 = if from_inside { -meeting.normal } else { meeting.normal };
    let cos_theta_i = (-ray.direction.dot(normal)).clamp(0.0, 1.0);
    let origin = ray.at(meeting.distance);
    let reflectance = fresnel::reflectance(cos_theta_i, relative_index);
    let refracted = fresnel::refract(ray.direction, normal, relative_index);
    match refracted.filter(|_| f64::from(u) >= reflectance) {
        Some(direction) => (Ray::new(origin, direction), true),
        None => (Ray::new(origin, fresnel::reflect(ray.direction, normal).normalize()), false),
    }
}
