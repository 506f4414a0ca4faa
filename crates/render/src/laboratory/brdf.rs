//! Into which directions layers of snow reflect parallel light.

use super::albedo::bands;
use super::batches::Batches;
use super::kernel::{absorptions, illumination, least_absorption, optical_bottoms, scattering};
use super::nodes::{nodes_for, weights_at};
use super::progress::{Tell, part_of};
use super::{AlbedoSettings, Incidence, SnowStack, homogeneous_albedo};
use crate::measure::Estimate;
use rayon::prelude::*;
use snowgrain_accel::SimdLevel;
use snowgrain_accel::homogeneous::{GrainExtent, Meeting, SpaceLayers, trace_in_space};
use snowgrain_math::trig;
use snowgrain_optics::phase::PhaseTable;
use snowgrain_optics::sphere::Polarisation;
use snowgrain_optics::{ice, theory};

/// Paths that are counted together; the differences between such counts give the errors.
const PATHS_PER_BATCH: u64 = 1 << 8;
/// Batches of the first round.
const FIRST_BATCHES: u64 = 32;
/// Optical depths along the way out from which less than 2e-7 of the light comes: not counted.
const DEEPEST: f32 = 16.0;
/// Below this optical depth little light escapes: of the meetings some are left out, half as fast as it
/// falls off, and the others count so much more.
const SHALLOW: f32 = 3.0;

/// A direction from which snow is seen.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct View {
    /// Angle from the vertical, degrees, in [0, 90).
    pub zenith_degrees: f64,
    /// Angle about the vertical, degrees: 0 is where the light goes (away from the sun), 180 where it
    /// comes from.
    pub azimuth_degrees: f64,
}

/// What to find, and how exactly.
#[derive(Clone, Debug, PartialEq)]
pub struct BrdfSettings {
    /// Wavelengths, nm, 300 to 2500.
    pub wavelengths_nm: Vec<f64>,
    /// Angle of the light from the vertical, degrees, in [0, 90).
    pub sun_zenith_degrees: f64,
    /// From where.
    pub views: Vec<View>,
    /// Polarisation within a grain.
    pub polarisation: Polarisation,
    /// Standard error to reach at every wavelength in every view.
    pub standard_error: f64,
    /// Paths for each refractive index at which the search for it ends.
    pub most_paths: u64,
    /// Seed.
    pub seed: u64,
    /// Instruction set of the kernels.
    pub level: SimdLevel,
}

impl BrdfSettings {
    /// The light and a view as unit vectors, z down, and the cosine of the angle between them.
    fn geometry(&self, view: View) -> ([f64; 2], f64) {
        let (sun_sin, sun_cos) = trig::sin_cos(self.sun_zenith_degrees.to_radians());
        let (sin, cos) = trig::sin_cos(view.zenith_degrees.to_radians());
        let about = trig::sin_cos(view.azimuth_degrees.to_radians()).1;
        ([sun_cos, cos], sun_sin * sin * about - sun_cos * cos)
    }

    /// The same search for fluxes under parallel light at this angle.
    fn fluxes(&self, incidence: Incidence) -> AlbedoSettings {
        AlbedoSettings {
            wavelengths_nm: self.wavelengths_nm.clone(),
            incidence,
            polarisation: self.polarisation,
            standard_error: self.standard_error,
            relative_error_of_transmittance: f64::INFINITY,
            most_paths: self.most_paths,
            seed: self.seed,
            level: self.level,
        }
    }
}

/// The bidirectional reflectance factor (pi times the BRDF; 1 for a white diffuse surface) of layers in
/// which grains are met at random, for each wavelength in all views, by Monte Carlo.
///
/// The first scattering is exact. At every later one the light that leaves from there in each view is
/// counted by the phase function of the grain (local estimate; Marchuk et al. 1980, "The Monte Carlo
/// Methods in Atmospheric Optics"): the mean is that of the equation of radiative transfer,
/// but for the interpolation between refractive indices and the width of the bins of the phase function.
/// A diffuse ground adds what reaches it and comes back, by the reciprocity of the layers.
/// The result depends on the settings only.
#[must_use]
pub fn homogeneous_brdf(
    stack: &SnowStack,
    settings: &BrdfSettings,
    tell: Tell<'_>,
) -> Vec<Vec<Estimate>> {
    let mut found = vec![Vec::new(); settings.wavelengths_nm.len()];
    let bands = bands(stack, &settings.wavelengths_nm);
    for (part, band) in bands.iter().enumerate() {
        let tell = part_of(tell, part, bands.len());
        let wavelengths_nm = band.iter().map(|&index| settings.wavelengths_nm[index]).collect();
        let settings = BrdfSettings { wavelengths_nm, ..settings.clone() };
        for (index, factors) in band.iter().zip(Search::new(stack, &settings).run(&tell)) {
            found[*index] = factors;
        }
    }
    if stack.ground_albedo > 0.0 && !stack.is_deep() {
        add_ground(stack, settings, &mut found);
    }
    found
}

/// The same by the theory of Kokhanovsky and Breon 2012 for one deep layer of natural snow; see
/// [`theory::kokhanovsky_breon`]. `None` for layers that are not deep, or several.
#[must_use]
pub fn kokhanovsky_breon_brdf(
    stack: &SnowStack,
    settings: &BrdfSettings,
) -> Option<Vec<Vec<Estimate>>> {
    let [layer] = stack.layers.as_slice() else { return None };
    let of_wavelength = |&nm: &f64| {
        let grain = layer.single_scattering(stack.ice, settings.polarisation, nm);
        let factor = |&view: &View| {
            let (cosines, scattering) = settings.geometry(view);
            let mean = theory::kokhanovsky_breon(grain, cosines, scattering);
            Estimate { mean, standard_error: 0.0 }
        };
        settings.views.iter().map(factor).collect()
    };
    stack.is_deep().then(|| settings.wavelengths_nm.iter().map(of_wavelength).collect())
}

/// A view as the search wants it.
struct Ray {
    /// Unit direction of the light that is seen, z down.
    direction: [f32; 3],
    /// Cosine of the angle from the vertical, and its number among those of all views.
    cosine: f64,
    slant: usize,
}

/// The tracing of wavelengths that share paths.
struct Search<'a> {
    stack: &'a SnowStack,
    settings: &'a BrdfSettings,
    rays: Vec<Ray>,
    /// The different cosines of the views with the vertical.
    slants: Vec<f32>,
    nodes: Vec<f64>,
    /// Phase functions for each node and layer.
    phases: Vec<Vec<PhaseTable>>,
    /// For each layer and wavelength.
    absorptions: Vec<Vec<f64>>,
}

impl<'a> Search<'a> {
    fn new(stack: &'a SnowStack, settings: &'a BrdfSettings) -> Self {
        let mut slants: Vec<f32> = Vec::new();
        let ray = |view: &View| {
            let (sin, cosine) = trig::sin_cos(view.zenith_degrees.to_radians());
            let (across, along) = trig::sin_cos(view.azimuth_degrees.to_radians());
            let known = slants.iter().position(|&slant| slant == cosine as f32);
            let slant = known.unwrap_or_else(|| {
                slants.push(cosine as f32);
                slants.len() - 1
            });
            let direction = [sin * along, sin * across, -cosine].map(|part| part as f32);
            Ray { direction, cosine, slant }
        };
        let rays = settings.views.iter().map(ray).collect();
        let absorptions = absorptions(&stack.layers, stack, &settings.wavelengths_nm);
        let nodes = nodes_for(&settings.wavelengths_nm);
        let phase = |&eta: &f64| phases(stack, settings.polarisation, eta, &absorptions);
        let phases = nodes.iter().map(phase).collect();
        Self { stack, settings, rays, slants, nodes, phases, absorptions }
    }

    /// Of each wavelength the factors in all views.
    fn run(&self, tell: Tell<'_>) -> Vec<Vec<Estimate>> {
        let settings = self.settings;
        let batches = Batches {
            paths: PATHS_PER_BATCH,
            first: FIRST_BATCHES,
            most_paths: settings.most_paths,
        };
        let error = |means: &[Estimate]| {
            let worst = means.iter().map(|mean| mean.standard_error).fold(0.0, f64::max);
            worst / settings.standard_error
        };
        let many = batches.until_exact(|batch| self.batch(batch), error, tell);
        let count = settings.wavelengths_nm.len();
        let of_wavelength = |(index, once): (usize, Vec<f64>)| {
            let add = |(view, once): (usize, f64)| {
                let more = many[view * count + index];
                Estimate { mean: once + more.mean, ..more }
            };
            once.into_iter().enumerate().map(add).collect()
        };
        self.scattered_once().into_iter().enumerate().map(of_wavelength).collect()
    }

    /// Of each wavelength the light that one grain sends into each view: p / (4 (mu + mu0)) for each
    /// layer, times what lies between its faces of exp(-tau (1/mu + 1/mu0)), where what goes straight through
    /// grains counts as not met. The refractive index is that of the wavelength: nothing can be interpolated
    /// across a rainbow.
    fn scattered_once(&self) -> Vec<Vec<f64>> {
        let settings = self.settings;
        let bottoms = optical_bottoms(&self.stack.layers);
        let of_wavelength = |(index, &nm): (usize, &f64)| {
            let here: Vec<Vec<f64>> = self.absorptions.iter().map(|of| vec![of[index]]).collect();
            let eta = ice::refractive_index(nm);
            let phases = phases(self.stack, settings.polarisation, eta, &here);
            let light = |&view: &View| {
                let ([sun, cosine], scattering) = settings.geometry(view);
                let slope = 1.0 / sun + 1.0 / cosine;
                let left = |depth: f64| trig::exp(-slope * depth);
                let (mut top, mut above, mut light) = (0.0, 0.0, 0.0);
                for (phase, &bottom) in phases.iter().zip(&bottoms) {
                    let bottom = f64::from(bottom);
                    let turned = 1.0 - phase.straight()[0];
                    let below = above + turned * (bottom - top);
                    let once = f64::from(phase.at(scattering as f32)[0]) / turned;
                    light += once * (left(above) - left(below)) / (4.0 * (sun + cosine));
                    (top, above) = (bottom, below);
                }
                light
            };
            settings.views.iter().map(light).collect()
        };
        settings.wavelengths_nm.par_iter().enumerate().map(of_wavelength).collect()
    }

    /// Of each wavelength the weights of the nodes.
    fn weights(&self) -> Vec<Vec<f64>> {
        let wavelengths = self.settings.wavelengths_nm.iter();
        wavelengths.map(|&nm| weights_at(&self.nodes, ice::refractive_index(nm))).collect()
    }

    /// Mean light of the paths of a batch that was scattered more than once: view by view, wavelength
    /// by wavelength.
    fn batch(&self, batch: u64) -> Vec<f64> {
        let (weights, count) = (self.weights(), self.settings.wavelengths_nm.len());
        let mut light = vec![0.0; self.rays.len() * count];
        for (node, &eta) in self.nodes.iter().enumerate() {
            let mut sums = vec![0.0; self.rays.len() * count];
            let layers = self.layers(eta);
            let mut seen = Seen {
                search: self,
                phases: &self.phases[node],
                bottoms: &layers.bottoms,
                sun: layers.illumination.direction(),
                left: vec![0.0; count],
                escapes: vec![0.0; self.slants.len() * count],
                sums: &mut sums,
            };
            let paths = batch * PATHS_PER_BATCH..(batch + 1) * PATHS_PER_BATCH;
            let mut met = |meeting: Meeting<'_>| seen.add(&meeting);
            trace_in_space(&layers, self.settings.level, paths, &mut met, &mut |_| ());
            let of_view = light.chunks_exact_mut(count).zip(sums.chunks_exact(count));
            for ((light, sums), ray) in of_view.zip(&self.rays) {
                let part = 1.0 / (4.0 * ray.cosine * PATHS_PER_BATCH as f64);
                for ((light, sum), weights) in light.iter_mut().zip(sums).zip(&weights) {
                    *light += weights[node] * part * sum;
                }
            }
        }
        light
    }

    fn layers(&self, eta: f64) -> SpaceLayers {
        let (stack, settings) = (self.stack, self.settings);
        let highest = self.slants.iter().copied().fold(0.0, f32::max);
        SpaceLayers {
            eta,
            polarisation: settings.polarisation,
            bottoms: optical_bottoms(&stack.layers),
            scattering: scattering(&stack.layers, eta),
            free_path: 1.0,
            extent: GrainExtent::Points,
            illumination: illumination(Incidence::Sun {
                zenith_degrees: settings.sun_zenith_degrees,
            }),
            shown_depth: DEEPEST * highest,
            seed: settings.seed,
            least_absorption: least_absorption(&stack.layers, stack, &settings.wavelengths_nm),
        }
    }
}

/// Of each layer, whose grains absorb so much a radius at each wavelength.
fn phases(
    stack: &SnowStack,
    polarisation: Polarisation,
    eta: f64,
    absorptions: &[Vec<f64>],
) -> Vec<PhaseTable> {
    let layers = stack.layers.iter().zip(absorptions);
    layers.map(|(layer, of)| layer.scatterers.at(eta).phase(polarisation, of)).collect()
}

/// What is seen of the grains that paths meet.
struct Seen<'a> {
    search: &'a Search<'a>,
    phases: &'a [PhaseTable],
    bottoms: &'a [f32],
    /// Where the light goes until a grain turns it.
    sun: Option<[f32; 3]>,
    /// Light of the path at each wavelength, and what of it escapes at each slant.
    left: Vec<f32>,
    escapes: Vec<f32>,
    sums: &'a mut [f64],
}

impl Seen<'_> {
    /// Adds the light that a meeting sends into every view.
    fn add(&mut self, meeting: &Meeting<'_>) {
        let kept = trig::exp_f32((0.5 * (SHALLOW - meeting.depth)).min(0.0));
        if meeting.grain_visits == 0 || meeting.number >= kept || self.is_unturned(meeting) {
            return;
        }
        let search = self.search;
        for (index, left) in self.left.iter_mut().enumerate() {
            let lengths = meeting.ice_lengths.iter().zip(&search.absorptions);
            let dark: f64 = lengths.map(|(length, of)| length * of[index]).sum();
            *left = meeting.weight / kept * trig::exp_f32(-dark as f32);
        }
        self.escape_from(meeting.depth);
        let layer = self.bottoms.iter().position(|&bottom| meeting.depth <= bottom);
        let phase = &self.phases[layer.unwrap_or(self.phases.len() - 1)];
        let [x, y, z] = meeting.direction;
        let count = self.left.len();
        for (ray, sums) in search.rays.iter().zip(self.sums.chunks_exact_mut(count)) {
            let [to_x, to_y, to_z] = ray.direction;
            let phase = phase.at(x * to_x + y * to_y + z * to_z);
            let escapes = &self.escapes[ray.slant * count..(ray.slant + 1) * count];
            for (((sum, left), phase), escape) in
                sums.iter_mut().zip(&self.left).zip(phase).zip(escapes)
            {
                *sum += f64::from(escape * left * phase);
            }
        }
    }

    /// Whether all grains so far let the light straight through, so that it is yet to be scattered once.
    fn is_unturned(&self, meeting: &Meeting<'_>) -> bool {
        self.lets_through() && self.sun == Some(meeting.direction)
    }

    fn lets_through(&self) -> bool {
        self.phases.iter().any(|phase| phase.straight().iter().any(|&part| part > 0.0))
    }

    /// What escapes from a depth at each slant and wavelength: what goes straight through grains counts as not met,
    /// but for what they absorb of it.
    fn escape_from(&mut self, depth: f32) {
        let count = self.left.len();
        let slants = &self.search.slants;
        if !self.lets_through() {
            for (escapes, slant) in self.escapes.chunks_exact_mut(count).zip(slants) {
                escapes.fill(trig::exp_f32(-depth / slant));
            }
            return;
        }
        for index in 0..count {
            let (mut top, mut met) = (0.0, 0.0);
            for (phase, &bottom) in self.phases.iter().zip(self.bottoms) {
                let here = f64::from(bottom.min(depth)) - top;
                met += (1.0 - phase.straight()[index]) * here.max(0.0);
                top = f64::from(bottom);
            }
            for (escapes, slant) in self.escapes.chunks_exact_mut(count).zip(slants) {
                escapes[index] = trig::exp_f32(-(met as f32) / slant);
            }
        }
    }
}

/// Adds the light that a diffuse ground sends up, and what ground and snow send to and fro:
/// a T(mu0) T(mu) / (1 - a R_d), with T those of parallel light and R_d that of diffuse light from
/// below. Light from the ground comes through into a direction as much as light from there would come
/// down to the ground.
fn add_ground(stack: &SnowStack, settings: &BrdfSettings, found: &mut [Vec<Estimate>]) {
    let albedo = stack.ground_albedo;
    let black = SnowStack { ground_albedo: 0.0, ..stack.clone() };
    let mut turned = black.clone();
    turned.layers.reverse();
    let through = |zenith_degrees: f64| {
        let settings = settings.fluxes(Incidence::Sun { zenith_degrees });
        let fluxes = homogeneous_albedo(&black, &settings, &|_| ());
        fluxes.iter().map(|fluxes| fluxes.transmittance).collect::<Vec<_>>()
    };
    let down = through(settings.sun_zenith_degrees);
    let mut known: Vec<(f64, Vec<Estimate>)> = Vec::new();
    for view in &settings.views {
        if !known.iter().any(|(zenith, _)| *zenith == view.zenith_degrees) {
            known.push((view.zenith_degrees, through(view.zenith_degrees)));
        }
    }
    let back = homogeneous_albedo(&turned, &settings.fluxes(Incidence::Diffuse), &|_| ());
    for (index, factors) in found.iter_mut().enumerate() {
        let (down, back) = (down[index], back[index].reflectance);
        let again = 1.0 / (1.0 - albedo * back.mean);
        for (factor, view) in factors.iter_mut().zip(&settings.views) {
            let up = known.iter().find(|(zenith, _)| *zenith == view.zenith_degrees);
            let up = up.map_or_else(Estimate::default, |(_, up)| up[index]);
            factor.mean += albedo * down.mean * up.mean * again;
            // All follow the same random numbers: their errors go together.
            let error = up.mean * down.standard_error
                + down.mean * up.standard_error
                + down.mean * up.mean * albedo * again * back.standard_error;
            factor.standard_error += albedo * again * error;
        }
    }
}
