//! `snowgrain develop`.

use super::denoise::{denoised, denoiser};
use super::pictures::Pictures;
use crate::arguments::{DevelopArguments, GroupFactor, PictureFormat};
use crate::failure::Failure;
use crate::output;
use snowgrain_film::{Film, FilmError, LightMix, Picture, spectral_layers};
use snowgrain_formats::read_film;
use snowgrain_optics::{Grade, Impurity};

pub(super) fn run(arguments: &DevelopArguments) -> Result<u8, Failure> {
    if arguments.output.iter().any(|file| file.format == PictureFormat::Film) {
        return Err(Failure::usage("a film is developed to .png or .exr files; name one"));
    }
    let writes_exr = arguments.output.iter().any(|file| file.format == PictureFormat::Exr);
    if arguments.wavelengths.is_some() && !writes_exr {
        return Err(Failure::usage("--wavelengths are layers of .exr files; name one by -o"));
    }
    if arguments.primaries.is_some() && !writes_exr {
        return Err(Failure::usage("--primaries are those of .exr files; name one by -o"));
    }
    let pictures = Pictures::new(&arguments.output, &arguments.display)?;
    let denoiser = denoiser(&arguments.denoise, &arguments.output, 0)?;
    let film = read_film(&arguments.film)?;
    let grade = grade(&film, arguments);
    let name = arguments.film.display().to_string();
    let of_film = |error| Failure::from(error).of(&name);
    let mix = mix(&film, &arguments.group).map_err(of_film)?;
    let mut picture = Picture::mixed(&film, &grade, mix.as_ref()).map_err(of_film)?;
    if let Some(wavelengths) = &arguments.wavelengths {
        picture.spectrum =
            spectral_layers(&film, &grade, mix.as_ref(), &wavelengths.0).map_err(of_film)?;
    }
    if let Some(denoiser) = denoiser {
        picture = denoised(&denoiser, &picture)?;
    }
    if let Some(stops) = pictures.automatic_stops(&picture)? {
        output::tell(&format!("exposure {stops:+.3} stops"));
    }
    pictures.write(&film, &picture)?;
    Ok(0)
}

/// How the film's lights are mixed, if anew.
fn mix(film: &Film, groups: &[GroupFactor]) -> Result<Option<LightMix>, FilmError> {
    if groups.is_empty() {
        return Ok(None);
    }
    let factors: Vec<_> = groups.iter().map(|group| (group.name.clone(), group.factor)).collect();
    LightMix::new(film, &factors).map(Some)
}

/// The film's grade with what the arguments change of it.
fn grade(film: &Film, arguments: &DevelopArguments) -> Grade {
    let mut grade = film.grade.clone();
    if let Some(absorption) = arguments.ice_k {
        grade.absorption = absorption;
    }
    if let Some(primaries) = arguments.primaries {
        grade.primaries = primaries;
    }
    if arguments.clean {
        grade.impurities.clear();
    }
    for &impurity in &arguments.impurity {
        grade.impurities.retain(|Impurity { kind, .. }| *kind != impurity.kind);
        grade.impurities.push(impurity);
    }
    grade
}
