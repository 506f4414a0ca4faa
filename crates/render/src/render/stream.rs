//! The paths of one thread: one stream through many tasks.
//!
//! While the last paths of a task are under way the first of the next ones begin, in the same pass or
//! not, so that the lanes of the flight stay full. A sample that comes back waits with others of its
//! task until there are enough of them to lock the tile and add them all.

use super::batch::Batch;
use super::camera_path::CameraPath;
use super::caught::{Caught, find_unoccluded};
use super::passes::{Part, Pass, Task};
use super::tile_sums::COARSE;
use super::{RenderControl, Rendering, TILE};
use crate::dispersion::residue_of;
use crate::transport::seek::View;
use crate::transport::{Contribution, NewPath, PathEnd, PathResult, PathSource};
use crate::{RenderError, Scene};
use snowgrain_film::{PixelRect, Sample};
use snowgrain_optics::BANDS;
use std::ops::Range;
use std::sync::Arc;
use std::sync::atomic::Ordering;

/// Samples that wait before their tile is locked.
const BATCH: usize = 64;

/// Most paths that are prepared at once.
const PREPARED: u64 = 16;

/// The paths of one thread.
pub(super) struct Stream<'a, 'film> {
    rendering: &'a Rendering<'film>,
    control: &'a RenderControl<'a>,
    /// Pass of the last task.
    pass: Option<Arc<Pass>>,
    /// Tasks of which samples are under way, by slot; and the slots that are free.
    open: Vec<OpenTask>,
    free: Vec<u32>,
    dealing: Option<Dealing>,
    /// Band of wavelengths of all paths that are under way, 0 where light is not parted.
    band: usize,
    /// The next task, of another band.
    held: Option<Task>,
    /// Paths that are prepared, the next one last.
    ready: Vec<NewPath<Tag>>,
    dry: bool,
    /// Whether rays of the camera may start in ice.
    may_start_in_ice: bool,
}

/// A task of which samples are under way.
struct OpenTask {
    pass: Arc<Pass>,
    tile: usize,
    /// Paths that are under way, and whether there are no more to come.
    under_way: u32,
    dealt: bool,
    /// Paths so far.
    paths: u64,
    /// What waits.
    batch: Batch,
}

/// The task whose paths are being dealt out: pixel by pixel in Morton order, so that paths that are
/// under way together meet the same grains.
struct Dealing {
    slot: u32,
    rect: PixelRect,
    part: Part,
    samples: Range<u64>,
    /// From one sample of a pixel to the next of the same band.
    step: u64,
    /// Number of the pixel in Morton order, and the pixel.
    morton: u32,
    pixel: (u32, u32),
    /// The next sample.
    sample: u64,
}

/// What ties a sample to its task and pixel.
#[derive(Clone, Copy)]
pub(super) struct Tag {
    slot: u32,
    x: u32,
    y: u32,
    sample: u64,
    /// Place in the image, pixels, and on the lens.
    image: [f64; 2],
    lens: [f64; 2],
}

impl PathSource for Stream<'_, '_> {
    type Tag = Tag;

    fn next_path(&mut self) -> Option<NewPath<Tag>> {
        if self.ready.is_empty() && !self.prepare() {
            return None;
        }
        self.ready.pop()
    }

    fn view(&self, tag: Tag) -> Option<View> {
        let (image, lens) = (tag.image, tag.lens);
        Some(View { bundle: self.rendering.scene.camera.bundle(lens), lens, image })
    }

    fn finish(&mut self, tag: Tag, path: &PathResult) {
        self.finish_with_light(tag, path, &[]);
    }

    fn finish_with_light(&mut self, tag: Tag, path: &PathResult, found: &[Contribution]) {
        let Tag { slot, x, y, sample, .. } = tag;
        if path.end == PathEnd::Enclosed {
            self.rendering.fail(RenderError::Enclosed { x, y });
        }
        let scene = self.rendering.scene;
        let task = &mut self.open[slot as usize];
        task.batch.statistics.count(path);
        let radiance = task.batch.add_light((scene, self.band), (x, y), path, found);
        task.batch.samples.push(((x, y), sample_of(scene, path, radiance)));
        if path.first_hit.is_some_and(|hit| hit.is_shadow_catcher) {
            let (pixel, lit, unoccluded) = ((x, y), radiance, [0.0; 3]);
            task.batch.caught.push(Caught { pixel, sample, lit, unoccluded });
        }
        task.under_way -= 1;
        if task.batch.samples.len() == BATCH {
            self.flush_task(slot);
        }
        self.close_if_done(slot);
    }
}

impl<'a, 'film> Stream<'a, 'film> {
    pub(super) fn new(rendering: &'a Rendering<'film>, control: &'a RenderControl<'a>) -> Self {
        Self {
            rendering,
            control,
            pass: None,
            open: Vec::new(),
            free: Vec::new(),
            dealing: None,
            band: 0,
            held: None,
            ready: Vec::with_capacity(PREPARED as usize),
            dry: false,
            may_start_in_ice: rendering.scene.may_start_in_ice(),
        }
    }

    /// Band of wavelengths of its paths.
    pub(super) fn band(&self) -> usize {
        self.band
    }

    /// Once no path is under way: goes on to the band of the next task; `false` where there is none.
    pub(super) fn turn_to_next_band(&mut self) -> bool {
        let next = self.held.as_ref().filter(|_| !self.dry);
        next.map(|task| self.band = task.band).is_some()
    }

    /// Adds what waits; the samples of tasks that were stopped half-way are left where they are.
    pub(super) fn flush(&mut self) {
        for slot in 0..self.open.len() as u32 {
            self.flush_task(slot);
        }
    }

    /// Prepares some paths at once, which takes half the time of one by one: what each waits for, others
    /// fill. `false` where there are no more.
    fn prepare(&mut self) -> bool {
        while self.dealing.as_ref().is_none_or(|dealing| dealing.sample >= dealing.samples.end) {
            if !self.go_on() {
                return false;
            }
        }
        let Some(dealing) = &mut self.dealing else { return false };
        let scene = self.rendering.scene;
        let (slot, (x, y)) = (dealing.slot, dealing.pixel);
        let (first, step) = (dealing.sample, dealing.step);
        let count = (dealing.samples.end - first).div_ceil(step).min(PREPARED);
        dealing.sample = first.saturating_add(count * step);
        self.open[slot as usize].under_way += count as u32;
        let (rendering, may_start_in_ice) = (self.rendering, self.may_start_in_ice);
        // Backwards, as they are taken from the end.
        self.ready.extend((0..count).rev().map(|number| {
            let sample = first + number * step;
            let path = CameraPath::of(scene, (x, y), sample);
            let CameraPath { ray, key, event, image, lens } = path;
            // Such a path would be taken for one in air.
            if may_start_in_ice && scene.world.grid.is_inside_grain(ray.origin) {
                rendering.fail(RenderError::CameraInIce { point: ray.origin });
            }
            let tag = Tag { slot, x, y, sample, image, lens };
            NewPath { tag, ray, key, event }
        }));
        true
    }

    /// Goes on to the next pixel, or towards the next task; `false` where there are no more paths.
    fn go_on(&mut self) -> bool {
        if self.is_stopped() {
            return false;
        }
        let Some(dealing) = &mut self.dealing else { return !self.dry && self.take_task() };
        if dealing.next_pixel() {
            dealing.sample = first_sample(self.rendering.scene, self.band, dealing);
        } else {
            let slot = dealing.slot;
            self.dealing = None;
            self.open[slot as usize].dealt = true;
            self.close_if_done(slot);
        }
        true
    }

    /// Whether no more paths are wanted.
    fn is_stopped(&mut self) -> bool {
        let stopped = self.control.stop.load(Ordering::Relaxed)
            || self.rendering.failed.load(Ordering::Relaxed);
        if stopped {
            self.dry = true;
            self.dealing = None;
        }
        stopped
    }

    fn take_task(&mut self) -> bool {
        let next = self.held.take().or_else(|| self.rendering.passes.take(&mut self.pass));
        let Some(task) = next else {
            self.dry = true;
            return false;
        };
        if task.band != self.band {
            self.held = Some(task);
            return false;
        }
        let Task { pass, tile, part, band } = task;
        let rect = self.rendering.tiles[tile].rect;
        let open =
            OpenTask { pass, tile, under_way: 0, dealt: false, paths: 0, batch: Batch::default() };
        let slot = self.slot_for(open);
        let samples = part.samples().clone();
        let mut dealing = Dealing {
            slot,
            rect,
            part,
            sample: samples.start,
            samples,
            step: if self.rendering.scene.bands.is_empty() { 1 } else { BANDS as u64 },
            morton: 0,
            pixel: (rect.x0, rect.y0),
        };
        dealing.sample = first_sample(self.rendering.scene, band, &dealing);
        if !dealing.has_pixel() {
            // The corner belongs to the coarse part.
            dealing.sample = dealing.samples.end;
        }
        self.dealing = Some(dealing);
        true
    }

    fn slot_for(&mut self, mut task: OpenTask) -> u32 {
        match self.free.pop() {
            Some(slot) => {
                // The memory of the samples is used again.
                task.batch = std::mem::take(&mut self.open[slot as usize].batch);
                self.open[slot as usize] = task;
                slot
            }
            None => {
                task.batch.samples.reserve_exact(BATCH);
                self.open.push(task);
                self.open.len() as u32 - 1
            }
        }
    }

    fn close_if_done(&mut self, slot: u32) {
        let task = &self.open[slot as usize];
        if !task.dealt || task.under_way > 0 {
            return;
        }
        self.flush_task(slot);
        let task = &self.open[slot as usize];
        self.control.samples_done.fetch_add(task.paths, Ordering::Relaxed);
        if !self.rendering.failed.load(Ordering::Relaxed)
            && let Some(samples) = self.rendering.passes.done(&task.pass)
        {
            (self.control.after_pass)(samples);
        }
        self.free.push(slot);
    }

    /// Adds the samples of a task that wait.
    fn flush_task(&mut self, slot: u32) {
        let task = &mut self.open[slot as usize];
        if task.batch.samples.is_empty() {
            return;
        }
        if !task.batch.caught.is_empty() {
            let (scene, level) = (self.rendering.scene, self.rendering.settings.level);
            if let Err(fault) = find_unoccluded(scene, (self.band, level), &mut task.batch.caught) {
                self.rendering.fail(fault);
            }
        }
        let mut tile = self.rendering.tiles[task.tile].lock();
        let complete = self.rendering.passes_to_settle();
        let added = tile.add(task.pass.index, &task.batch, complete);
        drop(tile);
        if let Err(fault) = added {
            self.rendering.fail(fault.into());
        }
        task.paths += task.batch.samples.len() as u64;
        task.batch.clear();
    }
}

/// The first sample of the pixel at hand that belongs to a band.
fn first_sample(scene: &Scene, band: usize, dealing: &Dealing) -> u64 {
    let start = dealing.samples.start;
    if scene.bands.is_empty() {
        return start;
    }
    let (x, y) = dealing.pixel;
    let stream = u64::from(y) * u64::from(scene.film.width) + u64::from(x);
    let residue = residue_of(scene.film.seed, stream, band);
    start.saturating_add((residue + BANDS as u64 - start % BANDS as u64) % BANDS as u64)
}

/// A path as a sample of this radiance.
fn sample_of(scene: &Scene, path: &PathResult, radiance: [f32; 3]) -> Sample {
    match path.first_hit {
        None => Sample { radiance, alpha: 0.0, depth: f32::INFINITY, ..Sample::default() },
        Some(hit) => Sample {
            radiance,
            alpha: if hit.is_shadow_catcher { 0.0 } else { 1.0 },
            albedo: hit.albedo,
            normal: hit.normal.to_array().map(|v| v as f32),
            depth: scene.camera.depth(hit.position) as f32,
        },
    }
}

impl Dealing {
    /// Goes on to the next pixel, if there is one.
    fn next_pixel(&mut self) -> bool {
        while self.morton + 1 < TILE * TILE {
            self.morton += 1;
            self.pixel =
                (self.rect.x0 + even_bits(self.morton), self.rect.y0 + even_bits(self.morton >> 1));
            if self.has_pixel() {
                return true;
            }
        }
        false
    }

    /// Whether the pixel is in the tile and belongs to the part.
    fn has_pixel(&self) -> bool {
        let (x, y) = self.pixel;
        let is_coarse =
            (x - self.rect.x0).is_multiple_of(COARSE) && (y - self.rect.y0).is_multiple_of(COARSE);
        self.rect.contains(x, y)
            && match self.part {
                Part::Coarse(_) => is_coarse,
                Part::Rest(_) => !is_coarse,
                Part::Whole(_) => true,
            }
    }
}

/// The bits 0, 2, 4, 6 of a number under 256, together.
fn even_bits(number: u32) -> u32 {
    let bits = number & 0x55;
    let pairs = (bits | bits >> 1) & 0x33;
    (pairs | pairs >> 2) & 0xf
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn morton_order_meets_every_pixel_of_a_tile_once() {
        let mut seen = [false; (TILE * TILE) as usize];
        for morton in 0..TILE * TILE {
            let (x, y) = (even_bits(morton), even_bits(morton >> 1));
            assert!(x < TILE && y < TILE);
            assert!(!std::mem::replace(&mut seen[(y * TILE + x) as usize], true));
        }
    }
}
