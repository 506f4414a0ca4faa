//! How far light that enters snow at a point spreads, and how long it takes.

mod histogram;
mod settings;

pub use settings::{FaceSpread, Spread, SpreadBin, SpreadSettings};

use super::batches::Batches;
use super::grains::GrainExit;
use super::kernel::{illumination, least_absorption};
use super::progress::Tell;
use super::{GrainLayer, Scatterers, SnowLayer, SnowStack};
use crate::measure::Estimate;
use histogram::{Axis, cumulated, quantile};
use snowgrain_accel::homogeneous::{
    GrainExtent, GrainScattering, HomogeneousEnd, SpaceEnd, SpaceLayers, trace_in_space,
};
use snowgrain_math::trig;
use snowgrain_optics::ice::{self, ICE_DENSITY};
use snowgrain_optics::sphere::Polarisation;
use std::ops::Range;

/// Paths that are counted together; the differences between such counts give the errors.
const PATHS_PER_BATCH: u64 = 1 << 11;
/// Batches of the first round.
const FIRST_BATCHES: u64 = 16;
/// Bins for each factor of ten; radii from .01 to 1000 transport lengths, paths to 100 000.
const BINS_PER_DECADE: u32 = 16;
const RADIUS_DECADES: u32 = 5;
const PATH_DECADES: u32 = 7;
const SHORTEST: f64 = 0.01;

/// Where light that enters one layer at a point leaves it, at each wavelength, where grains are met at
/// random.
///
/// Between grains a path is free for an exponential length whose mean is that between touching no other
/// grain, 4 r (1 - phi) / (3 phi); a grain takes it from where it enters to where it leaves the sphere.
/// (Grains that are points, as [`super::homogeneous_albedo`] has them, spread light 10 to 20 % less.)
/// `None` for several layers, a ground that reflects, or grains that are no spheres.
#[must_use]
pub fn homogeneous_spread(
    stack: &SnowStack,
    settings: &SpreadSettings,
    tell: Tell<'_>,
) -> Option<Vec<Spread>> {
    let layer = only_layer(stack).filter(|layer| layer.scatterers == Scatterers::Spheres)?;
    let spread = |index: usize, wavelength_nm: f64| {
        let tell = super::progress::part_of(tell, index, settings.wavelengths_nm.len());
        let layers = layers(stack, layer, settings, wavelength_nm);
        Search::new(stack, layer, settings, wavelength_nm).run(&tell, |paths, exits| {
            let mut ended = |end: SpaceEnd<'_>| {
                let below = match end.end {
                    HomogeneousEnd::Reflected => false,
                    HomogeneousEnd::Transmitted => true,
                    HomogeneousEnd::GivenUp => return,
                };
                exits(&Exit {
                    below,
                    weight: end.weight.into(),
                    place: end.place.map(|part| part * layer.radius),
                    ice: end.ice_lengths[0] * layer.radius,
                    air: end.void_length * layer.radius,
                });
            };
            trace_in_space(&layers, settings.level, paths, &mut |_| (), &mut ended);
        })
    };
    Some(settings.wavelengths_nm.iter().enumerate().map(|(i, &nm)| spread(i, nm)).collect())
}

/// The same, traced exactly through the grains of `grains`, which were made of `stack`; light enters at
/// points all over the pack. Unpolarised at each interface whatever the settings say.
#[must_use]
pub fn grain_spread(
    stack: &SnowStack,
    grains: &mut GrainLayer,
    settings: &SpreadSettings,
    tell: Tell<'_>,
) -> Option<Vec<Spread>> {
    let layer = only_layer(stack)?;
    let mut found = Vec::new();
    for (index, &wavelength_nm) in settings.wavelengths_nm.iter().enumerate() {
        let tell = super::progress::part_of(tell, index, settings.wavelengths_nm.len());
        grains.set_refractive_index(ice::refractive_index(wavelength_nm));
        let grains = &*grains;
        let search = Search::new(stack, layer, settings, wavelength_nm);
        found.push(search.run(&tell, |paths, exits| {
            grains.trace_from_points(settings, paths, &mut |exit: GrainExit| {
                let GrainExit { below, place, ice, air } = exit;
                exits(&Exit { below, weight: 1.0, place, ice, air });
            });
        }));
    }
    Some(found)
}

fn only_layer(stack: &SnowStack) -> Option<&SnowLayer> {
    let [layer] = stack.layers.as_slice() else { return None };
    (stack.ground_albedo == 0.0).then_some(layer)
}

/// Lengths in grain radii.
fn layers(
    stack: &SnowStack,
    layer: &SnowLayer,
    settings: &SpreadSettings,
    wavelength_nm: f64,
) -> SpaceLayers {
    let solid = layer.density / ICE_DENSITY;
    SpaceLayers {
        eta: ice::refractive_index(wavelength_nm),
        polarisation: settings.polarisation,
        bottoms: vec![(layer.depth / layer.radius) as f32],
        scattering: vec![GrainScattering::Sphere],
        free_path: (4.0 * (1.0 - solid) / (3.0 * solid)) as f32,
        extent: GrainExtent::Spheres,
        illumination: illumination(settings.incidence),
        shown_depth: -1.0,
        seed: settings.seed,
        least_absorption: least_absorption(&stack.layers, stack, &[wavelength_nm]),
    }
}

/// A path that leaves the snow. Lengths in metres.
struct Exit {
    below: bool,
    weight: f64,
    /// From where it entered: along the horizontal direction of the light, and across.
    place: [f64; 2],
    ice: f64,
    air: f64,
}

/// The search at one wavelength.
struct Search<'a> {
    settings: &'a SpreadSettings,
    wavelength_nm: f64,
    transport_length: f64,
    absorption_per_metre: f64,
    refractive_index: f64,
    radii: Axis,
    paths: Axis,
}

impl<'a> Search<'a> {
    fn new(
        stack: &SnowStack,
        layer: &SnowLayer,
        settings: &'a SpreadSettings,
        wavelength_nm: f64,
    ) -> Self {
        let eta = ice::refractive_index(wavelength_nm);
        let asymmetry = layer.scatterers.at(eta).asymmetry(Polarisation::Redrawn);
        let transport_length = 1.0 / (layer.extinction_per_metre() * (1.0 - asymmetry));
        let axis = |decades: u32| Axis {
            first: SHORTEST * transport_length,
            per_decade: BINS_PER_DECADE,
            bins: decades * BINS_PER_DECADE,
        };
        Self {
            settings,
            wavelength_nm,
            transport_length,
            absorption_per_metre: layer.absorption_per_metre(stack.ice, wavelength_nm),
            refractive_index: eta,
            radii: axis(RADIUS_DECADES),
            paths: axis(PATH_DECADES),
        }
    }

    /// `trace` shows the exits of numbered paths.
    fn run(
        &self,
        tell: Tell<'_>,
        trace: impl Fn(Range<u64>, &mut dyn FnMut(&Exit)) + Sync,
    ) -> Spread {
        let batches = Batches {
            paths: PATHS_PER_BATCH,
            first: FIRST_BATCHES,
            most_paths: self.settings.most_paths,
        };
        let batch = |batch: u64| {
            let mut faces = [Counts::new(self), Counts::new(self)];
            let paths = batch * PATHS_PER_BATCH..(batch + 1) * PATHS_PER_BATCH;
            trace(paths, &mut |exit| faces[usize::from(exit.below)].add(self, exit));
            faces.into_iter().flat_map(Counts::means).collect::<Vec<f64>>()
        };
        // The cumulative parts end with the total.
        let error = |means: &[Estimate]| {
            let worst = |face: &[Estimate]| {
                let errors = self.parts(face)[1].iter().map(|mean| mean.standard_error);
                errors.fold(0.0, f64::max)
            };
            let faces = means.chunks_exact(means.len() / 2);
            faces.map(worst).fold(0.0, f64::max) / self.settings.standard_error
        };
        let means = batches.until_exact(batch, error, tell);
        let (above, below) = means.split_at(means.len() / 2);
        Spread {
            wavelength_nm: self.wavelength_nm,
            transport_length: self.transport_length,
            reflected: self.face(above),
            transmitted: self.face(below),
        }
    }

    /// Of a face the parts in rings, those within radii, those in strips, those of paths, and the mean
    /// path.
    fn parts<'m>(&self, face: &'m [Estimate]) -> [&'m [Estimate]; 5] {
        let (rings, rest) = face.split_at(self.radii.count());
        let (within, rest) = rest.split_at(self.radii.count());
        let (strips, rest) = rest.split_at(self.radii.count());
        let (paths, mean) = rest.split_at(self.paths.count());
        [rings, within, strips, paths, mean]
    }

    fn face(&self, face: &[Estimate]) -> FaceSpread {
        let [rings, within, strips, paths, mean] = self.parts(face);
        let total = within.last().copied().unwrap_or_default();
        let area = |[from, to]: [f64; 2]| core::f64::consts::PI * (to * to - from * from);
        // A strip and its mirror image.
        let both = |[from, to]: [f64; 2]| 2.0 * (to - from);
        let length = |[from, to]: [f64; 2]| to - from;
        let part = |fraction: f64| quantile(&self.radii, rings, within, fraction);
        let path = Estimate {
            mean: mean[0].mean / total.mean,
            standard_error: mean[0].standard_error / total.mean,
        };
        FaceSpread {
            total,
            per_area: self.radii.densities(rings, area),
            within: self.radii.ends(within),
            per_width: self.radii.densities(strips, both),
            per_path: self.paths.densities(paths, length),
            mean_path: path,
            median_radius: part(0.5),
            radius_of_90_percent: part(0.9),
        }
    }
}

/// Sums over the paths of a batch that left by one face.
struct Counts {
    rings: Vec<f64>,
    strips: Vec<f64>,
    paths: Vec<f64>,
    path: f64,
}

impl Counts {
    fn new(search: &Search<'_>) -> Self {
        Self {
            rings: vec![0.0; search.radii.count()],
            strips: vec![0.0; search.radii.count()],
            paths: vec![0.0; search.paths.count()],
            path: 0.0,
        }
    }

    fn add(&mut self, search: &Search<'_>, exit: &Exit) {
        let light = exit.weight * trig::exp(-search.absorption_per_metre * exit.ice);
        let [along, across] = exit.place;
        let path = search.refractive_index * exit.ice + exit.air;
        self.rings[search.radii.bin((along * along + across * across).sqrt())] += light;
        self.strips[search.radii.bin(across.abs())] += light;
        self.paths[search.paths.bin(path)] += light;
        self.path += light * path;
    }

    /// As [`Search::parts`] takes them apart.
    fn means(self) -> Vec<f64> {
        let within = cumulated(&self.rings);
        let all = [self.rings, within, self.strips, self.paths, vec![self.path]].concat();
        all.into_iter().map(|sum| sum / PATHS_PER_BATCH as f64).collect()
    }
}
