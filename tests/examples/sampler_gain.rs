//! Prints what `film.sampler = "sobol"` gains: the variance of pixel means over independent renders, by
//! sampler and samples per pixel, where the picture has edges and where it has none.
//!
//! `cargo run --release -p snowgrain-tests --example sampler_gain -- [renders] [scene] [crop: x0 y0 x1 y1]`

use snowgrain_film::PixelRect;
use snowgrain_formats::scene::{Loader, SceneFile, builtin_scenes, resolve};
use snowgrain_render::description::Sampler;
use snowgrain_render::{RenderControl, RenderSettings, Scene, SimdLevel, render};
use std::error::Error;
use std::sync::atomic::{AtomicBool, AtomicU64};

fn main() -> Result<(), Box<dyn Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let renders = arguments.first().map_or(Ok(32), |text| text.parse())?;
    let name = arguments.get(1).map_or("snowy-sphere-thick", String::as_str);
    let scene = builtin_scenes().iter().find(|scene| scene.name == name).ok_or("no such scene")?;
    let overrides = ["film.width=96".to_owned(), "film.height=96".into()];
    let file = SceneFile::parse(scene.toml, name.as_ref(), &overrides)?;
    let loader = Loader {
        mesh: &mut |_| Err("no meshes".into()),
        grains: &mut |_| Err("no grains".into()),
        import: &mut |_| Err("no shots".into()),
        environment: &mut |_| Err("no maps".into()),
        texture: &mut |_| Err("nor to a picture".into()),
        sizes: &mut |_| Err("nor to a picture".into()),
        plan_image: &mut |_| Err("nor to a picture".into()),
        optical_constants: &mut |_| Err("no indices".into()),
    };
    let mut scene = Scene::build(&resolve(&file, loader)?, &mut |_| ())?;
    let crop = match arguments.get(2..6) {
        None => PixelRect::new(0, 0, 96, 96),
        Some(corners) => {
            let corners: Result<Vec<u32>, _> = corners.iter().map(|text| text.parse()).collect();
            let corners = corners?;
            PixelRect::new(corners[0], corners[1], corners[2], corners[3])
        }
    };
    for samples in [4, 16, 64, 256] {
        let mut variances = [0.0; 2];
        for (variance, sampler) in variances.iter_mut().zip([Sampler::Independent, Sampler::Sobol])
        {
            scene.film.sampler = sampler;
            *variance = variance_of_pixels(&mut scene, crop, samples, renders)?;
        }
        let [independent, sobol] = variances;
        println!(
            "{name}, {crop}: {samples} samples, variance of a pixel {independent:.3e} independent, \
             {sobol:.3e} sobol, ratio {:.3}",
            independent / sobol
        );
    }
    Ok(())
}

/// Mean over the pixels of the variance of their green over renders with different seeds.
fn variance_of_pixels(
    scene: &mut Scene,
    crop: PixelRect,
    samples: u64,
    renders: u64,
) -> Result<f64, Box<dyn Error>> {
    let mut sums = vec![[0.0f64; 2]; crop.area() as usize];
    for seed in 0..renders {
        scene.film.seed = 1000 + seed;
        let (stop, samples_done) = (AtomicBool::new(false), AtomicU64::new(0));
        let control =
            RenderControl { stop: &stop, samples_done: &samples_done, after_pass: &|_| () };
        let settings = RenderSettings { samples: 0..samples, crop, level: SimdLevel::detect() };
        let film = render(scene, &settings, &control)?.film;
        for (sum, pixel) in sums.iter_mut().zip(film.pixels()) {
            let [_, green, _] = pixel.mean_radiance();
            sum[0] += green;
            sum[1] += green * green;
        }
    }
    let n = renders as f64;
    let variance = |[sum, squares]: &[f64; 2]| (squares - sum * sum / n) / (n - 1.0);
    Ok(sums.iter().map(variance).sum::<f64>() / sums.len() as f64)
}
