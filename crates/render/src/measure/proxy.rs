//! What real grains differ by from grains that are met at random: measured on a slab of them.

use super::{PackedSlab, SlabMeasure, SlabSettings, measure_slab, measure_slab_in_medium};
use crate::transport::medium::{Calibration, InnerSnow, Medium, MediumKind};
use snowgrain_grains::{GrainsError, ICE_DENSITY, PACK_DENSITIES, PackSettings};

/// Paths by which a scene's own grains are measured.
pub const CALIBRATION_PATHS: u64 = 1 << 17;
/// Depth of the slab, mean radii.
const SLAB_DEPTH: f64 = 60.0;
/// Times that the part that passes straight is mended.
const STEPS: u32 = 3;
/// Bare part of the surface above which grains count as apart.
const APART: f64 = 0.98;
/// Seed of the pack and of its light.
const SEED: u64 = 0xca11_b0a7;
/// Light comes through a slab as one over the grains that turn it and about this.
const BEYOND_GRAINS: f64 = 1.072;

/// Makes a slab of such snow, of a pack or of a snowfall, and finds by so many paths the part of the grains that the proxy must let light straight
/// through, so that as much comes through the slab as through the grains: a pure function of the snow. By
/// [`CALIBRATION_PATHS`] the transmittance of both has a standard error of 1 in 200 or so, the part of about .005.
///
/// # Errors
/// Snow of which none can be made.
pub fn calibrate_proxy(snow: &InnerSnow, paths: u64) -> Result<Calibration, GrainsError> {
    let [low, high] = PACK_DENSITIES;
    let density = (ICE_DENSITY * snow.solid).clamp(low, high);
    let size = (SLAB_DEPTH * snow.radii.mean(), snow.eta);
    let mix = snow.mix.as_ref();
    let slab = match &snow.fell {
        Some(snowfall) => PackedSlab::fallen((snowfall, mix), size, (paths, SEED)),
        None => {
            let pack = PackSettings { radii: snow.radii.clone(), density, seed: SEED };
            PackedSlab::new((&pack, mix), size, (paths, SEED))
        }
    }?;
    let exact = measure_slab(&slab.world, &slab.settings);
    let measured = calibration_by(&slab, &exact, STEPS);
    Ok(Calibration { solid: density / ICE_DENSITY, ..measured })
}

/// The calibration by which light does the same in a slab, by what it does in it; lengths in ice as in lone grains, which is exact,
/// where these do not reach into each other.
///
/// # Panics
/// If the slab holds no grains.
#[must_use]
pub fn calibration_by(slab: &PackedSlab, exact: &SlabMeasure, steps: u32) -> Calibration {
    let PackedSlab { world, prototypes, settings, solid_fraction: solid, .. } = slab;
    let medium = Medium::in_the_dark(MediumKind::Proxy, (world, prototypes));
    let mut medium = medium.expect("a slab holds grains");
    // The way that light takes to come through grows as the grains that turn it.
    let way = |measure: &SlabMeasure| 1.0 / measure.transmittance.mean - BEYOND_GRAINS;
    let mut found = Calibration { solid: *solid, straight: 0.0, ice: 1.0 };
    let mut ice = 1.0;
    for step in 1..=steps {
        // What the first steps find is only nearer.
        let paths = (settings.paths >> (2 * (steps - step))).max(1);
        medium = medium.calibrated(&[found]);
        let settings = SlabSettings { paths, ..*settings };
        let measure = measure_slab_in_medium(world, &medium, &settings);
        found.straight = 1.0 - (1.0 - found.straight) * way(exact) / way(&measure);
        found.straight = found.straight.clamp(Calibration::PARTS[0], Calibration::PARTS[1]);
        ice = exact.ice_path.mean / measure.ice_path.mean;
    }
    if medium.bare_surface() < APART {
        found.ice = ice;
    }
    found
}
