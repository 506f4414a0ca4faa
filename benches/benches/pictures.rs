//! `cargo bench -p snowgrain-benches --bench pictures [-- overhead|threads|figure-3|quality]`: whole
//! pictures.
//!
//! - `overhead`: what a sample costs beside light among grains: the camera looks away from the snow.
//! - `threads`: two threads on one picture against two pictures of one thread each, side by side. Both
//!   have the same machine under them, so that the ratio shows what threads lose to each other.
//! - `figure-3`: the paper's cube, simple cubic, 512 x 512 pixels, 100 samples a pixel, 2 threads.
//! - `quality`: CPU seconds until the root mean square of the error of a pixel is 1 % of the mean
//!   radiance of the picture, from the film's own variance: errors fall as the square root of the time
//!   (`tests/physics/pictures.rs`), so that few samples tell.

use rayon::ThreadPool;
use snowgrain_benches::{best_of, cpu_seconds};
use snowgrain_film::{Layer, Picture, PixelRect};
use snowgrain_formats::scene::{Loader, SceneFile, builtin_scene, resolve};
use snowgrain_render::{
    RenderControl, RenderSettings, Rendered, Scene, SimdLevel, render, render_with,
};
use std::path::Path;
use std::sync::atomic::{AtomicBool, AtomicU64};
use std::time::{Duration, Instant};

const CUBE: &str = "snow-cube-sc";
const TEAPOT: &str = "snowy-teapot";

fn main() {
    let filter = std::env::args().skip(1).find(|argument| !argument.starts_with('-'));
    let wanted = |name: &str| filter.as_ref().is_none_or(|filter| name.contains(filter.as_str()));
    if wanted("overhead") {
        overhead();
    }
    if wanted("threads") {
        for name in [CUBE, TEAPOT] {
            threads(name);
        }
    }
    if wanted("figure-3") {
        figure_3();
    }
    if wanted("quality") {
        for name in [CUBE, TEAPOT] {
            quality(name);
        }
    }
}

/// A built-in scene, with these changes.
fn scene(name: &str, changes: &[&str]) -> Scene {
    let changes: Vec<String> = changes.iter().map(ToString::to_string).collect();
    let text = builtin_scene(name).expect("it is built in").toml;
    let file = SceneFile::parse(text, Path::new(name), &changes).expect("it is legal");
    let loader = Loader {
        mesh: &mut |_| Err("it refers to no file".into()),
        grains: &mut |_| Err("it refers to no file".into()),
        import: &mut |_| Err("it refers to no file".into()),
        environment: &mut |_| Err("it refers to no file".into()),
        texture: &mut |_| Err("it refers to no file".into()),
        sizes: &mut |_| Err("it refers to no file".into()),
        plan_image: &mut |_| Err("it refers to no file".into()),
        optical_constants: &mut |_| Err("no indices".into()),
    };
    let description = resolve(&file, loader).expect("it is legal");
    Scene::build(&description, &mut |_| ()).expect("its snow can be made")
}

fn pool(threads: usize) -> ThreadPool {
    rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads start")
}

fn settings(scene: &Scene, samples: u64) -> RenderSettings {
    let crop = PixelRect::new(0, 0, scene.film.width, scene.film.height);
    RenderSettings { samples: 0..samples, crop, level: SimdLevel::detect() }
}

fn picture(scene: &Scene, samples: u64, pool: &ThreadPool) -> Rendered {
    let (stop, samples_done) = (AtomicBool::new(false), AtomicU64::new(0));
    let control = RenderControl { stop: &stop, samples_done: &samples_done, after_pass: &|_| () };
    let settings = settings(scene, samples);
    pool.install(|| render(scene, &settings, &control)).expect("the film holds all samples")
}

fn overhead() {
    let scene = scene(CUBE, &["camera.at=[600,400,400]"]);
    let pool = pool(1);
    for samples in [1, 4, 64] {
        let (seconds, rendered) = best_of(5, || picture(&scene, samples, &pool));
        assert_eq!(rendered.statistics.paths_in_snow, 0, "the camera looks away");
        let nanoseconds = seconds / rendered.statistics.paths as f64 * 1e9;
        println!("a sample of nothing, {samples:2} a pixel  {nanoseconds:8.1} CPU-ns");
    }
}

/// Seconds on the clock.
fn wall(work: impl FnOnce()) -> f64 {
    let start = Instant::now();
    work();
    start.elapsed().as_secs_f64()
}

fn threads(name: &str) {
    const SAMPLES: u64 = 4;
    let scene = scene(name, &["film.width=256", "film.height=256"]);
    let (two, first, second) = (pool(2), pool(1), pool(1));
    let mut ratios: Vec<f64> = (0..7)
        .map(|_| {
            let together = wall(|| drop(picture(&scene, 2 * SAMPLES, &two)));
            let apart = wall(|| {
                std::thread::scope(|scope| {
                    scope.spawn(|| picture(&scene, SAMPLES, &first));
                    scope.spawn(|| picture(&scene, SAMPLES, &second));
                });
            });
            apart / together
        })
        .collect();
    ratios.sort_by(f64::total_cmp);
    let [low, median, high] = [0, 3, 6].map(|index| 100.0 * ratios[index]);
    println!(
        "{name:<14} two threads reach {median:.1} % of two renders side by side \
         (median of 7, {low:.1} to {high:.1})"
    );
}

fn figure_3() {
    let scene = scene(CUBE, &[]);
    let pool = pool(2);
    let (stop, samples_done) = (AtomicBool::new(false), AtomicU64::new(0));
    let start = Instant::now();
    let first = AtomicU64::new(0);
    let after_pass = |samples: u64| {
        if samples == 1 {
            let elapsed = start.elapsed().as_micros() as u64;
            first.store(elapsed, std::sync::atomic::Ordering::Relaxed);
        }
    };
    let control =
        RenderControl { stop: &stop, samples_done: &samples_done, after_pass: &after_pass };
    let (cpu, rendered) = cpu_seconds(|| {
        let settings = settings(&scene, 100);
        render_with(&scene, &settings, |rendering| pool.install(|| rendering.run(&control)))
    });
    let (rendered, ran) = rendered.expect("the film fits");
    ran.expect("the film holds all samples");
    let paths = rendered.statistics.paths as f64;
    println!(
        "figure 3: {:.1} s on the clock, {cpu:.1} CPU-s, {:.2} M samples/CPU-s, \
         {:.2} M visits/CPU-s, every pixel has a sample after {:.2} s",
        start.elapsed().as_secs_f64(),
        paths / cpu / 1e6,
        rendered.statistics.grain_visits as f64 / cpu / 1e6,
        Duration::from_micros(first.into_inner()).as_secs_f64(),
    );
}

fn quality(name: &str) {
    const SAMPLES: u64 = 16;
    let scene = scene(name, &["film.width=256", "film.height=256"]);
    let (cpu, rendered) = cpu_seconds(|| picture(&scene, SAMPLES, &pool(1)));
    let picture = Picture::from_film(&rendered.film).expect("the layers fit");
    let mean_of = |layer| {
        let values = picture.layer(layer).expect("a film has all layers");
        values.iter().map(|&value| f64::from(value)).sum::<f64>() / values.len() as f64
    };
    let radiance = mean_of(Layer::G);
    let error = mean_of(Layer::VarianceG).sqrt() / radiance;
    let factor = (error / 0.01) * (error / 0.01);
    println!(
        "{name:<14} 1 % error of a pixel of 256 x 256 after {:.0} CPU-s, {:.0} samples a pixel \
         ({SAMPLES} samples: {:.1} % after {cpu:.2} CPU-s)",
        cpu * factor,
        SAMPLES as f64 * factor,
        100.0 * error,
    );
}
