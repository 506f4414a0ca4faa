//! A film read off with another absorption than it was rendered with.
//!
//! The film's own colours are exact for its own grade. What another grade changes is found from the ice
//! paths: the difference of what both leave of the light at each node, so that only the change has their
//! error ([`crate::ice_paths`]).

use crate::ice_paths::{NODES, length_of_node};
use crate::{Film, FilmError, IcePaths, Layer, Picture};
use snowgrain_math::{DMat3, DVec3, trig};
use snowgrain_optics::{Grade, Illuminant, uplift};

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
        let mut picture = Self::from_film(film)?;
        let old = &film.grade;
        if grade == old {
            return Ok(picture);
        }
        let convert = grade.primaries.under_d65() * old.primaries.under_d65().inverse();
        let changes = match film.ice_paths() {
            Some(paths) => Some((paths, changes(old, grade, convert))),
            None if same_absorption(old, grade) => None,
            None => return Err(FilmError::NoIcePaths),
        };
        let colours = picture.colour()?.map(<[f32]>::to_vec);
        let mut graded = [const { Vec::new() }; 3];
        for (pixel, sums) in film.pixels().iter().enumerate() {
            let colour = DVec3::from([0, 1, 2].map(|c: usize| f64::from(colours[c][pixel])));
            let mut colour = convert * colour;
            if let Some((paths, changes)) = &changes {
                colour += change(paths, pixel, sums.samples(), changes);
            }
            graded.iter_mut().zip(colour.to_array()).for_each(|(v, x)| v.push(x as f32));
        }
        for (layer, values) in Layer::COLOUR.into_iter().zip(graded) {
            picture.set_layer(layer, values)?;
        }
        picture.remove_variance();
        picture.primaries = grade.primaries;
        picture.exposure_stops = grade.exposure_stops;
        Ok(picture)
    }
}

/// Radiances at wavelengths (nm) of the pixels of a film with a grade of the same lights, from its ice
/// paths.
///
/// # Errors
/// A film without ice paths; more layers than memory.
pub fn spectral_layers(
    film: &Film,
    grade: &Grade,
    wavelengths_nm: &[f64],
) -> Result<Vec<SpectralLayer>, FilmError> {
    let paths = film.ice_paths().ok_or(FilmError::NoIcePaths)?;
    let layer = |&wavelength_nm: &f64| {
        let weights = spectral_weights(grade, wavelength_nm);
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

/// Of each spectrum of lights and node, what a unit of red, green and blue gives at a wavelength.
fn spectral_weights(grade: &Grade, wavelength_nm: f64) -> Vec<DVec3> {
    let reflectances = DVec3::from(uplift::reflectances(wavelength_nm));
    let gamma = grade.per_metre(wavelength_nm);
    let of_light = |light: &Illuminant| {
        let power = light.power(wavelength_nm) / light.luminous_mean();
        (0..NODES)
            .map(move |node| reflectances * (power * trig::exp(-gamma * length_of_node(node))))
    };
    grade.lights.iter().flat_map(of_light).collect()
}

fn same_absorption(a: &Grade, b: &Grade) -> bool {
    a.absorption == b.absorption && a.impurities == b.impurities && a.enhancement == b.enhancement
}

/// Of each spectrum of lights and node, what the grade adds to the colours of the film's own, converted to
/// the primaries of the new.
fn changes(old: &Grade, new: &Grade, convert: DMat3) -> Vec<DMat3> {
    let pairs = old.colours().into_iter().zip(new.colours());
    pairs
        .flat_map(|(old, new)| {
            (0..NODES).map(move |node| {
                let length = length_of_node(node);
                new.matrix(length) - convert * old.matrix(length)
            })
        })
        .collect()
}

/// What a grade adds to the colour of a pixel.
fn change(paths: &IcePaths, pixel: usize, samples: u64, changes: &[DMat3]) -> DVec3 {
    let all = paths.light(pixel, samples).zip(changes);
    all.fold(DVec3::ZERO, |sum, (light, change)| sum + *change * DVec3::from(light))
}
