//! Metals: how much light a smooth face of them reflects.

use crate::colour::{Illuminant, Primaries, tristimulus};
use crate::{Spectrum, table};

/// Metals whose index of refraction is known.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Metal {
    /// Al: Rakic 1995, "Algorithm for the determination of intrinsic optical constants of metal films:
    /// application to aluminum", Appl. Opt. 34, 4755.
    Aluminium,
    /// Cr: Johnson and Christy 1974, "Optical constants of transition metals", Phys. Rev. B 9, 5056.
    Chromium,
    /// Cu: Johnson and Christy 1972, "Optical constants of the noble metals", Phys. Rev. B 6, 4370.
    Copper,
    /// Au: Johnson and Christy 1972.
    Gold,
    /// Fe: Johnson and Christy 1974.
    Iron,
    /// Ag: Johnson and Christy 1972.
    Silver,
}

impl Metal {
    /// All of them, by name.
    pub const ALL: [Self; 6] =
        [Self::Aluminium, Self::Chromium, Self::Copper, Self::Gold, Self::Iron, Self::Silver];

    /// The name by which users choose it.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Aluminium => "aluminium",
            Self::Chromium => "chromium",
            Self::Copper => "copper",
            Self::Gold => "gold",
            Self::Iron => "iron",
            Self::Silver => "silver",
        }
    }

    /// The part of white light (D65) that a face of it reflects at normal incidence, linear sRGB, each in
    /// [0, 1] (gold is out of the gamut by .04 and clamped): Fresnel's equations over the visible spectrum.
    #[must_use]
    pub fn reflectance(self) -> [f32; 3] {
        self.colour_at(1.0).map(|channel| channel.clamp(0.0, 1.0) as f32)
    }

    /// What the reflectance is less than Schlick's form of it towards grazing light, by channel: the factor
    /// `a` of `a c (1 - c)^6`, c the cosine of incidence, which is exact at c = 1/7 (Hoffman 2019, "Fresnel
    /// Equations Considered Harmful", section 4). With it no metal is off by more than .03.
    #[must_use]
    pub fn edge(self) -> [f32; 3] {
        let c = 1.0 / 7.0;
        let rest = 1.0 - c;
        let fifth = (rest * rest) * (rest * rest) * rest;
        let (normal, grazing) = (self.colour_at(1.0), self.colour_at(c));
        std::array::from_fn(|i| {
            let schlick = normal[i] + (1.0 - normal[i]) * fifth;
            ((schlick - grazing[i]) / (c * fifth * rest)).max(0.0) as f32
        })
    }

    /// Linear sRGB of the light reflected at this cosine of incidence, of white light.
    fn colour_at(self, cosine: f64) -> [f64; 3] {
        let [n, k] = self.index();
        let part = |nm: f64| reflectance(cosine, n.at(nm), k.at(nm));
        (Primaries::Srgb.under_d65() * tristimulus(Illuminant::D65, part)).to_array()
    }

    /// Real and imaginary part of its index of refraction.
    fn index(self) -> [Spectrum; 2] {
        let table = match self {
            Self::Aluminium => include_str!("../data/metals/aluminium.csv"),
            Self::Chromium => include_str!("../data/metals/chromium.csv"),
            Self::Copper => include_str!("../data/metals/copper.csv"),
            Self::Gold => include_str!("../data/metals/gold.csv"),
            Self::Iron => include_str!("../data/metals/iron.csv"),
            Self::Silver => include_str!("../data/metals/silver.csv"),
        };
        ["n", "k"].map(|name| table::column(table, name))
    }
}

/// Reflectance of unpolarised light by a metal of index n + ik (Born and Wolf, "Principles of Optics", 7th ed.,
/// section 14.2).
fn reflectance(cosine: f64, n: f64, k: f64) -> f64 {
    let (c2, s2) = (cosine * cosine, 1.0 - cosine * cosine);
    // Index times the complex cosine of refraction is u + iv.
    let difference = n * n - k * k - s2;
    let sum = (difference * difference + 4.0 * n * n * k * k).sqrt();
    let twice = 2.0 * cosine * (0.5 * (sum + difference)).max(0.0).sqrt();
    let across = (sum + c2 - twice) / (sum + c2 + twice);
    let both = (c2 * sum + s2 * s2, twice * s2);
    0.5 * across * (1.0 + (both.0 - both.1) / (both.0 + both.1))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn metals_have_the_reflectances_and_the_hues_of_handbooks() {
        // Round figures of handbooks, with room for the colour.
        for (metal, low, high) in [
            (Metal::Aluminium, 0.88, 0.93),
            (Metal::Silver, 0.94, 0.99),
            (Metal::Iron, 0.48, 0.60),
            (Metal::Chromium, 0.48, 0.60),
        ] {
            let rgb = metal.reflectance();
            assert!(rgb.iter().all(|c| (low..high).contains(c)), "{metal:?}: {rgb:?}");
        }
        for metal in [Metal::Gold, Metal::Copper] {
            let [r, g, b] = metal.reflectance();
            assert!(r > 0.9 && r > g + 0.15 && g > b, "{metal:?}: {r} {g} {b}");
        }
    }

    #[test]
    fn the_form_with_an_edge_follows_fresnel() {
        // Iron at 549 nm, by the complex arithmetic of another program.
        assert!((reflectance(1.0, 2.95, 2.93) - 0.5121).abs() < 1e-3);
        for metal in Metal::ALL {
            let (normal, edge) = (metal.reflectance(), metal.edge());
            for step in 0..=100 {
                let c = f64::from(step) / 100.0;
                let rest = 1.0 - c;
                let fifth = (rest * rest) * (rest * rest) * rest;
                for (i, exact) in
                    metal.colour_at(c).map(|x| x.clamp(0.0, 1.0)).into_iter().enumerate()
                {
                    let (normal, edge) = (f64::from(normal[i]), f64::from(edge[i]));
                    let form = normal + (1.0 - normal) * fifth - edge * c * fifth * rest;
                    assert!((form - exact).abs() < 0.03, "{metal:?} {c}: {form} {exact}");
                }
            }
        }
    }
}
