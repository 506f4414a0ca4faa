//! Light inside snow: how much of it goes down and up at a depth.

use super::albedo::bands;
use super::batches::Batches;
use super::kernel::layers_for;
use super::lengths::LengthHistogram;
use super::nodes::{nodes_for, weights_at};
use super::progress::{Tell, part_of};
use super::{AlbedoSettings, SnowStack};
use crate::measure::Estimate;
use snowgrain_accel::homogeneous::trace_homogeneous;
use snowgrain_optics::ice;

/// Paths that are counted together; the differences between such counts give the errors.
const PATHS_PER_TASK: u64 = 1 << 10;
/// Tasks of the first round.
const FIRST_TASKS: u64 = 16;

/// Fluxes through a level plane, in parts of the light that falls on the snow.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Flux {
    /// Downwards.
    pub down: Estimate,
    /// Upwards.
    pub up: Estimate,
}

/// Fluxes at depths below the surface (metres, within the layer) for each wavelength of the settings,
/// in one layer over a black ground, by Monte Carlo as [`super::homogeneous_albedo`]. Where the light
/// falls on the snow, at depth 0, down is 1 and up the albedo.
///
/// Paths are traced until each downward flux is known to the standard error of the settings, and to
/// their relative error, or too many are. `None` for several layers or a ground that reflects.
#[must_use]
pub fn flux_profile(
    stack: &SnowStack,
    depths: &[f64],
    settings: &AlbedoSettings,
    tell: Tell<'_>,
) -> Option<Vec<Vec<Flux>>> {
    if stack.layers.len() != 1 || stack.ground_albedo > 0.0 {
        return None;
    }
    let mut found = vec![Vec::new(); settings.wavelengths_nm.len()];
    let bands = bands(stack, &settings.wavelengths_nm);
    for (part, band) in bands.iter().enumerate() {
        let tell = part_of(tell, part, bands.len());
        let wavelengths_nm = band.iter().map(|&index| settings.wavelengths_nm[index]).collect();
        let settings = AlbedoSettings { wavelengths_nm, ..settings.clone() };
        let search = Search { stack, depths, settings: &settings };
        for (index, fluxes) in band.iter().zip(search.run(&tell)) {
            found[*index] = fluxes;
        }
    }
    Some(found)
}

struct Search<'a> {
    stack: &'a SnowStack,
    depths: &'a [f64],
    settings: &'a AlbedoSettings,
}

impl Search<'_> {
    /// Of each wavelength the fluxes at all depths.
    fn run(&self, tell: Tell<'_>) -> Vec<Vec<Flux>> {
        let nodes = nodes_for(&self.settings.wavelengths_nm);
        let batches = Batches {
            paths: PATHS_PER_TASK,
            first: FIRST_TASKS,
            most_paths: self.settings.most_paths,
        };
        let fluxes = |means: &[Estimate]| {
            let pairs = means.chunks_exact(2);
            pairs.map(|pair| Flux { down: pair[0], up: pair[1] }).collect::<Vec<Flux>>()
        };
        let error = |means: &[Estimate]| {
            fluxes(means).iter().map(|flux| self.error_to_reach(flux)).fold(0.0, f64::max)
        };
        let means = batches.until_exact(|task| self.task(&nodes, task), error, tell);
        fluxes(&means).chunks(self.depths.len().max(1)).map(<[Flux]>::to_vec).collect()
    }

    fn error_to_reach(&self, flux: &Flux) -> f64 {
        let error = flux.down.standard_error;
        let wanted = self.settings.relative_error_of_transmittance * flux.down.mean;
        let relative = if wanted > 0.0 { error / wanted } else { 0.0 };
        (error / self.settings.standard_error).max(relative)
    }

    /// Mean fluxes of the paths of a task: down and up, depth by depth, wavelength by wavelength.
    fn task(&self, nodes: &[f64], task: u64) -> Vec<f64> {
        let layer = &self.stack.layers[0];
        let (wavelengths, depths) = (&self.settings.wavelengths_nm, self.depths.len());
        let mut values = vec![0.0; wavelengths.len() * depths * 2];
        let weights: Vec<Vec<f64>> = wavelengths
            .iter()
            .map(|&wavelength| weights_at(nodes, ice::refractive_index(wavelength)))
            .collect();
        for (node, &eta) in nodes.iter().enumerate() {
            let mut layers = layers_for(&self.stack.layers, self.stack, self.settings, eta);
            let extinction = layer.extinction_per_metre();
            layers.planes = self.depths.iter().map(|depth| (extinction * depth) as f32).collect();
            let mut crossings = vec![LengthHistogram::default(); depths * 2];
            let paths = task * PATHS_PER_TASK..(task + 1) * PATHS_PER_TASK;
            trace_homogeneous(&layers, self.settings.level, paths, &mut |_| (), &mut |crossing| {
                let at = 2 * crossing.plane + usize::from(!crossing.downwards);
                crossings[at].add(crossing.weight.into(), crossing.ice_lengths[0]);
            });
            for (index, &wavelength) in wavelengths.iter().enumerate() {
                let absorption =
                    layer.absorption_per_metre(self.stack.ice, wavelength) * layer.radius;
                let values = &mut values[index * depths * 2..(index + 1) * depths * 2];
                for (value, crossings) in values.iter_mut().zip(&crossings) {
                    *value +=
                        weights[index][node] * crossings.light(absorption, PATHS_PER_TASK).mean;
                }
            }
        }
        // Paths begin at the surface: they do not cross it when they enter.
        for values in values.chunks_exact_mut(2 * depths.max(1)) {
            for (pair, _) in
                values.chunks_exact_mut(2).zip(self.depths).filter(|(_, depth)| **depth == 0.0)
            {
                pair[0] = 1.0;
            }
        }
        values
    }
}
