//! The closed form of one sphere that touches nothing.
//!
//! By symmetry a ray meets every interface of a sphere at the same angles, so everything about a
//! visit follows from `u = sin^2 theta_i`, uniform in [0, 1] for a parallel beam (van de Hulst,
//! "Light Scattering by Small Particles", chapter 12). *Order* 0 is reflected from outside; order
//! p >= 1 crosses p chords and leaves after p - 1 internal reflections. Polarisation is not
//! tracked: the mean reflectance is drawn anew at each interface, as the paper does.

use crate::{Dielectric, fresnel, quadrature::integrate};
use core::f64::consts::{FRAC_PI_2, PI};
use snowgrain_math::trig;

/// Where a ray strikes a sphere, and all that follows from it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Impact {
    /// Angle of incidence, radians.
    pub theta_i: f64,
    /// Angle of refraction, radians; pi/2 where no light enters.
    pub theta_t: f64,
    /// Reflectance of every interface of this visit.
    pub reflectance: f64,
}

impl Impact {
    /// The impact at the angle of incidence `theta_i`, radians in [0, pi/2].
    #[must_use]
    pub fn at_angle(medium: Dielectric, theta_i: f64) -> Self {
        let (sin_i, cos_i) = trig::sin_cos(theta_i);
        let theta_t = fresnel::cos_refracted(cos_i, medium.eta)
            .map_or(FRAC_PI_2, |cos_t| trig::atan2(sin_i / medium.eta, cos_t));
        Self { theta_i, theta_t, reflectance: medium.reflectance_from_outside(cos_i) }
    }

    /// The impact at `u = sin^2 theta_i`, in [0, 1]: uniform over the disc that a beam sees.
    #[must_use]
    pub fn at_disc_fraction(medium: Dielectric, u: f64) -> Self {
        Self::at_angle(medium, trig::atan2(u.sqrt(), (1.0 - u).max(0.0).sqrt()))
    }

    /// Length of each chord in radii, `2 cos theta_t`.
    #[must_use]
    pub fn chord(&self) -> f64 {
        2.0 * trig::sin_cos(self.theta_t).1
    }

    /// The fraction of the energy that leaves at this order: R, then (1-R)^2 R^(p-1).
    #[must_use]
    pub fn energy(&self, order: u32) -> f64 {
        let transmitted = 1.0 - self.reflectance;
        match order {
            0 => self.reflectance,
            p => transmitted * transmitted * trig::pow(self.reflectance, f64::from(p - 1)),
        }
    }

    /// The angle by which light of this order is turned in all, radians: not reduced to [0, pi].
    #[must_use]
    pub fn deflection(&self, order: u32) -> f64 {
        match order {
            0 => PI - 2.0 * self.theta_i,
            p => 2.0 * (self.theta_i - self.theta_t) + f64::from(p - 1) * (PI - 2.0 * self.theta_t),
        }
    }

    /// Mean cosine of the deflection over all orders: the geometric series of
    /// (1-R)^2 R^(p-1) cos(a + (p-1) b) in closed form, plus the reflected part.
    #[must_use]
    pub fn mean_cosine(&self) -> f64 {
        let r = self.reflectance;
        let cosine = |angle: f64| trig::sin_cos(angle).1;
        let outside = r * cosine(self.deflection(0));
        if r == 1.0 {
            return outside;
        }
        let (a, b) = (self.deflection(1), PI - 2.0 * self.theta_t);
        let series = (cosine(a) - r * cosine(a - b)) / (1.0 - 2.0 * r * cosine(b) + r * r);
        outside + (1.0 - r) * (1.0 - r) * series
    }

    /// Mean length in the sphere, in radii. The mean number of chords, the sum of
    /// p (1-R)^2 R^(p-1), is 1 whatever the reflectance, unless no light enters.
    #[must_use]
    pub fn mean_path(&self) -> f64 {
        if self.reflectance == 1.0 { 0.0 } else { self.chord() }
    }
}

/// The mean of `value` over the disc that a parallel beam sees, by quadrature over angles, in
/// which the integrands are smooth (over the angle of refraction where some light cannot enter).
#[must_use]
pub fn mean_over_disc(medium: Dielectric, value: impl Fn(&Impact) -> f64) -> f64 {
    let weighted = |theta_i: f64| {
        let (sin, cos) = trig::sin_cos(theta_i);
        2.0 * sin * cos * value(&Impact::at_angle(medium, theta_i))
    };
    if medium.eta >= 1.0 {
        return integrate(0.0, FRAC_PI_2, weighted);
    }
    let entering = integrate(0.0, FRAC_PI_2, |theta_t| {
        let (sin, cos) = trig::sin_cos(theta_t);
        let theta_i = trig::asin(medium.eta * sin);
        medium.eta * medium.eta * 2.0 * sin * cos * value(&Impact::at_angle(medium, theta_i))
    });
    entering + integrate(trig::asin(medium.eta), FRAC_PI_2, weighted)
}

/// E_p: the fraction of the energy that a beam loses to this order.
#[must_use]
pub fn energy(medium: Dielectric, order: u32) -> f64 {
    mean_over_disc(medium, |impact| impact.energy(order))
}

/// g: the mean cosine of the scattering angle, without diffraction.
#[must_use]
pub fn asymmetry(medium: Dielectric) -> f64 {
    mean_over_disc(medium, Impact::mean_cosine)
}

/// g of light that keeps its polarisation, across or along the plane of incidence, from the entry to the
/// exit: the mean of both, and what Mie's theory tends to for large spheres.
#[must_use]
pub fn asymmetry_of_polarised(medium: Dielectric) -> f64 {
    mean_over_disc(medium, |impact| {
        let cos_i = trig::sin_cos(impact.theta_i).1;
        let [s, p] = medium.polarised_reflectances_from_outside(cos_i);
        0.5 * (Impact { reflectance: s, ..*impact }.mean_cosine()
            + Impact { reflectance: p, ..*impact }.mean_cosine())
    })
}

/// Whether the polarisation is drawn anew at each interface of a grain, or is that of the grain.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Polarisation {
    /// The mean of both reflectances counts at every interface: the paper's way.
    #[default]
    Redrawn,
    /// A path is of one polarisation from the entry to a grain to its exit, and unpolarised again at
    /// the next grain: exact for one grain. 1 - g is 1.5 % less.
    Tracked,
}

/// The phase function of a sphere without diffraction: the parts of the scattered energy in `bins`
/// equal bins of the scattering angle from 0 to 180 degrees. They add up to 1.
///
/// Midpoints of 2^18 equal parts of the disc, and orders until less than 1e-9 of a ray is left.
#[must_use]
pub fn energy_by_angle(medium: Dielectric, polarisation: Polarisation, bins: usize) -> Vec<f64> {
    const PARTS: u32 = 1 << 18;
    let mut energies = vec![0.0; bins];
    let bin_of = |deflection: f64| {
        let around = deflection.rem_euclid(2.0 * PI);
        let angle = around.min(2.0 * PI - around);
        ((angle / PI * bins as f64) as usize).min(bins - 1)
    };
    for part in 0..PARTS {
        let u = (f64::from(part) + 0.5) / f64::from(PARTS);
        let impact = Impact::at_disc_fraction(medium, u);
        let reflectances = match polarisation {
            Polarisation::Redrawn => [impact.reflectance; 2],
            Polarisation::Tracked => {
                medium.polarised_reflectances_from_outside(trig::sin_cos(impact.theta_i).1)
            }
        };
        for reflectance in reflectances {
            let mut left = 0.5 / f64::from(PARTS);
            let mut energy = reflectance;
            for order in 0.. {
                energies[bin_of(impact.deflection(order))] += left * energy;
                left *= 1.0 - energy;
                energy = 1.0 - reflectance;
                if left * f64::from(PARTS) < 1e-9 {
                    break;
                }
            }
        }
    }
    energies
}

/// B: mean length in the sphere per visit over the mean straight chord 4r/3, that is the weak
/// absorption 1 - w = (4/3) gamma r B. Equals eta^2 - (eta^2-1)^(3/2)/eta for eta >= 1 and eta^2
/// below.
#[must_use]
pub fn absorption_enhancement(medium: Dielectric) -> f64 {
    0.75 * mean_over_disc(medium, Impact::mean_path)
}

/// 1 - w: the fraction of a beam on the sphere that its ice absorbs, for `absorption` a radius of it
/// (gamma r >= 0). To first order (4/3) gamma r B.
#[must_use]
pub fn co_albedo(medium: Dielectric, absorption: f64) -> f64 {
    mean_over_disc(medium, |impact| {
        let (r, entering) = (impact.reflectance, 1.0 - impact.reflectance);
        // What enters and the geometric series of its chords: (1-R) (1-e) / (1 - R e).
        let lost = -trig::exp_m1(-absorption * impact.chord());
        if r == 1.0 { 0.0 } else { entering * lost / (1.0 - r * (1.0 - lost)) }
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Columns n, g, E_0 ... E_5, E_6+ (mean reflectance redrawn at each interface) and B of the
    /// project's reference table `go_single_sphere.csv`: quadrature by an independent program,
    /// 600 Gauss-Legendre points in the angle of incidence, orders summed to 400.
    const TABLE: [[f64; 10]; 4] = [
        [
            1.28, 0.804443, 0.057877, 0.896824, 0.038095, 0.004811, 0.001305, 0.000503, 0.000585,
            1.239899,
        ],
        [
            1.31, 0.781657, 0.062742, 0.888052, 0.041412, 0.005229, 0.001402, 0.000538, 0.000624,
            1.253517,
        ],
        [
            1.32, 0.774174, 0.064341, 0.885165, 0.042504, 0.005369, 0.001434, 0.000549, 0.000636,
            1.257800,
        ],
        [
            1.335, 0.763059, 0.066722, 0.880866, 0.044132, 0.005579, 0.001481, 0.000566, 0.000654,
            1.264002,
        ],
    ];

    #[test]
    fn asymmetry_energies_and_enhancement_agree_with_the_reference_table() {
        for [eta, g, energies @ .., b] in TABLE {
            let ice = Dielectric { eta };
            assert!((asymmetry(ice) - g).abs() < 2e-6, "{eta}: {}", asymmetry(ice));
            assert!((absorption_enhancement(ice) - b).abs() < 2e-6);
            let mut rest = 1.0;
            for (order, expected) in (0..6).zip(energies) {
                let e = energy(ice, order);
                assert!((e - expected).abs() < 2e-6, "{eta}, order {order}: {e}");
                rest -= e;
            }
            let [.., tail] = energies;
            assert!((rest - tail).abs() < 2e-6, "{eta}: {rest}");
        }
    }

    #[test]
    fn light_that_keeps_its_polarisation_is_scattered_as_the_reference_table_says() {
        // Columns n and g_pol of `go_single_sphere.csv`.
        for (eta, g) in [(1.28, 0.806944), (1.29, 0.799552), (1.31, 0.784965)] {
            let value = asymmetry_of_polarised(Dielectric { eta });
            assert!((value - g).abs() < 5e-6, "{eta}: {value}");
        }
    }

    /// Parts of the energy in bins of 10 degrees for n = 1.31, by a separate program of a few lines
    /// (4 10^5 midpoints, 60 orders).
    #[test]
    fn energy_by_angle_is_that_of_an_independent_program_and_has_the_closed_asymmetry() {
        const REDRAWN: [f64; 18] = [
            0.12385, 0.25786, 0.23686, 0.16288, 0.09463, 0.04494, 0.01555, 0.00407, 0.00251,
            0.00206, 0.00181, 0.00189, 0.0025, 0.02856, 0.01316, 0.00424, 0.002, 0.00062,
        ];
        let ice = Dielectric { eta: 1.31 };
        let found = energy_by_angle(ice, Polarisation::Redrawn, 18);
        for (bin, (found, expected)) in found.iter().zip(REDRAWN).enumerate() {
            assert!((found - expected).abs() < 2e-5, "{bin}: {found}");
        }
        for polarisation in [Polarisation::Redrawn, Polarisation::Tracked] {
            let fine = energy_by_angle(ice, polarisation, 1800);
            assert!((fine.iter().sum::<f64>() - 1.0).abs() < 1e-8);
            let mean: f64 = (0u32..)
                .zip(&fine)
                .map(|(bin, e)| e * trig::sin_cos((f64::from(bin) + 0.5) * PI / 1800.0).1)
                .sum();
            let g = match polarisation {
                Polarisation::Redrawn => asymmetry(ice),
                Polarisation::Tracked => asymmetry_of_polarised(ice),
            };
            assert!((mean - g).abs() < 1e-5, "{polarisation:?}: {mean} {g}");
        }
    }

    #[test]
    fn enhancement_has_its_closed_form_on_both_sides_of_one() {
        for eta in [1.0f64, 1.05, 1.31, 2.0] {
            let closed = eta * eta - (eta * eta - 1.0).sqrt() * (eta * eta - 1.0) / eta;
            let b = absorption_enhancement(Dielectric { eta });
            assert!((b - closed).abs() < 1e-10, "{eta}: {b}");
        }
        for eta in [0.5f64, 0.76336, 0.98275] {
            assert!((absorption_enhancement(Dielectric { eta }) - eta * eta).abs() < 1e-10);
        }
    }

    #[test]
    fn ice_in_water_and_bubbles_in_ice_agree_with_the_reference_table() {
        // Rows of the project's `wet_relative_index.csv`, whose own quadrature is good to 1e-4 here.
        for (eta, g) in [(0.98275, 0.99617), (0.76336, 0.71251), (0.75019, 0.68977)] {
            let value = asymmetry(Dielectric { eta });
            assert!((value - g).abs() < 1e-4, "{eta}: {value}");
        }
        assert!((asymmetry(Dielectric { eta: 1.0 }) - 1.0).abs() < 1e-12);
    }

    #[test]
    fn a_visit_makes_two_interface_events_in_the_mean() {
        for u in [0.0, 0.3, 0.9, 0.9999] {
            let impact = Impact::at_disc_fraction(Dielectric { eta: 1.31 }, u);
            let events: f64 = (0..4000).map(|p| f64::from(p + 1) * impact.energy(p)).sum();
            assert!((events - 2.0).abs() < 1e-9, "{u}: {events}");
        }
    }

    #[test]
    fn the_series_over_orders_is_the_sum_of_its_terms() {
        for u in [0.01, 0.5, 0.95] {
            let impact = Impact::at_disc_fraction(Dielectric { eta: 1.32 }, u);
            let sum: f64 =
                (0..2000).map(|p| impact.energy(p) * trig::sin_cos(impact.deflection(p)).1).sum();
            assert!((impact.mean_cosine() - sum).abs() < 1e-12);
        }
    }

    #[test]
    fn the_co_albedo_is_what_the_orders_lose_and_to_first_order_the_enhanced_chord() {
        let ice = Dielectric { eta: 1.31 };
        for absorption in [1e-4, 0.01, 0.3, 3.0] {
            let kept = mean_over_disc(ice, |impact| {
                (0..300)
                    .map(|p| {
                        impact.energy(p) * trig::exp(-absorption * f64::from(p) * impact.chord())
                    })
                    .sum::<f64>()
            });
            assert!((co_albedo(ice, absorption) - (1.0 - kept)).abs() < 1e-6, "{absorption}");
        }
        let weak = co_albedo(ice, 1e-6) / (4.0 / 3.0 * 1e-6 * absorption_enhancement(ice));
        assert!((weak - 1.0).abs() < 1e-5, "{weak}");
    }

    #[test]
    fn the_mean_path_of_a_visit_is_1_671_radii() {
        let path = mean_over_disc(Dielectric { eta: 1.31 }, Impact::mean_path);
        assert!((path - 1.671).abs() < 5e-4, "{path}");
    }
}
