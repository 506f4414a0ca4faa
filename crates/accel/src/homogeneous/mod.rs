//! Light in plane layers of grains that are met at random: what radiative transfer assumes of snow,
//! without its equation.
//!
//! Between grains a path is free for an exponential length, at a grain it is turned by the closed form
//! of a sphere (`snowgrain_optics::sphere`), or by a sample of light that was followed through grains of other
//! shapes, from the point where it met it: grains are points here.
//! Only the depth and the cosine of the direction matter, so that is all that a path has. It carries
//! its length in the ice of each layer instead of a colour: every absorption follows afterwards.
//!
//! Sixteen paths at once; a path's numbers depend on its key alone.
//!
//! Where light leaves and in which direction needs paths in space: [`trace_in_space`].

mod account;
mod arithmetic;
mod grain;
mod paths;
mod sampled;
mod space;

pub use sampled::{GrainScattering, ScatteringSample};
pub use space::{GrainExtent, Meeting, SpaceEnd, SpaceLayers, trace_in_space};

use crate::SimdLevel;
use fearless_simd::dispatch;
use snowgrain_optics::sphere::Polarisation;
use std::ops::Range;

/// Most layers.
pub const MOST_LAYERS: usize = 32;

/// How a path's first direction is chosen.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Illumination {
    /// The same radiance from all directions above.
    Diffuse,
    /// Parallel light; the cosine of the angle from the vertical, in (0, 1].
    Parallel(f32),
}

impl Illumination {
    /// The direction in which all paths start in space, where there is one.
    #[must_use]
    pub fn direction(self) -> Option<[f32; 3]> {
        match self {
            Self::Diffuse => None,
            Self::Parallel(cos) => Some([(1.0 - cos * cos).max(0.0).sqrt(), 0.0, cos]),
        }
    }
}

/// The layers and the light that falls on them.
#[derive(Clone, Debug, PartialEq)]
pub struct HomogeneousLayers {
    /// Refractive index of the ice, at least 1.
    pub eta: f64,
    /// Polarisation within a grain.
    pub polarisation: Polarisation,
    /// Optical depth of the bottom of each layer, increasing; the last may be infinite.
    pub bottoms: Vec<f32>,
    /// What the grains of each layer do.
    pub scattering: Vec<GrainScattering>,
    /// Optical depths of level planes at which paths are seen to cross; mostly none.
    pub planes: Vec<f32>,
    /// Direction of the light.
    pub illumination: Illumination,
    /// Seed.
    pub seed: u64,
    /// Of each layer, the least absorption per grain radius of ice that will be asked for. Once a path
    /// has less than 1/e of its light at the best, half of the paths are given up each time
    /// that it halves, and the others count double.
    pub least_absorption: Vec<f32>,
}

/// Where a path ended.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum HomogeneousEnd {
    /// Out of the top.
    Reflected,
    /// Out of the bottom.
    Transmitted,
    /// Given up by roulette.
    GivenUp,
}

/// A path that has ended.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HomogeneousPath<'a> {
    /// Where.
    pub end: HomogeneousEnd,
    /// What it counts; the mean over all paths, those given up as 0, is 1.
    pub weight: f32,
    /// Cosine of its direction with the vertical, downwards positive.
    pub cos_theta: f32,
    /// Length in the ice of each layer, in radii of its grains.
    pub ice_lengths: &'a [f64],
    /// Grains that it met.
    pub grain_visits: u32,
}

/// A path that crosses a plane.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HomogeneousCrossing<'a> {
    /// Index of the plane.
    pub plane: usize,
    /// Whether it goes down.
    pub downwards: bool,
    /// What it counts.
    pub weight: f32,
    /// Length in the ice of each layer so far, in radii of its grains.
    pub ice_lengths: &'a [f64],
}

/// Follows the paths numbered `paths` on this thread and shows each end to `ended`, and each crossing
/// of a plane to `crossed`, in an order that depends on the numbers only.
///
/// # Panics
/// If there are no layers, too many, or not as many absorptions and grains; if the machine lacks `level`.
pub fn trace_homogeneous(
    layers: &HomogeneousLayers,
    level: SimdLevel,
    paths: Range<u64>,
    ended: &mut impl FnMut(HomogeneousPath<'_>),
    crossed: &mut impl FnMut(HomogeneousCrossing<'_>),
) {
    let count = layers.bottoms.len();
    assert!((1..=MOST_LAYERS).contains(&count) && count == layers.least_absorption.len());
    assert_eq!(count, layers.scattering.len());
    let level = level.token().expect("the SIMD level was checked when it was chosen");
    dispatch!(level, simd => paths::trace(simd, layers, paths, ended, crossed));
}

#[cfg(test)]
mod tests;
