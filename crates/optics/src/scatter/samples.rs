//! Tables of grains of any shape, from light that was followed through them.

use super::{Collected, Found, ScatterTable, bin_of, solid_angle_of_bin};
use core::f64::consts::TAU;

/// Ways that are kept of each bin: the first ones, which are as good as any.
const WAYS: usize = 16;
/// Less the cosine of the angle within which light counts as not scattered: what faces that are parallel let
/// through. A table does not hold it.
const STRAIGHT: f64 = 1e-9;

/// Light that met a grain once.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Scattered {
    /// Cosine of the angle by which it was turned.
    pub cosine: f64,
    /// Angle, in the plane of both directions from that of arrival towards that in which it left, of the
    /// place where it left, seen from the centre; radians.
    pub exit: f64,
    /// Length in the grain, in radii of the sphere of equal volume.
    pub length: f64,
}

impl ScatterTable {
    /// The table of grains that scattered light so, each sample with the same part of the energy; their mean
    /// over all directions, times 4 pi, is what is not let straight through.
    #[must_use]
    pub fn of_samples(samples: &[Scattered]) -> Self {
        let mut ways = Collected::default();
        let mut counts = vec![0u32; ways.bins.len()];
        for sample in samples.iter().filter(|sample| 1.0 - sample.cosine > STRAIGHT) {
            let bin = bin_of(sample.cosine);
            counts[bin] += 1;
            if ways.bins[bin].len() < WAYS {
                let exit = [sample.exit.rem_euclid(TAU); 2];
                let length = [sample.length; 2];
                // Where it arrived is not asked for.
                let found = Found { order: 0, energy: 1.0, entry: [0.0; 2], exit, length };
                ways.bins[bin].push(found);
            }
        }
        let mut table = ways.into_table();
        let all = samples.len().max(1) as f64;
        for (bin, (density, count)) in table.densities.iter_mut().zip(counts).enumerate() {
            *density = (f64::from(count) / (all * solid_angle_of_bin(bin))) as f32;
        }
        table.accumulate();
        table
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Dielectric;
    use crate::sphere::{self, Impact};
    use snowgrain_math::sampler::{PathKey, numbers};
    use snowgrain_math::trig;

    /// Samples of a sphere give its table.
    #[test]
    fn a_sphere_of_samples_scatters_as_a_sphere() {
        let ice = Dielectric { eta: 1.31 };
        let sample = |index| {
            let [place, which, _] = numbers(PathKey::new(3, index, 0), 0).map(f64::from);
            let impact = Impact::at_disc_fraction(ice, place);
            let (mut order, mut sum) = (0, impact.energy(0));
            while which >= sum && order < 40 {
                order += 1;
                sum += impact.energy(order);
            }
            let cosine = trig::sin_cos(impact.deflection(order)).1;
            let length = f64::from(order) * impact.chord();
            Scattered { cosine, exit: 0.3, length }
        };
        let samples: Vec<_> = (0..400_000).map(sample).collect();
        let (found, expected) = (ScatterTable::of_samples(&samples), ScatterTable::for_air(ice));
        let [mut total, mut mean_cosine] = [0.0; 2];
        for part in 0..64 {
            let bins = 32 * part..32 * (part + 1);
            let energy = |table: &ScatterTable| {
                bins.clone()
                    .map(|bin| f64::from(table.densities[bin]) * solid_angle_of_bin(bin))
                    .sum::<f64>()
            };
            let (a, b) = (energy(&found), energy(&expected));
            // 5 standard errors: one seed in 30 000 fails.
            assert!((a - b).abs() < 5.0 * (b / 400_000.0).sqrt() + 1e-5, "{part}: {a} {b}");
            total += a;
            let half_sine = (f64::from(part as u32) + 0.5) / 64.0;
            mean_cosine += a * (1.0 - 2.0 * half_sine * half_sine);
        }
        assert!((total - 1.0).abs() < 1e-5, "{total}");
        assert!((mean_cosine - sphere::asymmetry(ice)).abs() < 5e-3, "{mean_cosine}");
        let mut forward = 0;
        for index in 0..10_000 {
            let random = numbers(PathKey::new(4, index, 0), 0).map(f64::from);
            let Some((cosine, _)) = found.sample(random) else { continue };
            forward += u32::from(cosine > 0.9);
        }
        let within: f64 = (0..2048)
            .take_while(|bin| f64::from(*bin) / 2048.0 < 0.05f64.sqrt())
            .map(|bin| {
                f64::from(expected.densities[bin as usize]) * solid_angle_of_bin(bin as usize)
            })
            .sum();
        assert!((f64::from(forward) / 1e4 - within).abs() < 0.03, "{forward} {within}");
        let way = found.way(0.5, [0.4, 0.9]).expect("light is scattered by 60 degrees");
        assert!((way.exit - 0.3).abs() < 1e-6 && way.length > 0.0, "{way:?}");
    }

    #[test]
    fn what_is_let_straight_through_is_left_out() {
        let through = Scattered { cosine: 1.0, exit: 0.0, length: 1.0 };
        let aside = Scattered { cosine: 0.2, exit: 0.0, length: 1.0 };
        let table = ScatterTable::of_samples(&[through, aside, aside, through]);
        let bins = 0..table.densities.len();
        let total: f64 =
            bins.map(|bin| f64::from(table.densities[bin]) * solid_angle_of_bin(bin)).sum();
        assert!((total - 0.5).abs() < 1e-6, "{total}");
    }
}
