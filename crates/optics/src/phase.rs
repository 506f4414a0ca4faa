//! The phase function of a grain as a table: how much of the light on it goes into each direction.

use crate::Dielectric;
use crate::sphere::{Impact, Polarisation};
use snowgrain_math::trig;

/// Parts of the disc over which a grain is summed. Within one, the cosine of each order is taken to run
/// evenly from one end to the other.
const PARTS: u32 = 1 << 14;
/// Orders end where less of a ray is left.
const LEAST_LIGHT: f64 = 1e-7;

/// The phase function of a grain without diffraction, for several absorptions of its ice.
///
/// Its mean over all directions is the single-scattering albedo, 1 where nothing is absorbed, less what goes
/// straight through.
#[derive(Clone, Debug, PartialEq)]
pub struct PhaseTable {
    absorptions: usize,
    bins: usize,
    /// Of each bin of the cosine, from -1 up, the values for all absorptions.
    values: Vec<f32>,
    /// Bins for each unit of the cosine.
    scale: f32,
    /// For each absorption what goes straight through.
    straight: Vec<f64>,
}

impl PhaseTable {
    /// The table for ice of which a grain radius absorbs so much (gamma r, >= 0), in `bins` (at least 1)
    /// equal bins of the cosine of the scattering angle, that is of the solid angle.
    #[must_use]
    pub fn new(
        medium: Dielectric,
        polarisation: Polarisation,
        absorptions: &[f64],
        bins: usize,
    ) -> Self {
        let bins = bins.max(1);
        let mut sums = vec![0.0; bins * absorptions.len()];
        let edge = |part: u32| Impact::at_disc_fraction(medium, f64::from(part) / f64::from(PARTS));
        let mut from = edge(0);
        for part in 0..PARTS {
            let to = edge(part + 1);
            let u = (f64::from(part) + 0.5) / f64::from(PARTS);
            let middle = Impact::at_disc_fraction(medium, u);
            for reflectance in reflectances(medium, polarisation, &middle) {
                add_orders(&mut sums, reflectance, [&from, &middle, &to], absorptions);
            }
            from = to;
        }
        Self::of_energies(&sums, bins, vec![0.0; absorptions.len()])
    }

    /// The table of grains that turned light so: cosine of the angle, exactly 1 where it went straight through, and
    /// length in radii, each with the same part of the energy. Nothing at all where there is no light.
    #[must_use]
    pub fn of_samples(
        light: impl ExactSizeIterator<Item = (f32, f64)>,
        absorptions: &[f64],
        bins: usize,
    ) -> Self {
        let bins = bins.max(1);
        let (count, part) = (absorptions.len(), 1.0 / light.len().max(1) as f64);
        let (mut sums, mut straight) = (vec![0.0; bins * count], vec![0.0; count]);
        for (cosine, length) in light {
            let bin = ((0.5 * (f64::from(cosine) + 1.0) * bins as f64) as usize).min(bins - 1);
            let sums = match cosine {
                1.0 => &mut straight[..],
                _ => &mut sums[bin * count..(bin + 1) * count],
            };
            for (sum, absorption) in sums.iter_mut().zip(absorptions) {
                *sum += part * trig::exp(-absorption * length);
            }
        }
        Self::of_energies(&sums, bins, straight)
    }

    /// Of parts of the energy, of which a bin has 1/bins of all directions.
    fn of_energies(sums: &[f64], bins: usize, straight: Vec<f64>) -> Self {
        Self {
            absorptions: straight.len(),
            bins,
            values: sums.iter().map(|sum| (sum * bins as f64) as f32).collect(),
            scale: (0.5 * bins as f64) as f32,
            straight,
        }
    }

    /// For each absorption the part of the light on a grain that goes straight through it and is not absorbed: none
    /// of it is in the table.
    #[must_use]
    pub fn straight(&self) -> &[f64] {
        &self.straight
    }

    /// Its values for all absorptions at a cosine of the scattering angle, in [-1, 1].
    #[inline]
    #[must_use]
    pub fn at(&self, cosine: f32) -> &[f32] {
        // The conversion takes what lies below the first bin to it.
        let bin = (((cosine + 1.0) * self.scale) as usize).min(self.bins - 1);
        &self.values[bin * self.absorptions..(bin + 1) * self.absorptions]
    }
}

/// The two reflectances that share the light of a ray.
fn reflectances(medium: Dielectric, polarisation: Polarisation, impact: &Impact) -> [f64; 2] {
    match polarisation {
        Polarisation::Redrawn => [impact.reflectance; 2],
        Polarisation::Tracked => {
            medium.polarised_reflectances_from_outside(trig::sin_cos(impact.theta_i).1)
        }
    }
}

/// Adds the orders of half of the light on a part of the disc, which is given by its ends and middle.
fn add_orders(
    sums: &mut [f64],
    reflectance: f64,
    [from, middle, to]: [&Impact; 3],
    absorptions: &[f64],
) {
    let mut left = 0.5 / f64::from(PARTS);
    let mut energy = reflectance;
    for order in 0.. {
        let length = f64::from(order) * middle.chord();
        let cosines = [from, to].map(|end| trig::sin_cos(end.deflection(order)).1);
        let weights = absorptions.iter().map(|a| left * energy * trig::exp(-a * length));
        spread(sums, cosines, &weights.collect::<Vec<f64>>());
        left *= 1.0 - energy;
        energy = 1.0 - reflectance;
        if left * f64::from(PARTS) < LEAST_LIGHT {
            break;
        }
    }
}

/// Spreads energies evenly over the bins between two cosines.
fn spread(sums: &mut [f64], [a, b]: [f64; 2], energies: &[f64]) {
    let bins = sums.len() / energies.len().max(1);
    let place = |cosine: f64| (0.5 * (cosine + 1.0) * bins as f64).clamp(0.0, bins as f64);
    let [low, high] = [place(a.min(b)), place(a.max(b))];
    let (first, last) = ((low as usize).min(bins - 1), (high as usize).min(bins - 1));
    for bin in first..=last {
        let covered = high.min((bin + 1) as f64) - low.max(bin as f64);
        // What has no width lies in one bin.
        let part = if high > low { covered / (high - low) } else { 1.0 };
        let sums = &mut sums[bin * energies.len()..(bin + 1) * energies.len()];
        for (sum, energy) in sums.iter_mut().zip(energies) {
            *sum += part * energy;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sphere;

    fn means(table: &PhaseTable, bins: u32) -> [f64; 2] {
        let mut means = [0.0; 2];
        for bin in 0..bins {
            let cosine = (f64::from(bin) + 0.5) * 2.0 / f64::from(bins) - 1.0;
            let value = f64::from(table.at(cosine as f32)[0]) / f64::from(bins);
            means = [means[0] + value, means[1] + value * cosine];
        }
        means
    }

    #[test]
    fn the_mean_is_the_albedo_and_the_mean_cosine_the_asymmetry() {
        let ice = Dielectric { eta: 1.31 };
        for polarisation in [Polarisation::Redrawn, Polarisation::Tracked] {
            let [all, asymmetry] = means(&PhaseTable::new(ice, polarisation, &[0.0], 4096), 4096);
            let g = match polarisation {
                Polarisation::Redrawn => sphere::asymmetry(ice),
                Polarisation::Tracked => sphere::asymmetry_of_polarised(ice),
            };
            assert!((all - 1.0).abs() < 1e-5, "{all}");
            assert!((asymmetry - g).abs() < 1e-4, "{asymmetry} {g}");
        }
        for absorption in [0.001, 0.1, 1.0] {
            let table = PhaseTable::new(ice, Polarisation::Redrawn, &[absorption], 512);
            let lost = 1.0 - means(&table, 512)[0];
            let expected = sphere::co_albedo(ice, absorption);
            assert!((lost - expected).abs() < 2e-5, "{absorption}: {lost} {expected}");
        }
    }

    /// What goes straight through is told apart; the rest lies in its bins.
    #[test]
    fn samples_make_a_table() {
        let light = [(1.0, 1.0), (0.3, 2.0), (-1.0, 0.0), (0.3, 0.0)];
        let table = PhaseTable::of_samples(light.into_iter(), &[0.0, 0.5], 8);
        let left = |length: f64| trig::exp(-0.5 * length);
        let close = |found: &[f32], expected: [f64; 2]| {
            let near = |(one, other): (&f32, &f64)| (f64::from(*one) - other).abs() < 1e-6;
            assert!(found.iter().zip(&expected).all(near), "{found:?} {expected:?}");
        };
        assert_eq!(table.straight(), [0.25, 0.25 * left(1.0)]);
        close(table.at(0.3), [4.0, 2.0 * (left(2.0) + 1.0)]);
        close(table.at(-0.9), [2.0, 2.0]);
        close(table.at(0.9), [0.0, 0.0]);
        let sphere = PhaseTable::new(Dielectric { eta: 1.31 }, Polarisation::Redrawn, &[0.0], 8);
        assert_eq!(sphere.straight(), [0.0]);
    }

    /// Bins of 10 degrees from the fine table, against the independent figures of `sphere`'s tests.
    #[test]
    fn energies_by_angle_are_those_that_are_known() {
        let table =
            PhaseTable::new(Dielectric { eta: 1.31 }, Polarisation::Redrawn, &[0.0], 1 << 15);
        let cosine = |degrees: f64| trig::sin_cos(degrees.to_radians()).1;
        for (from, expected) in [(0.0, 0.12385), (30.0, 0.16288), (90.0, 0.00206), (130.0, 0.02856)]
        {
            let [low, high] = [cosine(from + 10.0), cosine(from)];
            let parts = 20_000u32;
            let at = |part: u32| low + (high - low) * (f64::from(part) + 0.5) / f64::from(parts);
            let mean = (0..parts).map(|part| f64::from(table.at(at(part) as f32)[0])).sum::<f64>()
                / f64::from(parts);
            let energy = 0.5 * (high - low) * mean;
            assert!((energy - expected).abs() < 3e-5, "{from}: {energy}");
        }
    }
}
