//! What turns lengths in ice into colours, and may be chosen again after a render.

use crate::{Absorption, Band, IceColour, Illuminant, Impurity, Primaries, StrataColour};

/// The absorption that a scene's light met and the colours that it is told in. Paths do not depend on
/// it (white Monte Carlo), only their colours do.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Grade {
    /// Primaries of the picture.
    pub primaries: Primaries,
    /// Spectra of the lights, each once.
    pub lights: Vec<Illuminant>,
    /// Absorption of the ice.
    pub absorption: Absorption,
    /// What lies between the grains, everywhere alike.
    pub impurities: Vec<Impurity>,
    /// Light's path in a grain over that of a sphere that does not refract: by how much less impurities
    /// beside the grains absorb for each metre of ice ([`crate::sphere::absorption_enhancement`]); 0 where
    /// there are no impurities.
    pub enhancement: f64,
    /// Exposure at which the picture is meant to be shown, stops: 1 is white after a multiplication by
    /// 2^this.
    pub exposure_stops: f64,
}

impl Grade {
    /// Absorption per metre of ice, impurities included, 1/m.
    #[must_use]
    pub fn per_metre(&self, wavelength_nm: f64) -> f64 {
        let beside =
            |impurity: &Impurity| impurity.per_metre_of_ice(wavelength_nm, self.enhancement);
        self.absorption.per_metre(wavelength_nm) + self.impurities.iter().map(beside).sum::<f64>()
    }

    /// The colours of each of its lights after lengths in ice of strata with these impurities beside its
    /// own; none where there are no strata.
    #[must_use]
    pub fn strata_colours(&self, loads: &[Vec<Impurity>]) -> Vec<StrataColour> {
        if loads.is_empty() {
            return Vec::new();
        }
        let absorptions = |nm: f64| self.per_metre_of_strata(loads, nm);
        let colour = |&light| StrataColour::new(light, self.primaries, &absorptions);
        self.lights.iter().map(colour).collect()
    }

    /// Of each of its lights the colours of a band of wavelengths alone, as of [`Self::colours`] and
    /// [`Self::strata_colours`].
    #[must_use]
    pub fn colours_in(
        &self,
        band: &Band,
        loads: &[Vec<Impurity>],
    ) -> (Vec<IceColour>, Vec<StrataColour>) {
        let colour =
            |&light| IceColour::in_band(light, self.primaries, band, |nm| self.per_metre(nm));
        let absorptions = |nm: f64| self.per_metre_of_strata(loads, nm);
        let strata = |&light| StrataColour::in_band(light, self.primaries, band, &absorptions);
        let lights_in_strata = self.lights.iter().filter(|_| !loads.is_empty());
        (self.lights.iter().map(colour).collect(), lights_in_strata.map(strata).collect())
    }

    /// Absorption of all ice, then of each stratum beside that, 1/m.
    fn per_metre_of_strata(&self, loads: &[Vec<Impurity>], wavelength_nm: f64) -> Vec<f64> {
        let of = |impurities: &Vec<Impurity>| {
            let beside = |i: &Impurity| i.per_metre_of_ice(wavelength_nm, self.enhancement);
            impurities.iter().map(beside).sum::<f64>()
        };
        core::iter::once(self.per_metre(wavelength_nm)).chain(loads.iter().map(of)).collect()
    }

    /// The colours of each of its lights after any length in ice.
    #[must_use]
    pub fn colours(&self) -> Vec<IceColour> {
        let colour = |&light| IceColour::new(light, self.primaries, |nm| self.per_metre(nm));
        self.lights.iter().map(colour).collect()
    }
}
