//! A grey picture of a patch of snow, and what it measures.

use anyhow::{Context as _, Result, ensure};
use snowgrain_film::{Layer, Picture};

/// Radiance of green, which is close to luminance, and the variance of its noise, over rows of pixels.
pub(super) struct Patch {
    pub(super) width: usize,
    pub(super) values: Vec<f64>,
    pub(super) variance: Vec<f64>,
}

impl Patch {
    /// # Errors
    /// A picture without light or without its variance.
    pub(super) fn of(picture: &Picture) -> Result<Self> {
        let layer = |layer: Layer| {
            let values = picture.layer(layer).with_context(|| layer.name())?;
            Ok::<Vec<f64>, anyhow::Error>(values.iter().map(|&x| f64::from(x)).collect())
        };
        let (values, variance) = (layer(Layer::G)?, layer(Layer::VarianceG)?);
        ensure!(variance.iter().all(|x| x.is_finite()), "the variance is not known");
        Ok(Self { width: picture.window().width() as usize, values, variance })
    }

    pub(super) fn mean(&self) -> f64 {
        mean(&self.values)
    }

    /// Standard deviation over mean, after noise and all structure wider than `side` (odd) pixels is taken
    /// away; below 0 where there is less of it than of noise that was taken away.
    ///
    /// From each pixel the mean of the square about it is taken (at the rim of what there is of it). Of n
    /// pixels with noise of one variance v that leaves v (1 - 1/n).
    pub(super) fn contrast(&self, side: usize) -> f64 {
        let height = self.values.len() / self.width;
        let (mut signal, mut noise) = (0.0, 0.0);
        for (y, x) in (0..height).flat_map(|y| (0..self.width).map(move |x| (y, x))) {
            let about =
                |at: usize, size: usize| at.saturating_sub(side / 2)..(at + side / 2 + 1).min(size);
            let (rows, columns) = (about(y, height), about(x, self.width));
            let count = (rows.len() * columns.len()) as f64;
            let sum: f64 = rows
                .map(|row| {
                    let row = &self.values[row * self.width..][..self.width];
                    row[columns.clone()].iter().sum::<f64>()
                })
                .sum();
            let pixel = y * self.width + x;
            let above = self.values[pixel] - sum / count;
            signal += above * above;
            noise += self.variance[pixel] * (1.0 - 1.0 / count);
        }
        let excess = (signal - noise) / self.values.len() as f64;
        excess.signum() * excess.abs().sqrt() / self.mean()
    }

    /// Means of the columns.
    pub(super) fn columns(&self) -> Vec<f64> {
        let height = self.values.len() / self.width;
        let column = |x: usize| (0..height).map(|y| self.values[y * self.width + x]).sum::<f64>();
        (0..self.width).map(|x| column(x) / height as f64).collect()
    }
}

/// The mean of values.
pub(super) fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len() as f64
}

/// How far apart a falling or rising edge passes two levels between 0 and 1, in steps of its values; each
/// place is where the edge first passes the level, coming from its lower end, between two values.
pub(super) fn edge_width(edge: &[f64], levels: [f64; 2]) -> Option<f64> {
    let rising = edge.last()? > edge.first()?;
    let edge: Vec<f64> = if rising { edge.to_vec() } else { edge.iter().rev().copied().collect() };
    let place = |level: f64| {
        let at = edge.windows(2).position(|pair| pair[0] < level && pair[1] >= level)?;
        Some(at as f64 + (level - edge[at]) / (edge[at + 1] - edge[at]))
    };
    Some(place(levels[1])? - place(levels[0])?)
}

#[cfg(test)]
mod tests {
    use super::*;
    use snowgrain_math::sampler::pcg3d;

    /// Independent numbers between 0 and 1.
    fn noise(count: u32) -> Vec<f64> {
        (0..count).map(|n| f64::from(pcg3d(n, 0, 0)[0]) / f64::from(u32::MAX)).collect()
    }

    #[test]
    fn noise_and_wide_structure_are_no_contrast_and_grains_are() {
        let noise = noise(4096);
        let slope = |pixel: usize| 1.0 + 1e-3 * (pixel % 64) as f64;
        let values: Vec<f64> = (0..4096).map(|pixel| slope(pixel) + 0.2 * noise[pixel]).collect();
        let variance = vec![0.04 / 12.0; 4096];
        let patch = Patch { width: 64, values, variance };
        assert!(patch.contrast(9).abs() < 0.02, "{}", patch.contrast(9));
        let seen = Patch { variance: vec![0.0; 4096], ..patch };
        let expected = 0.2 / 12.0f64.sqrt() / seen.mean();
        assert!((seen.contrast(9) / expected - 1.0).abs() < 0.05, "{}", seen.contrast(9));
    }

    #[test]
    fn the_width_of_a_ramp_is_known_whichever_way_it_goes() {
        let mut ramp = [0.0, 0.0, 0.25, 0.5, 0.75, 1.0, 1.0];
        assert_eq!(edge_width(&ramp, [0.25, 0.75]), Some(2.0));
        ramp.reverse();
        assert_eq!(edge_width(&ramp, [0.25, 0.75]), Some(2.0));
        assert_eq!(edge_width(&ramp, [0.25, 1.75]), None);
    }
}
