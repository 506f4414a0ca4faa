//! What the library does to pictures, where it is installed; and what is said where it is not.

#![expect(clippy::unwrap_used, reason = "what cannot go on fails the test")]

use snowgrain_denoise::{DenoiseError, Denoiser};
use snowgrain_film::{Film, FilmIdentity, FilmTile, Layer, Picture, PixelRect, Sample};
use std::path::PathBuf;

/// The library that `SNOWGRAIN_OIDN` names, or the system's; `None`, and said, where there is none.
fn installed() -> Option<Denoiser> {
    let named = std::env::var_os("SNOWGRAIN_OIDN").map(PathBuf::from);
    match Denoiser::open(named.as_deref(), 1) {
        Ok(denoiser) => Some(denoiser),
        Err(DenoiseError::NotFound { tried }) => {
            println!("skipped: Intel Open Image Denoise is not installed ({tried})");
            None
        }
        Err(error) => panic!("{error}"),
    }
}

const SIDE: u32 = 64;

/// A white square before grey, with 8 samples a pixel of which each is black or twice as bright.
fn noisy() -> Picture {
    let window = PixelRect::new(3, 2, 3 + SIDE, 2 + SIDE);
    let identity = FilmIdentity { scene_hash: [0; 32], seed: 0 };
    let mut film = Film::new(100, 100, window, identity).unwrap();
    let mut tile = FilmTile::new(window).unwrap();
    let mut state = 1u32;
    for index in 0..(SIDE * SIDE) as usize {
        let (x, y) = window.pixel(index);
        for _ in 0..8 {
            state = state.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            let light = 2.0 * (state >> 31) as f32 * truth(x);
            let sample = Sample {
                radiance: [light; 3],
                alpha: 1.0,
                albedo: [truth(x); 3],
                normal: [0.0, 0.0, 1.0],
                depth: 1.0,
            };
            tile.add(x, y, &sample).unwrap();
        }
    }
    film.merge_tile(&tile).unwrap();
    film.record_samples(0..8).unwrap();
    Picture::from_film(&film).unwrap()
}

fn truth(x: u32) -> f32 {
    if x < 3 + SIDE / 2 { 0.8 } else { 0.2 }
}

/// Root mean square distance of the green from the truth.
fn error(picture: &Picture) -> f64 {
    let green = picture.layer(Layer::G).unwrap();
    let squares = green.iter().enumerate().map(|(index, &value)| {
        let (x, _) = picture.window().pixel(index);
        f64::from(value - truth(x)) * f64::from(value - truth(x))
    });
    (squares.sum::<f64>() / green.len() as f64).sqrt()
}

#[test]
fn noise_goes_edges_and_other_layers_stay() {
    let Some(denoiser) = installed() else { return };
    let noisy = noisy();
    let clean = denoiser.denoise_picture(&noisy, None).unwrap();
    assert!(error(&noisy) > 0.1 && error(&clean) < 0.25 * error(&noisy), "{}", error(&clean));
    assert!(clean.variance().is_none() && clean.denoised);
    for layer in [Layer::A, Layer::AlbedoG, Layer::NormalZ, Layer::Depth, Layer::SampleCount] {
        assert_eq!(clean.layer(layer), noisy.layer(layer), "{layer:?}");
    }
    assert_eq!(clean.provenance, noisy.provenance);
}

#[test]
fn light_that_is_set_apart_comes_through_untouched() {
    let Some(denoiser) = installed() else { return };
    let noisy = noisy();
    let mut glint = vec![0.0; (SIDE * SIDE) as usize];
    glint[(20 * SIDE + 20) as usize] = 500.0;
    let mut with_glint = noisy.clone();
    for layer in Layer::COLOUR {
        let values = noisy.layer(layer).unwrap().iter().zip(&glint).map(|(a, b)| a + b).collect();
        with_glint.set_layer(layer, values).unwrap();
    }
    let clean = denoiser.denoise_picture(&noisy, None).unwrap();
    let apart = denoiser.denoise_picture(&with_glint, Some([&glint; 3])).unwrap();
    let green = |picture: &Picture| picture.layer(Layer::G).unwrap().to_vec();
    for ((value, clean), glint) in green(&apart).into_iter().zip(green(&clean)).zip(&glint) {
        // 500 + .4 - 500 keeps four digits.
        assert!((value - clean - glint).abs() < 1e-3, "{value} for {clean} and {glint}");
    }
    let short = [0.0; 5];
    let refused = denoiser.denoise_picture(&noisy, Some([&short; 3]));
    assert!(matches!(refused, Err(DenoiseError::Size { values: 5, .. })));
    let bare = Picture::new(4, 4, PixelRect::new(0, 0, 4, 4)).unwrap();
    assert!(matches!(denoiser.denoise_picture(&bare, None), Err(DenoiseError::Film(_))));
}

#[test]
fn a_library_that_is_not_there_or_another_one_is_refused_by_name() {
    let missing = Denoiser::open(Some("no/such/library.so".as_ref()), 0).err().unwrap();
    let said = missing.to_string();
    for part in ["no/such/library.so", "SNOWGRAIN_OIDN", "--denoise-library"] {
        assert!(said.contains(part), "{said}");
    }
    let text = Denoiser::open(Some("Cargo.toml".as_ref()), 0).err().unwrap();
    assert!(text.to_string().contains("Cargo.toml"), "{text}");
    #[cfg(all(target_os = "linux", target_env = "gnu"))]
    {
        let other = Denoiser::open(Some("libc.so.6".as_ref()), 0).err().unwrap();
        let said = other.to_string();
        assert!(said.contains("libc.so.6: this is not version 2"), "{said}");
    }
}
