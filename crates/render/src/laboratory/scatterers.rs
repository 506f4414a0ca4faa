//! The grains of a layer as what they are to light: spheres, or shapes in all orientations alike.

use super::lengths::LengthHistogram;
use super::scattering::{scattered_of, told_of_met};
use core::f64::consts::PI;
use snowgrain_accel::SimdLevel;
use snowgrain_accel::homogeneous::{GrainScattering, ScatteringSample};
use snowgrain_geometry::Shape;
use snowgrain_grains::ShapeMix;
use snowgrain_optics::scatter::Scattered;
use snowgrain_optics::sphere::{self, Polarisation};
use snowgrain_optics::{Dielectric, PhaseTable};
use std::collections::BTreeMap;
use std::sync::{Arc, Mutex, PoisonError};

/// Samples of light that stand for the shapes of a layer.
const SAMPLES: usize = 1 << 21;
/// Less the cosine of the angle within which light counts as not turned: what faces that are parallel let through.
const STRAIGHT: f64 = 1e-9;
/// The greatest cosine of light that was turned.
const TURNED: f32 = 1.0 - f32::EPSILON / 2.0;
/// Bins of the phase function of spheres: .04 degrees wide at its rainbow, 1.8 at its very front.
const SPHERE_BINS: usize = 1 << 12;
/// Bins of that of shapes: about 4000 samples each.
const SHAPE_BINS: usize = 1 << 9;

/// What scatters light in a layer.
#[derive(Clone, Debug, Default, PartialEq)]
pub enum Scatterers {
    /// Spheres, by their closed form.
    #[default]
    Spheres,
    /// Grains of shapes.
    Shapes(Arc<ScatteringMix>),
}

/// Shapes that are met at random, each as often as its part of all shadows, in all orientations alike. What they do
/// to light is sampled: 2^21 times at each refractive index that is asked for, by the kernel that traces snow.
#[derive(Debug)]
pub struct ScatteringMix {
    name: String,
    mix: ShapeMix,
    seed: u64,
    /// By the bits of the refractive index.
    known: Mutex<BTreeMap<u64, Arc<SampledGrain>>>,
}

/// A grain at one refractive index.
#[derive(Clone, Debug)]
pub(super) enum Grain {
    Sphere(Dielectric),
    Sampled(Arc<SampledGrain>),
}

/// What a mix of shapes does to light, by samples of it.
#[derive(Debug)]
pub(super) struct SampledGrain {
    samples: Arc<[ScatteringSample]>,
    lengths: LengthHistogram,
    asymmetry: f64,
    mean_length: f64,
    /// Mean shadow, in discs of the radius of equal volume.
    shadow: f64,
}

impl PartialEq for ScatteringMix {
    fn eq(&self, other: &Self) -> bool {
        self.mix == other.mix && self.seed == other.seed
    }
}

impl ScatteringMix {
    /// Of these shapes, whose orientations are taken as random; `seed` draws the samples.
    #[must_use]
    pub fn new(name: impl Into<String>, mix: ShapeMix, seed: u64) -> Self {
        Self { name: name.into(), mix, seed, known: Mutex::default() }
    }

    /// What it is called.
    #[must_use]
    pub fn name(&self) -> &str {
        &self.name
    }

    /// The shapes.
    #[must_use]
    pub fn mix(&self) -> &ShapeMix {
        &self.mix
    }

    /// Mean over the grains.
    fn mean(&self, of: impl Fn(&Shape) -> f64) -> f64 {
        let (sum, all) = self.mix.shapes().iter().fold((0.0, 0.0), |(sum, all), mixed| {
            (sum + mixed.fraction * of(&mixed.shape), all + mixed.fraction)
        });
        sum / all
    }

    /// Samples of a refractive index; nothing is held while they are made, as that asks for all threads.
    fn at(&self, eta: f64) -> Arc<SampledGrain> {
        let known = || self.known.lock().unwrap_or_else(PoisonError::into_inner);
        let found = known().get(&eta.to_bits()).map(Arc::clone);
        found.unwrap_or_else(|| {
            let made = Arc::new(self.sampled(eta));
            Arc::clone(known().entry(eta.to_bits()).or_insert(made))
        })
    }

    fn sampled(&self, eta: f64) -> SampledGrain {
        let shadow = self.mean(Shape::mean_projected_area);
        let all: f64 = self.mix.shapes().iter().map(|mixed| mixed.fraction).sum();
        let mut light: Vec<Scattered> = Vec::with_capacity(SAMPLES);
        let mut until = 0.0;
        for (index, mixed) in (0..).zip(self.mix.shapes()) {
            until += mixed.fraction * mixed.shape.mean_projected_area() / (all * shadow);
            let end = (until * SAMPLES as f64).round() as usize;
            let wanted = end.min(SAMPLES).saturating_sub(light.len());
            let paths = (wanted, self.seed ^ (index << 32));
            let level = SimdLevel::detect();
            light.extend(told_of_met(&mixed.shape, eta, paths, level, &scattered_of));
        }
        SampledGrain::new(&light, shadow / PI)
    }
}

impl SampledGrain {
    fn new(light: &[Scattered], shadow: f64) -> Self {
        let sample = |of: &Scattered| ScatteringSample {
            cosine: if 1.0 - of.cosine <= STRAIGHT { 1.0 } else { (of.cosine as f32).min(TURNED) },
            length: of.length as f32,
        };
        let mut lengths = LengthHistogram::default();
        light.iter().for_each(|of| lengths.add(1.0, of.length));
        let mean =
            |of: fn(&Scattered) -> f64| light.iter().map(of).sum::<f64>() / light.len() as f64;
        Self {
            samples: light.iter().map(sample).collect(),
            lengths,
            asymmetry: mean(|of| of.cosine),
            mean_length: mean(|of| of.length),
            shadow,
        }
    }
}

impl Scatterers {
    /// Mean shadow of a grain, in discs of the radius of equal volume.
    #[must_use]
    pub fn shadow(&self) -> f64 {
        match self {
            Self::Spheres => 1.0,
            Self::Shapes(mix) => mix.mean(Shape::mean_projected_area) / PI,
        }
    }

    /// Mean surface of a grain, in surfaces of the sphere of equal volume: by so much the specific surface area is
    /// greater.
    #[must_use]
    pub fn surface(&self) -> f64 {
        match self {
            Self::Spheres => 1.0,
            Self::Shapes(mix) => mix.mean(Shape::surface_area) / (4.0 * PI),
        }
    }

    /// The grains at a refractive index.
    pub(super) fn at(&self, eta: f64) -> Grain {
        match self {
            Self::Spheres => Grain::Sphere(Dielectric { eta }),
            Self::Shapes(mix) => Grain::Sampled(mix.at(eta)),
        }
    }
}

impl Grain {
    /// Part of the light on a grain that it absorbs, where a radius of ice absorbs `absorption`.
    pub(super) fn co_albedo(&self, absorption: f64) -> f64 {
        match self {
            Self::Sphere(medium) => sphere::co_albedo(*medium, absorption),
            Self::Sampled(grain) => {
                1.0 - grain.lengths.light(absorption, grain.samples.len() as u64).mean
            }
        }
    }

    /// Mean cosine of the angle of scattering; of shapes, unpolarised at each interface.
    pub(super) fn asymmetry(&self, polarisation: Polarisation) -> f64 {
        match (self, polarisation) {
            (Self::Sphere(medium), Polarisation::Redrawn) => sphere::asymmetry(*medium),
            (Self::Sphere(medium), Polarisation::Tracked) => {
                sphere::asymmetry_of_polarised(*medium)
            }
            (Self::Sampled(grain), _) => grain.asymmetry,
        }
    }

    /// Absorption enhancement: the mean length in a grain of light on it, times its shadow, by its volume.
    pub(super) fn enhancement(&self) -> f64 {
        match self {
            Self::Sphere(medium) => sphere::absorption_enhancement(*medium),
            Self::Sampled(grain) => 0.75 * grain.mean_length * grain.shadow,
        }
    }

    /// Mean length in a grain of light on it, radii.
    pub(super) fn mean_length(&self) -> f64 {
        match self {
            Self::Sphere(_) => 4.0 / 3.0 * self.enhancement(),
            Self::Sampled(grain) => grain.mean_length,
        }
    }

    /// For the kernels.
    pub(super) fn scattering(&self) -> GrainScattering {
        match self {
            Self::Sphere(_) => GrainScattering::Sphere,
            Self::Sampled(grain) => GrainScattering::Sampled(Arc::clone(&grain.samples)),
        }
    }

    /// The phase function, where a radius of ice absorbs so much.
    pub(super) fn phase(&self, polarisation: Polarisation, absorptions: &[f64]) -> PhaseTable {
        match self {
            Self::Sphere(medium) => {
                PhaseTable::new(*medium, polarisation, absorptions, SPHERE_BINS)
            }
            Self::Sampled(grain) => {
                let light = grain.samples.iter();
                let light = light.map(|of| (of.cosine, f64::from(of.length)));
                PhaseTable::of_samples(light, absorptions, SHAPE_BINS)
            }
        }
    }
}
