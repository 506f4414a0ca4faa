//! From a scene to a film: passes over tiles.
//!
//! A pass adds a few samples to every pixel; each tile of it is one task that owns its own sums, so
//! threads share nothing but the list of tasks. Sums are exact, so the film is the same whatever
//! the threads, tiles and passes were.

use crate::statistics::Statistics;
use crate::transport::{NewPath, PathEnd, PathResult, PathSource, trace};
use crate::{RenderError, Scene};
use rayon::prelude::*;
use snowgrain_accel::SimdLevel;
use snowgrain_film::{Film, FilmIdentity, FilmTile, PixelRect, Sample};
use snowgrain_math::sampler::{PathKey, numbers};
use snowgrain_math::trig;
use std::ops::Range;
use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::time::{Duration, Instant};

/// Pixels along an edge of a tile.
const TILE: u32 = 32;
/// Wanted duration of a pass once the picture has begun: how often it can be refreshed or stopped.
const PASS: Duration = Duration::from_secs(2);

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
    /// Counts samples as tiles are done.
    pub samples_done: &'a AtomicU64,
    /// Called after every pass with the film so far; a refreshed picture can be written here.
    pub after_pass: &'a mut dyn FnMut(&Film),
}

/// A film and how it came about.
#[derive(Debug)]
pub struct Rendered {
    /// The film.
    pub film: Film,
    /// Counts of all its paths.
    pub statistics: Statistics,
    /// Whether all samples were rendered (else the render was stopped).
    pub complete: bool,
}

/// Renders with the threads of the current rayon pool.
///
/// # Errors
/// A sample that the film cannot hold, or a size that it refuses.
pub fn render(
    scene: &Scene,
    settings: &RenderSettings,
    control: &mut RenderControl<'_>,
) -> Result<Rendered, RenderError> {
    let identity = FilmIdentity { scene_hash: scene.hash, seed: scene.film.seed };
    let mut film = Film::new(scene.film.width, scene.film.height, settings.crop, identity)?;
    let mut statistics = Statistics::default();
    let tiles: Vec<PixelRect> = settings.crop.tiles(TILE).collect();
    let mut next = settings.samples.start;
    let mut pass_samples = 1;
    while next < settings.samples.end {
        let range = next..settings.samples.end.min(next + pass_samples);
        let started = Instant::now();
        let Some(pass) = render_pass(scene, settings, control, &tiles, range.clone(), &film)?
        else {
            return Ok(Rendered { film, statistics, complete: false });
        };
        film = pass.0;
        statistics.add(&pass.1);
        film.record_samples(range.clone())?;
        next = range.end;
        (control.after_pass)(&film);
        if started.elapsed() * 2 < PASS {
            pass_samples *= 2;
        } else if started.elapsed() > PASS * 2 {
            pass_samples = (pass_samples / 2).max(1);
        }
    }
    Ok(Rendered { film, statistics, complete: true })
}

/// One pass over all tiles, added to a copy of `film`; `None` where it was stopped.
fn render_pass(
    scene: &Scene,
    settings: &RenderSettings,
    control: &RenderControl<'_>,
    tiles: &[PixelRect],
    samples: Range<u64>,
    film: &Film,
) -> Result<Option<(Film, Statistics)>, RenderError> {
    let gathered = Mutex::new((film.clone(), Statistics::default()));
    let (stop, samples_done) = (control.stop, control.samples_done);
    tiles.par_iter().try_for_each(|&rect| -> Result<(), RenderError> {
        if stop.load(Ordering::Relaxed) {
            return Ok(());
        }
        let (tile, counts) = render_tile(scene, rect, samples.clone(), settings.level)?;
        samples_done.fetch_add(counts.paths, Ordering::Relaxed);
        let mut gathered = gathered.lock().expect("no task panics while it holds the film");
        gathered.0.merge_tile(&tile)?;
        gathered.1.add(&counts);
        Ok(())
    })?;
    if stop.load(Ordering::Relaxed) {
        return Ok(None);
    }
    Ok(Some(gathered.into_inner().expect("no task panicked")))
}

fn render_tile(
    scene: &Scene,
    rect: PixelRect,
    samples: Range<u64>,
    level: SimdLevel,
) -> Result<(FilmTile, Statistics), RenderError> {
    let mut source = TileSource {
        scene,
        tile: FilmTile::new(rect)?,
        pixel: (rect.x0, rect.y0),
        sample: samples.start,
        samples,
        statistics: Statistics::default(),
        fault: None,
    };
    trace(&scene.world, level, &mut source);
    match source.fault {
        Some(fault) => Err(fault),
        None => Ok((source.tile, source.statistics)),
    }
}

/// The samples of one tile, pixel by pixel.
struct TileSource<'a> {
    scene: &'a Scene,
    tile: FilmTile,
    pixel: (u32, u32),
    sample: u64,
    samples: Range<u64>,
    statistics: Statistics,
    fault: Option<RenderError>,
}

impl PathSource for TileSource<'_> {
    type Tag = (u32, u32);

    fn next_path(&mut self) -> Option<NewPath<Self::Tag>> {
        let rect = self.tile.rect();
        if self.sample == self.samples.end {
            self.sample = self.samples.start;
            self.pixel.0 += 1;
            if self.pixel.0 == rect.x1 {
                self.pixel = (rect.x0, self.pixel.1 + 1);
            }
        }
        let (x, y) = self.pixel;
        if y >= rect.y1 || self.samples.is_empty() || self.fault.is_some() {
            return None;
        }
        let film = &self.scene.film;
        let stream = u64::from(y) * u64::from(film.width) + u64::from(x);
        let key = PathKey::new(film.seed, stream, self.sample);
        self.sample += 1;
        let [jitter_x, jitter_y, _] = numbers(key, 0);
        let (px, py) = (f64::from(x) + f64::from(jitter_x), f64::from(y) + f64::from(jitter_y));
        Some(NewPath { tag: (x, y), ray: self.scene.camera.ray(px, py), key, event: 1 })
    }

    fn finish(&mut self, (x, y): Self::Tag, path: &PathResult) {
        self.statistics.count(path);
        if path.end == PathEnd::Enclosed {
            self.fault.get_or_insert(RenderError::Enclosed { x, y });
        } else if let Err(fault) = self.tile.add(x, y, &self.sample_of(path)) {
            self.fault.get_or_insert(fault.into());
        }
    }
}

impl TileSource<'_> {
    fn sample_of(&self, path: &PathResult) -> Sample {
        let scene = self.scene;
        let radiance = match (path.end, path.first_hit) {
            (PathEnd::Escaped(ray), None) => scene.environment.seen_by_camera(ray.direction),
            (PathEnd::Escaped(ray), Some(_)) => {
                let light = scene.environment.radiance(ray.direction);
                let ice = -scene.ice.absorption_per_metre * path.ice_length;
                let ice = if ice == 0.0 { 1.0 } else { trig::exp(ice) as f32 };
                std::array::from_fn(|c| light[c] * path.throughput[c] * ice)
            }
            (PathEnd::Absorbed | PathEnd::Enclosed, _) => [0.0; 3],
        };
        match path.first_hit {
            None => Sample { radiance, alpha: 0.0, depth: f32::INFINITY, ..Sample::default() },
            Some(hit) => Sample {
                radiance,
                alpha: 1.0,
                albedo: hit.albedo,
                normal: hit.normal.to_array().map(|v| v as f32),
                depth: scene.camera.depth(hit.position) as f32,
            },
        }
    }
}
