//! Renders until each block of pixels is as good as `--noise-target` asks.

use crate::failure::Failure;
use crate::process::{Spent, Stopwatch};
use crate::progress::Progress;
use crate::summary::NoiseFigures;
use rayon::ThreadPool;
use snowgrain_film::{BlockCounts, Film};
use snowgrain_render::{PILOT_SAMPLES, Pilot, RenderControl, RenderSettings, Scene, block_counts};
use std::sync::atomic::{AtomicBool, AtomicU64};

/// How many samples each block is to have, and what it cost to know.
pub(super) struct Plan {
    pilot: Pilot,
    spent: Spent,
}

impl Plan {
    /// Renders the pilot for a relative error of `target`. Until there is a picture, a signal ends the
    /// program.
    ///
    /// # Errors
    /// As those of a render.
    pub(super) fn find(
        scene: &Scene,
        settings: &RenderSettings,
        target: f64,
        pool: &ThreadPool,
        progress: &Progress,
    ) -> Result<Self, Failure> {
        let (stop, samples_done) = (AtomicBool::new(false), AtomicU64::new(0));
        let control =
            RenderControl { stop: &stop, samples_done: &samples_done, after_pass: &|_| () };
        let watch = Stopwatch::start();
        progress.note("a pilot looks how many samples each block of pixels needs");
        let pilot = progress.samples(
            &samples_done,
            settings.crop.area().saturating_mul(PILOT_SAMPLES),
            || {
                let most = scene.film.samples_per_pixel;
                pool.install(|| block_counts(scene, settings, target, most, &control))
            },
        )?;
        let pilot = pilot.ok_or_else(|| Failure::refused("the pilot was stopped"))?;
        Ok(Self { pilot, spent: watch.spent() })
    }

    /// How many samples each block is to have.
    pub(super) fn counts(&self) -> &BlockCounts {
        &self.pilot.counts
    }

    /// What the film came to.
    pub(super) fn figures(&self, film: &Film) -> NoiseFigures {
        let samples = film.pixels().iter().map(|pixel| pixel.samples());
        let worst = film.block_noise().map(|block| block.relative_error()).fold(0.0, f64::max);
        NoiseFigures {
            target: self.counts().relative_error(),
            largest_relative_error: worst.is_finite().then_some(worst),
            samples_per_pixel_least: samples.clone().min().unwrap_or(0),
            samples_per_pixel_mean: samples.sum::<u64>() as f64 / film.pixels().len() as f64,
            blocks: self.counts().counts().len() as u64,
            blocks_held_back: self.pilot.held_back,
            pilot_samples: self.pilot.statistics.paths,
            pilot_seconds: self.spent.wall,
            pilot_cpu_seconds: self.spent.cpu,
        }
    }
}
