//! Lights mixed after the render give what a render with those lights would have given.

#![allow(clippy::unwrap_used, reason = "a failing test may panic")]

use snowgrain_film::light_layers::GLINTS;
use snowgrain_film::{
    Film, FilmError, FilmIdentity, FilmTile, IcePathLayout, Kept, LightLayerNames, LightMix,
    Picture, PixelRect, Sample, spectral_layers,
};
use snowgrain_optics::{Absorption, Grade, IceColour, Illuminant, Impurity, ImpurityKind, Load};

const WHOLE: PixelRect = PixelRect::new(0, 0, 4, 1);
const SPECTRA: [Illuminant; 2] = [Illuminant::D65, Illuminant::A];

fn grade(ppb: f64) -> Grade {
    Grade {
        lights: SPECTRA.to_vec(),
        absorption: Absorption::default(),
        impurities: vec![Impurity {
            kind: ImpurityKind::BlackCarbon,
            load: Load::MassFraction(ppb * 1e-9),
        }],
        enhancement: 1.25,
        ..Grade::default()
    }
}

/// A film of some light of both lights, times these factors, after many lengths in ice; one in five paths of
/// the first light is a glint.
fn film(grade: &Grade, factors: [[f32; 3]; 3], keeps_ice: bool) -> Film {
    let identity = FilmIdentity { scene_hash: [1; 32], seed: 0 };
    let names = ["sun", "sky", GLINTS].map(str::to_owned).to_vec();
    let names = LightLayerNames::new(names, vec![0, 1]).unwrap();
    let layout = IcePathLayout::for_radiance(2, 8.0);
    let mut film = Film::new(4, 1, WHOLE, identity).unwrap().keeping_light_layers(names).unwrap();
    let ice_paths = keeps_ice.then_some(layout);
    if keeps_ice {
        film = film.keeping_ice_paths(layout).unwrap();
    }
    film.grade = grade.clone();
    let colours: Vec<IceColour> = grade.colours();
    let mut tile =
        FilmTile::keeping(WHOLE, Kept { ice_paths, light_layers: 3, ..Kept::default() }).unwrap();
    for sample in 0..400u32 {
        let pixel = sample % 4;
        let glint = sample % 5 == 0;
        let length = if glint { 0.0 } else { 0.003 * f64::from(sample % 71) };
        let mut weights = [[1.0f32, 0.9, 0.8], [0.2, 0.25, 0.3 + 0.001 * sample as f32]];
        let layer_of = |slot: usize| if glint && slot == 0 { 2 } else { slot };
        let mut layers = [[0.0f32; 3]; 3];
        for (slot, weight) in weights.iter_mut().enumerate() {
            let factor = factors[layer_of(slot)];
            weight.iter_mut().zip(factor).for_each(|(weight, factor)| *weight *= factor);
            layers[layer_of(slot)] = colours[slot].apply(*weight, length);
        }
        let radiance = std::array::from_fn(|c| layers[0][c] + layers[1][c] + layers[2][c]);
        tile.add(pixel, 0, &Sample { radiance, ..Sample::default() }).unwrap();
        tile.add_light_layers(pixel, 0, radiance, &layers).unwrap();
        tile.add_ice_path(pixel, 0, length, &weights).unwrap();
    }
    film.merge_tile(&tile).unwrap();
    film.record_samples(0..100).unwrap();
    film
}

fn mix(film: &Film, factors: [[f32; 3]; 3]) -> LightMix {
    let names = ["sun", "sky", GLINTS];
    let factors = factors.map(|factor| factor.map(f64::from));
    let named: Vec<_> = names.map(str::to_owned).into_iter().zip(factors).collect();
    LightMix::new(film, &named).unwrap()
}

fn most_apart(a: &Picture, b: &Picture) -> f64 {
    let pairs = a.colour().unwrap().into_iter().zip(b.colour().unwrap());
    let apart = pairs.flat_map(|(a, b)| a.iter().zip(b)).map(|(a, b)| f64::from((a - b).abs()));
    apart.fold(0.0, f64::max)
}

const ONE: [f32; 3] = [1.0; 3];

#[test]
fn a_mix_and_a_grade_together_are_a_fresh_render() {
    let before = film(&grade(0.0), [ONE; 3], true);
    for (factors, ppb) in [
        ([[0.5; 3], [2.0; 3], [0.5; 3]], 0.0),
        ([ONE, [0.0; 3], ONE], 0.0),
        ([[0.9, 0.5, 0.2], [2.0, 1.0, 3.0], [0.9, 0.5, 0.2]], 0.0),
        ([[0.9, 0.5, 0.2], [2.0, 1.0, 3.0], [4.0; 3]], 500.0),
    ] {
        let fresh = Picture::from_film(&film(&grade(ppb), factors, true)).unwrap();
        let mixed = Picture::mixed(&before, &grade(ppb), Some(&mix(&before, factors))).unwrap();
        // Soot on glints that met no ice, and that the mix takes for their light's: to first order nothing.
        let apart = most_apart(&fresh, &mixed);
        assert!(apart < 2e-3, "{factors:?} {ppb}: {apart}");
        for (fresh, mixed) in fresh.light_layers.iter().zip(&mixed.light_layers) {
            assert_eq!(fresh.name, mixed.name);
        }
    }
}

#[test]
fn layers_add_up_to_the_picture_before_and_after() {
    let film = film(&grade(0.0), [ONE; 3], true);
    let before = Picture::from_film(&film).unwrap();
    let mix = mix(&film, [[0.3, 0.2, 0.1], [5.0; 3], [0.0; 3]]);
    let after = Picture::mixed(&film, &grade(50.0), Some(&mix)).unwrap();
    for picture in [before, after] {
        for (c, channel) in picture.colour().unwrap().into_iter().enumerate() {
            for (pixel, &whole) in channel.iter().enumerate() {
                let parts = picture.light_layers.iter().map(|layer| layer.values[c][pixel]);
                assert!((parts.sum::<f32>() - whole).abs() < 1e-5);
            }
        }
    }
}

#[test]
fn a_film_without_ice_paths_is_mixed_by_its_layers() {
    let before = film(&grade(0.0), [ONE; 3], false);
    let factors = [[0.25; 3], [3.0; 3], [2.0; 3]];
    let fresh = Picture::from_film(&film(&grade(0.0), factors, false)).unwrap();
    let mixed = Picture::mixed(&before, &grade(0.0), Some(&mix(&before, factors))).unwrap();
    assert!(most_apart(&fresh, &mixed) < 1e-5);
    let other = Picture::mixed(&before, &grade(1.0), Some(&mix(&before, factors)));
    assert_eq!(other, Err(FilmError::NoIcePaths));
}

#[test]
fn spectral_layers_are_mixed_too() {
    let film = film(&grade(0.0), [ONE; 3], true);
    let factors = [[2.0; 3], [2.0; 3], [2.0; 3]];
    let of = |mix| spectral_layers(&film, &film.grade, mix, &[550.0]).unwrap();
    let (plain, double) = (of(None), of(Some(&mix(&film, factors))));
    for (plain, double) in plain[0].values.iter().zip(&double[0].values) {
        assert!((2.0 * plain - double).abs() < 1e-6 * plain);
    }
}

#[test]
fn groups_are_named_and_the_last_factor_counts() {
    let film = film(&grade(0.0), [ONE; 3], false);
    let of = |factors: &[(&str, f64)]| {
        let factors: Vec<_> =
            factors.iter().map(|(name, factor)| ((*name).to_owned(), [*factor; 3])).collect();
        LightMix::new(&film, &factors)
    };
    let mix = of(&[("sky", 2.0), ("sun", 0.5), ("sky", 3.0)]).unwrap();
    assert_eq!(mix.factors().iter().map(|f| f[0]).collect::<Vec<_>>(), [0.5, 3.0, 1.0]);
    assert!(of(&[]).unwrap().is_neutral() && !mix.is_neutral());
    let error = of(&[("moon", 1.0)]).unwrap_err().to_string();
    assert!(error.contains("moon; it has sun, sky, glints"), "{error}");
    let plain = Film::new(4, 1, WHOLE, film.identity()).unwrap();
    assert_eq!(LightMix::new(&plain, &[]), Err(FilmError::NoLightLayers));
}
