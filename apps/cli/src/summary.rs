//! The figures of a run, for people and for programs.

use crate::budget::readable_bytes;
use crate::process::{self, Spent};
use serde::Serialize;
use snowgrain_render::description::Packing;
use snowgrain_render::{BuildReport, BuildStage, SnowReport, Statistics};

/// Time that the stages of a build took.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct BuildTimes {
    /// Snow falling or being placed.
    pub(crate) deposit: Spent,
    /// Surfaces, and packing for light.
    pub(crate) build: Spent,
    /// What is measured of the search for light, and learnt of light deep in the snow.
    pub(crate) learning: Spent,
}

impl BuildTimes {
    /// Books the time of a stage that is over.
    pub(crate) fn book(&mut self, stage: BuildStage, spent: Spent) {
        match stage {
            BuildStage::Snow { .. } | BuildStage::Fallen { .. } => self.deposit += spent,
            BuildStage::Surfaces | BuildStage::Packing => self.build += spent,
            BuildStage::Light | BuildStage::Deep => self.learning += spent,
        }
    }
}

/// The figures that `--json-stats` holds.
#[derive(Debug, Serialize)]
pub(crate) struct RunFigures {
    pub(crate) grains: u64,
    pub(crate) grain_bytes: u64,
    pub(crate) surface_bytes: u64,
    pub(crate) peak_rss_bytes: Option<u64>,
    pub(crate) deposit_seconds: f64,
    pub(crate) deposit_cpu_seconds: f64,
    pub(crate) build_seconds: f64,
    pub(crate) build_cpu_seconds: f64,
    /// Of the search for light, and of light deep in the snow.
    pub(crate) learning_seconds: f64,
    pub(crate) learning_cpu_seconds: f64,
    pub(crate) render_seconds: f64,
    pub(crate) render_cpu_seconds: f64,
    pub(crate) samples: u64,
    pub(crate) samples_per_pixel: u64,
    pub(crate) complete: bool,
    /// Where a noise was asked for.
    pub(crate) noise: Option<NoiseFigures>,
    pub(crate) paths_in_snow: u64,
    pub(crate) interface_events: u64,
    pub(crate) grain_visits: u64,
    pub(crate) surface_bounces: u64,
    pub(crate) trapped_paths: u64,
    pub(crate) rays: u64,
    /// Of all pixels, linear; `None` where no pass was completed.
    pub(crate) mean_radiance: Option<[f64; 3]>,
    pub(crate) snowfalls: Vec<Option<SnowfallFigures>>,
    /// Cells of what light brings from deep in the snow, where that was learnt, and bytes that they take.
    pub(crate) learnt_cells: Option<u64>,
    pub(crate) learnt_bytes: Option<u64>,
    /// Relative standard error of the learnt light of the whole picture.
    pub(crate) learnt_relative_error: Option<f64>,
    /// How grains were packed: "fast" or "compact".
    pub(crate) packing: &'static str,
    pub(crate) threads: usize,
    pub(crate) simd: String,
    pub(crate) version: &'static str,
    pub(crate) scene_hash: String,
}

/// What became of a wanted noise; `samples_per_pixel` of the run is that of the noisiest block.
#[derive(Clone, Copy, Debug, Serialize)]
pub(crate) struct NoiseFigures {
    pub(crate) target: f64,
    /// Of all blocks, as their samples say; `None` where a pixel has fewer than two.
    pub(crate) largest_relative_error: Option<f64>,
    pub(crate) samples_per_pixel_least: u64,
    pub(crate) samples_per_pixel_mean: f64,
    pub(crate) blocks: u64,
    /// Of these, those that would need more samples than were allowed.
    pub(crate) blocks_held_back: u64,
    /// Samples of all pixels together that are not part of the picture.
    pub(crate) pilot_samples: u64,
    pub(crate) pilot_seconds: f64,
    pub(crate) pilot_cpu_seconds: f64,
}

/// What became of the grains of one snowfall.
#[derive(Clone, Debug, Serialize)]
pub(crate) struct SnowfallFigures {
    pub(crate) accepted: u64,
    pub(crate) discarded: u64,
    pub(crate) missed: u64,
    pub(crate) unsettled: u64,
    /// How the density asked for was reached, where one was.
    pub(crate) density: Option<DensityFigures>,
}

/// How a density was reached; kg/m^3.
#[derive(Clone, Debug, Serialize)]
pub(crate) struct DensityFigures {
    pub(crate) asked: f64,
    /// Measured where the snow lies, or of the pack, or of the last pilot.
    pub(crate) reached: f64,
    pub(crate) by: String,
}

impl DensityFigures {
    fn line(&self) -> String {
        let Self { asked, reached, by } = self;
        format!("density {asked} kg/m3 asked for, {reached:.1} by {by}")
    }
}

impl SnowfallFigures {
    /// `ratio`: density of the grains' substance by that of ice, as which reports count.
    fn of(report: &SnowReport, ratio: f64) -> Option<Self> {
        match report {
            SnowReport::Fell(fall) => Some(Self {
                accepted: fall.accepted,
                discarded: fall.discarded,
                missed: fall.missed,
                unsettled: fall.unsettled,
                density: fall.reached.map(|reached| DensityFigures {
                    asked: as_asked(reached.asked * ratio),
                    reached: reached.density() * ratio,
                    by: reached.settling.to_string(),
                }),
            }),
            SnowReport::Filled(pack) => Some(Self {
                accepted: pack.grains,
                discarded: 0,
                missed: 0,
                unsettled: 0,
                density: Some(DensityFigures {
                    asked: as_asked(pack.asked * ratio),
                    reached: pack.density * ratio,
                    by: pack.method.to_string(),
                }),
            }),
            SnowReport::Placed => None,
        }
    }
}

/// A density as it was written, before it was counted as that of ice and back.
fn as_asked(density: f64) -> f64 {
    (density * 1e6).round() / 1e6
}

/// The figures of all bodies of snow, of grains of a substance whose density by that of ice is `ratio`; `None` for
/// snow that was placed.
pub(crate) fn snowfalls(reports: &[SnowReport], ratio: f64) -> Vec<Option<SnowfallFigures>> {
    reports.iter().map(|report| SnowfallFigures::of(report, ratio)).collect()
}

/// How the densities asked for were reached, a line each.
pub(crate) fn density_lines(
    snowfalls: &[Option<SnowfallFigures>],
) -> impl Iterator<Item = String> + '_ {
    snowfalls.iter().flatten().filter_map(|fall| fall.density.as_ref()).map(DensityFigures::line)
}

/// What a render did, as its parts report it.
pub(crate) struct Run<'a> {
    pub(crate) report: &'a BuildReport,
    /// Density of the grains' substance by that of ice.
    pub(crate) density_ratio: f64,
    pub(crate) scene_hash: &'a [u8; 32],
    pub(crate) times: BuildTimes,
    pub(crate) render: Spent,
    pub(crate) statistics: &'a Statistics,
    pub(crate) samples_per_pixel: u64,
    pub(crate) complete: bool,
    pub(crate) noise: Option<NoiseFigures>,
    pub(crate) mean_radiance: Option<[f64; 3]>,
    pub(crate) packing: Packing,
    pub(crate) threads: usize,
    pub(crate) simd: String,
}

impl Run<'_> {
    pub(crate) fn figures(&self) -> RunFigures {
        let (report, counts) = (self.report, self.statistics);
        RunFigures {
            grains: report.grains,
            grain_bytes: report.grain_bytes,
            surface_bytes: report.surface_bytes,
            peak_rss_bytes: process::peak_memory(),
            deposit_seconds: self.times.deposit.wall,
            deposit_cpu_seconds: self.times.deposit.cpu,
            build_seconds: self.times.build.wall,
            build_cpu_seconds: self.times.build.cpu,
            learning_seconds: self.times.learning.wall,
            learning_cpu_seconds: self.times.learning.cpu,
            render_seconds: self.render.wall,
            render_cpu_seconds: self.render.cpu,
            samples: counts.paths,
            samples_per_pixel: self.samples_per_pixel,
            complete: self.complete,
            noise: self.noise,
            paths_in_snow: counts.paths_in_snow,
            interface_events: counts.interface_events,
            grain_visits: counts.grain_visits,
            surface_bounces: counts.surface_bounces,
            trapped_paths: counts.trapped_paths,
            rays: counts.rays,
            mean_radiance: self.mean_radiance,
            snowfalls: snowfalls(&report.snow, self.density_ratio),
            learnt_cells: report.learnt.map(|learnt| learnt.cells),
            learnt_bytes: report.learnt.map(|learnt| learnt.bytes),
            learnt_relative_error: report.learnt.map(|learnt| learnt.relative_error),
            packing: match self.packing {
                Packing::Fast => "fast",
                Packing::Compact => "compact",
            },
            threads: self.threads,
            simd: self.simd.clone(),
            version: env!("CARGO_PKG_VERSION"),
            scene_hash: self.scene_hash.iter().map(|byte| format!("{byte:02x}")).collect(),
        }
    }
}

impl RunFigures {
    /// The summary, line by line.
    pub(crate) fn lines(&self) -> Vec<String> {
        let mut lines = vec![format!(
            "{} grains in {}{}; peak memory {}",
            grouped(self.grains),
            readable_bytes(self.grain_bytes),
            match self.grain_bytes.checked_div(self.grains) {
                Some(each) if each > 0 => format!(" ({each} bytes each)"),
                _ => String::new(),
            },
            self.peak_rss_bytes.map_or_else(|| "unknown".into(), readable_bytes),
        )];
        let fallen = self.snowfalls.iter().flatten();
        let (discarded, missed) =
            fallen.fold((0, 0), |sum, fall| (sum.0 + fall.discarded, sum.1 + fall.missed));
        if discarded + missed > 0 {
            lines.push(format!(
                "{} grains were discarded as too steep, {} fell past everything",
                grouped(discarded),
                grouped(missed)
            ));
        }
        lines.extend(density_lines(&self.snowfalls));
        if let (Some(cells), Some(bytes)) = (self.learnt_cells, self.learnt_bytes) {
            lines.push(format!(
                "light from deep in the snow learnt in {} cells, {}",
                grouped(cells),
                readable_bytes(bytes)
            ));
        }
        lines.push(format!(
            "snow {}, surfaces and packing {}, learning {}, rendering {}",
            seconds(self.deposit_seconds, self.deposit_cpu_seconds),
            seconds(self.build_seconds, self.build_cpu_seconds),
            seconds(self.learning_seconds, self.learning_cpu_seconds),
            seconds(self.render_seconds, self.render_cpu_seconds),
        ));
        let per_second = self.interface_events as f64 / self.render_cpu_seconds.max(1e-9);
        lines.push(format!(
            "{} samples a pixel, {} paths, {} grain visits, {:.1} million interfaces a CPU second, \
             {} trapped",
            self.samples_per_pixel,
            grouped(self.samples),
            grouped(self.grain_visits),
            per_second * 1e-6,
            self.trapped_paths,
        ));
        lines.extend(self.noise.as_ref().map(|noise| noise.line(self.samples_per_pixel)));
        if let Some([r, g, b]) = self.mean_radiance {
            lines.push(format!("mean radiance {r:.5} {g:.5} {b:.5}"));
        }
        lines
    }
}

impl NoiseFigures {
    fn line(&self, most: u64) -> String {
        let held_back = match self.blocks_held_back {
            0 => String::new(),
            blocks => format!("; {blocks} of {} blocks need more than --spp", self.blocks),
        };
        format!(
            "noise target {}: {} to {most} samples a pixel, {:.1} on average, largest relative error \
             {}{held_back}; the pilot took {}",
            self.target,
            self.samples_per_pixel_least,
            self.samples_per_pixel_mean,
            self.largest_relative_error.map_or_else(|| "unknown".into(), |e| format!("{e:.4}")),
            seconds(self.pilot_seconds, self.pilot_cpu_seconds),
        )
    }
}

fn seconds(wall: f64, cpu: f64) -> String {
    format!("{wall:.2} s ({cpu:.2} s CPU)")
}

/// A number with its thousands apart: `1 000 000`.
pub(crate) fn grouped(number: u64) -> String {
    let digits = number.to_string();
    let first = digits.len() % 3;
    let mut text = String::with_capacity(digits.len() * 4 / 3);
    for (index, digit) in digits.chars().enumerate() {
        if index > 0 && index % 3 == first {
            text.push(' ');
        }
        text.push(digit);
    }
    text
}

#[cfg(test)]
mod tests {
    use super::grouped;

    #[test]
    fn thousands_stand_apart() {
        assert_eq!(grouped(0), "0");
        assert_eq!(grouped(999), "999");
        assert_eq!(grouped(1000), "1 000");
        assert_eq!(grouped(12_345_678), "12 345 678");
        assert_eq!(grouped(123_456), "123 456");
    }
}
