//! Whether noise explains the difference of two pictures.

use crate::{FilmError, Picture};

/// The difference of two independent renders in units of its standard deviation.
///
/// For every pixel and channel `z = (a - b) / sqrt(var a + var b)`, with the variances of the means
/// from the variance layers; `z` is 0 where the values are equal, infinite where they differ without
/// any variance. Pixels of which a variance is not known (infinite) are left out. Probabilities
/// hold for means that are close to normal: with fewer than about 64 samples a pixel of a
/// black-and-white scene alarms too often. Renders of one seed share their noise: compare different
/// seeds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ZTest {
    /// Number of values tested: three channels of every pixel whose variances are known.
    pub tests: u64,
    /// Largest |z|.
    pub largest_z: f64,
    /// Column and row of the pixel that has it.
    pub largest_at: (u32, u32),
    /// Probability that noise alone makes some |z| at least as large, with the correction of Šidák
    /// for [`ZTest::tests`] tests.
    pub pixel_probability: f64,
    /// z of the mean over all pixels, R, G, B.
    pub mean_z: [f64; 3],
    /// Chi-square of the means: the sum of the squares of [`ZTest::mean_z`].
    pub mean_chi_square: f64,
    /// Probability that noise alone makes some mean z at least as large, with the correction of
    /// Šidák for three tests.
    pub mean_probability: f64,
    /// Mean of z squared over the pixels, R, G, B: near 1 where noise alone is at work.
    pub chi_square_per_pixel: [f64; 3],
}

impl ZTest {
    /// Whether noise explains both the pixels and the mean, each at this significance: the
    /// probability of a false alarm is at most twice `significance`.
    #[must_use]
    pub fn consistent(&self, significance: f64) -> bool {
        self.pixel_probability >= significance && self.mean_probability >= significance
    }
}

/// The test, where both pictures have variance layers and some pixel known variances.
pub(super) fn z_test(picture: &Picture, reference: &Picture) -> Result<Option<ZTest>, FilmError> {
    let (Some(variance), Some(reference_variance)) = (picture.variance(), reference.variance())
    else {
        return Ok(None);
    };
    let (colour, reference_colour) = (picture.colour()?, reference.colour()?);
    let mut tests = 0;
    let (mut largest, mut at) = (0.0, 0);
    let (mut mean_z, mut chi_square) = ([0.0; 3], [0.0; 3]);
    for channel in 0..3 {
        let (mut differences, mut variances, mut pixels) = (0.0, 0.0, 0u64);
        for index in 0..colour[channel].len() {
            let difference =
                f64::from(colour[channel][index]) - f64::from(reference_colour[channel][index]);
            let noise =
                f64::from(variance[channel][index]) + f64::from(reference_variance[channel][index]);
            if !noise.is_finite() {
                continue;
            }
            pixels += 1;
            let z = ratio(difference, noise);
            differences += difference;
            variances += noise;
            chi_square[channel] += z * z;
            if z.abs() > largest {
                (largest, at) = (z.abs(), index);
            }
        }
        mean_z[channel] = ratio(differences, variances);
        chi_square[channel] /= pixels.max(1) as f64;
        tests += pixels;
    }
    if tests == 0 {
        return Ok(None);
    }
    let largest_mean = mean_z.iter().fold(0.0, |m: f64, z| m.max(z.abs()));
    Ok(Some(ZTest {
        tests,
        largest_z: largest,
        largest_at: picture.window().pixel(at),
        pixel_probability: sidak(two_sided(largest), tests),
        mean_z,
        mean_chi_square: mean_z.iter().map(|z| z * z).sum(),
        mean_probability: sidak(two_sided(largest_mean), 3),
        chi_square_per_pixel: chi_square,
    }))
}

fn ratio(difference: f64, variance: f64) -> f64 {
    if difference == 0.0 { 0.0 } else { difference / variance.sqrt() }
}

/// Probability that a standard normal variable lies at least `z` from 0.
fn two_sided(z: f64) -> f64 {
    libm::erfc(z * std::f64::consts::FRAC_1_SQRT_2)
}

/// Probability that the least of `tests` independent probabilities is at most `p`.
fn sidak(p: f64, tests: u64) -> f64 {
    -libm::expm1(tests as f64 * libm::log1p(-p))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Film, FilmIdentity, FilmTile, Layer, PixelRect, Sample};
    use snowgrain_math::sampler::{PathKey, numbers};

    /// A render of coins: every sample is 0 or 1 with probability `p` of 1.
    fn coins(side: u32, samples: u32, p: f32, seed: u64) -> Picture {
        let whole = PixelRect::new(0, 0, side, side);
        let identity = FilmIdentity { scene_hash: [0; 32], seed };
        let mut film = Film::new(side, side, whole, identity).unwrap();
        let mut tile = FilmTile::new(whole).unwrap();
        for index in 0..whole.area() as u32 {
            let (x, y) = whole.pixel(index as usize);
            for sample in 0..samples {
                let u = numbers(PathKey::new(seed, index.into(), sample.into()), 0);
                let radiance: [f32; 3] = std::array::from_fn(|c| f32::from(u8::from(u[c] < p)));
                tile.add(x, y, &Sample { radiance, ..Sample::default() }).unwrap();
            }
        }
        film.merge_tile(&tile).unwrap();
        Picture::from_film(&film).unwrap()
    }

    #[test]
    fn the_correction_is_that_of_sidak() {
        assert!((sidak(0.01, 1) - 0.01).abs() < 1e-15);
        assert!((sidak(0.1, 2) - 0.19).abs() < 1e-15);
        assert!((two_sided(1.959_963_984_540_054) - 0.05).abs() < 1e-12);
        assert_eq!(sidak(two_sided(f64::INFINITY), 1000), 0.0);
    }

    #[test]
    fn pixels_without_a_known_variance_are_left_out() {
        let (few, many) = (coins(4, 1, 0.5, 1), coins(4, 64, 0.5, 2));
        assert_eq!(z_test(&few, &many), Ok(None));
        let mut one_unknown = many.clone();
        let mut variance = many.layer(Layer::VarianceR).unwrap().to_vec();
        variance[3] = f32::INFINITY;
        one_unknown.set_layer(Layer::VarianceR, variance).unwrap();
        let test = z_test(&one_unknown, &many).unwrap().unwrap();
        assert_eq!((test.tests, test.largest_z, test.pixel_probability), (47, 0.0, 1.0));
    }

    // False alarms: 2e-6 for a right program if means were normal; the seeds are fixed, so the test
    // gives the same answer on every run.
    #[test]
    fn two_renders_of_one_scene_agree_and_of_two_scenes_do_not() {
        let first = coins(24, 256, 0.5, 1);
        let same = z_test(&first, &coins(24, 256, 0.5, 2)).unwrap().unwrap();
        assert!(same.consistent(1e-6), "{same:?}");
        // chi-square per pixel: mean 1, standard deviation sqrt(2/576) = .059; 5 of them
        assert!(same.chi_square_per_pixel.iter().all(|c| (c - 1.0).abs() < 0.3), "{same:?}");
        let other = z_test(&first, &coins(24, 256, 0.52, 3)).unwrap().unwrap();
        assert!(!other.consistent(1e-6), "{other:?}");
    }
}
