//! The sunlit body of a picture: what exposure and white balance are set by.
//!
//! Of the pixels that hit something (alpha of at least a half; all where alpha is not known) and have light, the
//! 95th percentile of luminance is the level of the brightest part that is large: glints, lamps and outliers of
//! noise are fewer than a twentieth. The body is what lies from one stop under that level to one stop over it:
//! sunlit snow where there is sun (its shade is two stops darker), all snow under an overcast sky.
//! The backdrop has no part in it.

use super::Scene;

/// The percentile that is the level of the body.
const PERCENTILE: f64 = 0.95;

/// The body of a picture.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Body {
    /// Median luminance.
    pub(super) luminance: f64,
    /// Mean colour, linear sRGB.
    pub(super) colour: [f64; 3],
}

/// Luminance of linear sRGB (IEC 61966-2-1).
pub(super) fn luminance([r, g, b]: [f64; 3]) -> f64 {
    0.2126 * r + 0.7152 * g + 0.0722 * b
}

impl Body {
    /// The body of a picture; `None` where nothing has light.
    pub(super) fn of(scene: &Scene<'_>) -> Option<Self> {
        let alpha = scene.alpha;
        let hit = |&pixel: &usize| alpha.is_none_or(|alpha| alpha[pixel] >= 0.5);
        let lit = (0..scene.pixels()).filter(hit).map(|pixel| scene.colour(pixel));
        let lit: Vec<_> = lit
            .map(|colour| (luminance(colour), colour))
            .filter(|(y, _)| *y > 0.0 && y.is_finite())
            .collect();
        let mut levels: Vec<f64> = lit.iter().map(|(y, _)| *y).collect();
        let level = quantile(&mut levels, PERCENTILE)?;
        let body = lit.iter().filter(|(y, _)| (0.5 * level..=2.0 * level).contains(y));
        let (mut inside, mut colour) = (Vec::new(), [0.0; 3]);
        for (y, light) in body {
            inside.push(*y);
            colour.iter_mut().zip(light).for_each(|(sum, x)| *sum += x);
        }
        let count = inside.len() as f64;
        let luminance = quantile(&mut inside, 0.5)?;
        Some(Self { luminance, colour: colour.map(|sum| sum / count) })
    }
}

/// The value under which this part of the values lies; `None` of none.
fn quantile(values: &mut [f64], part: f64) -> Option<f64> {
    let last = values.len().checked_sub(1)?;
    let (_, value, _) =
        values.select_nth_unstable_by((part * last as f64) as usize, f64::total_cmp);
    Some(*value)
}
