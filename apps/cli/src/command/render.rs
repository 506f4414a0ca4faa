//! `snowgrain render`.

mod noise;

use super::denoise::{denoised, denoiser};
use super::pictures::Pictures;
use crate::arguments::{PictureFormat, RenderArguments};
use crate::budget::{Budget, readable_bytes};
use crate::failure::Failure;
use crate::load::{self, LoadedScene};
use crate::output;
use crate::process::{Spent, Stopwatch};
use crate::progress::Progress;
use crate::signals::Interrupts;
use crate::summary::{BuildTimes, Run, grouped};
use crate::threads::{pool, threads};
use crate::viewer::Viewer;
use noise::Plan;
use rayon::ThreadPool;
use snowgrain_accel::SimdLevel;
use snowgrain_denoise::Denoiser;
use snowgrain_film::{BlockCounts, Picture, PixelRect, spectral_layers};
use snowgrain_formats::{atomic, scene};
use snowgrain_render::description::{Packing, SceneDescription};
use snowgrain_render::{
    BuildStage, CostEstimate, RenderControl, RenderSettings, Rendered, Scene, render_blocks_with,
};
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::Instant;

pub(super) fn run(arguments: &RenderArguments) -> Result<u8, Failure> {
    let started = Instant::now();
    refuse_options_without_file(arguments)?;
    let mut pictures = Pictures::new(&arguments.output, &arguments.display)?;
    if let Some(path) = &arguments.report.json_stats {
        if arguments.output.iter().any(|picture| picture.path == *path) {
            return Err(Failure::usage("--json-stats and --output name the same file; name two"));
        }
        atomic::check_writable_target(path)?;
    }
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
    let cost = CostEstimate::of(description, crop);
    let budget = Budget::of_this_machine(arguments.machine.max_memory);
    let fits = budget.map_or(Ok(()), |budget| budget.check(&cost));
    if arguments.dry_run {
        output::print(&estimate(&cost, description, crop, threads(&arguments.machine)))?;
        return fits.map(|()| 0);
    }
    fits.map_err(|failure| failure.of(&loaded.name))?;
    progress.detail(&format!(
        "about {} grains, {} of memory",
        grouped(cost.grains),
        readable_bytes(cost.peak_bytes())
    ));
    let pool = pool(&arguments.machine)?;
    let level = arguments.machine.simd.unwrap_or_else(SimdLevel::detect);
    progress.detail(&format!("{} threads, {level}", pool.current_num_threads()));
    let (scene, times) = build(&loaded, &pool, level, &progress)?;
    let packing = description.packing.unwrap_or_default();
    refuse_camera_in_ice(&scene, &loaded)?;
    let settings =
        RenderSettings { samples: 0..u64::from(scene.film.samples_per_pixel), crop, level };
    if let Some(address) = &arguments.display_server {
        pictures.show_in(Viewer::at(address, loaded.name.clone()));
    }
    let plan = match arguments.noise_target {
        Some(target) => Some(Plan::find(&scene, &settings, target, &pool, &progress)?),
        None => None,
    };
    let (scene, pool) = (&scene, &pool);
    let task = Task { arguments, scene, packing, settings, plan, denoiser, pool, started };
    let (rendered, spent) = task.render(&pictures, &interrupts, &progress)?;
    progress.finish();
    task.report(&pictures, &interrupts, &progress, &rendered, times, spent)
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

/// Lets the snow fall and packs it.
fn build(
    loaded: &LoadedScene,
    pool: &ThreadPool,
    level: SimdLevel,
    progress: &Progress,
) -> Result<(Scene, BuildTimes), Failure> {
    let mut times = BuildTimes::default();
    let mut running: Option<(BuildStage, Stopwatch)> = None;
    let snow = &loaded.description.snow;
    let built = pool.install(|| {
        Scene::build_at(&loaded.description, level, &mut |stage| {
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

/// What a render leaves.
struct Outcome {
    rendered: Rendered,
    /// A coarse picture, where the render was stopped before every pixel had a sample.
    preview: Option<Picture>,
}

/// A picture to be rendered.
struct Task<'a> {
    arguments: &'a RenderArguments,
    scene: &'a Scene,
    packing: Packing,
    settings: RenderSettings,
    /// How many samples each block is to have, where blocks differ.
    plan: Option<Plan>,
    denoiser: Option<Denoiser>,
    pool: &'a ThreadPool,
    started: Instant,
}

impl Task<'_> {
    /// Most samples that a pixel is to have.
    fn wanted(&self) -> u64 {
        let counts = self.plan.as_ref().map(Plan::counts);
        counts.map_or(self.settings.samples.end, |counts| counts.greatest().into())
    }

    /// Renders, refreshing the PNG files.
    fn render(
        &self,
        pictures: &Pictures,
        interrupts: &Interrupts,
        progress: &Progress,
    ) -> Result<(Outcome, Spent), Failure> {
        let samples_done = AtomicU64::new(0);
        let wanted = self.wanted();
        let counts = self.plan.as_ref().map(Plan::counts);
        let every = self.settings.crop.area().saturating_mul(wanted);
        let total = counts.map_or(every, BlockCounts::total);
        let (limit, started) = (self.arguments.time_limit, self.started);
        let after_pass = |samples: u64| {
            let over = limit.is_some_and(|limit| started.elapsed() >= limit);
            if over && samples < wanted {
                interrupts.stop().store(true, Ordering::SeqCst);
            }
        };
        interrupts.keep_what_there_is();
        let watch = Stopwatch::start();
        let control = RenderControl {
            stop: interrupts.stop(),
            samples_done: &samples_done,
            after_pass: &after_pass,
        };
        let (rendered, preview) = progress.samples(&samples_done, total, || {
            render_blocks_with(self.scene, &self.settings, counts.cloned(), |rendering| {
                pictures.refreshed(rendering, interrupts, progress, || {
                    self.pool.install(|| rendering.run(&control))
                })?;
                if rendering.samples() > 0 { Ok(None) } else { rendering.preview() }
            })
        })?;
        Ok((Outcome { rendered, preview: preview? }, watch.spent()))
    }

    /// Writes everything, whatever of it fails, and tells what there is.
    fn report(
        &self,
        pictures: &Pictures,
        interrupts: &Interrupts,
        progress: &Progress,
        Outcome { rendered, preview }: &Outcome,
        times: BuildTimes,
        spent: Spent,
    ) -> Result<u8, Failure> {
        let samples = rendered.film.samples().total();
        let mut written = Ok(());
        let mut mean_radiance = None;
        if samples > 0 {
            let film = &rendered.film;
            let mut picture = Picture::from_film(film)?;
            if let Some(wavelengths) = &self.arguments.wavelengths {
                picture.spectrum = spectral_layers(film, &film.grade, None, &wavelengths.0)?;
            }
            mean_radiance = Some(picture.mean_radiance()?);
            if let Some(denoiser) = &self.denoiser {
                picture = denoised(denoiser, &picture)?;
            }
            written = interrupts.while_writing(|| pictures.write(&rendered.film, &picture));
            pictures.show_last(&picture, progress);
        } else if let Some(preview) = preview {
            written = interrupts.while_writing(|| pictures.write_preview(preview));
            pictures.show_last(preview, progress);
        }
        let figures = Run {
            report: &self.scene.report,
            scene_hash: &self.scene.hash,
            times,
            render: spent,
            statistics: &rendered.statistics,
            samples_per_pixel: samples,
            complete: rendered.complete,
            noise: self.plan.as_ref().map(|plan| plan.figures(&rendered.film)),
            mean_radiance,
            packing: self.packing,
            threads: self.pool.current_num_threads(),
            simd: self.settings.level.to_string(),
        }
        .figures();
        figures.lines().iter().for_each(|line| progress.note(line));
        if let Some(path) = &self.arguments.report.json_stats {
            let text = output::json(&figures)?;
            written = written.and(interrupts.while_writing(|| output::write_text(path, &text)));
        }
        written?;
        let wanted = self.wanted();
        let kept = match (samples, preview) {
            (0, None) => "before there was a picture; nothing was written".to_owned(),
            (0, Some(_)) => "before every pixel had a sample; PNG files show a coarse picture, \
                             nothing else was written"
                .to_owned(),
            _ => format!(
                "after {samples} of {wanted} samples a pixel; the picture of these is written"
            ),
        };
        match interrupts.exit_code() {
            Some(code) => {
                progress.note(&format!("stopped by a signal {kept}"));
                Ok(code)
            }
            None if !rendered.complete => {
                progress.note(&format!("ended by --time-limit {kept}"));
                Ok(0)
            }
            None => Ok(0),
        }
    }
}
