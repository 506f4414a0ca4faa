//! Wet snow: light in grains of ice that are coated with water, exactly.
//!
//! Water lies around each grain as a film of one thickness. Where films touch they join, so that they fill
//! necks first and, as they grow, all pores: a *saturation* of 0 is dry snow, of 1 no air. A path meets every
//! surface between air, water and ice with the relative index that it has.
//!
//! Two things happen when pores fill. The surface of what borders on air shrinks, as if grains were larger;
//! and ice that lies in water (relative index .983) hardly turns light. [`WetLayer::effective_radius`] is the
//! size of the spheres that have the same surface to air and volume as ice and water together, which is what
//! is left of the first without the second.

mod coated;
mod walk;

use super::Incidence;
use crate::RenderError;
use crate::measure::{self, Estimate, SlabSettings};
use coated::Coated;
use rayon::prelude::*;
use snowgrain_accel::SimdLevel;
use snowgrain_geometry::Grain;
use snowgrain_grains::{RandomSettings, random_pack};
use snowgrain_math::DVec3;
use snowgrain_math::sampler::pcg3d;
use snowgrain_math::trig;
use snowgrain_optics::ice::{self, ICE_DENSITY};
use snowgrain_optics::{IceAbsorption, water};
use walk::{Indices, WetPath, follow};

/// Period along x and z, in radii.
const WIDTH_IN_RADII: f64 = 20.0;
/// Points at which the distance to the nearest grain is taken.
const POINTS: u32 = 1 << 18;
/// Films are looked for up to this thickness, in radii: beyond any pore but the largest of thin snow.
const MOST_FILM: f64 = 6.0;
/// Paths that a thread follows at a time.
const PATHS_PER_TASK: u64 = 1 << 8;

/// A layer of equal grains at random places, dry.
#[derive(Debug)]
pub struct WetLayer {
    grains: Vec<Grain>,
    periods: [f64; 2],
    radius: f64,
    depth: f64,
    /// Solid fraction of ice.
    ice_fraction: f64,
    /// Distances of points in the pores from the nearest grain, metres, increasing.
    distances: Vec<f64>,
}

/// What is done with light.
#[derive(Clone, Debug, PartialEq)]
pub struct WetSettings {
    /// Wavelengths, nm, 300 to 2500.
    pub wavelengths_nm: Vec<f64>,
    /// How light arrives.
    pub incidence: Incidence,
    /// Absorption of the ice.
    pub ice: IceAbsorption,
    /// Paths for each wavelength, at least 2.
    pub paths: u64,
    /// Seed.
    pub seed: u64,
}

/// What becomes of the light on a wet layer over black ground.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct WetAlbedo {
    /// Wavelength, nm.
    pub wavelength_nm: f64,
    /// Reflected.
    pub reflectance: Estimate,
    /// Transmitted.
    pub transmittance: Estimate,
}

impl WetLayer {
    /// Packs the grains: `radius` and `depth` in metres, `density` of the ice in kg/m^3.
    ///
    /// # Errors
    /// A density that random places do not reach (321 kg/m^3 is the highest), a depth of less than a grain.
    pub fn new(radius: f64, density: f64, depth: f64, seed: u64) -> Result<Self, RenderError> {
        let width = WIDTH_IN_RADII * radius;
        let (field, period) = random_pack(&RandomSettings { radius, density, depth, width, seed })?;
        let periods = period.map(|quanta| quanta as f64 * field.quantisation.quantum());
        let grains: Vec<Grain> = field.iter().collect();
        let probe = Coated::new(&grains, periods, MOST_FILM * radius);
        let mut distances: Vec<f64> = (0..POINTS)
            .into_par_iter()
            .map(|number| {
                let [x, y, z] = pcg3d(number, seed as u32, 0x9E7)
                    .map(|word| (f64::from(word) + 0.5) / 4_294_967_296.0);
                let point = DVec3::new(x * periods[0], y * depth, z * periods[1]);
                probe.distance_from_grains(point).unwrap_or(MOST_FILM * radius)
            })
            .filter(|&distance| distance > 0.0)
            .collect();
        distances.sort_by(f64::total_cmp);
        let ice_fraction = density / ICE_DENSITY;
        Ok(Self { grains, periods, radius, depth, ice_fraction, distances })
    }

    /// Thickness of the films that fill a part `saturation`, 0 to 1, of the pores, metres.
    #[must_use]
    pub fn film(&self, saturation: f64) -> f64 {
        if saturation <= 0.0 {
            return 0.0;
        }
        let last = self.distances.len() - 1;
        self.distances[((saturation * last as f64).round() as usize).min(last)]
    }

    /// Water by volume of snow, as a part of 1 (the field's liquid water content, in per cent 100 times
    /// that).
    #[must_use]
    pub fn liquid_water_content(&self, saturation: f64) -> f64 {
        saturation * (1.0 - self.ice_fraction)
    }

    /// Water by volume of ice (the paper's W).
    #[must_use]
    pub fn wetness(&self, saturation: f64) -> f64 {
        self.liquid_water_content(saturation) / self.ice_fraction
    }

    /// Radius of the spheres that have the volume of ice and water together and their surface to air,
    /// metres; infinite where no air is left. `3 V / S`, the surface being by how much the volume grows with
    /// the thickness of the films.
    #[must_use]
    pub fn effective_radius(&self, saturation: f64) -> f64 {
        if saturation <= 0.0 {
            return self.radius;
        }
        // Points in a window around the thickness; a hundredth of a radius holds thousands of them.
        let (film, half) = (self.film(saturation), 0.02 * self.radius);
        let below =
            |distance: f64| self.distances.partition_point(|&known| known < distance) as f64;
        let low = (film - half).max(0.0);
        let part = (below(film + half) - below(low)) / self.distances.len() as f64;
        let surface = part * (1.0 - self.ice_fraction) / (film + half - low);
        let volume = self.ice_fraction + self.liquid_water_content(saturation);
        3.0 * volume / surface
    }

    /// Ice and water by volume of snow.
    #[must_use]
    pub fn filled(&self, saturation: f64) -> f64 {
        self.ice_fraction + self.liquid_water_content(saturation)
    }

    /// Follows light through the layer with its pores filled to `saturation`, over black ground. The result
    /// depends on the settings only.
    #[must_use]
    pub fn albedo(&self, saturation: f64, settings: &WetSettings) -> Vec<WetAlbedo> {
        let pack = Coated::new(&self.grains, self.periods, self.film(saturation));
        let [bottom, top] = pack.heights;
        let slab = SlabSettings {
            top: top.max(self.depth),
            bottom,
            period: self.periods,
            incidence: match settings.incidence {
                Incidence::Diffuse => measure::Incidence::Lambertian,
                Incidence::Sun { zenith_degrees } => {
                    measure::Incidence::Collimated { zenith_degrees }
                }
            },
            from_below: false,
            absorption_per_metre: 0.0,
            paths: settings.paths,
            seed: settings.seed,
            level: SimdLevel::detect(),
        };
        settings.wavelengths_nm.iter().map(|&nm| wet_albedo(&pack, &slab, settings, nm)).collect()
    }
}

fn wet_albedo(
    pack: &Coated,
    slab: &SlabSettings,
    settings: &WetSettings,
    wavelength_nm: f64,
) -> WetAlbedo {
    let indices = Indices {
        ice: ice::refractive_index(wavelength_nm),
        water: water::refractive_index(wavelength_nm),
    };
    let absorption =
        [settings.ice.per_metre(wavelength_nm), water::absorption_per_metre(wavelength_nm)];
    let light = |path: &WetPath| {
        trig::exp(-(absorption[0] * path.ice_length + absorption[1] * path.water_length))
    };
    // Of the light that is reflected and transmitted, the sum and that of squares.
    let parts: Vec<[[f64; 2]; 2]> = (0..settings.paths.div_ceil(PATHS_PER_TASK))
        .into_par_iter()
        .map(|task| {
            let first = task * PATHS_PER_TASK;
            let mut sums = [[0.0; 2]; 2];
            for number in first..settings.paths.min(first + PATHS_PER_TASK) {
                let start = slab.path(number);
                let path = follow(pack, indices, start.ray, start.key, start.event);
                let light = light(&path);
                let [sum, squares] = &mut sums[usize::from(!path.reflected)];
                *sum += light;
                *squares += light * light;
            }
            sums
        })
        .collect();
    let [reflectance, transmittance] = [0, 1].map(|side: usize| {
        let [sum, squares] = parts
            .iter()
            .fold([0.0; 2], |[sum, squares], part| [sum + part[side][0], squares + part[side][1]]);
        let n = settings.paths as f64;
        let mean = sum / n;
        let variance = (squares / n - mean * mean).max(0.0);
        Estimate { mean, standard_error: (variance / (n - 1.0)).sqrt() }
    });
    WetAlbedo { wavelength_nm, reflectance, transmittance }
}

#[cfg(test)]
mod tests;
