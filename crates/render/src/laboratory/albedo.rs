//! Spectral albedo of layers of snow.

use super::kernel::layers_for;
use super::lengths::Ends;
use super::nodes::{nodes_for, weights_at};
use super::progress::{Round, Tell, part_of};
use super::{GrainLayer, Incidence, Scatterers, SnowLayer, SnowStack};
use crate::measure::Estimate;
use rayon::prelude::*;
use snowgrain_accel::SimdLevel;
use snowgrain_accel::homogeneous::{HomogeneousEnd, trace_homogeneous};
use snowgrain_math::trig;
use snowgrain_optics::ice;
use snowgrain_optics::sphere::Polarisation;
use snowgrain_optics::theory::{self, Fluxes};

/// Paths that a thread follows at a time.
const PATHS_PER_TASK: u64 = 1 << 10;
/// Paths of the first round, for each refractive index.
const FIRST_ROUND: u64 = 1 << 12;
/// Wavelengths share paths as long as none absorbs so many times as much as another: where ice absorbs
/// more, more paths are needed, but short ones.
const ABSORPTION_OF_BAND: f64 = 8.0;

/// What to find, and how exactly.
#[derive(Clone, Debug, PartialEq)]
pub struct AlbedoSettings {
    /// Wavelengths, nm, 300 to 2500.
    pub wavelengths_nm: Vec<f64>,
    /// How light arrives.
    pub incidence: Incidence,
    /// Polarisation within a grain.
    pub polarisation: Polarisation,
    /// Standard error to reach at every wavelength, of reflectance and of transmittance.
    pub standard_error: f64,
    /// Standard error of the transmittance as a part of it, to reach as well; infinite: any will do.
    pub relative_error_of_transmittance: f64,
    /// Paths for each refractive index at which the search for it ends.
    pub most_paths: u64,
    /// Seed.
    pub seed: u64,
    /// Instruction set of the kernels.
    pub level: SimdLevel,
}

impl AlbedoSettings {
    /// The standard errors of reflectance and transmittance, in those to reach: the larger one.
    fn errors_to_reach(&self, [up, down]: [Estimate; 2]) -> f64 {
        let absolute = up.standard_error.max(down.standard_error) / self.standard_error;
        let wanted = self.relative_error_of_transmittance * down.mean;
        // Where nothing came through yet, nothing is known of its error.
        let relative = if wanted > 0.0 { down.standard_error / wanted } else { 0.0 };
        absolute.max(relative)
    }
}

/// What becomes of the light on a stack of layers at one wavelength.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Albedo {
    /// Wavelength, nm.
    pub wavelength_nm: f64,
    /// Reflected by snow and ground.
    pub reflectance: Estimate,
    /// Arriving at the ground, direct light included, with what ground and snow send to and fro.
    pub transmittance: Estimate,
    /// Absorbed by ice and impurities.
    pub absorptance: f64,
}

/// Layers in which grains are met at random, by the closed form of a sphere or by samples of what shapes do (see
/// `snowgrain_accel::homogeneous`): Monte Carlo, unbiased but for the interpolation between refractive
/// indices. The result depends on the settings only.
#[must_use]
pub fn homogeneous_albedo(
    stack: &SnowStack,
    settings: &AlbedoSettings,
    tell: Tell<'_>,
) -> Vec<Albedo> {
    let mut found: Vec<Option<Albedo>> = vec![None; settings.wavelengths_nm.len()];
    let bands = bands(stack, &settings.wavelengths_nm);
    for (part, band) in bands.iter().enumerate() {
        let tell = part_of(tell, part, bands.len());
        let wavelengths_nm = band.iter().map(|&index| settings.wavelengths_nm[index]).collect();
        let settings = AlbedoSettings { wavelengths_nm, ..settings.clone() };
        let albedos = albedo_of_band(stack, &settings, &mut Way::Homogeneous, &tell);
        for (index, albedo) in band.iter().zip(albedos) {
            found[*index] = Some(albedo);
        }
    }
    found.into_iter().flatten().collect()
}

/// The layer of `stack` traced exactly through its grains: unbiased, but for the interpolation between
/// refractive indices, for this pack. `polarisation` is drawn anew at each interface whatever the
/// settings say.
#[must_use]
pub fn grain_albedo(
    stack: &SnowStack,
    layer: &mut GrainLayer,
    settings: &AlbedoSettings,
    tell: Tell<'_>,
) -> Vec<Albedo> {
    albedo_of_band(stack, settings, &mut Way::Grains(layer), tell)
}

/// Ways to trace paths.
enum Way<'w> {
    Homogeneous,
    Grains(&'w mut GrainLayer),
}

/// Indices of the wavelengths, by the absorption of the top layer that they meet.
pub(super) fn bands(stack: &SnowStack, wavelengths_nm: &[f64]) -> Vec<Vec<usize>> {
    let absorption: Vec<f64> = wavelengths_nm
        .iter()
        .map(|&wavelength| {
            let layer = |layer: &SnowLayer| layer.absorption_per_metre(stack.ice, wavelength);
            stack.layers.first().map_or(0.0, layer)
        })
        .collect();
    let mut order: Vec<usize> = (0..wavelengths_nm.len()).collect();
    order.sort_by(|&a, &b| absorption[a].total_cmp(&absorption[b]));
    let mut bands: Vec<Vec<usize>> = Vec::new();
    for index in order {
        match bands.last_mut() {
            Some(band) if absorption[index] <= ABSORPTION_OF_BAND * absorption[band[0]] => {
                band.push(index);
            }
            _ => bands.push(vec![index]),
        }
    }
    bands
}

fn albedo_of_band(
    stack: &SnowStack,
    settings: &AlbedoSettings,
    way: &mut Way<'_>,
    tell: Tell<'_>,
) -> Vec<Albedo> {
    let reflects = stack.ground_albedo > 0.0 && !stack.is_deep();
    let parts = 1 + usize::from(reflects);
    let first = part_of(tell, 0, parts);
    let above = Runs::until_exact(&stack.layers, false, stack, (settings, way), &first);
    let below = reflects.then(|| {
        let turned: Vec<SnowLayer> = stack.layers.iter().rev().cloned().collect();
        let diffuse = AlbedoSettings { incidence: Incidence::Diffuse, ..settings.clone() };
        let second = part_of(tell, 1, parts);
        Runs::until_exact(&turned, true, stack, (&diffuse, way), &second)
    });
    settings
        .wavelengths_nm
        .iter()
        .map(|&wavelength_nm| {
            let [up, down] = above.at(stack, wavelength_nm);
            let ground = below.as_ref().map(|below| below.at(stack, wavelength_nm));
            with_ground(wavelength_nm, [up, down], ground, stack.ground_albedo)
        })
        .collect()
}

/// Adds what a diffuse ground sends back: R' = R + a T T_d / (1 - a R_d), with R_d and T_d those of
/// diffuse light from below.
fn with_ground(
    wavelength_nm: f64,
    [up, down]: [Estimate; 2],
    ground: Option<[Estimate; 2]>,
    albedo: f64,
) -> Albedo {
    let Some([back, through]) = ground else {
        let absorptance = 1.0 - up.mean - down.mean;
        return Albedo { wavelength_nm, reflectance: up, transmittance: down, absorptance };
    };
    let again = 1.0 / (1.0 - albedo * back.mean);
    let arrives = down.mean * again;
    let error = |parts: &[f64]| parts.iter().map(|part| part * part).sum::<f64>().sqrt();
    let arrives_error = error(&[
        down.standard_error * again,
        down.mean * albedo * again * again * back.standard_error,
    ]);
    let returned = albedo * through.mean;
    let reflectance = Estimate {
        mean: up.mean + arrives * returned,
        standard_error: error(&[
            up.standard_error,
            arrives_error * returned,
            arrives * albedo * through.standard_error,
        ]),
    };
    Albedo {
        wavelength_nm,
        reflectance,
        transmittance: Estimate { mean: arrives, standard_error: arrives_error },
        absorptance: 1.0 - reflectance.mean - (1.0 - albedo) * arrives,
    }
}

/// Paths through layers, one set for each refractive index.
struct Runs {
    /// From where light enters on.
    layers: Vec<SnowLayer>,
    /// Whether it enters from below.
    from_below: bool,
    nodes: Vec<f64>,
    ends: Vec<Ends>,
    paths: u64,
}

impl Runs {
    /// Traces paths until the standard error is reached at all wavelengths, or too many are.
    fn until_exact(
        layers: &[SnowLayer],
        from_below: bool,
        stack: &SnowStack,
        (settings, way): (&AlbedoSettings, &mut Way<'_>),
        tell: Tell<'_>,
    ) -> Self {
        let nodes = nodes_for(&settings.wavelengths_nm);
        let ends = vec![Ends::of(layers.len()); nodes.len()];
        let mut runs = Self { layers: layers.to_vec(), from_below, nodes, ends, paths: 0 };
        let mut next = FIRST_ROUND.min(settings.most_paths.max(1));
        let mut short = f64::INFINITY;
        loop {
            let paths = runs.paths..runs.paths + next;
            let round = Round::new(tell, runs.paths * runs.nodes.len() as u64, short);
            match way {
                Way::Homogeneous => runs.trace_homogeneous(stack, settings, next, &round),
                Way::Grains(layer) => {
                    for (ends, &eta) in runs.ends.iter_mut().zip(&runs.nodes) {
                        ends.merge(&layer.trace(eta, settings, (runs.from_below, &paths), &round));
                    }
                }
            }
            runs.paths = paths.end;
            let worst = settings
                .wavelengths_nm
                .iter()
                .map(|&wavelength| settings.errors_to_reach(runs.at(stack, wavelength)))
                .fold(0.0, f64::max);
            short = worst * worst;
            tell((1.0 / short).min(1.0));
            if short <= 1.0 || runs.paths >= settings.most_paths {
                return runs;
            }
            // A little more than is missing, but not far beyond what is known.
            let wanted = (runs.paths as f64 * (1.05 * short - 1.0).clamp(0.1, 3.0)) as u64;
            next = wanted.max(PATHS_PER_TASK).min(settings.most_paths - runs.paths);
        }
    }

    fn trace_homogeneous(
        &mut self,
        stack: &SnowStack,
        settings: &AlbedoSettings,
        more: u64,
        round: &Round<'_>,
    ) {
        let first = self.paths;
        let tasks: Vec<(usize, u64)> = (0..self.nodes.len())
            .flat_map(|node| (0..more.div_ceil(PATHS_PER_TASK)).map(move |task| (node, task)))
            .collect();
        let count = self.layers.len();
        let parts: Vec<(usize, Ends)> = tasks
            .into_par_iter()
            .map(|(node, task)| {
                let from = first + task * PATHS_PER_TASK;
                let until = (from + PATHS_PER_TASK).min(first + more);
                let layers = layers_for(&self.layers, stack, settings, self.nodes[node]);
                let mut ends = Ends::of(count);
                trace_homogeneous(
                    &layers,
                    settings.level,
                    from..until,
                    &mut |path| {
                        let below = match path.end {
                            HomogeneousEnd::Reflected => false,
                            HomogeneousEnd::Transmitted => true,
                            HomogeneousEnd::GivenUp => return,
                        };
                        ends.add(path.weight, below, path.ice_lengths);
                    },
                    &mut |_| (),
                );
                round.add(until - from);
                (node, ends)
            })
            .collect();
        parts.iter().for_each(|(node, ends)| self.ends[*node].merge(ends));
    }

    /// Reflectance and transmittance of the layers, interpolated between refractive indices.
    fn at(&self, stack: &SnowStack, wavelength_nm: f64) -> [Estimate; 2] {
        let absorption: Vec<f64> = self
            .layers
            .iter()
            .map(|layer| layer.absorption_per_metre(stack.ice, wavelength_nm) * layer.radius)
            .collect();
        let weights = weights_at(&self.nodes, ice::refractive_index(wavelength_nm));
        let mut found = [Estimate::default(); 2];
        for (ends, weight) in self.ends.iter().zip(weights) {
            let lights = ends.light(&absorption, self.paths);
            for (found, light) in found.iter_mut().zip(lights) {
                let variance = (light.mean_of_squares - light.mean * light.mean).max(0.0);
                // Where none came through, one path more might have.
                let least = if light.mean == 0.0 && !stack.is_deep() { 1.0 } else { 0.0 };
                let standard_error =
                    (variance / self.paths as f64).sqrt().max(least / self.paths as f64);
                found.mean += weight * light.mean;
                // All nodes follow the same random numbers: their errors go together.
                found.standard_error += weight.abs() * standard_error;
            }
        }
        found
    }
}

/// Theories in closed form; see [`snowgrain_optics::theory`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Theory {
    /// Wiscombe and Warren 1980.
    WiscombeWarren,
    /// Two streams, delta-Eddington.
    TwoStream,
    /// Kokhanovsky and Zege 2004.
    KokhanovskyZege,
    /// Bohren and Barkstrom 1974: deep snow of spheres under diffuse light.
    BohrenBarkstrom,
}

/// Albedo of one layer by theory; `None` for several layers, and where the theory says nothing.
#[must_use]
pub fn theoretical_albedo(
    theory: Theory,
    stack: &SnowStack,
    incidence: Incidence,
    polarisation: Polarisation,
    wavelength_nm: f64,
) -> Option<Albedo> {
    let [layer] = stack.layers.as_slice() else { return None };
    let grain = layer.single_scattering(stack.ice, polarisation, wavelength_nm);
    let absorption = layer.absorption_per_metre(stack.ice, wavelength_nm) * layer.radius;
    let depth = layer.optical_depth();
    let fluxes = |incidence: theory::Incidence| match theory {
        Theory::WiscombeWarren => Some(theory::wiscombe_warren(grain, depth, incidence)),
        Theory::TwoStream => Some(theory::two_stream(grain, depth, incidence)),
        Theory::KokhanovskyZege => Some(theory::kokhanovsky_zege(grain, depth, incidence)),
        Theory::BohrenBarkstrom => {
            let applies = depth.is_infinite()
                && incidence == theory::Incidence::Diffuse
                && layer.scatterers == Scatterers::Spheres;
            let reflectance = theory::bohren_barkstrom(absorption).max(0.0);
            applies.then_some(Fluxes { reflectance, transmittance: 0.0 })
        }
    };
    let exact = |fluxes: Fluxes| {
        [fluxes.reflectance, fluxes.transmittance]
            .map(|mean| Estimate { mean, standard_error: 0.0 })
    };
    let above = fluxes(match incidence {
        Incidence::Diffuse => theory::Incidence::Diffuse,
        Incidence::Sun { zenith_degrees } => {
            theory::Incidence::Parallel(trig::sin_cos(zenith_degrees.to_radians()).1)
        }
    })?;
    let reflects = stack.ground_albedo > 0.0 && !stack.is_deep();
    let below = if reflects { Some(exact(fluxes(theory::Incidence::Diffuse)?)) } else { None };
    Some(with_ground(wavelength_nm, exact(above), below, stack.ground_albedo))
}
