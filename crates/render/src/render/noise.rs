//! How many samples each block of pixels needs for a wanted noise, found before the picture is rendered.
//!
//! A pilot gives every pixel of a block [`PILOT_SAMPLES`] samples of a stream that no picture uses, and
//! the spread of these says how many the block needs. So counts are a function of the scene, the seed and
//! the target alone (contract 2), and since the samples of the picture do not decide how many they are,
//! their mean stays unbiased. Counting on until the samples themselves look good enough would not: dark
//! pixels would stop by chance before they met their light.

use super::{RenderControl, RenderSettings, render_to};
use crate::statistics::Statistics;
use crate::{RenderError, Scene};
use snowgrain_film::{BlockCounts, Film, FilmIdentity, PixelRect};

/// Samples of each pixel in the pilot: 4096 of a whole block, which know its variance to a few percent
/// where single samples are all or nothing.
pub const PILOT_SAMPLES: u64 = 16;

/// The first of them: sample indices from here on are never part of a picture.
const PILOT_START: u64 = 1 << 63;

/// What a pilot found.
#[derive(Clone, Debug)]
pub struct Pilot {
    /// How many samples each block is to have.
    pub counts: BlockCounts,
    /// Blocks that would need more than was allowed.
    pub held_back: u64,
    /// Counts of the pilot's own paths.
    pub statistics: Statistics,
}

/// Renders the pilot with the threads of the current rayon pool, and chooses how many samples each block
/// of `settings.crop` needs for a relative error ([`snowgrain_film::noise`]) of `target`: at least
/// [`PILOT_SAMPLES`], but never more than `most`. `None` where `control` stopped it.
///
/// A block that the crop cuts is taken whole, so that a crop has the counts of the whole picture. Of the
/// settings only crop and level count.
///
/// # Errors
/// As [`super::render`]; a target that is not above 0 and finite.
pub fn block_counts(
    scene: &Scene,
    settings: &RenderSettings,
    target: f64,
    most: u32,
    control: &RenderControl<'_>,
) -> Result<Option<Pilot>, RenderError> {
    let whole_blocks = whole_blocks(settings.crop, scene.film.width, scene.film.height);
    let settings_of_pilot = RenderSettings {
        samples: PILOT_START..PILOT_START + PILOT_SAMPLES,
        crop: whole_blocks,
        level: settings.level,
    };
    let identity = FilmIdentity { scene_hash: scene.hash, seed: scene.film.seed };
    let film = Film::new(scene.film.width, scene.film.height, whole_blocks, identity)?;
    let (rendered, ran) =
        render_to(film, scene, &settings_of_pilot, |rendering| rendering.run(control))?;
    ran?;
    if !rendered.complete {
        return Ok(None);
    }
    let mut held_back = 0;
    let counts = rendered.film.block_noise().map(|block| {
        let ratio = block.relative_error() / target;
        // Where this is beyond all numbers the conversion saturates.
        let needed = (PILOT_SAMPLES as f64 * (ratio * ratio)).ceil() as u64;
        held_back += u64::from(needed > u64::from(most));
        needed.max(PILOT_SAMPLES).min(u64::from(most)) as u32
    });
    let counts = BlockCounts::new(settings.crop, target, counts.collect())?;
    Ok(Some(Pilot { counts, held_back, statistics: rendered.statistics }))
}

/// A crop grown to whole blocks, as far as the picture goes.
fn whole_blocks(crop: PixelRect, width: u32, height: u32) -> PixelRect {
    let down = |x: u32| x - x % BlockCounts::SIDE;
    let up = |x: u32| x.div_ceil(BlockCounts::SIDE).saturating_mul(BlockCounts::SIDE);
    PixelRect::new(down(crop.x0), down(crop.y0), up(crop.x1).min(width), up(crop.y1).min(height))
}
