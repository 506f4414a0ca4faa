//! Closed forms of how much light snow reflects and lets through, by those who found them.
//!
//! All take a grain by its co-albedo 1 - w, its asymmetry g, both without diffraction, and layers by
//! their optical depth tau = (3/4) phi H / r, infinite for deep snow. They know neither packing nor
//! the shape of the phase function.

use snowgrain_math::trig;

/// Scattering by one grain, diffraction left out.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SingleScattering {
    /// 1 - w: the fraction of the light on a grain that it (with its share of impurities) absorbs.
    pub co_albedo: f64,
    /// Asymmetry g, the mean cosine of the scattering angle.
    pub asymmetry: f64,
}

/// How light arrives at the top.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Incidence {
    /// The same radiance from all of the upper hemisphere.
    Diffuse,
    /// Parallel light, by the cosine of its angle with the vertical, in (0, 1].
    Parallel(f64),
}

/// Fractions of the light that a layer reflects and lets through, direct light included.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Fluxes {
    /// Reflected.
    pub reflectance: f64,
    /// Let through.
    pub transmittance: f64,
}

/// Kokhanovsky and Zege 2004, "Scattering optics of snow", Appl. Opt. 43, 1589: the asymptotic theory
/// of weak absorption, with escape function u = (3/7)(1 + 2 mu).
#[must_use]
pub fn kokhanovsky_zege(grain: SingleScattering, depth: f64, incidence: Incidence) -> Fluxes {
    let co_albedo = grain.co_albedo.max(0.0);
    let y = 4.0 * (co_albedo / (3.0 * (1.0 - grain.asymmetry))).sqrt();
    let escape = match incidence {
        Incidence::Diffuse => 1.0,
        Incidence::Parallel(cosine) => 3.0 / 7.0 * (1.0 + 2.0 * cosine),
    };
    let deep = trig::exp(-y * escape);
    if depth.is_infinite() {
        return Fluxes { reflectance: deep, transmittance: 0.0 };
    }
    let similarity = 1.0 - (1.0 - co_albedo) * grain.asymmetry;
    let x = (3.0 * co_albedo * similarity).sqrt() * depth;
    let transmittance = if y < 1e-9 {
        1.0 / (1.072 + 0.75 * depth * similarity)
    } else {
        sinh_ratio(y, x + 1.072 * y)
    };
    let transmittance = transmittance * escape;
    Fluxes { reflectance: deep - transmittance * trig::exp(-x - y), transmittance }
}

/// The bidirectional reflectance factor (pi times the BRDF) of deep natural snow: Kokhanovsky and Breon
/// 2012, "Validation of an analytical snow BRDF model using PARASOL multi-angular and multispectral
/// observations", IEEE Geosci. Remote Sens. Lett. 9, 928. The fit R0 to snow that absorbs nothing,
/// darkened by the asymptotic theory: R0 exp(-y u(mu0) u(mu) / R0).
///
/// `cosines` with the vertical of the light that arrives and of that which is seen, in (0, 1], and
/// `cosine` of the scattering angle, in [-1, 1]. The fit is of grains of natural shapes: whatever the
/// grain, it has no rainbow.
#[must_use]
pub fn kokhanovsky_breon(grain: SingleScattering, cosines: [f64; 2], cosine: f64) -> f64 {
    let [from, to] = cosines;
    let degrees = trig::acos(cosine.clamp(-1.0, 1.0)).to_degrees();
    let once = 11.1 * trig::exp(-0.087 * degrees) + 1.1 * trig::exp(-0.014 * degrees);
    let clear = (1.247 + 1.186 * (from + to) + 5.157 * from * to + once) / (4.0 * (from + to));
    let y = 4.0 * (grain.co_albedo.max(0.0) / (3.0 * (1.0 - grain.asymmetry))).sqrt();
    let escape = |cosine: f64| 3.0 / 7.0 * (1.0 + 2.0 * cosine);
    clear * trig::exp(-y * escape(from) * escape(to) / clear)
}

/// sinh(a) / sinh(b) for 0 <= a <= b, b > 0, however large.
fn sinh_ratio(a: f64, b: f64) -> f64 {
    trig::exp(a - b) * (1.0 - trig::exp(-2.0 * a)) / (1.0 - trig::exp(-2.0 * b))
}

/// The delta-Eddington layer of Wiscombe and Warren 1980, "A model for the spectral albedo of snow.
/// I: Pure snow", J. Atmos. Sci. 37, 2712: parallel light in closed form (its equations 3 to 7; of a
/// finite layer by Meador and Weaver 1980, J. Atmos. Sci. 37, 630), diffuse light as the mean of
/// parallel light from all directions.
#[must_use]
pub fn wiscombe_warren(grain: SingleScattering, depth: f64, incidence: Incidence) -> Fluxes {
    let layer = Eddington::new(grain, depth);
    match incidence {
        Incidence::Parallel(cosine) => layer.parallel(cosine),
        Incidence::Diffuse if depth.is_infinite() => {
            Fluxes { reflectance: layer.deep_diffuse(), transmittance: 0.0 }
        }
        Incidence::Diffuse => {
            let mean = |part: fn(Fluxes) -> f64| {
                crate::quadrature::integrate(0.0, 1.0, |cosine| {
                    2.0 * cosine * part(layer.parallel(cosine))
                })
            };
            Fluxes {
                reflectance: mean(|fluxes| fluxes.reflectance),
                transmittance: mean(|fluxes| fluxes.transmittance),
            }
        }
    }
}

/// The same two-stream equations with their own diffuse boundary (Meador and Weaver 1980, their
/// delta-Eddington coefficients): differs from [`wiscombe_warren`] for diffuse light only.
#[must_use]
pub fn two_stream(grain: SingleScattering, depth: f64, incidence: Incidence) -> Fluxes {
    let layer = Eddington::new(grain, depth);
    match incidence {
        Incidence::Parallel(cosine) => layer.parallel(cosine),
        Incidence::Diffuse => layer.diffuse(),
    }
}

/// Bohren and Barkstrom 1974, "Theory of the optical properties of snow", J. Geophys. Res. 79, 4527:
/// deep snow under diffuse light, 1 - 8.43 (gamma r)^(1/2); weak absorption only. `absorption` is that
/// of the ice a grain radius, gamma r.
#[must_use]
pub fn bohren_barkstrom(absorption: f64) -> f64 {
    1.0 - 8.43 * absorption.max(0.0).sqrt()
}

/// Delta-Eddington coefficients of a layer.
struct Eddington {
    albedo: f64,
    asymmetry: f64,
    depth: f64,
    /// Coefficients gamma1 and gamma2, and the extinction k of diffuse light.
    back: [f64; 2],
    extinction: f64,
}

impl Eddington {
    fn new(grain: SingleScattering, depth: f64) -> Self {
        let g = grain.asymmetry;
        // A little absorption keeps the conservative limit from dividing by nothing.
        let w = 1.0 - grain.co_albedo.clamp(1e-12, 1.0);
        let scaled = 1.0 - w * g * g;
        let albedo = w * (1.0 - g * g) / scaled;
        let asymmetry = g / (1.0 + g);
        let back = [
            0.25 * (7.0 - albedo * (4.0 + 3.0 * asymmetry)),
            -0.25 * (1.0 - albedo * (4.0 - 3.0 * asymmetry)),
        ];
        let extinction = (back[0] * back[0] - back[1] * back[1]).sqrt();
        Self { albedo, asymmetry, depth: depth * scaled, back, extinction }
    }

    /// Meador and Weaver's equations 14 and 15, with exp(k tau) divided out.
    fn parallel(&self, cosine: f64) -> Fluxes {
        let (k, w, tau) = (self.extinction, self.albedo, self.depth);
        let [g1, g2] = self.back;
        let g3 = 0.25 * (2.0 - 3.0 * self.asymmetry * cosine);
        let g4 = 1.0 - g3;
        let (a1, a2) = (g1 * g4 + g2 * g3, g1 * g3 + g2 * g4);
        // Where k mu is 1 both sides vanish: the limit is as near as rounding allows.
        let km = if (k * cosine - 1.0).abs() < 1e-7 { 1.0 + 1e-7 } else { k * cosine };
        let decay = trig::exp(-k * tau);
        let direct = trig::exp(-tau / cosine);
        let below = (1.0 - km * km) * ((k + g1) + (k - g1) * decay * decay);
        let up = (1.0 - km) * (a2 + k * g3)
            - (1.0 + km) * (a2 - k * g3) * decay * decay
            - 2.0 * k * (g3 - a2 * cosine) * decay * direct;
        let through = (1.0 + km) * (a1 + k * g4) - (1.0 - km) * (a1 - k * g4) * decay * decay;
        let down = direct * through - 2.0 * k * (g4 + a1 * cosine) * decay;
        Fluxes { reflectance: w * up / below, transmittance: direct - w * down / below }
    }

    fn diffuse(&self) -> Fluxes {
        let (k, [g1, g2]) = (self.extinction, self.back);
        let decay = trig::exp(-k * self.depth);
        let below = k + g1 + (k - g1) * decay * decay;
        Fluxes {
            reflectance: g2 * (1.0 - decay * decay) / below,
            transmittance: 2.0 * k * decay / below,
        }
    }

    /// Wiscombe and Warren's equation 8: the integral of parallel light over all directions.
    fn deep_diffuse(&self) -> f64 {
        let a = 1.0 - self.albedo * self.asymmetry;
        let b = self.asymmetry / a;
        let xi = (3.0 * a * (1.0 - self.albedo)).sqrt();
        let p = 2.0 * xi / (3.0 * a);
        let integral = if xi < 1e-4 {
            // (xi - ln(1 + xi)) / xi^2 by its series.
            0.5 - xi / 3.0
        } else {
            (xi - trig::ln(1.0 + xi)) / (xi * xi)
        };
        2.0 * self.albedo / (1.0 + p) * ((1.0 + b) * integral - 0.5 * b)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::quadrature::integrate;

    const GRAIN: SingleScattering = SingleScattering { co_albedo: 0.01, asymmetry: 0.89 };

    #[test]
    fn wiscombe_and_warren_s_diffuse_albedo_is_the_mean_of_their_direct_one() {
        for co_albedo in [1e-6, 1e-3, 0.01, 0.3] {
            for asymmetry in [0.5, 0.78, 0.89] {
                let grain = SingleScattering { co_albedo, asymmetry };
                let deep = f64::INFINITY;
                let closed = wiscombe_warren(grain, deep, Incidence::Diffuse).reflectance;
                let mean = integrate(0.0, 1.0, |mu| {
                    2.0 * mu * wiscombe_warren(grain, deep, Incidence::Parallel(mu)).reflectance
                });
                assert!((closed - mean).abs() < 1e-6, "{grain:?}: {closed} {mean}");
            }
        }
    }

    #[test]
    fn both_forms_of_the_two_stream_albedo_are_those_of_the_literature() {
        // The project's physics, section 4: at 1 - w = .01, with g = .78, .6104 and .6186.
        let deep = f64::INFINITY;
        let grain = SingleScattering { co_albedo: 0.01, asymmetry: 0.78 };
        let stream = two_stream(grain, deep, Incidence::Diffuse).reflectance;
        let warren = wiscombe_warren(grain, deep, Incidence::Diffuse).reflectance;
        assert!((stream - 0.6104).abs() < 5e-5 && (warren - 0.6186).abs() < 5e-5);
    }

    #[test]
    fn layers_become_deep_snow_and_keep_light_that_nothing_absorbs() {
        for theory in [kokhanovsky_zege, wiscombe_warren, two_stream] {
            for incidence in [Incidence::Diffuse, Incidence::Parallel(0.6)] {
                let deep = theory(GRAIN, f64::INFINITY, incidence);
                let thick = theory(GRAIN, 1e4, incidence);
                assert!((deep.reflectance - thick.reflectance).abs() < 1e-9, "{incidence:?}");
                assert!(thick.transmittance.abs() < 1e-9 && deep.transmittance == 0.0);
                let white = SingleScattering { co_albedo: 0.0, ..GRAIN };
                let layer = theory(white, 10.0, incidence);
                let sum = layer.reflectance + layer.transmittance;
                assert!((sum - 1.0).abs() < 1e-4, "{incidence:?}: {layer:?}");
            }
        }
        assert!((bohren_barkstrom(1e-6) - 0.99157).abs() < 1e-9);
    }
}
