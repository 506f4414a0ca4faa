//! What a picture measured, and how two differ.

use anyhow::{Context as _, Result, ensure};
use serde_json::Value;
use std::path::Path;

/// Pixels along an edge of a block.
const BLOCK: u32 = 16;

/// A rendered picture: the mean of the channels of each pixel, with the variance of that mean.
pub(crate) struct Film {
    width: u32,
    height: u32,
    means: Vec<f64>,
    variances: Vec<f64>,
    samples: f64,
    /// Processor seconds of one sample, and of what was learnt and measured of light before the picture.
    pub(crate) seconds_per_sample: f64,
    pub(crate) learning_seconds: f64,
    /// Processor seconds of what is made of the grains before: their cells, a medium.
    pub(crate) build_seconds: f64,
}

impl Film {
    /// The film and the figures that lie in a folder.
    pub(crate) fn read(folder: &Path) -> Result<Self> {
        let film = snowgrain_formats::read_film(&folder.join("deep.film"))?;
        let stats = std::fs::read_to_string(folder.join("stats.json"))?;
        let stats: Value = serde_json::from_str(&stats)?;
        let number = |key: &str| stats[key].as_f64().with_context(|| format!("no {key}"));
        let third = |channels: [f64; 3]| channels.iter().sum::<f64>() / 3.0;
        Ok(Self {
            width: film.width(),
            height: film.height(),
            means: film.pixels().iter().map(|pixel| third(pixel.mean_radiance())).collect(),
            // Of colours that rise and fall together.
            variances: film.pixels().iter().map(|pixel| third(pixel.variance_of_mean())).collect(),
            samples: number("samples_per_pixel")?,
            seconds_per_sample: number("render_cpu_seconds")? / number("samples")?,
            learning_seconds: number("learning_cpu_seconds")?,
            build_seconds: number("build_cpu_seconds")?,
        })
    }

    pub(crate) fn mean(&self) -> f64 {
        self.means.iter().sum::<f64>() / self.means.len() as f64
    }

    /// Variance of one sample of a pixel over the square of the mean of the picture.
    pub(crate) fn relative_variance(&self) -> f64 {
        let mean = self.mean();
        let variance = self.variances.iter().sum::<f64>() / self.variances.len() as f64;
        variance * self.samples / (mean * mean)
    }

    /// Means of blocks of so many pixels across, and the variance of each.
    fn blocks(&self, side: u32) -> Vec<[f64; 2]> {
        let mut blocks = Vec::new();
        for y0 in (0..self.height).step_by(side as usize) {
            for x0 in (0..self.width).step_by(side as usize) {
                let mut sums = [0.0; 2];
                for y in y0..y0 + side {
                    for x in x0..x0 + side {
                        let at = (y * self.width + x) as usize;
                        sums[0] += self.means[at];
                        sums[1] += self.variances[at];
                    }
                }
                let pixels = f64::from(side * side);
                blocks.push([sums[0] / pixels, sums[1] / (pixels * pixels)]);
            }
        }
        blocks
    }
}

/// Relative differences of a picture from another.
pub(crate) struct Comparison {
    pub(crate) mean: f64,
    /// Standard error of it.
    pub(crate) mean_error: f64,
    /// Root mean squares without the noise.
    pub(crate) blocks: f64,
    pub(crate) pixels: f64,
}

impl Comparison {
    pub(crate) fn of(exact: &Film, learnt: &Film) -> Result<Self> {
        ensure!(exact.means.len() == learnt.means.len(), "pictures of one size");
        ensure!(exact.width.is_multiple_of(BLOCK) && exact.height.is_multiple_of(BLOCK));
        let mean = exact.mean();
        let rms = |side: u32| {
            let pairs = exact.blocks(side).into_iter().zip(learnt.blocks(side));
            let squares = pairs.map(|([a, va], [b, vb])| (b - a) * (b - a) - va - vb);
            let count = f64::from(exact.width / side) * f64::from(exact.height / side);
            (squares.sum::<f64>() / count).max(0.0).sqrt() / mean
        };
        let all: f64 = exact.variances.iter().chain(&learnt.variances).sum();
        Ok(Self {
            mean: learnt.mean() / mean - 1.0,
            mean_error: all.sqrt() / (exact.means.len() as f64 * mean),
            blocks: rms(BLOCK),
            pixels: rms(1),
        })
    }
}
