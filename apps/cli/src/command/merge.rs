//! `snowgrain merge`.

use super::pictures::Pictures;
use crate::arguments::{MergeArguments, PictureFile, PictureFormat};
use crate::failure::{Failure, exit};
use crate::output;
use snowgrain_film::{Film, Picture};
use snowgrain_formats::{film_summary, read_film};
use std::ops::Range;

pub(super) fn run(arguments: &MergeArguments) -> Result<u8, Failure> {
    let pictures = Pictures::new(&arguments.output, &arguments.display)?;
    let _claims = output::claim_films(&arguments.output)?;
    let film = sum(arguments)?;
    let missing = missing(&film, arguments.require.clone());
    if !missing.is_empty() {
        let listed: Vec<_> = missing.iter().map(|m| format!("{}..{}", m.start, m.end)).collect();
        let listed = listed.join(", ");
        if !arguments.allow_missing {
            let mend = "render them, or --allow-missing writes what there is";
            let message = format!("samples {listed} are missing; {mend}");
            return Err(Failure::new(exit::INCOMPLETE, message));
        }
        output::tell(&format!("snowgrain: samples {listed} are missing"));
    }
    arguments.output.iter().try_for_each(|file| keep_samples_there(file, &film))?;
    pictures.write(&film, &Picture::from_film(&film)?)?;
    Ok(0)
}

/// Refuses to replace a film of the same render by a sum that lacks samples or pixels of it, and tells of the film of
/// another that will be replaced.
fn keep_samples_there(file: &PictureFile, sum: &Film) -> Result<(), Failure> {
    let there = match file.format {
        PictureFormat::Film => film_summary(&file.path),
        PictureFormat::Png | PictureFormat::Exr => return Ok(()),
    };
    // What is no film is replaced, as every file is that is named.
    let Ok(there) = there else { return Ok(()) };
    let name = file.path.display();
    if there.identity != sum.identity() {
        let held = &there.samples;
        output::tell(&format!(
            "snowgrain: {name}: the film of another render that is there (samples {held}) will be replaced"
        ));
        return Ok(());
    }
    let mut held = there.samples.as_slice().iter();
    let lost = held.any(|range| !sum.samples().missing_from(range.clone()).is_empty());
    if !lost && sum.crop().encloses(&there.crop) {
        return Ok(());
    }
    let what = format!(
        "there is a film of this render with samples {} of the pixels {}, not all of which are in the sum; merge it, \
         too, name another file, or remove it",
        there.samples, there.crop
    );
    Err(Failure::usage(what).of(&name.to_string()))
}

/// The sum of all films. Those of one crop are added as they are read, so that few are held at once.
fn sum(arguments: &MergeArguments) -> Result<Film, Failure> {
    let mut crops: Vec<Film> = Vec::new();
    for path in &arguments.films {
        let film = read_film(path)?;
        let of_file = |error| Failure::from(error).of(&path.display().to_string());
        match crops.iter_mut().find(|known| known.crop() == film.crop()) {
            Some(known) => known.merge(&film).map_err(of_file)?,
            None => crops.push(film),
        }
    }
    match crops.pop() {
        Some(film) if crops.is_empty() => Ok(film),
        last => {
            crops.extend(last);
            Ok(Film::assembled(&crops)?)
        }
    }
}

/// What is missing of the samples that are required, or between the first and the last.
fn missing(film: &Film, required: Option<Range<u64>>) -> Vec<Range<u64>> {
    let held = film.samples().as_slice();
    let hull = || Some(held.first()?.start..held.last()?.end);
    required.or_else(hull).map_or_else(Vec::new, |wanted| film.samples().missing_from(wanted))
}
