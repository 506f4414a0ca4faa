//! A picture while it is rendered, and what is written of it.

use super::checkpoints::Checkpoints;
use super::earlier::Request;
use super::noise::Plan;
use crate::arguments::RenderArguments;
use crate::command::denoise::denoised;
use crate::command::pictures::Pictures;
use crate::failure::Failure;
use crate::output;
use crate::process::{Spent, Stopwatch};
use crate::progress::Progress;
use crate::signals::Interrupts;
use crate::summary::{BuildTimes, Run};
use rayon::ThreadPool;
use snowgrain_denoise::Denoiser;
use snowgrain_film::{BlockCounts, Film, Picture, spectral_layers};
use snowgrain_render::description::Packing;
use snowgrain_render::{
    RenderControl, RenderSettings, Rendered, Scene, Statistics, render_blocks_with,
};
use std::ops::Range;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::Instant;

/// What a render leaves.
pub(super) struct Outcome {
    /// `None` where nothing was rendered.
    film: Option<Film>,
    statistics: Statistics,
    /// Whether all that was wanted is in the film.
    complete: bool,
    /// A coarse picture, where the render was stopped before every pixel had a sample.
    preview: Option<Picture>,
}

/// A picture to be rendered.
pub(super) struct Task<'a> {
    pub(super) arguments: &'a RenderArguments,
    pub(super) scene: &'a Scene,
    pub(super) packing: Packing,
    pub(super) settings: RenderSettings,
    /// How many samples each block is to have, where blocks differ.
    pub(super) plan: Option<Plan>,
    pub(super) denoiser: Option<Denoiser>,
    pub(super) checkpoints: Checkpoints<'a>,
    pub(super) pool: &'a ThreadPool,
    pub(super) started: Instant,
}

impl Task<'_> {
    /// The samples that a pixel is to have at most.
    fn wanted(&self) -> Range<u64> {
        let counts = self.plan.as_ref().map(Plan::counts);
        let end = counts.map_or(self.settings.samples.end, |counts| counts.greatest().into());
        self.settings.samples.start..end
    }

    /// Renders what the film of an earlier run does not hold, refreshing the PNG files and saving the film.
    pub(super) fn render(
        &self,
        earlier: Option<Film>,
        pictures: &Pictures,
        interrupts: &Interrupts,
        progress: &Progress,
    ) -> Result<(Outcome, Spent), Failure> {
        let counts = self.plan.as_ref().map(Plan::counts);
        let checked = earlier.as_ref().map_or(Ok(()), |film| Request::check_counts(film, counts));
        let earlier = match checked {
            Ok(()) => earlier,
            Err(refusal) if self.arguments.resume => return Err(refusal),
            Err(_) => {
                progress.note(
                    "the film that is there had other numbers of samples; it will be replaced",
                );
                None
            }
        };
        let samples_done = AtomicU64::new(0);
        let missing = match &earlier {
            Some(film) => film.samples().missing_from(self.wanted()),
            None => vec![self.wanted()],
        };
        let total = missing.iter().map(|range| self.samples_of(range)).sum();
        interrupts.keep_what_there_is();
        let watch = Stopwatch::start();
        let mut outcome = Outcome {
            film: earlier,
            statistics: Statistics::default(),
            complete: true,
            preview: None,
        };
        progress.samples(&samples_done, total, || {
            for (index, samples) in missing.iter().enumerate() {
                let is_last = index + 1 == missing.len();
                let part = (samples.clone(), is_last);
                self.render_part(
                    part,
                    &samples_done,
                    &mut outcome,
                    (pictures, interrupts, progress),
                )?;
                if !outcome.complete {
                    break;
                }
            }
            Ok::<_, Failure>(())
        })?;
        Ok((outcome, watch.spent()))
    }

    /// Renders samples that are missing and adds them to the film; after the last of them nothing is.
    fn render_part(
        &self,
        (samples, is_last): (Range<u64>, bool),
        samples_done: &AtomicU64,
        outcome: &mut Outcome,
        (pictures, interrupts, progress): (&Pictures, &Interrupts, &Progress),
    ) -> Result<(), Failure> {
        let (limit, started) = (self.arguments.time_limit, self.started);
        let wanted = samples.end - samples.start;
        let after_pass = |done: u64| {
            let over = limit.is_some_and(|limit| started.elapsed() >= limit);
            if over && !(is_last && done == wanted) {
                interrupts.stop().store(true, Ordering::SeqCst);
            }
        };
        let control =
            RenderControl { stop: interrupts.stop(), samples_done, after_pass: &after_pass };
        let settings = RenderSettings { samples, ..self.settings.clone() };
        let earlier = outcome.film.as_ref().filter(|film| film.samples().total() > 0);
        let (rendered, preview) =
            render_blocks_with(self.scene, &settings, self.counts(), |rendering| {
                self.checkpoints.during((rendering, earlier), interrupts, progress, || {
                    pictures.refreshed((rendering, earlier), interrupts, progress, || {
                        self.pool.install(|| rendering.run(&control))
                    })
                })?;
                if rendering.samples() > 0 { Ok(None) } else { rendering.preview(None) }
            })?;
        let Rendered { film, statistics, complete } = rendered;
        outcome.statistics.add(&statistics);
        outcome.complete = complete;
        match &mut outcome.film {
            Some(whole) if film.samples().total() > 0 => whole.merge(&film)?,
            Some(_) => {}
            none => (*none, outcome.preview) = (Some(film), preview?),
        }
        Ok(())
    }

    /// Samples of a range over all pixels.
    fn samples_of(&self, range: &Range<u64>) -> u64 {
        match self.plan.as_ref().map(Plan::counts) {
            Some(counts) if range.start == 0 => counts.total(),
            _ => self.settings.crop.area().saturating_mul(range.end - range.start),
        }
    }

    fn counts(&self) -> Option<BlockCounts> {
        self.plan.as_ref().map(Plan::counts).cloned()
    }

    /// Writes everything, whatever of it fails, and tells what there is.
    pub(super) fn report(
        &self,
        pictures: &Pictures,
        interrupts: &Interrupts,
        progress: &Progress,
        Outcome { film, statistics, complete, preview }: &Outcome,
        times: BuildTimes,
        spent: Spent,
    ) -> Result<u8, Failure> {
        let film = film.as_ref();
        let samples = film.map_or(0, |film| film.samples().total());
        let mut written = Ok(());
        let mut mean_radiance = None;
        if let Some(film) = film.filter(|_| samples > 0) {
            let picture = picture_of(film, self.arguments)?;
            mean_radiance = Some(picture.mean_radiance()?);
            let picture = match &self.denoiser {
                Some(denoiser) => denoised(denoiser, &picture)?,
                None => picture,
            };
            written = interrupts.while_writing(|| pictures.write(film, &picture));
            pictures.show_last(&picture, progress);
        } else if let Some(preview) = preview {
            written = interrupts.while_writing(|| pictures.write_preview(preview));
            pictures.show_last(preview, progress);
        }
        let figures = Run {
            report: &self.scene.report,
            density_ratio: self.scene.grade.absorption.density_ratio(),
            scene_hash: &self.scene.hash,
            times,
            render: spent,
            statistics,
            samples_per_pixel: samples,
            complete: *complete,
            noise: self.plan.as_ref().zip(film).map(|(plan, film)| plan.figures(film)),
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
        let Range { start, end } = self.wanted();
        let wanted = end - start;
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
            None if !complete => {
                progress.note(&format!("ended by --time-limit {kept}"));
                Ok(0)
            }
            None => Ok(0),
        }
    }
}

/// The picture of a film, as the arguments want it.
pub(super) fn picture_of(film: &Film, arguments: &RenderArguments) -> Result<Picture, Failure> {
    let mut picture = Picture::from_film(film)?;
    if let Some(wavelengths) = &arguments.wavelengths {
        picture.spectrum = spectral_layers(film, &film.grade, None, &wavelengths.0)?;
    }
    Ok(picture)
}
