//! The colour of light that has passed through ice of several absorptions.
//!
//! As [`crate::ice_colour`], but with a length for each stratum of snow, so that no table serves: the
//! light is summed over bands of 5 nm, in each of which absorption has one value.

use crate::colour::{Illuminant, Primaries};
use crate::ice_colour::{lines, lines_of};
use snowgrain_math::{DMat3, DVec3, trig};

/// Lines of 1 nm in a band.
const LINES_PER_BAND: usize = 5;

/// Light after any lengths in ice of several strata.
#[derive(Clone, Debug)]
pub struct StrataColour {
    /// Without ice, in columns.
    clear: DMat3,
    bands: Vec<Band>,
}

#[derive(Clone, Debug)]
struct Band {
    colour: DMat3,
    /// Of all ice, then of each stratum beside that, 1/m.
    absorptions: Vec<f64>,
}

impl StrataColour {
    /// The colours of `light` in amounts of `primaries`, in ice that absorbs the first of `per_metre(lambda in
    /// nm)` everywhere, and in stratum i the (i + 1)-th beside that; 1/m, at least 0.
    #[must_use]
    pub fn new(
        light: Illuminant,
        primaries: Primaries,
        per_metre: &impl Fn(f64) -> Vec<f64>,
    ) -> Self {
        let lines = lines(light, primaries);
        let clear = match (light, primaries) {
            // What the sum over wavelengths gives to within 1e-11.
            (Illuminant::D65, Primaries::Srgb) => DMat3::IDENTITY,
            _ => sum_of(&lines),
        };
        Self::of_lines(clear, &lines, per_metre)
    }

    /// The same of the wavelengths of a band alone, times the number of bands.
    #[must_use]
    pub fn in_band(
        light: Illuminant,
        primaries: Primaries,
        band: &crate::Band,
        per_metre: &impl Fn(f64) -> Vec<f64>,
    ) -> Self {
        let lines = lines_of(light, primaries, band);
        Self::of_lines(sum_of(&lines), &lines, per_metre)
    }

    fn of_lines(
        clear: DMat3,
        lines: &[(f64, DMat3)],
        per_metre: &impl Fn(f64) -> Vec<f64>,
    ) -> Self {
        let band = |lines: &[(f64, DMat3)]| {
            let colour = sum_of(lines);
            let middle = lines.iter().map(|(nm, _)| nm).sum::<f64>() / lines.len() as f64;
            Band { colour, absorptions: per_metre(middle) }
        };
        Self { clear, bands: lines.chunks(LINES_PER_BAND).map(band).collect() }
    }

    /// The colour of a path of light and albedos `weight` (linear sRGB) after `length` metres of ice in all, of
    /// which `in_strata` in each stratum.
    #[must_use]
    pub fn apply(&self, weight: [f32; 3], length: f64, in_strata: &[f64]) -> [f32; 3] {
        let weight = DVec3::from(weight.map(f64::from));
        let mut colour = self.clear * weight;
        for Band { colour: line, absorptions } in &self.bands {
            let beside = absorptions[1..].iter().zip(in_strata);
            let depth =
                beside.fold(absorptions[0] * length, |sum, (gamma, length)| sum + gamma * length);
            colour += *line * weight * trig::exp_m1(-depth);
        }
        colour.to_array().map(|x| x as f32)
    }
}

fn sum_of(lines: &[(f64, DMat3)]) -> DMat3 {
    lines.iter().fold(DMat3::ZERO, |sum, (_, colour)| sum + *colour)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Absorption, Grade, Impurity, ImpurityKind, Load};

    #[test]
    fn ice_of_one_stratum_has_the_colour_of_the_same_load_everywhere() {
        let soot = Impurity { kind: ImpurityKind::BlackCarbon, load: Load::MassFraction(2e-6) };
        let dust = Impurity { kind: ImpurityKind::DustSahara, load: Load::MassFraction(1e-4) };
        let grade = Grade {
            primaries: Primaries::Srgb,
            lights: vec![Illuminant::D65, Illuminant::A],
            absorption: Absorption::default(),
            impurities: Vec::new(),
            enhancement: 1.2535,
            exposure_stops: 0.0,
        };
        let loaded = Grade { impurities: vec![soot, dust], ..grade.clone() };
        let strata = grade.strata_colours(&[vec![soot, dust], vec![soot]]);
        let clean = grade.colours();
        for (slot, everywhere) in loaded.colours().into_iter().enumerate() {
            for length in [1e-4, 0.003, 0.05, 0.7, 4.0] {
                let weight = [0.9, 0.5, 0.2];
                let near = |a: [f32; 3], b: [f32; 3]| {
                    assert!(a.iter().zip(b).all(|(a, b)| (a - b).abs() < 2e-4), "{a:?} {b:?}");
                };
                let all = everywhere.apply(weight, length);
                near(strata[slot].apply(weight, length, &[length, 0.0]), all);
                let none = clean[slot].apply(weight, length);
                near(strata[slot].apply(weight, length, &[0.0, 0.0]), none);
            }
        }
        assert!(grade.strata_colours(&[]).is_empty());
    }
}
