//! The lattice of quanta to which all grains of a scene are rounded.

use crate::RenderError;
use crate::description::{SceneDescription, SnowDescription};
use snowgrain_accel::Surfaces;
use snowgrain_geometry::Quantisation;
use snowgrain_grains::GrainsError;
use snowgrain_math::{Aabb, DVec3};

/// Least mean radius, in quanta, of grains that share a scene with larger ones.
const LEAST_MEAN_RADIUS_QUANTA: f64 = 32.0;

/// Refuses snow whose grains are so much smaller than others of the scene that rounding to their
/// common quanta would change them.
pub(super) fn check_sizes(
    description: &SceneDescription,
    quantisation: Quantisation,
) -> Result<(), RenderError> {
    for (index, snow) in description.snow.iter().enumerate() {
        let mean = match snow {
            SnowDescription::Deposit(settings) => settings.radii.mean(),
            SnowDescription::Filled(settings) => settings.pack.radii.mean(),
            SnowDescription::Lattice(settings) => settings.radius,
            SnowDescription::Grains(_) => continue,
        };
        let least = LEAST_MEAN_RADIUS_QUANTA * quantisation.quantum();
        if mean < least {
            let largest = quantisation.largest_radius();
            let reason = format!(
                "{mean} m is too small beside grains of {largest} m in the same scene; use at least {least:.3e} m"
            );
            let source = GrainsError::Setting { key: "radius", reason };
            return Err(RenderError::Snow { index, source });
        }
    }
    Ok(())
}

/// One lattice of quanta for all snow of a scene: that of a grain file where it holds all other
/// grains too (so that the file comes back bit for bit), else made for the longest reach of a grain around
/// the whole metre nearest to the middle of the scene.
pub(super) fn quantisation_of(description: &SceneDescription, surfaces: &Surfaces) -> Quantisation {
    let mut largest: f64 = 0.0;
    let mut bounds = surfaces.bounds();
    let mut from_file: Option<Quantisation> = None;
    // Lattices start at the origin of the quanta, which must then be that of the scene.
    let mut at_origin = false;
    for (body, snow) in description.snow.iter().enumerate() {
        let reach = description.reach_of(body);
        match snow {
            SnowDescription::Deposit(settings) => {
                largest = largest.max(settings.radii.largest() * reach);
                if let Some([x0, z0, x1, z1]) = settings.area {
                    bounds =
                        bounds.union(&Aabb::new(DVec3::new(x0, 0.0, z0), DVec3::new(x1, 0.0, z1)));
                }
            }
            SnowDescription::Filled(settings) => {
                largest = largest.max(settings.pack.radii.largest() * reach);
                bounds = bounds.union(&settings.body.bounds());
            }
            SnowDescription::Lattice(settings) => {
                largest = largest.max(settings.radius * reach);
                at_origin = true;
            }
            SnowDescription::Grains(field) => {
                let mixed = description.shapes_of(body).is_some();
                let radius =
                    f64::from(field.largest_radius_quanta()) * field.quantisation.quantum();
                let farthest = if mixed { radius * reach } else { field.largest_reach() };
                largest = largest.max(farthest);
                bounds = bounds.union(&field.bounds());
                if from_file.is_none_or(|q| q.quantum() < field.quantisation.quantum()) {
                    from_file = Some(field.quantisation);
                }
            }
        }
    }
    // The radii of shapes were rounded too, up by half a quantum at most, and grains reach that much farther.
    let bodies = 0..description.snow.len();
    let reach = bodies.map(|body| description.reach_of(body)).fold(0.0, f64::max);
    let slack = if description.has_shapes() { reach } else { 0.0 };
    let usable = |q: &Quantisation| {
        largest <= q.largest_radius() + slack * q.quantum()
            && (!at_origin || q.origin() == DVec3::ZERO)
    };
    if let Some(quantisation) = from_file.filter(usable) {
        return quantisation;
    }
    let origin = if bounds.is_empty() || at_origin { DVec3::ZERO } else { bounds.center().round() };
    Quantisation::for_grains(origin, if largest > 0.0 { largest } else { 1.0 })
}
