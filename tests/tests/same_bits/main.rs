//! Same input, same bits: pixels depend on the scene, the seed and the sample indices alone.
//!
//! Films are compared as the bytes of their files, so that every sum counts, not only what a
//! picture shows of it.

#![expect(clippy::unwrap_used, reason = "what cannot go on fails the test")]

mod golden;
mod lasting;

use snowgrain_accel::SimdLevel;
use snowgrain_film::{Film, Picture, PixelRect};
use snowgrain_formats::scene::{Loader, SceneFile, resolve};
use snowgrain_formats::{read_film, read_grains, write_film, write_grains};
use snowgrain_math::sampler::split_mix;
use snowgrain_render::description::{SceneDescription, SnowDescription};
use snowgrain_render::{
    RenderControl, RenderSettings, Rendered, Scene, Strata, render, render_with,
};
use std::ops::Range;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};

/// The scenes: a lattice, a mesh buried in overlapping grains with absorption, layers of many sizes on
/// round and flat objects, snow in sun and lamps that are looked for, grains of many shapes, and
/// glass that parts colours.
const SCENES: [&str; 6] = ["lattice", "buried", "layers", "sunlit", "shapes", "dispersed"];

fn data(name: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("data/golden").join(name)
}

fn description(name: &str) -> SceneDescription {
    let file = SceneFile::read(&data(&format!("{name}.toml")), &[]).unwrap();
    let loader = Loader {
        mesh: &mut |_| Err("these scenes refer to no mesh".into()),
        grains: &mut |_| Err("nor to grains".into()),
        import: &mut |_| Err("nor to shots".into()),
        environment: &mut |_| Err("nor to a map".into()),
        texture: &mut |_| Err("nor to a picture".into()),
        sizes: &mut |_| Err("nor to a picture".into()),
        plan_image: &mut |_| Err("nor to a picture".into()),
        optical_constants: &mut |_| Err("no indices".into()),
    };
    resolve(&file, loader).unwrap()
}

fn build(description: &SceneDescription) -> Scene {
    Scene::build(description, &mut |_| ()).unwrap()
}

fn whole(scene: &Scene) -> PixelRect {
    PixelRect::new(0, 0, scene.film.width, scene.film.height)
}

fn all_samples(scene: &Scene) -> Range<u64> {
    0..u64::from(scene.film.samples_per_pixel)
}

fn part(scene: &Scene, samples: Range<u64>, crop: PixelRect, level: SimdLevel) -> Film {
    let (stop, samples_done) = (AtomicBool::new(false), AtomicU64::new(0));
    let control = RenderControl { stop: &stop, samples_done: &samples_done, after_pass: &|_| () };
    render(scene, &RenderSettings { samples, crop, level }, &control).unwrap().film
}

fn film(scene: &Scene) -> Film {
    part(scene, all_samples(scene), whole(scene), SimdLevel::detect())
}

/// The bytes of the film's file.
fn bytes(film: &Film) -> Vec<u8> {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("picture.film");
    write_film(&path, film).unwrap();
    std::fs::read(path).unwrap()
}

/// A fixed random order of `count` things.
fn shuffled(count: usize, seed: u64) -> Vec<usize> {
    let mut order: Vec<usize> = (0..count).collect();
    order.sort_by_key(|&index| split_mix(seed ^ split_mix(index as u64)));
    order
}

#[test]
fn threads_change_nothing() {
    for name in SCENES {
        let description = description(name);
        let on = |threads: usize| {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
            pool.install(|| bytes(&film(&build(&description))))
        };
        let one = on(1);
        for threads in [2, 7, 16] {
            assert!(on(threads) == one, "{name}: {threads} threads differ from one");
        }
    }
}

#[test]
fn simd_levels_change_nothing() {
    for name in SCENES {
        let description = description(name);
        let expected = bytes(&film(&build(&description)));
        for level in SimdLevel::available() {
            let scene = Scene::build_at(&description, level, &mut |_| ()).unwrap();
            let film = part(&scene, all_samples(&scene), whole(&scene), level);
            assert!(bytes(&film) == expected, "{name}: {level} differs");
        }
    }
}

/// Cuts of the picture into rectangles, until each is small or chance lets it be.
fn cut(rect: PixelRect, word: u64, cuts: &mut Vec<PixelRect>) {
    let (width, height) = (rect.width(), rect.height());
    if width.max(height) < 4 || word.is_multiple_of(5) && width.max(height) < 20 {
        cuts.push(rect);
        return;
    }
    let (mut first, mut second) = (rect, rect);
    let at = |length: u32| 1 + (word >> 8) as u32 % (length - 1);
    if width > height {
        first.x1 = rect.x0 + at(width);
        second.x0 = first.x1;
    } else {
        first.y1 = rect.y0 + at(height);
        second.y0 = first.y1;
    }
    cut(first, split_mix(word), cuts);
    cut(second, split_mix(word ^ 1), cuts);
}

#[test]
fn crops_in_any_order_are_the_whole_picture() {
    for name in SCENES {
        let scene = build(&description(name));
        let expected = film(&scene);
        let mut crops = Vec::new();
        cut(whole(&scene), 17, &mut crops);
        assert!(crops.len() > 20);
        let mut seen = 0;
        for index in shuffled(crops.len(), 3) {
            let crop = crops[index];
            let film = part(&scene, all_samples(&scene), crop, SimdLevel::detect());
            for (index, pixel) in film.pixels().iter().enumerate() {
                let (x, y) = crop.pixel(index);
                let full = expected.pixels()[whole(&scene).index(x, y).unwrap()];
                assert!(*pixel == full, "{name}: pixel ({x}, {y}) of the crop {crop}");
                seen += 1;
            }
        }
        assert_eq!(seen, expected.pixels().len());
    }
}

#[test]
fn sample_ranges_rendered_apart_merge_in_any_order() {
    for name in SCENES {
        let scene = build(&description(name));
        let (samples, level) = (0..11u64, SimdLevel::detect());
        let expected = part(&scene, samples, whole(&scene), level);
        let ranges = [0..1u64, 1..2, 2..5, 5..9, 9..11];
        for seed in 0..3 {
            let mut merged = expected.empty_copy().unwrap();
            let folder = tempfile::tempdir().unwrap();
            for index in shuffled(ranges.len(), seed) {
                let film = part(&scene, ranges[index].clone(), whole(&scene), level);
                let path = folder.path().join(format!("{index}.film"));
                write_film(&path, &film).unwrap();
                merged.merge(&read_film(&path).unwrap()).unwrap();
            }
            assert!(bytes(&merged) == bytes(&expected), "{name}: order {seed}");
        }
    }
}

/// Renders samples `0..64` and asks for a stop once `enough(samples of every pixel, of all pixels)`.
fn stopped(scene: &Scene, enough: impl Fn(u64, u64) -> bool + Sync) -> Rendered {
    let (stop, samples_done) = (AtomicBool::new(false), AtomicU64::new(0));
    let look = |every: u64| {
        if enough(every, samples_done.load(Ordering::Relaxed)) {
            stop.store(true, Ordering::Relaxed);
        }
    };
    let settings =
        RenderSettings { samples: 0..64, crop: whole(scene), level: SimdLevel::detect() };
    std::thread::scope(|scope| {
        let (working, ended) = std::sync::mpsc::channel::<()>();
        let look = &look;
        scope.spawn(move || {
            let moment = std::time::Duration::from_micros(100);
            while ended.recv_timeout(moment) == Err(std::sync::mpsc::RecvTimeoutError::Timeout) {
                look(0);
            }
        });
        let control = RenderControl { stop: &stop, samples_done: &samples_done, after_pass: &look };
        let rendered = render(scene, &settings, &control).unwrap();
        drop(working);
        rendered
    })
}

/// When a stop comes is chance here; what it leaves must be right at any moment.
#[test]
fn a_stopped_render_holds_the_samples_that_it_says_and_goes_on_from_there() {
    for name in SCENES {
        let scene = build(&description(name));
        let pixels = whole(&scene).area();
        let level = SimdLevel::detect();
        let expected = part(&scene, 0..64, whole(&scene), level);
        for step in 0..12u64 {
            let rendered = match step {
                0 => stopped(&scene, |_, _| true),
                1..=4 => stopped(&scene, |every, _| every >= step),
                _ => stopped(&scene, |_, all| all >= pixels * (step - 5) * 5 / 2),
            };
            let held = rendered.film.samples().total();
            assert_eq!(rendered.complete, held == 64, "{name}: {held}");
            if held == 0 {
                assert!(rendered.film.samples().as_slice().is_empty());
                continue;
            }
            assert_eq!(rendered.film.samples().as_slice().first(), Some(&(0..held)));
            assert_eq!(rendered.statistics.paths, held * pixels);
            let mut film = rendered.film;
            assert!(film.pixels().iter().all(|pixel| pixel.samples() == held), "{name}: {held}");
            if held < 64 {
                film.merge(&part(&scene, held..64, whole(&scene), level)).unwrap();
            }
            assert!(bytes(&film) == bytes(&expected), "{name}: stopped at {held}");
        }
    }
}

#[test]
fn a_preview_of_all_samples_shows_the_colours_of_the_film() {
    let scene = build(&description("lattice"));
    let (stop, samples_done) = (AtomicBool::new(false), AtomicU64::new(0));
    let control = RenderControl { stop: &stop, samples_done: &samples_done, after_pass: &|_| () };
    let crop = PixelRect::new(3, 1, whole(&scene).x1, whole(&scene).y1 - 2);
    let settings = RenderSettings { samples: 5..12, crop, level: SimdLevel::detect() };
    let (rendered, preview) = render_with(&scene, &settings, |rendering| {
        assert!(rendering.preview(None).unwrap().is_none(), "nothing is rendered yet");
        rendering.run(&control).unwrap();
        assert_eq!(rendering.samples(), 7);
        rendering.preview(None).unwrap().unwrap()
    })
    .unwrap();
    let picture = Picture::from_film(&rendered.film).unwrap();
    assert_eq!(preview.colour().unwrap(), picture.colour().unwrap());
    assert_eq!(samples_done.load(Ordering::Relaxed), 7 * crop.area());
    let earlier = rendered.film;
    let settings = RenderSettings { samples: 12..15, ..settings };
    let (rendered, [before, after]) = render_with(&scene, &settings, |rendering| {
        let before = rendering.preview(Some(&earlier)).unwrap().unwrap();
        rendering.run(&control).unwrap();
        [before, rendering.preview(Some(&earlier)).unwrap().unwrap()]
    })
    .unwrap();
    assert_eq!(before.colour().unwrap(), picture.colour().unwrap());
    let mut resumed = rendered.film;
    resumed.merge(&earlier).unwrap();
    let picture = Picture::from_film(&resumed).unwrap();
    assert_eq!(after.colour().unwrap(), picture.colour().unwrap());
}

#[test]
fn grains_written_and_read_back_give_the_same_pixels() {
    for name in ["buried", "layers", "shapes"] {
        let mut fallen = description(name);
        // A file does not tell which snow a grain belongs to.
        fallen.strata = Strata::default();
        let (field, _) = snowgrain_render::deposit(&fallen, &mut |_| ()).unwrap();
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("grains.ply");
        write_grains(&path, &field).unwrap();
        let back = read_grains(&path).unwrap();
        assert!(back == field, "{name}: the grains differ");
        let snow = vec![SnowDescription::Grains(Arc::new(back))];
        // A file tells the shapes.
        let placed = SceneDescription { snow, shapes: Vec::new(), ..fallen.clone() };
        let (mut fallen, placed) = (build(&fallen), build(&placed));
        assert_eq!(fallen.hash, placed.hash, "{name}: the scene's hash is over its content");
        assert_ne!(fallen.recipe, placed.recipe, "{name}: other things were asked for");
        fallen.recipe = placed.recipe;
        assert!(bytes(&film(&fallen)) == bytes(&film(&placed)), "{name}: the pixels differ");
    }
}
