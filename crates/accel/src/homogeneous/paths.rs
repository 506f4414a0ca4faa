//! Sixteen paths and their steps.

use super::arithmetic::{cos_of_turn, ln};
use super::{
    HomogeneousCrossing, HomogeneousEnd, HomogeneousLayers, HomogeneousPath, Illumination,
    MOST_LAYERS,
};
use crate::flight::random::{NEXT_EVENT, hashed, prepared, unit_interval};
use crate::flight::vector::{F, M, W, WIDTH};
use fearless_simd::prelude::*;
use snowgrain_math::sampler::{PathKey, numbers};
use snowgrain_optics::sphere::Polarisation;
use std::ops::Range;

/// The first roulette is at this darkness, as a power of e; the others at each halving of the light.
const DARK: f32 = 1.0;
/// Radii of ice from which lengths are summed apart: single precision adds chords of about two.
const MUCH_ICE: f32 = 4096.0;

/// The state of sixteen paths. Depths are optical.
struct Paths {
    key: [[u32; WIDTH]; 2],
    event: [u32; WIDTH],
    depth: [f32; WIDTH],
    cos_theta: [f32; WIDTH],
    visits: [u32; WIDTH],
    /// Power of two that a path counts.
    doublings: [u32; WIDTH],
    /// Least darkness of ice crossed until the next roulette, as a power of e.
    light: [f32; WIDTH],
    /// Ice of each layer: what was summed apart, and the rest.
    much_ice: [[f64; WIDTH]; MOST_LAYERS],
    ice: [[f32; WIDTH]; MOST_LAYERS],
    flying: u32,
}

/// What does not change.
struct Constants<'a> {
    layers: &'a HomogeneousLayers,
    eta: f32,
    /// Depth of the bottom.
    bottom: f32,
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
    let constants = Constants { layers, eta: layers.eta as f32, bottom };
    let mut paths = Box::new(Paths {
        key: [[0; WIDTH]; 2],
        event: [0; WIDTH],
        depth: [0.0; WIDTH],
        cos_theta: [0.0; WIDTH],
        visits: [0; WIDTH],
        doublings: [0; WIDTH],
        light: [0.0; WIDTH],
        much_ice: [[0.0; WIDTH]; MOST_LAYERS],
        ice: [[0.0; WIDTH]; MOST_LAYERS],
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
        self.key[0][lane] = prepared(key.lo);
        self.key[1][lane] = prepared(key.hi);
        self.event[lane] = prepared(1);
        self.depth[lane] = 0.0;
        self.cos_theta[lane] = match layers.illumination {
            Illumination::Parallel(cos_theta) => cos_theta,
            // The square root of a number in (0, 1]: as flux through a plane.
            Illumination::Diffuse => (1.0 - numbers(key, 0)[0]).sqrt(),
        };
        self.visits[lane] = 0;
        self.doublings[lane] = 0;
        self.light[lane] = DARK;
        for layer in 0..layers.bottoms.len() {
            self.much_ice[layer][lane] = 0.0;
            self.ice[layer][lane] = 0.0;
        }
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
        for layer in 0..layers.bottoms.len() {
            self.much_ice[layer][lane] += f64::from(self.ice[layer][lane]);
            self.ice[layer][lane] = 0.0;
        }
        while self.light[lane] < 0.0 {
            let key = PathKey::new(layers.seed, self.doublings[lane].into(), self.path_word(lane));
            if numbers(key, 0)[0] < 0.5 {
                return Some(HomogeneousEnd::GivenUp);
            }
            self.doublings[lane] += 1;
            self.light[lane] += core::f32::consts::LN_2;
        }
        None
    }

    /// A number of the path, for random numbers beside those of its events.
    fn path_word(&self, lane: usize) -> u64 {
        u64::from(self.key[0][lane]) << 32 | u64::from(self.key[1][lane])
    }

    fn tell(
        &self,
        lane: usize,
        end: HomogeneousEnd,
        layers: &HomogeneousLayers,
        ended: &mut impl FnMut(HomogeneousPath<'_>),
    ) {
        ended(HomogeneousPath {
            end,
            weight: self.weight(lane),
            cos_theta: self.cos_theta[lane],
            ice_lengths: &self.ice_lengths(lane)[..layers.bottoms.len()],
            grain_visits: self.visits[lane],
        });
    }

    fn weight(&self, lane: usize) -> f32 {
        (1u64 << self.doublings[lane].min(62)) as f32
    }

    fn ice_lengths(&self, lane: usize) -> [f64; MOST_LAYERS] {
        std::array::from_fn(|layer| self.much_ice[layer][lane] + f64::from(self.ice[layer][lane]))
    }

    /// Shows the paths `which` that went through a plane.
    fn show_crossings(
        &self,
        mut which: u32,
        (plane, layers): (usize, &HomogeneousLayers),
        crossed: &mut impl FnMut(HomogeneousCrossing<'_>),
    ) {
        which &= self.flying;
        while which != 0 {
            let lane = which.trailing_zeros() as usize;
            which &= which - 1;
            crossed(HomogeneousCrossing {
                plane,
                downwards: self.cos_theta[lane] > 0.0,
                weight: self.weight(lane),
                ice_lengths: &self.ice_lengths(lane)[..layers.bottoms.len()],
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
    let key = [W::<S>::from_slice(simd, &paths.key[0]), W::<S>::from_slice(simd, &paths.key[1])];
    let event = W::<S>::from_slice(simd, &paths.event);
    let [a, b, c] = hashed::<S>(key, event);
    (event + W::<S>::splat(simd, NEXT_EVENT)).store_slice(&mut paths.event);

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
    let grain = Grain::met(simd, constants, unit_interval(simd, b), rest);
    let (cos_turn, chords) = grain.pass(simd, unit_interval(simd, c));
    let sin_turn = (one - cos_turn * cos_turn).max(zero).sqrt();
    // The bit that chose the polarisation is not used again.
    let azimuth = unit_interval(simd, rest << 9);
    let sin_theta = (one - cos_theta * cos_theta).max(zero).sqrt();
    let turned = cos_theta * cos_turn + sin_theta * sin_turn * cos_of_turn(simd, azimuth);
    let turned = turned.min(one).max(splat(-1.0));
    inside.select(turned, cos_theta).store_slice(&mut paths.cos_theta);

    // 3. Its ice.
    let ice = inside.select(chords, zero);
    let mut much = M::<S>::splat(simd, false);
    let mut top = splat(f32::NEG_INFINITY);
    let mut light = F::<S>::from_slice(simd, &paths.light);
    let layers = constants.layers;
    for (layer, (&bottom, &absorption)) in
        layers.bottoms.iter().zip(&layers.least_absorption).enumerate()
    {
        let bottom = splat(bottom);
        let here = depth.simd_gt(top) & depth.simd_le(bottom);
        let added = here.select(ice, zero);
        let sum = F::<S>::from_slice(simd, &paths.ice[layer]) + added;
        sum.store_slice(&mut paths.ice[layer]);
        light -= added * splat(absorption);
        much |= sum.simd_gt(splat(MUCH_ICE));
        top = bottom;
    }
    light.store_slice(&mut paths.light);
    let visits = W::<S>::from_slice(simd, &paths.visits);
    let visits = visits + inside.select(W::<S>::splat(simd, 1), W::<S>::splat(simd, 0));
    visits.store_slice(&mut paths.visits);
    let look = !inside | much | light.simd_lt(zero);
    look.to_bitmask() as u32 & paths.flying
}

/// A sphere that a path has met: angles and reflectance are the same at all its interfaces.
struct Grain<S: Simd> {
    sin2_i: F<S>,
    cos_i: F<S>,
    sin_t: F<S>,
    cos_t: F<S>,
    reflectance: F<S>,
}

impl<S: Simd> Grain<S> {
    /// Where the sine of the angle of incidence has the square `u`, uniform over the disc.
    #[inline(always)]
    fn met(simd: S, constants: &Constants<'_>, u: F<S>, bits: W<S>) -> Self {
        let splat = |v: f32| F::<S>::splat(simd, v);
        let one = splat(1.0);
        let eta = splat(constants.eta);
        let cos_i = (one - u).sqrt();
        let sin2_t = u * splat(1.0 / (constants.eta * constants.eta));
        let cos_t = (one - sin2_t).sqrt();
        let across = (cos_i - eta * cos_t) / (cos_i + eta * cos_t);
        let along = (eta * cos_i - cos_t) / (eta * cos_i + cos_t);
        let (s, p) = (across * across, along * along);
        let reflectance = match constants.layers.polarisation {
            Polarisation::Redrawn => (s + p) * splat(0.5),
            Polarisation::Tracked => {
                let bit = W::<S>::splat(simd, 1 << 23);
                (bits & bit).simd_eq(bit).select(s, p)
            }
        };
        Self { sin2_i: u, cos_i, sin_t: sin2_t.sqrt(), cos_t, reflectance }
    }

    /// The cosine of the angle by which the path is turned, and its length in ice in radii, for a
    /// number in [0, 1).
    #[inline(always)]
    fn pass(&self, simd: S, v: F<S>) -> (F<S>, F<S>) {
        let splat = |v: f32| F::<S>::splat(simd, v);
        let (zero, one) = (splat(0.0), splat(1.0));
        let (ci, ct, st) = (self.cos_i, self.cos_t, self.sin_t);
        let si = self.sin2_i.sqrt();
        // Refracted in and out: 2 (theta_i - theta_t).
        let (c, s) = (ci * ct + si * st, si * ct - ci * st);
        let (mut cos, mut sin) = (c * c - s * s, splat(2.0) * s * c);
        // Each reflection inside: pi - 2 theta_t more.
        let (cos_more, sin_more) = (st * st - ct * ct, splat(2.0) * st * ct);
        let enters = v.simd_ge(self.reflectance);
        let chord = ct + ct;
        let mut chords = chord;
        // What is left of [0, 1) above `v` is cut at R, R^2, ... of it: as many reflections.
        let mut left = enters.select(one - v, one);
        let mut limit = (one - self.reflectance) * self.reflectance;
        loop {
            let again = left.simd_le(limit) & limit.simd_gt(zero);
            if again.to_bitmask() == 0 {
                break;
            }
            let next = cos * cos_more - sin * sin_more;
            sin = again.select(sin * cos_more + cos * sin_more, sin);
            cos = again.select(next, cos);
            chords += again.select(chord, zero);
            limit = again.select(limit * self.reflectance, zero);
            left = again.select(left, one);
        }
        let mirrored = self.sin2_i + self.sin2_i - one;
        (enters.select(cos, mirrored), enters.select(chords, zero))
    }
}
