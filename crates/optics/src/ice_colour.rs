//! The colour of light that has passed through ice.
//!
//! Lights and objects are given as linear sRGB and multiply as such; ice multiplies in the spectrum. With
//! `w` the product of a path's light and albedos and `L` its length in ice, what reaches the film is
//!
//! ```text
//! colour = integral of S(lambda) (w . reflectances(lambda)) exp(-gamma(lambda) L) observer(lambda)
//! ```
//!
//! over [`VISIBLE_NM`], with the light's spectrum S and the spectra of [`crate::uplift`]: linear in `w`, so
//! a matrix that depends on L alone. It is tabulated at lengths 1/16 octave apart and interpolated by
//! cubics through values and slopes, within 1e-6 of white.

use crate::band::{BANDS, Band};
use crate::colour::{Illuminant, Primaries, VISIBLE_NM, observer};
use crate::uplift::reflectances;
use snowgrain_math::{DMat3, DVec3, trig};

/// Intervals of the table in each octave of length, and the bits of a mantissa that number them.
const INTERVALS_PER_OCTAVE: usize = 16;
const MANTISSA_BITS: u32 = 48;

/// Optical depth at the greatest absorption below which the change is a straight line, and at the
/// least absorption above which nothing is left.
const THIN: f64 = 1.0 / (1u64 << 16) as f64;
const THICK: f64 = 40.0;

/// Most octaves of the table: ice that hardly absorbs at some wavelength ends it.
const MOST_OCTAVES: i32 = 48;

/// The colour of light after any length in ice of one absorption, for one light and one set of
/// primaries.
#[derive(Clone, Debug)]
pub struct IceColour {
    /// Without ice, in columns.
    clear: DMat3,
    /// What ice adds to it, by interval.
    table: Vec<Node>,
    /// Bits above [`MANTISSA_BITS`] of the first length of the table.
    first: u64,
    /// The first length, metres.
    shortest: f64,
}

/// What ice of a length adds to the matrix without ice, and its slope for each metre; nine numbers by
/// columns.
#[derive(Clone, Copy, Debug)]
struct Node {
    value: [f32; 9],
    slope: [f32; 9],
}

impl IceColour {
    /// The colours of `light` in ice that absorbs `per_metre(lambda in nm)`, 1/m and at least 0, in
    /// amounts of `primaries`; light of D65 without ice and of weight 1, 1, 1 is 1, 1, 1, other lights have
    /// its luminance.
    #[must_use]
    pub fn new(light: Illuminant, primaries: Primaries, per_metre: impl Fn(f64) -> f64) -> Self {
        let lines = Lines::new(lines(light, primaries), per_metre);
        let clear = match (light, primaries) {
            // What the sum over wavelengths gives to within 1e-11.
            (Illuminant::D65, Primaries::Srgb) => DMat3::IDENTITY,
            _ => lines.clear(),
        };
        Self::tabulated(clear, &lines)
    }

    /// The same of the wavelengths of a band alone, times the number of bands: the mean over all bands is the
    /// colour of the light.
    #[must_use]
    pub fn in_band(
        light: Illuminant,
        primaries: Primaries,
        band: &Band,
        per_metre: impl Fn(f64) -> f64,
    ) -> Self {
        let lines = Lines::new(lines_of(light, primaries, band), per_metre);
        Self::tabulated(lines.clear(), &lines)
    }

    fn tabulated(clear: DMat3, lines: &Lines) -> Self {
        let [least, greatest] = lines.absorptions();
        if greatest == 0.0 {
            return Self { clear, table: Vec::new(), first: 0, shortest: f64::INFINITY };
        }
        let start = trig::pow(2.0, (trig::ln(THIN / greatest) * core::f64::consts::LOG2_E).floor());
        let end = trig::ln(THICK / least.max(1e-300) / start) * core::f64::consts::LOG2_E;
        let octaves = (end.ceil().max(1.0) as i32).min(MOST_OCTAVES) as usize;
        let first = start.to_bits() >> MANTISSA_BITS;
        let nodes = 0..=(octaves * INTERVALS_PER_OCTAVE) as u64;
        let table = nodes.map(|k| lines.node(f64::from_bits((first + k) << MANTISSA_BITS)));
        Self { clear, table: table.collect(), first, shortest: start }
    }

    /// The colour of a path that has passed through `length` metres of ice, of light and albedos whose
    /// product is `weight` (linear sRGB). Components may be below 0: deep ice is bluer than any screen.
    #[must_use]
    pub fn apply(&self, weight: [f32; 3], length: f64) -> [f32; 3] {
        let weight = weight.map(f64::from);
        let clear = self.clear * DVec3::from(weight);
        if self.table.is_empty() || length <= 0.0 {
            return clear.to_array().map(|x| x as f32);
        }
        let change = self.change(length);
        let changed = |row: usize| {
            let by = f64::from(change[row]) * weight[0]
                + f64::from(change[3 + row]) * weight[1]
                + f64::from(change[6 + row]) * weight[2];
            (clear[row] + by) as f32
        };
        [changed(0), changed(1), changed(2)]
    }

    /// The same for a unit of each weight, in columns.
    #[must_use]
    pub fn matrix(&self, length: f64) -> DMat3 {
        let [red, green, blue] = [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]]
            .map(|weight| DVec3::from(self.apply(weight, length).map(f64::from)));
        DMat3::from_cols(red, green, blue)
    }

    /// What a length above 0 adds to the matrix without ice.
    fn change(&self, length: f64) -> [f32; 9] {
        if length < self.shortest {
            let part = (length / self.shortest) as f32;
            return self.table[0].value.map(|value| value * part);
        }
        let bits = length.to_bits();
        let index = ((bits >> MANTISSA_BITS) - self.first) as usize;
        let Some([low, high]) = self.table.get(index..index + 2) else {
            return self.table[self.table.len() - 1].value;
        };
        let start = f64::from_bits(bits >> MANTISSA_BITS << MANTISSA_BITS);
        let width = f64::from_bits(((bits >> MANTISSA_BITS) + 1) << MANTISSA_BITS) - start;
        let t = ((length - start) / width) as f32;
        let width = width as f32;
        let (s, t2) = (1.0 - t, t * t);
        let low_value = s * s * (1.0 + 2.0 * t);
        let high_value = t2 * (3.0 - 2.0 * t);
        let (low_slope, high_slope) = (width * t * s * s, width * -t2 * s);
        core::array::from_fn(|i| {
            (low.value[i] * low_value + high.value[i] * high_value)
                + (low.slope[i] * low_slope + high.slope[i] * high_slope)
        })
    }
}

/// Every whole nanometre of [`VISIBLE_NM`]: wavelength, and what one unit of each weight gives (in
/// columns); the sum is 1 for D65 and sRGB.
pub(crate) fn lines(light: Illuminant, primaries: Primaries) -> Vec<(f64, DMat3)> {
    let to_rgb = primaries.under_d65();
    let [first, last] = VISIBLE_NM;
    let wavelengths = (0..=(last - first) as u32).map(|step| first + f64::from(step));
    let powers = wavelengths.map(|nm| (nm, observer(nm) * light.power(nm)));
    let white = powers.clone().map(|(_, line)| line.y).sum::<f64>();
    let colour = |(nm, line): (f64, DVec3)| {
        let line = to_rgb * (line / white);
        let [red, green, blue] = reflectances(nm).map(|share| line * share);
        (nm, DMat3::from_cols(red, green, blue))
    };
    powers.map(colour).collect()
}

/// Those of a band, times the number of bands.
pub(crate) fn lines_of(light: Illuminant, primaries: Primaries, band: &Band) -> Vec<(f64, DMat3)> {
    let all = lines(light, primaries).into_iter();
    all.filter(|(nm, _)| band.contains(*nm)).map(|(nm, line)| (nm, line * BANDS as f64)).collect()
}

/// The same with the absorption.
struct Lines {
    colours: Vec<DMat3>,
    absorptions: Vec<f64>,
}

impl Lines {
    fn new(lines: Vec<(f64, DMat3)>, per_metre: impl Fn(f64) -> f64) -> Self {
        let (absorptions, colours) =
            lines.into_iter().map(|(nm, colour)| (per_metre(nm), colour)).unzip();
        Self { colours, absorptions }
    }

    fn clear(&self) -> DMat3 {
        self.colours.iter().fold(DMat3::ZERO, |sum, colour| sum + *colour)
    }

    /// The least and the greatest absorption, 1/m.
    fn absorptions(&self) -> [f64; 2] {
        let fold =
            |start, pick: fn(f64, f64) -> f64| self.absorptions.iter().copied().fold(start, pick);
        [fold(f64::INFINITY, f64::min), fold(0.0, f64::max)]
    }

    fn node(&self, length: f64) -> Node {
        let (mut value, mut slope) = (DMat3::ZERO, DMat3::ZERO);
        for (colour, &gamma) in self.colours.iter().zip(&self.absorptions) {
            let lost = trig::exp_m1(-gamma * length);
            value += *colour * lost;
            slope += *colour * (-gamma * (1.0 + lost));
        }
        let narrow = |matrix: DMat3| matrix.to_cols_array().map(|x| x as f32);
        Node { value: narrow(value), slope: narrow(slope) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::colour::tristimulus;
    use crate::ice::{Absorption, IceAbsorption};

    const ICE: IceAbsorption = IceAbsorption::Picard2016;

    /// The sum over wavelengths itself.
    fn summed(light: Illuminant, primaries: Primaries, weight: [f32; 3], length: f64) -> DVec3 {
        let xyz = tristimulus(light, |nm| {
            let spectra = reflectances(nm);
            let weight = (0..3).map(|i| f64::from(weight[i]) * spectra[i]).sum::<f64>();
            weight * trig::exp(-ICE.per_metre(nm) * length)
        });
        primaries.under_d65() * xyz
    }

    #[test]
    fn the_table_is_the_sum_over_wavelengths() {
        for (light, primaries) in [
            (Illuminant::D65, Primaries::Srgb),
            (Illuminant::D65, Primaries::AcesCg),
            (Illuminant::A, Primaries::Srgb),
        ] {
            let colour = IceColour::new(light, primaries, |nm| ICE.per_metre(nm));
            for step in -120..90 {
                let length = trig::pow(1.17, f64::from(step));
                for weight in [[1.0; 3], [0.7, 0.1, 0.0], [0.0, 0.0, 1.0]] {
                    let found = DVec3::from(colour.apply(weight, length).map(f64::from));
                    let expected = summed(light, primaries, weight, length);
                    let error = (found - expected).abs().max_element();
                    assert!(error < 1e-6, "{light:?} {length}: {found} {expected}");
                }
            }
        }
    }

    #[test]
    fn clear_ice_and_no_ice_change_no_bit_of_daylight() {
        let clear = IceColour::new(Illuminant::D65, Primaries::Srgb, |_| 0.0);
        let weight = [0.3, 1.0, 7e-5];
        assert_eq!(clear.apply(weight, 12.0), weight);
        let ice = IceColour::new(Illuminant::D65, Primaries::Srgb, |nm| ICE.per_metre(nm));
        assert_eq!(ice.apply(weight, 0.0), weight);
        assert_eq!(clear.apply([1.0; 3], 1e9), [1.0; 3]);
    }

    #[test]
    fn the_mean_of_the_bands_is_the_colour_of_the_light() {
        for (light, primaries) in
            [(Illuminant::D65, Primaries::Srgb), (Illuminant::A, Primaries::AcesCg)]
        {
            let whole = IceColour::new(light, primaries, |nm| ICE.per_metre(nm));
            let bands = Band::all()
                .map(|band| IceColour::in_band(light, primaries, &band, |nm| ICE.per_metre(nm)));
            for length in [0.0, 1e-3, 0.1, 3.0] {
                for weight in [[1.0; 3], [0.7, 0.1, 0.0]] {
                    let sum = bands.iter().fold(DVec3::ZERO, |sum, band| {
                        sum + DVec3::from(band.apply(weight, length).map(f64::from))
                    });
                    let expected = DVec3::from(whole.apply(weight, length).map(f64::from));
                    let error = (sum / BANDS as f64 - expected).abs().max_element();
                    assert!(error < 4e-6, "{light:?} {length}: {error:e}");
                }
            }
        }
    }

    #[test]
    fn grey_ice_follows_beer_and_lambert() {
        for per_metre in [1e-9, 3.0, 1e7] {
            let grey = Absorption::Grey(per_metre);
            let colour = IceColour::new(Illuminant::D65, Primaries::Srgb, |nm| grey.per_metre(nm));
            for depth in [1e-9, 1e-3, 0.5, 1.0, 3.7, 12.0, 1e4] {
                let expected = trig::exp(-depth) as f32;
                for found in colour.apply([1.0; 3], depth / per_metre) {
                    assert!((found - expected).abs() < 1e-6, "{depth}: {found} {expected}");
                }
            }
        }
    }

    #[test]
    fn deep_ice_is_bluer_than_a_screen_and_ends_black() {
        let ice = IceColour::new(Illuminant::D65, Primaries::Srgb, |nm| ICE.per_metre(nm));
        let [red, green, blue] = ice.apply([1.0; 3], 20.0);
        assert!(red < -0.01 && green > 0.0 && blue > green, "{red} {green} {blue}");
        assert!(ice.apply([1.0; 3], 1e5).iter().all(|x| x.abs() < 1e-6));
    }
}
