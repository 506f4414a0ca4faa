//! How far two pictures are apart.

pub mod flip;
mod z_test;

pub use z_test::ZTest;

use crate::develop::{self, Development};
use crate::{FilmError, Picture};

/// Everything said about a picture against a reference.
#[derive(Clone, Debug, PartialEq)]
pub struct Comparison {
    /// Root mean square of the difference over all pixels and the channels R, G, B.
    pub rmse: f64,
    /// [`Comparison::rmse`] divided by the mean of the reference over the same values; infinite
    /// where a black reference differs from the picture, 0 where it does not.
    pub relative_rmse: f64,
    /// Mean of the picture, RGB.
    pub mean: [f64; 3],
    /// Mean of the reference, RGB.
    pub reference_mean: [f64; 3],
    /// Whether noise explains the difference; where both pictures have variance layers and some
    /// pixel at least two samples in both.
    pub z_test: Option<ZTest>,
    /// Mean LDR-FLIP error of both pictures developed to 8 bits, in [0, 1].
    pub flip: f64,
}

/// Compares a picture with a reference; `exposure` in stops and `pixels_per_degree` serve FLIP only.
///
/// # Errors
/// A picture without colour, or pictures that do not cover the same pixels or have other primaries.
pub fn compare(
    picture: &Picture,
    reference: &Picture,
    exposure: f64,
    pixels_per_degree: f64,
) -> Result<Comparison, FilmError> {
    if picture.window() != reference.window() {
        let (ours, theirs) = (picture.window(), reference.window());
        return Err(FilmError::PicturesDiffer { ours, theirs });
    }
    if picture.primaries != reference.primaries {
        let (ours, theirs) = (picture.primaries.name(), reference.primaries.name());
        return Err(FilmError::PrimariesDiffer { ours, theirs });
    }
    let rmse = rmse(picture, reference)?;
    let reference_mean = reference.mean_radiance()?;
    let level = reference_mean.iter().sum::<f64>() / 3.0;
    let flip = flip::flip(
        &develop::to_8_bit(reference, &Development::plain(exposure))?,
        &develop::to_8_bit(picture, &Development::plain(exposure))?,
        pixels_per_degree,
    )?;
    Ok(Comparison {
        rmse,
        relative_rmse: if rmse == 0.0 { 0.0 } else { rmse / level },
        mean: picture.mean_radiance()?,
        reference_mean,
        z_test: z_test::z_test(picture, reference)?,
        flip: flip.mean,
    })
}

fn rmse(picture: &Picture, reference: &Picture) -> Result<f64, FilmError> {
    let (ours, theirs) = (picture.colour()?, reference.colour()?);
    let mut sum = 0.0;
    for (a, b) in ours.iter().zip(theirs) {
        for (&x, &y) in a.iter().zip(b) {
            let difference = f64::from(x) - f64::from(y);
            sum += difference * difference;
        }
    }
    Ok((sum / (3.0 * picture.window().area() as f64)).sqrt())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Layer, PixelRect};

    fn grey(width: u32, height: u32, value: f32) -> Picture {
        let window = PixelRect::new(0, 0, width, height);
        let mut picture = Picture::new(width, height, window).unwrap();
        for layer in Layer::COLOUR {
            picture.set_layer(layer, vec![value; window.area() as usize]).unwrap();
        }
        picture
    }

    #[test]
    fn equal_pictures_are_at_no_distance() {
        let comparison = compare(&grey(8, 8, 0.3), &grey(8, 8, 0.3), 0.0, 67.0).unwrap();
        assert_eq!((comparison.rmse, comparison.relative_rmse, comparison.flip), (0.0, 0.0, 0.0));
        assert_eq!(comparison.z_test, None);
    }

    #[test]
    fn the_root_mean_square_is_that_of_the_definition() {
        let (mut picture, reference) = (grey(2, 1, 0.5), grey(2, 1, 0.5));
        picture.set_layer(Layer::G, vec![0.5, 1.0]).unwrap();
        let comparison = compare(&picture, &reference, 0.0, 67.0).unwrap();
        assert_eq!(comparison.rmse, (0.25f64 / 6.0).sqrt());
        assert_eq!(comparison.relative_rmse, comparison.rmse / 0.5);
        assert_eq!(comparison.mean, [0.5, 0.75, 0.5]);
    }

    #[test]
    fn other_pixels_are_refused() {
        let error = compare(&grey(2, 1, 0.5), &grey(1, 2, 0.5), 0.0, 67.0).unwrap_err();
        assert!(matches!(error, FilmError::PicturesDiffer { .. }));
    }
}
