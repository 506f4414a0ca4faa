//! Light whose colours are refracted each by its own index.
//!
//! Every sample of a pixel belongs to one of the [`BANDS`] of wavelengths, by its number: each run of [`BANDS`] samples
//! has one of every band, in an order that spreads any part of the run over the visible, and begins with a band
//! that is drawn for the pixel. So any number of samples is unbiased, and a multiple of [`BANDS`] is white where
//! light is. A sample of a band meets grains of the band's index and has the colour of the band
//! ([`snowgrain_optics::IceColour::in_band`]). Objects of glass keep one index.

use crate::description::SceneDescription;
use crate::transport::seek::LightSearch;
use snowgrain_math::sampler::{PathKey, split_mix};
use snowgrain_optics::{BANDS, Band, Grade, IceColour, StrataColour};

/// What a band of wavelengths meets and becomes.
#[derive(Debug)]
pub struct BandOptics {
    /// The wavelengths.
    pub band: Band,
    /// Index of refraction of the grains relative to what is between them.
    pub eta: f64,
    /// As of [`crate::Scene`], of these wavelengths, times [`BANDS`].
    pub colours: Vec<IceColour>,
    /// The same after lengths in ice of several strata.
    pub strata_colours: Vec<StrataColour>,
    /// How their light is looked for, where it is: in closed form and through the first crystal by their own index;
    /// what is measured, by that of the scene.
    pub search: Option<LightSearch>,
}

/// Of each band, from violet to red; none where colours are not parted.
pub(crate) fn bands_of(
    description: &SceneDescription,
    grade: &Grade,
    search: Option<&LightSearch>,
) -> Vec<BandOptics> {
    if !description.ice.disperses {
        return Vec::new();
    }
    let optics = |band: &Band| {
        let (colours, strata_colours) = grade.colours_in(band, &description.strata.loads);
        let eta = description.ice.eta_at(band.middle_nm);
        let search = search.map(|search| search.refracting_by(eta));
        BandOptics { band: *band, eta, colours, strata_colours, search }
    };
    Band::all().iter().map(optics).collect()
}

/// What tells the random number of a pixel's first band from others.
const FIRST_BAND: u64 = 0xd15b_e25e;

/// Of a pixel's samples, those that belong to `band` are congruent to this number modulo [`BANDS`]; `stream` is
/// the number of the pixel.
pub(crate) fn residue_of(seed: u64, stream: u64, band: usize) -> u64 {
    let PathKey { lo: first, .. } = PathKey::new(seed ^ split_mix(FIRST_BAND), stream, 0);
    let place = (band as u32).wrapping_sub(first) % BANDS as u32;
    u64::from(place.reverse_bits() >> (u32::BITS - BANDS.ilog2()))
}

const _: () = assert!(BANDS.is_power_of_two());

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_run_of_samples_has_each_band_once_and_pixels_begin_with_any() {
        let mut first = [0i32; BANDS];
        for pixel in 0..4096 {
            let mut taken = [false; BANDS];
            for (band, first) in first.iter_mut().enumerate() {
                let residue = residue_of(7, pixel, band) as usize;
                assert!(!std::mem::replace(&mut taken[residue], true));
                *first += i32::from(residue == 0);
            }
        }
        // 256 each; five standard deviations.
        assert!(first.iter().all(|count| (count - 256).abs() < 78), "{first:?}");
    }

    #[test]
    fn four_samples_in_a_row_lie_in_four_quarters_of_the_visible() {
        let bands: Vec<usize> = (0..4u64)
            .map(|sample| (0..BANDS).find(|&band| residue_of(1, 5, band) == sample).unwrap())
            .collect();
        let mut apart: Vec<usize> =
            bands.iter().map(|band| (band + BANDS - bands[0]) % BANDS).collect();
        apart.sort_unstable();
        assert_eq!(apart, [0, 4, 8, 12]);
    }
}
