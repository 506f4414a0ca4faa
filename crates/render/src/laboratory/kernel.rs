//! Layers as the kernels of `snowgrain_accel::homogeneous` want them.

use super::{AlbedoSettings, Incidence, SnowLayer, SnowStack};
use snowgrain_accel::homogeneous::{GrainScattering, HomogeneousLayers, Illumination};
use snowgrain_math::trig;

/// The layers from where light enters on.
pub(super) fn layers_for(
    layers: &[SnowLayer],
    stack: &SnowStack,
    settings: &AlbedoSettings,
    eta: f64,
) -> HomogeneousLayers {
    HomogeneousLayers {
        eta,
        polarisation: settings.polarisation,
        bottoms: optical_bottoms(layers),
        scattering: scattering(layers, eta),
        planes: Vec::new(),
        illumination: illumination(settings.incidence),
        seed: settings.seed,
        least_absorption: least_absorption(layers, stack, &settings.wavelengths_nm),
    }
}

pub(super) fn illumination(incidence: Incidence) -> Illumination {
    match incidence {
        Incidence::Diffuse => Illumination::Diffuse,
        Incidence::Sun { zenith_degrees } => {
            Illumination::Parallel(trig::sin_cos(zenith_degrees.to_radians()).1 as f32)
        }
    }
}

/// What the grains of each layer do at a refractive index.
pub(super) fn scattering(layers: &[SnowLayer], eta: f64) -> Vec<GrainScattering> {
    layers.iter().map(|layer| layer.scatterers.at(eta).scattering()).collect()
}

/// Optical depth of the bottom of each layer.
pub(super) fn optical_bottoms(layers: &[SnowLayer]) -> Vec<f32> {
    let mut bottom = 0.0;
    let below = layers.iter().map(|layer| {
        bottom += layer.optical_depth();
        bottom as f32
    });
    below.collect()
}

/// What a grain radius of the ice of each layer absorbs at each wavelength, its impurities included.
pub(super) fn absorptions(
    layers: &[SnowLayer],
    stack: &SnowStack,
    wavelengths_nm: &[f64],
) -> Vec<Vec<f64>> {
    let of = |layer: &SnowLayer| {
        let each = wavelengths_nm.iter();
        each.map(|&nm| layer.absorption_per_metre(stack.ice, nm) * layer.radius).collect()
    };
    layers.iter().map(of).collect()
}

/// The least of them in each layer.
pub(super) fn least_absorption(
    layers: &[SnowLayer],
    stack: &SnowStack,
    wavelengths_nm: &[f64],
) -> Vec<f32> {
    let absorptions = absorptions(layers, stack, wavelengths_nm);
    absorptions.iter().map(|of| of.iter().copied().fold(f64::INFINITY, f64::min) as f32).collect()
}
