//! A film read off with another absorption than it was rendered with, or with its lights mixed anew.
//!
//! The film's own colours are exact for its own grade. What another grade changes is found from the ice
//! paths: the difference of what both leave of the light at each node, so that only the change has their
//! error ([`crate::ice_paths`]).

use crate::ice_paths::{NODES, length_of_node};
use crate::picture::empty_layers;
use crate::{Film, FilmError, IcePaths, Layer, LightMix, Picture};
use snowgrain_math::{DMat3, DVec3, trig};
use snowgrain_optics::{Grade, Illuminant, Primaries, uplift};

/// A spectral layer: radiance at one wavelength.
#[derive(Clone, Debug, PartialEq)]
pub struct SpectralLayer {
    /// Wavelength, nm.
    pub wavelength_nm: f64,
    /// Radiance over the window in row-major order. White light of radiance 1 has the power of its
    /// illuminant, as a multiple of its mean over the eye's sensitivity: D65 of radiance 1 is about 1 at
    /// 560 nm.
    pub values: Vec<f32>,
}

impl Picture {
    /// All layers of a film as they would be with another grade of the same lights; the layers of
    /// variance are left out where that changes colours.
    ///
    /// # Errors
    /// A film without ice paths where the grade has another absorption; more layers than memory.
    pub fn graded(film: &Film, grade: &Grade) -> Result<Self, FilmError> {
        Self::mixed(film, grade, None)
    }

    /// The same, with the layers of the film's light mixed anew.
    ///
    /// A colour is given to a light before it meets ice where the film keeps ice paths, and to what it
    /// leaves in the picture else. Glints are taken to have met no ice.
    ///
    /// # Errors
    /// A film without ice paths where the grade has another absorption; a film with shadow catchers; more
    /// layers than memory.
    ///
    /// # Panics
    /// If the mix is of another film.
    pub fn mixed(film: &Film, grade: &Grade, mix: Option<&LightMix>) -> Result<Self, FilmError> {
        let mut picture = Self::from_film(film)?;
        let mix = mix.filter(|mix| !mix.is_neutral());
        if *grade == film.grade && mix.is_none() {
            return Ok(picture);
        }
        if film.shadow_sums().is_some() {
            return Err(FilmError::ShadowCatcherIsFixed);
        }
        let change = Change::new(film, grade, mix)?;
        let mut colours = [const { Vec::new() }; 3];
        let mut layers = match film.light_layers() {
            Some(light) => empty_layers(film, light.layers().names())?,
            None => Vec::new(),
        };
        let mut light = Vec::new();
        for (pixel, sums) in film.pixels().iter().enumerate() {
            light.clear();
            match film.light_layers() {
                Some(layers) => light.extend(layers.light(pixel, sums.samples()).map(DVec3::from)),
                None => light.push(DVec3::from(sums.mean_radiance())),
            }
            change.apply(pixel, sums.samples(), &mut light);
            push(&mut colours, light.iter().sum());
            layers.iter_mut().zip(&light).for_each(|(layer, &x)| push(&mut layer.values, x));
        }
        for (layer, values) in Layer::COLOUR.into_iter().zip(colours) {
            picture.set_layer(layer, values)?;
        }
        picture.light_layers = layers;
        picture.remove_variance();
        picture.learnt.clear();
        picture.primaries = grade.primaries;
        picture.exposure_stops = grade.exposure_stops;
        Ok(picture)
    }
}

/// Adds a pixel to the values of three channels.
fn push(channels: &mut [Vec<f32>; 3], colour: DVec3) {
    channels.iter_mut().zip(colour.to_array()).for_each(|(values, x)| values.push(x as f32));
}

/// What a grade and a mix make of the light of a film, layer by layer; a film without layers has one.
struct Change<'a> {
    /// Of each layer, from the primaries of the film to those of the grade, times its factor.
    layers: Vec<DMat3>,
    /// Of each slot, the layer that it belongs to.
    layer_of_slot: Vec<usize>,
    /// The ice paths, and of each slot and node what is added to the changed colours of the film.
    ice: Option<(&'a IcePaths, Vec<DMat3>)>,
}

impl<'a> Change<'a> {
    fn new(film: &'a Film, new: &Grade, mix: Option<&LightMix>) -> Result<Self, FilmError> {
        let old = &film.grade;
        let from_srgb = |primaries: Primaries| match primaries {
            Primaries::Srgb => DMat3::IDENTITY,
            other => other.under_d65() * Primaries::Srgb.under_d65().inverse(),
        };
        let (to_new, to_srgb) = (from_srgb(new.primaries), from_srgb(old.primaries).inverse());
        let count = film.kept().light_layers.max(1);
        let factors = mix.map_or_else(|| vec![[1.0; 3]; count], |mix| mix.factors().to_vec());
        assert_eq!(factors.len(), count, "the mix is of this film");
        let layers: Vec<_> = factors
            .iter()
            .map(|&factor| to_new * DMat3::from_diagonal(factor.into()) * to_srgb)
            .collect();
        let layer_of_slot: Vec<_> = match film.light_layers() {
            Some(light) => light.layers().layer_of_slot().iter().map(|&l| l as usize).collect(),
            None => vec![0; old.lights.len()],
        };
        let ice = match film.ice_paths() {
            None if same_absorption(old, new) => None,
            None => return Err(FilmError::NoIcePaths),
            Some(paths) => {
                let slots = old.colours().into_iter().zip(new.colours()).zip(&layer_of_slot);
                let nodes = slots.flat_map(|((old, new), &layer)| {
                    let factor = DMat3::from_diagonal(factors[layer].into());
                    let changed = layers[layer];
                    (0..NODES).map(length_of_node).map(move |length| {
                        new.matrix(length) * factor - changed * old.matrix(length)
                    })
                });
                Some((paths, nodes.collect()))
            }
        };
        Ok(Self { layers, layer_of_slot, ice })
    }

    /// Changes the light of a pixel in each layer.
    fn apply(&self, pixel: usize, samples: u64, light: &mut [DVec3]) {
        for (light, matrix) in light.iter_mut().zip(&self.layers) {
            *light = *matrix * *light;
        }
        let Some((paths, changes)) = &self.ice else { return };
        let nodes = paths.light(pixel, samples).zip(changes).enumerate();
        for (index, (weight, change)) in nodes {
            light[self.layer_of_slot[index / NODES]] += *change * DVec3::from(weight);
        }
    }
}

/// Radiances at wavelengths (nm) of the pixels of a film with a grade of the same lights, and with its
/// layers of light mixed anew if wanted, from its ice paths.
///
/// # Errors
/// A film without ice paths; more layers than memory.
pub fn spectral_layers(
    film: &Film,
    grade: &Grade,
    mix: Option<&LightMix>,
    wavelengths_nm: &[f64],
) -> Result<Vec<SpectralLayer>, FilmError> {
    let paths = film.ice_paths().ok_or(FilmError::NoIcePaths)?;
    let factors: Vec<DVec3> = match (mix, film.light_layers()) {
        (Some(mix), Some(light)) => {
            let of_slot = light.layers().layer_of_slot().iter();
            of_slot.map(|&layer| mix.factors()[layer as usize].into()).collect()
        }
        _ => vec![DVec3::ONE; grade.lights.len()],
    };
    let layer = |&wavelength_nm: &f64| {
        let weights = spectral_weights(grade, &factors, wavelength_nm);
        let mut values = Vec::new();
        values.try_reserve_exact(film.pixels().len()).map_err(|_| FilmError::TooLarge {
            pixels: film.crop().area(),
            bytes: u128::from(film.crop().area()) * 4,
        })?;
        values.extend(film.pixels().iter().enumerate().map(|(pixel, sums)| {
            let all = paths.light(pixel, sums.samples()).zip(&weights);
            all.map(|(light, weight)| DVec3::from(light).dot(*weight)).sum::<f64>() as f32
        }));
        Ok(SpectralLayer { wavelength_nm, values })
    };
    wavelengths_nm.iter().map(layer).collect()
}

/// Of each slot and node, what a unit of red, green and blue gives at a wavelength.
fn spectral_weights(grade: &Grade, factors: &[DVec3], wavelength_nm: f64) -> Vec<DVec3> {
    let reflectances = DVec3::from(uplift::reflectances(wavelength_nm));
    let gamma = grade.per_metre(wavelength_nm);
    let of_light = |(light, factor): (&Illuminant, &DVec3)| {
        let reflectances = reflectances * *factor;
        let power = light.power(wavelength_nm) / light.luminous_mean();
        (0..NODES)
            .map(move |node| reflectances * (power * trig::exp(-gamma * length_of_node(node))))
    };
    grade.lights.iter().zip(factors).flat_map(of_light).collect()
}

fn same_absorption(a: &Grade, b: &Grade) -> bool {
    a.absorption == b.absorption && a.impurities == b.impurities && a.enhancement == b.enhancement
}
