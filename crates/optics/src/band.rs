//! Bands of wavelengths, into which light is parted where grains refract each colour by its own index.
//!
//! The visible is cut into [`BANDS`] runs of whole nanometres, of about equal parts of what white light (D65)
//! brings to the three functions of the observer: so each band counts as much in a picture as any other. A path
//! of one band stands for all of them, and has [`BANDS`] times the colour of its band, of which the mean over the
//! bands is the colour of the light itself.

use crate::colour::{Illuminant, VISIBLE_NM, observer};
use std::sync::LazyLock;

/// Bands that light is parted into.
pub const BANDS: usize = 16;

/// One of the [`BANDS`].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Band {
    /// First and last wavelength, whole nm.
    pub range_nm: [f64; 2],
    /// Wavelength by whose index it is refracted, nm: the mean, weighted as the bands are cut.
    pub middle_nm: f64,
}

impl Band {
    /// All of them, from violet to red.
    #[must_use]
    pub fn all() -> &'static [Self; BANDS] {
        static ALL: LazyLock<[Band; BANDS]> = LazyLock::new(cut);
        &ALL
    }

    /// Whether a wavelength, whole nm, belongs to it.
    #[must_use]
    pub fn contains(&self, wavelength_nm: f64) -> bool {
        (self.range_nm[0]..=self.range_nm[1]).contains(&wavelength_nm)
    }
}

fn cut() -> [Band; BANDS] {
    let [first, last] = VISIBLE_NM;
    let weight = |nm: f64| observer(nm).element_sum() * Illuminant::D65.power(nm);
    let lines: Vec<(f64, f64)> = (0..=(last - first) as u32)
        .map(|step| first + f64::from(step))
        .map(|nm| (nm, weight(nm)))
        .collect();
    let whole: f64 = lines.iter().map(|(_, weight)| weight).sum();
    let mut rest = lines.as_slice();
    let mut before = 0.0;
    std::array::from_fn(|index| {
        let end = whole * (index + 1) as f64 / BANDS as f64;
        let mut sum = before;
        let belongs = |(_, weight): &&(f64, f64)| {
            let middle = sum + 0.5 * weight;
            sum += weight;
            middle < end || index + 1 == BANDS
        };
        let (band, after) = rest.split_at(rest.iter().take_while(belongs).count());
        rest = after;
        let total: f64 = band.iter().map(|(_, weight)| weight).sum();
        before += total;
        let moment: f64 = band.iter().map(|(nm, weight)| nm * weight).sum();
        Band { range_nm: [band[0].0, band[band.len() - 1].0], middle_nm: moment / total }
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bands_follow_one_another_over_the_visible() {
        let bands = Band::all();
        assert_eq!(bands[0].range_nm[0], VISIBLE_NM[0]);
        assert_eq!(bands[BANDS - 1].range_nm[1], VISIBLE_NM[1]);
        for pair in bands.windows(2) {
            assert_eq!(pair[0].range_nm[1] + 1.0, pair[1].range_nm[0]);
            assert!(pair[0].middle_nm < pair[1].middle_nm);
        }
        assert!(bands.iter().all(|band| band.contains(band.middle_nm.round())));
    }
}
