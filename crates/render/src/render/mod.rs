//! From a scene to a film: passes over tiles.
//!
//! A pass adds a few samples to every pixel. Its tasks, each some samples of one tile, are dealt out
//! by one atomic counter (`passes`). Each thread draws all its paths from one stream (`stream`) that
//! goes on from task to task and from pass to pass, so that its flight never runs dry before the
//! render ends; samples come back in any order and are added to their tile in batches (`tile_sums`).
//! A tile's lock is taken once a batch and hardly ever found held, and nothing else is shared. Sums
//! are exact, so the film is the same whatever the threads, tiles and passes were.

mod batch;
mod camera_path;
mod caught;
mod noise;
mod passes;
mod snapshot;
mod stream;
mod tile_sums;

use crate::statistics::Statistics;
use crate::transport::deep::Deep;
use crate::transport::medium::trace_in_medium;
use crate::transport::seek::Seeker;
use crate::transport::trace_with;
use crate::{RenderError, Scene};
pub use noise::{PILOT_SAMPLES, Pilot, block_counts};
use passes::Passes;
use snowgrain_accel::SimdLevel;
use snowgrain_film::{
    BlockCounts, Film, FilmError, FilmIdentity, IcePathLayout, Layer, Picture, PixelRect,
};
use std::ops::Range;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::{Mutex, MutexGuard, PoisonError};
use stream::Stream;
use tile_sums::TileSums;

/// Pixels along an edge of a tile. Its sums (53 kB) stay in a core's cache while a task adds to them;
/// small enough that a thumbnail keeps many threads busy. Tiles are the blocks that may have sample counts
/// of their own.
const TILE: u32 = BlockCounts::SIDE;

/// What part of the picture to render, and how.
#[derive(Clone, Debug)]
pub struct RenderSettings {
    /// Samples of every pixel, by index.
    pub samples: Range<u64>,
    /// Pixels, half-open.
    pub crop: PixelRect,
    /// Instruction set of the kernels.
    pub level: SimdLevel,
}

/// How a render talks to whoever started it.
pub struct RenderControl<'a> {
    /// Set from outside to stop: the passes that are complete are kept.
    pub stop: &'a AtomicBool,
    /// Counts samples as tasks are done.
    pub samples_done: &'a AtomicU64,
    /// Told how many samples every pixel has whenever a pass is complete, by the thread that
    /// completed it, while others go on: to be left soon.
    pub after_pass: &'a (dyn Fn(u64) + Sync),
}

/// A film and how it came about.
#[derive(Debug)]
pub struct Rendered {
    /// The film. Where it says that it holds no samples, the render was stopped before every pixel
    /// had one: then its pixels show what there was, but they cannot be merged or continued.
    pub film: Film,
    /// Counts of all its paths.
    pub statistics: Statistics,
    /// Whether all samples were rendered (else the render was stopped).
    pub complete: bool,
}

/// A render under way: any thread may look at it while others work on it.
pub struct Rendering<'a> {
    scene: &'a Scene,
    settings: &'a RenderSettings,
    passes: Passes,
    /// As [`PixelRect::tiles`] orders them.
    tiles: Vec<SharedTile<'a>>,
    counts: Option<BlockCounts>,
    /// Set while a snapshot is taken: passes that become complete stay beside the film.
    holds_settling: AtomicBool,
    /// Set with `fault`, so that all threads stop.
    failed: AtomicBool,
    fault: Mutex<Option<RenderError>>,
}

/// A tile on cache lines of its own (two, as processors fetch them in pairs).
#[repr(align(128))]
struct SharedTile<'a> {
    rect: PixelRect,
    sums: Mutex<TileSums<'a>>,
}

/// Renders with the threads of the current rayon pool.
///
/// # Errors
/// As [`render_with`] and [`Rendering::run`].
pub fn render(
    scene: &Scene,
    settings: &RenderSettings,
    control: &RenderControl<'_>,
) -> Result<Rendered, RenderError> {
    let (rendered, ran) = render_with(scene, settings, |rendering| rendering.run(control))?;
    ran.map(|()| rendered)
}

/// Hands a render of which nothing is done yet to `work`, which is to call [`Rendering::run`] and may
/// look at it meanwhile; then gives the film, and what `work` gave.
///
/// # Errors
/// A crop that the film refuses, more pixels than memory, sums that leave their range.
pub fn render_with<T>(
    scene: &Scene,
    settings: &RenderSettings,
    work: impl FnOnce(&Rendering<'_>) -> T,
) -> Result<(Rendered, T), RenderError> {
    render_blocks_with(scene, settings, None, work)
}

/// As [`render_with`], where each block of pixels has of `settings.samples` those below its count (of
/// [`block_counts`]), if counts are given.
///
/// # Errors
/// As [`render_with`]; counts of another crop.
pub fn render_blocks_with<T>(
    scene: &Scene,
    settings: &RenderSettings,
    counts: Option<BlockCounts>,
    work: impl FnOnce(&Rendering<'_>) -> T,
) -> Result<(Rendered, T), RenderError> {
    render_to(empty_film(scene, settings.crop, counts)?, scene, settings, work)
}

/// A film of a crop of a scene's picture that keeps what the scene asks for, without samples.
///
/// # Errors
/// A crop that the film refuses, counts of another crop, more pixels than memory.
pub fn empty_film(
    scene: &Scene,
    crop: PixelRect,
    counts: Option<BlockCounts>,
) -> Result<Film, FilmError> {
    let identity = FilmIdentity { scene_hash: scene.hash, seed: scene.film.seed };
    let mut film = Film::new(scene.film.width, scene.film.height, crop, identity)?;
    film.grade = scene.grade.clone();
    film.recipe = Some(scene.recipe);
    film.vertical_fov_degrees = scene.camera.vertical_fov_degrees();
    if let Some(layers) = &scene.light_layers {
        film = film.keeping_light_layers(layers.clone())?;
    }
    if scene.film.keep_ice_paths {
        let lights = scene.lights.slots().len() as u32;
        let greatest = scene.lights.greatest_radiance();
        film = film.keeping_ice_paths(IcePathLayout::for_radiance(lights, greatest))?;
    }
    if scene.catchers_alone.is_some() {
        film = film.keeping_shadow_catcher()?;
    }
    if scene.outcomes.is_some() {
        film = film.keeping_learnt_light()?;
    }
    if let Some(counts) = counts {
        film = film.with_block_counts(counts)?;
    }
    Ok(film)
}

/// Renders to an empty film.
fn render_to<T>(
    mut film: Film,
    scene: &Scene,
    settings: &RenderSettings,
    work: impl FnOnce(&Rendering<'_>) -> T,
) -> Result<(Rendered, T), RenderError> {
    let rendering = Rendering::new(scene, settings, &mut film);
    let wanted = rendering.passes.wanted();
    let result = work(&rendering);
    let (complete, done) = (rendering.passes.complete(), rendering.passes.samples());
    let mut statistics = Statistics::default();
    for tile in rendering.tiles {
        let mut sums = tile.sums.into_inner().unwrap_or_else(PoisonError::into_inner);
        sums.settle(complete)?;
        statistics.add(sums.statistics());
    }
    let complete = done.end == wanted.end;
    if !done.is_empty() {
        film.record_samples(done)?;
    }
    Ok((Rendered { film, statistics, complete }, result))
}

impl<'a> Rendering<'a> {
    fn new(scene: &'a Scene, settings: &'a RenderSettings, film: &'a mut Film) -> Self {
        let crop = settings.crop;
        let counts = film.block_counts().cloned();
        let tiles: Vec<_> = film
            .tiles_mut(TILE)
            .into_iter()
            .map(|base| SharedTile { rect: base.rect(), sums: Mutex::new(TileSums::new(base)) })
            .collect();
        let pixels = u64::from(TILE.min(crop.width())) * u64::from(TILE.min(crop.height()));
        let end =
            |tile| counts.as_ref().map_or(u64::MAX, |counts| u64::from(counts.counts()[tile]));
        let ends = (0..tiles.len()).map(end);
        Self {
            scene,
            settings,
            passes: Passes::new(settings.samples.clone(), ends, (pixels, scene.bands.len().max(1))),
            tiles,
            counts,
            holds_settling: AtomicBool::new(false),
            failed: AtomicBool::new(false),
            fault: Mutex::new(None),
        }
    }

    /// Renders with the threads of the current rayon pool, until all is done or `control` stops it.
    ///
    /// # Errors
    /// A sample that the film cannot hold, light that is enclosed, or tiles beyond memory.
    pub fn run(&self, control: &RenderControl<'_>) -> Result<(), RenderError> {
        rayon::broadcast(|_| {
            let mut stream = Stream::new(self, control);
            let Scene { world, camera, outcomes, medium, proxy, .. } = self.scene;
            if let Some(medium) = medium {
                trace_in_medium(world, medium, &mut stream);
                return stream.flush();
            }
            let level = self.settings.level;
            loop {
                let (eta, search) = self.scene.optics_of(stream.band());
                let seeker = search.map(|search| Seeker::new(world, camera, search, level));
                // Learnt by light of the middle index: deep in the snow it makes no difference.
                let deep = outcomes.as_ref().map(Deep::HandOver);
                let deep = deep.or_else(|| proxy.as_ref().map(Deep::Proxy));
                trace_with((world, eta), level, (seeker, deep), &mut stream);
                if !stream.turn_to_next_band() {
                    break;
                }
            }
            stream.flush();
        });
        let fault = self.fault.lock().unwrap_or_else(PoisonError::into_inner).take();
        fault.map_or(Ok(()), Err)
    }

    /// The colours of all samples so far, complete passes or not, together with those of an `earlier` film of
    /// the same crop; `None` where there is too little. In the first pass, pixels without a sample show what a
    /// neighbour of at most three pixels to the left and above does.
    ///
    /// # Errors
    /// More pixels than memory.
    pub fn preview(&self, earlier: Option<&Film>) -> Result<Option<Picture>, RenderError> {
        let crop = self.settings.crop;
        let count = usize::try_from(crop.area()).unwrap_or(usize::MAX);
        let mut layers = [const { Vec::<f32>::new() }; 3];
        for layer in &mut layers {
            layer.try_reserve_exact(count).map_err(|_| FilmError::TooLarge {
                pixels: crop.area(),
                bytes: u128::from(crop.area()) * 12,
            })?;
            layer.resize(count, 0.0);
        }
        for shared in &self.tiles {
            let sums = shared.lock();
            for (x, y) in pixels_of(shared.rect) {
                let at = crop.index(x, y).unwrap_or(0);
                let before = earlier.and_then(|film| film.pixels().get(at));
                let Some(colour) = sums.colour(x, y, before) else { return Ok(None) };
                layers.iter_mut().zip(colour).for_each(|(layer, value)| layer[at] = value);
            }
        }
        let mut picture = Picture::new(self.scene.film.width, self.scene.film.height, crop)?;
        picture.primaries = self.scene.film.primaries;
        picture.exposure_stops = self.scene.film.exposure_stops;
        picture.vertical_fov_degrees = self.scene.camera.vertical_fov_degrees();
        for (layer, values) in Layer::COLOUR.into_iter().zip(layers) {
            picture.set_layer(layer, values)?;
        }
        Ok(Some(picture))
    }

    /// Samples that every pixel has so far, of those that its block is to have.
    #[must_use]
    pub fn samples(&self) -> u64 {
        let samples = self.passes.samples();
        samples.end - samples.start
    }

    /// Passes that a thread which holds a tile may move to the film.
    fn passes_to_settle(&self) -> u64 {
        if self.holds_settling.load(Ordering::SeqCst) { 0 } else { self.passes.complete() }
    }

    /// Keeps the first fault and stops all threads.
    fn fail(&self, fault: RenderError) {
        self.fault.lock().unwrap_or_else(PoisonError::into_inner).get_or_insert(fault);
        self.failed.store(true, Ordering::Relaxed);
    }
}

impl<'a> SharedTile<'a> {
    fn lock(&self) -> MutexGuard<'_, TileSums<'a>> {
        self.sums.lock().expect("no thread panics while it holds a tile")
    }
}

/// Pixels in row-major order.
fn pixels_of(rect: PixelRect) -> impl Iterator<Item = (u32, u32)> {
    (rect.y0..rect.y1).flat_map(move |y| (rect.x0..rect.x1).map(move |x| (x, y)))
}
