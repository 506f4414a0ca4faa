//! The phase function of transparent spheres that are only refracted, in closed form.
//!
//! Bohren and Barkstrom 1974, "Theory of the optical properties of snow", J. Geophys. Res. 79(30): light that is
//! refracted into a large sphere and out of it again, nothing else. Their formula with its slip mended: with
//! c = cos(Theta/2) and 0 <= Theta <= 2 arccos(1/eta),
//!
//! p = T2 eta^2 (eta c - 1)(eta - c) / (T2bar c (eta^2 + 1 - 2 eta c)^2),
//!
//! T2 the mean over both polarisations of the squared transmittance of an interface, T2bar its mean over the disc of the
//! sphere. The mean of p over all directions is 1. Nishita et al. 1997, "A Modeling and Rendering Method for Snow by Using
//! Metaballs", Computer Graphics Forum 16(3), light snow by it.

use crate::Dielectric;
use core::f64::consts::PI;

/// Parts of the disc over which is summed: rings of equal area.
const PARTS: usize = 4096;

/// Light that is refracted twice by a sphere.
#[derive(Clone, Debug)]
pub struct BohrenBarkstrom {
    medium: Dielectric,
    /// Mean of the squared transmittance over the disc.
    mean_transmittance: f64,
    /// At each edge of the rings the light within, as a part of all.
    cumulative: Vec<f64>,
}

/// What a sphere made of a ray.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Refracted {
    /// Cosine of the angle by which it was turned.
    pub cosine: f64,
    /// Length in the sphere, radii.
    pub length: f64,
}

impl BohrenBarkstrom {
    /// Spheres of this relative index, above 1.
    ///
    /// # Panics
    /// If the index is not above 1.
    #[must_use]
    pub fn new(medium: Dielectric) -> Self {
        assert!(medium.eta > 1.0, "spheres that are denser than what is around them");
        let of_part = |part| squared_transmittance(medium, (part as f64 + 0.5) / PARTS as f64);
        let mut cumulative = vec![0.0; PARTS + 1];
        for part in 0..PARTS {
            cumulative[part + 1] = cumulative[part] + of_part(part) / PARTS as f64;
        }
        let mean_transmittance = cumulative[PARTS];
        cumulative.iter_mut().for_each(|sum| *sum /= mean_transmittance);
        Self { medium, mean_transmittance, cumulative }
    }

    /// Mean over the disc of the squared transmittance: the part of the light that is refracted twice.
    #[must_use]
    pub fn mean_transmittance(&self) -> f64 {
        self.mean_transmittance
    }

    /// Energy scattered into a unit of solid angle, 1/sr, at a cosine of the scattering angle.
    #[must_use]
    pub fn density(&self, cosine: f64) -> f64 {
        let eta = self.medium.eta;
        let c = (0.5 + 0.5 * cosine).max(0.0).sqrt();
        if eta * c <= 1.0 {
            return 0.0;
        }
        // A cosine of 1 is a ray through the middle: the same limit from either side.
        let square = eta * eta + 1.0 - 2.0 * eta * c;
        let u = self.disc_fraction(c);
        let transmittance = squared_transmittance(self.medium, u);
        let shape = eta * eta * (eta * c - 1.0) * (eta - c) / (c * square * square);
        transmittance * shape / (4.0 * PI * self.mean_transmittance)
    }

    /// The ray into an angle with this cosine: its length in the sphere, radii.
    #[must_use]
    pub fn length(&self, cosine: f64) -> f64 {
        let c = (0.5 + 0.5 * cosine).max(0.0).sqrt();
        self.ray(self.disc_fraction(c)).length
    }

    /// A ray of the light, by a uniform number in [0, 1).
    #[must_use]
    pub fn sample(&self, random: f64) -> Refracted {
        let part = self.cumulative.partition_point(|&sum| sum <= random).clamp(1, PARTS) - 1;
        let [from, to] = [part, part + 1].map(|edge| self.cumulative[edge]);
        self.ray((part as f64 + (random - from) / (to - from)) / PARTS as f64)
    }

    /// Square of the sine of incidence that is turned by an angle whose half has the cosine `c`: with
    /// Theta/2 = theta_i - theta_t, tan theta_i = eta sin(Theta/2) / (eta c - 1).
    fn disc_fraction(&self, c: f64) -> f64 {
        let eta = self.medium.eta;
        let (across, along) = (eta * (1.0 - c * c).max(0.0).sqrt(), (eta * c - 1.0).max(0.0));
        let square = across * across + along * along;
        if square > 0.0 { across * across / square } else { 1.0 }
    }

    /// The ray at a place of the disc.
    fn ray(&self, u: f64) -> Refracted {
        let sin2_t = u / (self.medium.eta * self.medium.eta);
        let (cos_i, cos_t) = ((1.0 - u).max(0.0).sqrt(), (1.0 - sin2_t).sqrt());
        let half = (cos_i * cos_t + (u * sin2_t).sqrt()).min(1.0);
        Refracted { cosine: 2.0 * half * half - 1.0, length: 2.0 * cos_t }
    }
}

/// Mean over both polarisations of the squared transmittance at a place of the disc.
fn squared_transmittance(medium: Dielectric, u: f64) -> f64 {
    let cosine = (1.0 - u).max(0.0).sqrt();
    let both = medium.polarised_reflectances_from_outside(cosine);
    both.map(|reflectance| 0.5 * (1.0 - reflectance) * (1.0 - reflectance)).iter().sum()
}

#[cfg(test)]
mod tests {
    use super::*;
    use snowgrain_math::trig;

    /// The mean transmittance at 1.32 is the known .88724 (the light of order 1 of spheres, polarisations apart).
    #[test]
    fn the_phase_function_is_normalised() {
        for (eta, known) in [(1.32, Some(0.88724)), (1.31, None), (1.5, None)] {
            let phase = BohrenBarkstrom::new(Dielectric { eta });
            if let Some(known) = known {
                assert!((phase.mean_transmittance() - known).abs() < 1e-4);
            }
            // Evenly in the half angle, which the function is smooth in.
            let (steps, widest) = (20_000u32, trig::acos(1.0 / eta));
            let step = widest / f64::from(steps);
            let of_step = |index: u32| {
                let (sin, cos) = trig::sin_cos((f64::from(index) + 0.5) * step);
                8.0 * PI * sin * cos * step * phase.density(2.0 * cos * cos - 1.0)
            };
            let sum: f64 = (0..steps).map(of_step).sum();
            assert!((sum - 1.0).abs() < 1e-4, "{eta}: {sum}");
        }
    }

    /// Samples fall as the closed form says: chi-square over 32 bins of equal probability; by chance beyond 80 once in
    /// 10^5 (31 degrees of freedom). The numbers are evenly spaced, so it is far below.
    #[test]
    fn samples_fall_as_the_density_says() {
        let phase = BohrenBarkstrom::new(Dielectric { eta: 1.31 });
        let (count, bins) = (1u32 << 16, 64u32);
        let mut found = vec![0.0; bins as usize];
        let least = 2.0 / (1.31 * 1.31) - 1.0;
        let place = |cosine: f64| (1.0 - cosine) / (1.0 - least) * f64::from(bins);
        for index in 0..count {
            let ray = phase.sample((f64::from(index) + 0.5) / f64::from(count));
            found[(place(ray.cosine) as usize).min(bins as usize - 1)] += 1.0 / f64::from(count);
            let length = phase.length(ray.cosine);
            assert!((length - ray.length).abs() < 1e-6, "{length} {}", ray.length);
        }
        let width = (1.0 - least) / f64::from(bins);
        for (bin, found) in found.iter().enumerate() {
            let at = |part: u32| 1.0 - width * (bin as f64 + (f64::from(part) + 0.5) / 64.0);
            let mean = (0..64).map(|part| phase.density(at(part))).sum::<f64>() / 64.0;
            let expected = 2.0 * PI * width * mean;
            assert!((found - expected).abs() < 2e-4, "{bin}: {found} {expected}");
        }
    }
}
