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

    /// The part of white light (D65) that a face of it reflects at normal incidence, linear sRGB, each
    /// clamped to [0, 1] (gold is out of the gamut by .01): `((n - 1)^2 + k^2) / ((n + 1)^2 + k^2)`
    /// (Born and Wolf, "Principles of Optics", 7th ed., section 14.2) over the visible spectrum.
    #[must_use]
    pub fn reflectance(self) -> [f32; 3] {
        let [n, k] = self.index();
        let at_normal = |nm: f64| {
            let (n, k) = (n.at(nm), k.at(nm));
            ((n - 1.0) * (n - 1.0) + k * k) / ((n + 1.0) * (n + 1.0) + k * k)
        };
        let rgb = Primaries::Srgb.under_d65() * tristimulus(Illuminant::D65, at_normal);
        rgb.to_array().map(|channel| channel.clamp(0.0, 1.0) as f32)
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn metals_have_the_reflectances_and_the_hues_of_handbooks() {
        // Round figures of handbooks, with room for the colour.
        for (metal, low, high) in [
            (Metal::Aluminium, 0.88, 0.93),
            (Metal::Silver, 0.94, 0.99),
            (Metal::Iron, 0.50, 0.60),
            (Metal::Chromium, 0.50, 0.60),
        ] {
            let rgb = metal.reflectance();
            assert!(rgb.iter().all(|c| (low..high).contains(c)), "{metal:?}: {rgb:?}");
        }
        for metal in [Metal::Gold, Metal::Copper] {
            let [r, g, b] = metal.reflectance();
            assert!(r > 0.9 && r > g + 0.15 && g > b, "{metal:?}: {r} {g} {b}");
        }
    }
}
