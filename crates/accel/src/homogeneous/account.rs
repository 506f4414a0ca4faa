//! What sixteen paths carry whichever way they are followed: their random numbers, what they count,
//! and the ice that they have crossed.

use super::MOST_LAYERS;
use crate::flight::random::{NEXT_EVENT, hashed, prepared};
use crate::flight::vector::{F, M, W, WIDTH};
use fearless_simd::prelude::*;
use snowgrain_math::sampler::{PathKey, numbers};

/// The first roulette is at this darkness, as a power of e; the others at each halving of the light.
const DARK: f32 = 1.0;
/// Lengths from which they are summed apart: single precision adds chords of about two radii.
pub(super) const MUCH: f32 = 4096.0;

pub(super) struct Account {
    key: [[u32; WIDTH]; 2],
    event: [u32; WIDTH],
    pub(super) visits: [u32; WIDTH],
    /// Power of two that a path counts.
    doublings: [u32; WIDTH],
    /// Least darkness of ice crossed until the next roulette, as a power of e.
    light: [f32; WIDTH],
    /// Ice of each layer: what was summed apart, and the rest.
    much_ice: [[f64; WIDTH]; MOST_LAYERS],
    ice: [[f32; WIDTH]; MOST_LAYERS],
}

impl Account {
    pub(super) fn new() -> Self {
        Self {
            key: [[0; WIDTH]; 2],
            event: [0; WIDTH],
            visits: [0; WIDTH],
            doublings: [0; WIDTH],
            light: [0.0; WIDTH],
            much_ice: [[0.0; WIDTH]; MOST_LAYERS],
            ice: [[0.0; WIDTH]; MOST_LAYERS],
        }
    }

    /// A new path of this key, whose event 0 is used, through so many layers.
    pub(super) fn open(&mut self, lane: usize, key: PathKey, layers: usize) {
        self.key[0][lane] = prepared(key.lo);
        self.key[1][lane] = prepared(key.hi);
        self.event[lane] = prepared(1);
        self.visits[lane] = 0;
        self.doublings[lane] = 0;
        self.light[lane] = DARK;
        for layer in 0..layers {
            self.much_ice[layer][lane] = 0.0;
            self.ice[layer][lane] = 0.0;
        }
    }

    /// The random words of the next event of each path.
    #[inline(always)]
    pub(super) fn next_words<S: Simd>(&mut self, simd: S) -> [W<S>; 3] {
        let key = [W::<S>::from_slice(simd, &self.key[0]), W::<S>::from_slice(simd, &self.key[1])];
        let event = W::<S>::from_slice(simd, &self.event);
        (event + W::<S>::splat(simd, NEXT_EVENT)).store_slice(&mut self.event);
        hashed::<S>(key, event)
    }

    /// Books a grain of the paths `inside`, at their depths, with the lengths `ice` in it, by layers
    /// with these bottoms and least absorptions; the paths that must be looked at for it.
    #[inline(always)]
    pub(super) fn book<S: Simd>(
        &mut self,
        simd: S,
        (inside, depth, ice): (M<S>, F<S>, F<S>),
        layers: (&[f32], &[f32]),
    ) -> M<S> {
        let splat = |v: f32| F::<S>::splat(simd, v);
        let zero = splat(0.0);
        let ice = inside.select(ice, zero);
        let mut much = M::<S>::splat(simd, false);
        let mut top = splat(f32::NEG_INFINITY);
        let mut light = F::<S>::from_slice(simd, &self.light);
        for (layer, (&bottom, &absorption)) in layers.0.iter().zip(layers.1).enumerate() {
            let bottom = splat(bottom);
            let here = depth.simd_gt(top) & depth.simd_le(bottom);
            let added = here.select(ice, zero);
            let sum = F::<S>::from_slice(simd, &self.ice[layer]) + added;
            sum.store_slice(&mut self.ice[layer]);
            light -= added * splat(absorption);
            much |= sum.simd_gt(splat(MUCH));
            top = bottom;
        }
        light.store_slice(&mut self.light);
        let visits = W::<S>::from_slice(simd, &self.visits);
        let visits = visits + inside.select(W::<S>::splat(simd, 1), W::<S>::splat(simd, 0));
        visits.store_slice(&mut self.visits);
        much | light.simd_lt(zero)
    }

    /// Sums apart what has grown large, and plays the roulettes that are due; whether the path goes on.
    pub(super) fn settle(&mut self, lane: usize, layers: usize, seed: u64) -> bool {
        for layer in 0..layers {
            self.much_ice[layer][lane] += f64::from(self.ice[layer][lane]);
            self.ice[layer][lane] = 0.0;
        }
        while self.light[lane] < 0.0 {
            let key = PathKey::new(seed, self.doublings[lane].into(), self.path_word(lane));
            if numbers(key, 0)[0] < 0.5 {
                return false;
            }
            self.doublings[lane] += 1;
            self.light[lane] += core::f32::consts::LN_2;
        }
        true
    }

    /// A random number in [0, 1) of the path's present grain that nothing else uses.
    pub(super) fn spare_number(&self, lane: usize, seed: u64) -> f32 {
        // Beyond the numbers of roulettes.
        let grain = 1 << 32 | u64::from(self.visits[lane]);
        numbers(PathKey::new(seed, grain, self.path_word(lane)), 0)[0]
    }

    /// A number of the path, for random numbers beside those of its events.
    fn path_word(&self, lane: usize) -> u64 {
        u64::from(self.key[0][lane]) << 32 | u64::from(self.key[1][lane])
    }

    pub(super) fn weight(&self, lane: usize) -> f32 {
        (1u64 << self.doublings[lane].min(62)) as f32
    }

    /// Of the first layers, so many; 0 for the rest.
    pub(super) fn ice_lengths(&self, lane: usize, layers: usize) -> [f64; MOST_LAYERS] {
        let mut lengths = [0.0; MOST_LAYERS];
        for (layer, length) in lengths.iter_mut().enumerate().take(layers) {
            *length = self.much_ice[layer][lane] + f64::from(self.ice[layer][lane]);
        }
        lengths
    }
}
