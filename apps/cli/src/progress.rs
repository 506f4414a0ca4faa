//! What is being done, on standard error: a bar on a terminal, short lines elsewhere.
//!
//! No colours are used, so that `NO_COLOR` is honoured as it is.

use crate::output::tell;
use crate::summary::grouped;
use indicatif::{ProgressBar, ProgressDrawTarget, ProgressStyle};
use snowgrain_render::BuildStage;
use snowgrain_render::description::SnowDescription;
use std::io::IsTerminal;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::mpsc::{RecvTimeoutError, channel};
use std::time::Duration;

/// Between two looks at the counter of samples.
const LOOK: Duration = Duration::from_millis(100);
/// Percent of the samples between two lines where there is no terminal.
const LINE_PERCENT: f64 = 10.0;

/// Parts into which the way of a case is divided.
const WHOLE: u64 = 1_000_000;

/// How far each of several cases is.
#[derive(Debug)]
pub(crate) struct Cases(Vec<AtomicU64>);

impl Cases {
    /// The part of the case that is done, 0 to 1; what was done stays done.
    pub(crate) fn tell(&self, case: usize, done: f64) {
        self.0[case].fetch_max((done * WHOLE as f64) as u64, Ordering::Relaxed);
    }

    fn percent(&self) -> f64 {
        let done: u64 = self.0.iter().map(|case| case.load(Ordering::Relaxed)).sum();
        100.0 * done as f64 / (WHOLE as f64 * self.0.len().max(1) as f64)
    }
}

/// Tells the user what is being done.
#[derive(Debug)]
pub(crate) struct Progress {
    shown: Shown,
    verbose: bool,
}

#[derive(Debug)]
enum Shown {
    Nothing,
    Lines,
    Bar(ProgressBar),
}

impl Progress {
    pub(crate) fn new(quiet: bool, verbose: bool) -> Self {
        let shown = if quiet {
            Shown::Nothing
        } else if std::io::stderr().is_terminal() {
            Shown::Bar(ProgressBar::with_draw_target(None, ProgressDrawTarget::stderr()))
        } else {
            Shown::Lines
        };
        Self { shown, verbose: verbose && !quiet }
    }

    /// A stage in the building of these snows begins.
    pub(crate) fn build_stage(&self, stage: BuildStage, snow: &[SnowDescription]) {
        let name = match stage {
            BuildStage::Surfaces => "surfaces".to_owned(),
            BuildStage::Packing => "packing".to_owned(),
            BuildStage::Light => "light".to_owned(),
            BuildStage::Deep => "light deep in the snow".to_owned(),
            BuildStage::Fallen { index, grains } => {
                if let Shown::Bar(bar) = &self.shown {
                    let of = format!("({} of {})", index + 1, snow.len());
                    bar.set_message(format!("snow falls {of}: {} grains", grouped(grains)));
                }
                return;
            }
            BuildStage::Snow { index } => {
                let does = match snow.get(index) {
                    Some(SnowDescription::Deposit(_)) => "falls",
                    Some(SnowDescription::Filled(_)) => "is packed",
                    _ => "is placed",
                };
                format!("snow {does} ({} of {})", index + 1, snow.len())
            }
        };
        self.stage(&name);
    }

    /// A new stage of unknown length begins.
    pub(crate) fn stage(&self, name: &str) {
        match &self.shown {
            Shown::Nothing => {}
            Shown::Lines => tell(&format!("snowgrain: {name}")),
            Shown::Bar(bar) => {
                if let Ok(style) = ProgressStyle::with_template("{spinner} {msg} ({elapsed})") {
                    bar.set_style(style);
                }
                bar.set_message(name.to_owned());
                bar.enable_steady_tick(LOOK);
            }
        }
    }

    /// Something the user should know.
    pub(crate) fn note(&self, line: &str) {
        match &self.shown {
            Shown::Nothing => {}
            Shown::Lines => tell(&format!("snowgrain: {line}")),
            Shown::Bar(bar) => bar.suspend(|| tell(&format!("snowgrain: {line}"))),
        }
    }

    /// Something that only `--verbose` asks for.
    pub(crate) fn detail(&self, line: &str) {
        if self.verbose {
            self.note(line);
        }
    }

    /// Does `work` and shows how far `done` is on its way to `total` samples.
    pub(crate) fn samples<T>(&self, done: &AtomicU64, total: u64, work: impl FnOnce() -> T) -> T {
        match &self.shown {
            Shown::Nothing => work(),
            Shown::Lines => {
                tell(&format!("snowgrain: rendering {total} samples"));
                let mut next = LINE_PERCENT;
                watching(work, || {
                    let done = done.load(Ordering::Relaxed);
                    let percent = 100.0 * done as f64 / total.max(1) as f64;
                    if percent >= next {
                        tell(&format!("snowgrain: {percent:.0} % of the samples"));
                        next = percent + LINE_PERCENT;
                    }
                })
            }
            Shown::Bar(bar) => {
                let template = "{msg} [{bar:30}] {percent:>3} %  {human_pos} of {human_len} \
                                samples  {elapsed}, {eta} to go";
                bar.disable_steady_tick();
                if let Ok(style) = ProgressStyle::with_template(template) {
                    bar.set_style(style.progress_chars("=> "));
                }
                bar.set_message("rendering");
                bar.set_length(total);
                bar.reset();
                watching(work, || bar.set_position(done.load(Ordering::Relaxed)))
            }
        }
    }

    /// Does `work` on so many cases and shows how far all of them are together.
    pub(crate) fn cases<T>(&self, name: &str, count: usize, work: impl FnOnce(&Cases) -> T) -> T {
        let cases = Cases((0..count).map(|_| AtomicU64::new(0)).collect());
        let many = if count == 1 { "1 case".into() } else { format!("{count} cases") };
        match &self.shown {
            Shown::Nothing => work(&cases),
            Shown::Lines => {
                tell(&format!("snowgrain: {name}, {many}"));
                let mut next = LINE_PERCENT;
                watching(
                    || work(&cases),
                    || {
                        let percent = cases.percent();
                        if percent >= next {
                            tell(&format!("snowgrain: {percent:.0} %"));
                            next = percent + LINE_PERCENT;
                        }
                    },
                )
            }
            Shown::Bar(bar) => {
                let template = "{msg} [{bar:30}] {percent:>3} %  {elapsed}, {eta} to go";
                bar.disable_steady_tick();
                if let Ok(style) = ProgressStyle::with_template(template) {
                    bar.set_style(style.progress_chars("=> "));
                }
                bar.set_message(format!("{name}, {many}"));
                bar.set_length(WHOLE);
                bar.reset();
                watching(
                    || work(&cases),
                    || bar.set_position((cases.percent() / 100.0 * WHOLE as f64) as u64),
                )
            }
        }
    }

    /// Takes the bar away.
    pub(crate) fn finish(&self) {
        if let Shown::Bar(bar) = &self.shown {
            bar.finish_and_clear();
        }
    }
}

/// Does `work` and looks every now and then.
fn watching<T>(work: impl FnOnce() -> T, mut look: impl FnMut() + Send) -> T {
    std::thread::scope(|scope| {
        let (working, ended) = channel::<()>();
        scope.spawn(move || {
            while ended.recv_timeout(LOOK) == Err(RecvTimeoutError::Timeout) {
                look();
            }
        });
        let result = work();
        drop(working);
        result
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cases_count_alike_and_never_go_back() {
        let cases = Cases((0..4).map(|_| AtomicU64::new(0)).collect());
        cases.tell(1, 0.5);
        cases.tell(1, 0.25);
        cases.tell(3, 1.0);
        assert_eq!(cases.percent(), 37.5);
        assert_eq!(Cases(Vec::new()).percent(), 0.0);
    }
}
