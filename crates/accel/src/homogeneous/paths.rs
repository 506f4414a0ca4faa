//! Sixteen paths and their steps, of which only the depth and the cosine of the direction count.

use super::account::Account;
use super::arithmetic::{cos_of_turn, ln};
use super::grain::{Grain, Passage};
use super::sampled::{any_sampled, replace};
use super::{
    HomogeneousCrossing, HomogeneousEnd, HomogeneousLayers, HomogeneousPath, Illumination,
};
use crate::flight::random::unit_interval;
use crate::flight::vector::{F, W, WIDTH};
use fearless_simd::prelude::*;
use snowgrain_math::sampler::{PathKey, numbers};
use std::ops::Range;

/// The state of sixteen paths. Depths are optical.
struct Paths {
    account: Account,
    depth: [f32; WIDTH],
    cos_theta: [f32; WIDTH],
    flying: u32,
}

/// What does not change.
struct Constants<'a> {
    layers: &'a HomogeneousLayers,
    eta: f32,
    /// Depth of the bottom.
    bottom: f32,
    /// Whether any grains are no spheres.
    sampled: bool,
}

#[inline(always)]
pub(super) fn trace<S: Simd>(
    simd: S,
    layers: &HomogeneousLayers,
    mut todo: Range<u64>,
    ended: &mut impl FnMut(HomogeneousPath<'_>),
    crossed: &mut impl FnMut(HomogeneousCrossing<'_>),
) {
    let bottom = layers.bottoms.last().copied().unwrap_or(0.0);
    let sampled = any_sampled(&layers.scattering);
    let constants = Constants { layers, eta: layers.eta as f32, bottom, sampled };
    let mut paths = Box::new(Paths {
        account: Account::new(),
        depth: [0.0; WIDTH],
        cos_theta: [0.0; WIDTH],
        flying: 0,
    });
    for lane in 0..WIDTH {
        paths.start(lane, layers, &mut todo);
    }
    while paths.flying != 0 {
        let mut done = step(simd, &constants, &mut paths, crossed);
        while done != 0 {
            let lane = done.trailing_zeros() as usize;
            done &= done - 1;
            if let Some(end) = paths.end_of(lane, &constants) {
                paths.tell(lane, end, layers, ended);
                paths.start(lane, layers, &mut todo);
            }
        }
    }
}

impl Paths {
    /// The next path takes a lane, if one is left.
    fn start(&mut self, lane: usize, layers: &HomogeneousLayers, todo: &mut Range<u64>) {
        self.flying &= !(1 << lane);
        let Some(number) = todo.next() else { return };
        let key = PathKey::new(layers.seed, number, 0);
        self.account.open(lane, key, layers.bottoms.len());
        self.depth[lane] = 0.0;
        self.cos_theta[lane] = match layers.illumination {
            Illumination::Parallel(cos_theta) => cos_theta,
            // The square root of a number in (0, 1]: as flux through a plane.
            Illumination::Diffuse => (1.0 - numbers(key, 0)[0]).sqrt(),
        };
        self.flying |= 1 << lane;
    }

    /// Looks at a path that has left, has crossed much ice, or comes to a roulette.
    fn end_of(&mut self, lane: usize, constants: &Constants<'_>) -> Option<HomogeneousEnd> {
        let layers = constants.layers;
        if self.depth[lane] < 0.0 {
            return Some(HomogeneousEnd::Reflected);
        }
        if self.depth[lane] > constants.bottom {
            return Some(HomogeneousEnd::Transmitted);
        }
        let goes_on = self.account.settle(lane, layers.bottoms.len(), layers.seed);
        (!goes_on).then_some(HomogeneousEnd::GivenUp)
    }

    fn tell(
        &self,
        lane: usize,
        end: HomogeneousEnd,
        layers: &HomogeneousLayers,
        ended: &mut impl FnMut(HomogeneousPath<'_>),
    ) {
        let count = layers.bottoms.len();
        ended(HomogeneousPath {
            end,
            weight: self.account.weight(lane),
            cos_theta: self.cos_theta[lane],
            ice_lengths: &self.account.ice_lengths(lane, count)[..count],
            grain_visits: self.account.visits[lane],
        });
    }

    /// Shows the paths `which` that went through a plane.
    fn show_crossings(
        &self,
        mut which: u32,
        (plane, layers): (usize, &HomogeneousLayers),
        crossed: &mut impl FnMut(HomogeneousCrossing<'_>),
    ) {
        which &= self.flying;
        let count = layers.bottoms.len();
        while which != 0 {
            let lane = which.trailing_zeros() as usize;
            which &= which - 1;
            crossed(HomogeneousCrossing {
                plane,
                downwards: self.cos_theta[lane] > 0.0,
                weight: self.account.weight(lane),
                ice_lengths: &self.account.ice_lengths(lane, count)[..count],
            });
        }
    }
}

/// One free path and one grain for each path; the set of those that must be looked at.
#[inline(always)]
fn step<S: Simd>(
    simd: S,
    constants: &Constants<'_>,
    paths: &mut Paths,
    crossed: &mut impl FnMut(HomogeneousCrossing<'_>),
) -> u32 {
    let splat = |v: f32| F::<S>::splat(simd, v);
    let (zero, one) = (splat(0.0), splat(1.0));
    let [a, b, c] = paths.account.next_words(simd);

    // 1. The free path.
    let cos_theta = F::<S>::from_slice(simd, &paths.cos_theta);
    let free = zero - ln(simd, one - unit_interval(simd, a));
    let before = F::<S>::from_slice(simd, &paths.depth);
    let depth = before + cos_theta * free;
    depth.store_slice(&mut paths.depth);
    for (plane, &at) in constants.layers.planes.iter().enumerate() {
        let at_plane = splat(at);
        let through = before.simd_lt(at_plane) ^ depth.simd_lt(at_plane);
        let through = through.to_bitmask() as u32;
        if through != 0 {
            paths.show_crossings(through, (plane, constants.layers), crossed);
        }
    }
    let inside = depth.simd_ge(zero) & depth.simd_le(splat(constants.bottom));

    // 2. The grain, and the angle by which it turns the path.
    let low = W::<S>::splat(simd, 0xFF);
    let rest = ((a & low) << 16) | ((b & low) << 8) | (c & low);
    let of = (constants.eta, constants.layers.polarisation);
    let grain = Grain::met(simd, of, unit_interval(simd, b), rest);
    let Passage { cos, chords, .. } = grain.pass(simd, unit_interval(simd, c));
    let [cos_turn, chords] = if constants.sampled {
        let layers = constants.layers;
        replace(simd, (&layers.scattering, &layers.bottoms), (depth, b), [cos, chords])
    } else {
        [cos, chords]
    };
    let sin_turn = (one - cos_turn * cos_turn).max(zero).sqrt();
    // The bit that chose the polarisation is not used again.
    let azimuth = unit_interval(simd, rest << 9);
    let sin_theta = (one - cos_theta * cos_theta).max(zero).sqrt();
    // Counted from the direction that leads up.
    let turned = cos_theta * cos_turn - sin_theta * sin_turn * cos_of_turn(simd, azimuth);
    let turned = turned.min(one).max(splat(-1.0));
    inside.select(turned, cos_theta).store_slice(&mut paths.cos_theta);

    // 3. Its ice.
    let layers = (&constants.layers.bottoms[..], &constants.layers.least_absorption[..]);
    let look = !inside | paths.account.book(simd, (inside, depth, chords), layers);
    look.to_bitmask() as u32 & paths.flying
}
