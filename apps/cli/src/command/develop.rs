//! `snowgrain develop`.

use super::denoise::{denoised, denoiser};
use super::pictures::Pictures;
use crate::arguments::{DevelopArguments, GroupFactor, PictureFormat};
use crate::failure::Failure;
use crate::output;
use snowgrain_film::{Film, FilmError, LightMix, Picture, spectral_layers};
use snowgrain_formats::read_film;
use snowgrain_optics::{Absorption, Grade, Impurity};

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
    let name = arguments.film.display().to_string();
    refuse_ice(&film, arguments).map_err(|failure| failure.of(&name))?;
    let grade = grade(&film, arguments);
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

/// # Errors
/// An option that is of ice, for a film of grains of something else.
fn refuse_ice(film: &Film, arguments: &DevelopArguments) -> Result<(), Failure> {
    let Absorption::Of(substance) = &film.grade.absorption else { return Ok(()) };
    let of_ice = [
        ("--ice-k", arguments.ice_k.is_some()),
        ("--impurity", !arguments.impurity.is_empty()),
        ("--clean", arguments.clean),
    ];
    let typed = of_ice.iter().find(|(_, typed)| *typed);
    typed.map_or(Ok(()), |(option, _)| {
        let name = substance.name();
        Err(Failure::usage(format!(
            "{option} is of ice, but its grains are of {name}; leave it out"
        )))
    })
}

/// The film's grade with what the arguments change of it.
fn grade(film: &Film, arguments: &DevelopArguments) -> Grade {
    let mut grade = film.grade.clone();
    if let Some(absorption) = &arguments.ice_k {
        grade.absorption = absorption.clone();
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
