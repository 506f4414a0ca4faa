//! `snowgrain render`.

mod checkpoints;
mod earlier;
mod noise;
mod task;

use super::denoise::{denoised, denoiser};
use super::pictures::Pictures;
use crate::arguments::{PictureFile, PictureFormat, RenderArguments};
use crate::budget::{Budget, readable_bytes};
use crate::disk;
use crate::failure::{Failure, exit};
use crate::load::{self, LoadedScene};
use crate::output;
use crate::process::Stopwatch;
use crate::progress::Progress;
use crate::signals::Interrupts;
use crate::summary::{BuildTimes, grouped};
use crate::threads::{pool, threads};
use crate::viewer::Viewer;
use checkpoints::Checkpoints;
use earlier::{Request, film_path};
use noise::Plan;
use rayon::ThreadPool;
use snowgrain_accel::SimdLevel;
use snowgrain_denoise::Denoiser;
use snowgrain_film::{Film, PixelRect};
use snowgrain_formats::{atomic, read_learnt, scene, write_learnt};
use snowgrain_render::description::{Packing, SceneDescription};
use snowgrain_render::transport::deep::LearntStore;
use snowgrain_render::{BuildStage, CostEstimate, RenderSettings, Scene, recipe};
use std::path::Path;
use std::time::Instant;
use task::{Task, picture_of};

pub(super) fn run(arguments: &RenderArguments) -> Result<u8, Failure> {
    let started = Instant::now();
    let arguments = &arguments.with_names_of_frame()?;
    refuse_options_without_file(arguments)?;
    let mut pictures = Pictures::new(&arguments.output, &arguments.display)?;
    if let Some(path) = &arguments.report.json_stats {
        if arguments.output.iter().any(|picture| picture.path == *path) {
            return Err(Failure::usage("--json-stats and --output name the same file; name two"));
        }
        atomic::check_writable_target(path)?;
    }
    let checkpoints = Checkpoints::new(arguments)?;
    let denoiser = denoiser(&arguments.denoise, &arguments.output, threads(&arguments.machine))?;
    let progress = Progress::new(arguments.report.quiet, arguments.report.verbose);
    let interrupts = Interrupts::watch();
    let mut loaded = load(arguments, &progress)?;
    let crop = crop(arguments, &loaded.description)?;
    let most = arguments.machine.max_memory;
    if most.is_some_and(|most| pack_to_fit(&mut loaded.description, crop, most)) {
        progress.note(
            "grains are packed compactly to keep within --max-memory, which is slower; --packing \
             fast or a higher limit prevents it",
        );
    }
    let description = &loaded.description;
    let mut cost = CostEstimate::of(description, crop);
    if film_path(arguments).is_some() {
        // A checkpoint, and what is resumed.
        cost.add_films(if arguments.resume { 2 } else { 1 });
    }
    let budget = Budget::of_this_machine(arguments.machine.max_memory);
    let fits = budget.map_or(Ok(()), |budget| budget.check(&cost));
    if arguments.dry_run {
        output::print(&estimate(&cost, description, crop, threads(&arguments.machine)))?;
        return fits.map(|()| 0);
    }
    fits.map_err(|failure| failure.of(&loaded.name))?;
    disk::check(&arguments.output, &cost, crop)?;
    progress.detail(&format!(
        "about {} grains, {} of memory",
        grouped(cost.grains),
        readable_bytes(cost.peak_bytes())
    ));
    let samples = arguments.samples.clone();
    let samples = samples.unwrap_or(0..u64::from(description.film.samples_per_pixel));
    let request = Request::new(arguments, description, crop, samples.clone());
    let _claims = output::claim_films(&arguments.output)?;
    let earlier = request.earlier_film(arguments, &progress)?;
    if let Some(film) = earlier.as_ref().filter(|film| request.is_finished(film)) {
        progress.note(&request.told_of_finished(film, arguments));
        write_again(film, arguments, &pictures, denoiser.as_ref())?;
        return Ok(0);
    }
    let pool = pool(&arguments.machine)?;
    let level = arguments.machine.simd.unwrap_or_else(SimdLevel::detect);
    progress.detail(&format!("{} threads, {level}", pool.current_num_threads()));
    let learnt = learnt_folder(arguments, &loaded)?;
    let (scene, times) = build(&loaded, &pool, (level, learnt), &progress)?;
    let packing = description.packing.unwrap_or_default();
    refuse_camera_in_ice(&scene, &loaded)?;
    let settings = RenderSettings { samples, crop, level };
    if let Some(address) = &arguments.display_server {
        pictures.show_in(Viewer::at(address, loaded.name.clone()));
    }
    let plan = match arguments.noise_target {
        Some(target) => Some(Plan::find(&scene, &settings, target, &pool, &progress)?),
        None => None,
    };
    let (scene, pool) = (&scene, &pool);
    let task =
        Task { arguments, scene, packing, settings, plan, denoiser, checkpoints, pool, started };
    let (rendered, spent) = task.render(earlier, &pictures, &interrupts, &progress)?;
    progress.finish();
    task.report(&pictures, &interrupts, &progress, &rendered, times, spent)
}

/// Digests ([`recipe`]) that a film of these arguments may have, whatever `--max-memory` it is rendered with.
///
/// # Errors
/// A scene that cannot be loaded.
pub(super) fn recipes(arguments: &RenderArguments) -> Result<[[u8; 32]; 2], Failure> {
    let mut scene = load(arguments, &Progress::new(true, false))?.description;
    let chosen = recipe(&scene);
    scene.packing.get_or_insert(Packing::Compact);
    Ok([chosen, recipe(&scene)])
}

/// Options that only show in a kind of file that is not asked for.
fn refuse_options_without_file(arguments: &RenderArguments) -> Result<(), Failure> {
    let writes = |format| arguments.output.iter().any(|file| file.format == format);
    if arguments.dry_run {
        return Ok(());
    }
    if arguments.wavelengths.is_some() && !writes(PictureFormat::Exr) {
        return Err(Failure::usage("--wavelengths are layers of .exr files; name one by -o"));
    }
    let kept = |what: &str| arguments.keep.iter().any(|keep| keep == what);
    if kept("ice-paths") && !writes(PictureFormat::Film) {
        return Err(Failure::usage("--keep ice-paths is for .film files; name one by -o"));
    }
    if kept("light-groups") && !writes(PictureFormat::Film) && !writes(PictureFormat::Exr) {
        return Err(Failure::usage(
            "--keep light-groups is for .film and .exr files; name one by -o",
        ));
    }
    Ok(())
}

/// Chooses the compact packing where the scene leaves the choice, and only that keeps within
/// `most` bytes. Only a limit that was given may decide: what is free on a machine must not show in
/// pixels.
fn pack_to_fit(scene: &mut SceneDescription, crop: PixelRect, most: u64) -> bool {
    if scene.packing.is_some() || CostEstimate::of(scene, crop).peak_bytes() <= most {
        return false;
    }
    scene.packing = Some(Packing::Compact);
    let fits = CostEstimate::of(scene, crop).peak_bytes() <= most;
    if !fits {
        scene.packing = None;
    }
    fits
}

/// The scene with all options applied.
fn load(arguments: &RenderArguments, progress: &Progress) -> Result<LoadedScene, Failure> {
    let mut changes = Vec::new();
    if let Some(samples) = arguments.spp {
        changes.push(format!("film.samples_per_pixel={samples}"));
    }
    if let Some(seed) = arguments.seed {
        changes.push(format!("film.seed={seed}"));
    }
    if let Some(size) = arguments.size {
        changes.push(format!("film.width={}", size.width));
        changes.push(format!("film.height={}", size.height));
    }
    if let Some(packing) = &arguments.packing {
        changes.push(format!("integrator.packing={packing}"));
    }
    match arguments.lod_error {
        None => {}
        Some(0.0) => changes.push("integrator.deep=exact".to_owned()),
        Some(error) => {
            changes.push("integrator.deep=learnt".to_owned());
            changes.push(format!("integrator.lod_error={error}"));
        }
    }
    let for_wavelengths = arguments.wavelengths.as_ref().map(|_| "ice-paths");
    for keep in arguments.keep.iter().map(String::as_str).chain(for_wavelengths) {
        changes.push(format!("film.keep+={keep}"));
    }
    let mut loaded = load::load(&arguments.scene, changes)?;
    for line in &loaded.assumptions {
        progress.note(line);
    }
    if let Some(view) = arguments.view {
        let nothing = "--view finds nothing finite to look at, or no snow to look at closely";
        let camera = view.camera(&loaded.description);
        loaded.description.camera =
            camera.ok_or_else(|| Failure::bad_input(nothing).of(&loaded.name))?;
    }
    if arguments.furnace {
        loaded.description = scene::furnace(loaded.description);
    }
    Ok(loaded)
}

fn crop(arguments: &RenderArguments, scene: &SceneDescription) -> Result<PixelRect, Failure> {
    let (width, height) = (scene.film.width, scene.film.height);
    let whole = PixelRect::new(0, 0, width, height);
    match arguments.crop {
        Some(crop) if !whole.encloses(&crop) => Err(Failure::usage(format!(
            "--crop {},{},{},{} leaves the picture of {width}x{height} pixels",
            crop.x0, crop.y0, crop.x1, crop.y1
        ))),
        crop => Ok(crop.unwrap_or(whole)),
    }
}

/// What `--dry-run` prints.
fn estimate(
    cost: &CostEstimate,
    scene: &SceneDescription,
    crop: PixelRect,
    threads: usize,
) -> String {
    let render = cost.render_seconds / threads as f64;
    format!(
        "grains   about {}\n\
         memory   about {} ({} for grains, {} more while they fall and are packed, {} for \
         surfaces, {} for the film)\n\
         pixels   {}x{}, {} samples each\n\
         time     about {:.0} s (snow {:.0} s, rendering {render:.0} s with {threads} threads); \
         within a factor of 3 on the machines it was measured on\n",
        grouped(cost.grains),
        readable_bytes(cost.peak_bytes()),
        readable_bytes(cost.grain_bytes),
        readable_bytes(cost.building_bytes),
        readable_bytes(cost.surface_bytes),
        readable_bytes(cost.film_bytes),
        crop.width(),
        crop.height(),
        scene.film.samples_per_pixel,
        cost.build_seconds + render,
        cost.build_seconds,
    )
}

/// The folder where learnt light is kept, which is made where it is not there.
fn learnt_folder<'a>(
    arguments: &'a RenderArguments,
    loaded: &LoadedScene,
) -> Result<Option<&'a Path>, Failure> {
    let Some(folder) = &arguments.learnt_cache else { return Ok(None) };
    let LoadedScene { description, .. } = loaded;
    if description.deep.is_none() && !description.integrator.is_proxy() {
        let what = "--learnt-cache is for light that is learnt; add --lod-error 0.01";
        return Err(Failure::usage(what));
    }
    std::fs::create_dir_all(folder).map_err(|error| {
        let what = format!("--learnt-cache {}: {error}; name a folder", folder.display());
        Failure::new(exit::CANNOT_CREATE, what)
    })?;
    Ok(Some(folder))
}

/// Lets the snow fall and packs it.
fn build(
    loaded: &LoadedScene,
    pool: &ThreadPool,
    (level, learnt): (SimdLevel, Option<&Path>),
    progress: &Progress,
) -> Result<(Scene, BuildTimes), Failure> {
    let mut times = BuildTimes::default();
    let mut running: Option<(BuildStage, Stopwatch)> = None;
    let snow = &loaded.description.snow;
    let built = pool.install(|| {
        let mut load = |key: &[u8; 32]| read_learnt(learnt?, key);
        let mut save = |key: &[u8; 32], bytes: &[u8]| {
            let Some(folder) = learnt else { return };
            if let Err(error) = write_learnt(folder, key, bytes) {
                progress.note(&format!("what was learnt is not kept: {error}"));
            }
        };
        let store = learnt.map(|_| LearntStore { load: &mut load, save: &mut save });
        Scene::build_keeping(&loaded.description, (level, store), &mut |stage| {
            if let Some((ended, watch)) = running.replace((stage, Stopwatch::start())) {
                times.book(ended, watch.spent());
            }
            progress.build_stage(stage, snow);
        })
    });
    if let Some((ended, watch)) = running {
        times.book(ended, watch.spent());
    }
    match built {
        Ok(scene) => Ok((scene, times)),
        Err(error) => Err(Failure::from(error).of(&loaded.name)),
    }
}

/// A path that starts in ice would be taken for one in air.
fn refuse_camera_in_ice(scene: &Scene, loaded: &LoadedScene) -> Result<(), Failure> {
    let from = loaded.description.camera.from;
    if !scene.world.grid.is_inside_grain(from) {
        return Ok(());
    }
    let message = format!(
        "camera.from = [{}, {}, {}]: the camera lies inside a grain of snow; move it out",
        from.x, from.y, from.z
    );
    Err(Failure::bad_input(message).of(&loaded.name))
}

/// Writes the files of a finished film that are not the film.
fn write_again(
    film: &Film,
    arguments: &RenderArguments,
    pictures: &Pictures,
    denoiser: Option<&Denoiser>,
) -> Result<(), Failure> {
    let is_there = |file: &PictureFile| film_path(arguments) == Some(file.path.as_path());
    if arguments.output.iter().all(is_there) {
        return Ok(());
    }
    let mut picture = picture_of(film, arguments)?;
    if let Some(denoiser) = denoiser {
        picture = denoised(denoiser, &picture)?;
    }
    pictures.write(film, &picture)
}
