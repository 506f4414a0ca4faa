//! The same light followed in space: with a direction of three parts and a place on the surface.
//!
//! The path starts at the origin, on the surface; x points where parallel light goes, z down.

use super::account::{Account, MUCH};
use super::arithmetic::{cos_sin_of_turn, ln};
use super::grain::{Grain, Passage};
use super::sampled::{GrainScattering, any_sampled, replace};
use super::{HomogeneousEnd, Illumination, MOST_LAYERS};
use crate::SimdLevel;
use crate::flight::random::unit_interval;
use crate::flight::vector::{F, M, Vector, W, WIDTH};
use fearless_simd::dispatch;
use fearless_simd::prelude::*;
use snowgrain_math::sampler::{PathKey, numbers};
use snowgrain_math::trig;
use snowgrain_optics::sphere::Polarisation;
use std::ops::Range;

/// Whether a grain takes room.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum GrainExtent {
    /// A path goes on from where it met the grain: the equation of radiative transfer.
    Points,
    /// It goes on from where it leaves the sphere, whose radius is the unit of length. A grain that would
    /// reach beyond a face of the snow lets light out at that face.
    Spheres,
}

/// The layers and the light that falls on them.
#[derive(Clone, Debug, PartialEq)]
pub struct SpaceLayers {
    /// Refractive index of the ice, at least 1.
    pub eta: f64,
    /// Polarisation within a grain.
    pub polarisation: Polarisation,
    /// Depth of the bottom of each layer, increasing; the last may be infinite.
    pub bottoms: Vec<f32>,
    /// What the grains of each layer do; other than spheres are points.
    pub scattering: Vec<GrainScattering>,
    /// Mean way from grain to grain, in the unit of the depths: 1 where they are optical.
    pub free_path: f32,
    /// Whether grains take room.
    pub extent: GrainExtent,
    /// Direction of the light.
    pub illumination: Illumination,
    /// Depth down to which meetings with grains are shown; below 0: none is.
    pub shown_depth: f32,
    /// Seed.
    pub seed: u64,
    /// As for [`super::HomogeneousLayers`].
    pub least_absorption: Vec<f32>,
}

/// A path that comes to a grain.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Meeting<'a> {
    /// Depth.
    pub depth: f32,
    /// Unit direction in which it comes.
    pub direction: [f32; 3],
    /// What the path counts.
    pub weight: f32,
    /// Length in the ice of each layer so far, in radii of its grains.
    pub ice_lengths: &'a [f64],
    /// Grains that it met before.
    pub grain_visits: u32,
    /// A random number in [0, 1) that nothing else uses.
    pub number: f32,
}

/// A path that has ended.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SpaceEnd<'a> {
    /// Where.
    pub end: HomogeneousEnd,
    /// What it counts; the mean over all paths, those given up as 0, is 1.
    pub weight: f32,
    /// x and y of the point of the face where it left.
    pub place: [f64; 2],
    /// Unit direction.
    pub direction: [f32; 3],
    /// Length between grains, in the unit of the depths.
    pub void_length: f64,
    /// Length in the ice of each layer, in radii of its grains.
    pub ice_lengths: &'a [f64],
    /// Grains that it met.
    pub grain_visits: u32,
}

/// Follows the paths numbered `paths` on this thread and shows each grain that they come to, down to the
/// depth asked for, to `met`, and each end to `ended`, in an order that depends on the numbers only.
///
/// # Panics
/// If there are no layers, too many, or not as many absorptions and grains; if grains that take room are no
/// spheres; if the machine lacks `level`.
pub fn trace_in_space(
    layers: &SpaceLayers,
    level: SimdLevel,
    paths: Range<u64>,
    met: &mut impl FnMut(Meeting<'_>),
    ended: &mut impl FnMut(SpaceEnd<'_>),
) {
    let count = layers.bottoms.len();
    assert!((1..=MOST_LAYERS).contains(&count) && count == layers.least_absorption.len());
    assert_eq!(count, layers.scattering.len());
    let spheres = !any_sampled(&layers.scattering);
    assert!(spheres || layers.extent == GrainExtent::Points, "only spheres take room");
    let level = level.token().expect("the SIMD level was checked when it was chosen");
    dispatch!(level, simd => trace(simd, (layers, spheres), paths, met, ended));
}

/// The state of sixteen paths.
struct Paths {
    account: Account,
    position: [[f32; WIDTH]; 3],
    direction: [[f32; WIDTH]; 3],
    /// Length between grains: what was summed apart, and the rest.
    much_void: [f64; WIDTH],
    void: [f32; WIDTH],
    flying: u32,
}

#[inline(always)]
fn trace<S: Simd>(
    simd: S,
    (layers, spheres): (&SpaceLayers, bool),
    mut todo: Range<u64>,
    met: &mut impl FnMut(Meeting<'_>),
    ended: &mut impl FnMut(SpaceEnd<'_>),
) {
    let mut paths = Box::new(Paths {
        account: Account::new(),
        position: [[0.0; WIDTH]; 3],
        direction: [[0.0; WIDTH]; 3],
        much_void: [0.0; WIDTH],
        void: [0.0; WIDTH],
        flying: 0,
    });
    for lane in 0..WIDTH {
        paths.start(lane, layers, &mut todo);
    }
    while paths.flying != 0 {
        let mut done = step(simd, (layers, spheres), &mut paths, met);
        while done != 0 {
            let lane = done.trailing_zeros() as usize;
            done &= done - 1;
            if let Some(end) = paths.end_of(lane, layers) {
                paths.tell(lane, end, layers, ended);
                paths.start(lane, layers, &mut todo);
            }
        }
    }
}

impl Paths {
    /// The next path takes a lane, if one is left.
    fn start(&mut self, lane: usize, layers: &SpaceLayers, todo: &mut Range<u64>) {
        self.flying &= !(1 << lane);
        let Some(number) = todo.next() else { return };
        let key = PathKey::new(layers.seed, number, 0);
        self.account.open(lane, key, layers.bottoms.len());
        let direction = first_direction(layers.illumination, key);
        for (axis, part) in direction.into_iter().enumerate() {
            self.position[axis][lane] = 0.0;
            self.direction[axis][lane] = part;
        }
        self.much_void[lane] = 0.0;
        self.void[lane] = 0.0;
        self.flying |= 1 << lane;
    }

    /// Looks at a path that has left, has gone far, or comes to a roulette.
    fn end_of(&mut self, lane: usize, layers: &SpaceLayers) -> Option<HomogeneousEnd> {
        let depth = self.position[2][lane];
        if depth < 0.0 {
            return Some(HomogeneousEnd::Reflected);
        }
        if depth > bottom_of(layers) {
            return Some(HomogeneousEnd::Transmitted);
        }
        self.much_void[lane] += f64::from(self.void[lane]);
        self.void[lane] = 0.0;
        let goes_on = self.account.settle(lane, layers.bottoms.len(), layers.seed);
        (!goes_on).then_some(HomogeneousEnd::GivenUp)
    }

    fn direction(&self, lane: usize) -> [f32; 3] {
        self.direction.map(|axis| axis[lane])
    }

    fn tell(
        &self,
        lane: usize,
        end: HomogeneousEnd,
        layers: &SpaceLayers,
        ended: &mut impl FnMut(SpaceEnd<'_>),
    ) {
        let direction = self.direction(lane);
        let face = match end {
            HomogeneousEnd::Reflected => 0.0,
            HomogeneousEnd::Transmitted => bottom_of(layers),
            HomogeneousEnd::GivenUp => self.position[2][lane],
        };
        // How far the last way leads beyond the face.
        let beyond = f64::from(self.position[2][lane] - face) / f64::from(direction[2]);
        let beyond = if beyond.is_finite() { beyond } else { 0.0 };
        let place = [0, 1].map(|axis: usize| {
            f64::from(self.position[axis][lane]) - beyond * f64::from(direction[axis])
        });
        let count = layers.bottoms.len();
        ended(SpaceEnd {
            end,
            weight: self.account.weight(lane),
            place,
            direction,
            void_length: self.much_void[lane] + f64::from(self.void[lane]) - beyond,
            ice_lengths: &self.account.ice_lengths(lane, count)[..count],
            grain_visits: self.account.visits[lane],
        });
    }

    /// Shows the paths `which` that come to a grain.
    fn show_meetings(
        &self,
        mut which: u32,
        layers: &SpaceLayers,
        met: &mut impl FnMut(Meeting<'_>),
    ) {
        which &= self.flying;
        let count = layers.bottoms.len();
        while which != 0 {
            let lane = which.trailing_zeros() as usize;
            which &= which - 1;
            met(Meeting {
                depth: self.position[2][lane],
                direction: self.direction(lane),
                weight: self.account.weight(lane),
                ice_lengths: &self.account.ice_lengths(lane, count)[..count],
                grain_visits: self.account.visits[lane],
                number: self.account.spare_number(lane, layers.seed),
            });
        }
    }
}

fn first_direction(illumination: Illumination, key: PathKey) -> [f32; 3] {
    illumination.direction().unwrap_or_else(|| {
        // The square root of a number in (0, 1]: as flux through a plane.
        let [sin2, azimuth, _] = numbers(key, 0);
        let (across, along) = trig::sin_cos(core::f64::consts::TAU * f64::from(azimuth));
        let sin = f64::from(sin2.sqrt());
        [(sin * along) as f32, (sin * across) as f32, (1.0 - sin2).sqrt()]
    })
}

fn bottom_of(layers: &SpaceLayers) -> f32 {
    layers.bottoms.last().copied().unwrap_or(0.0)
}

/// One free path and one grain for each path; the set of those that must be looked at.
#[inline(always)]
fn step<S: Simd>(
    simd: S,
    (layers, spheres): (&SpaceLayers, bool),
    paths: &mut Paths,
    met: &mut impl FnMut(Meeting<'_>),
) -> u32 {
    let splat = |v: f32| F::<S>::splat(simd, v);
    let (zero, one) = (splat(0.0), splat(1.0));
    let [a, b, c] = paths.account.next_words(simd);

    // 1. The free path.
    let direction = Vector::load(simd, &paths.direction, 0);
    let free = splat(layers.free_path) * (zero - ln(simd, one - unit_interval(simd, a)));
    let position = Vector::load(simd, &paths.position, 0).plus(direction, free);
    position.store(&mut paths.position, 0);
    let void = F::<S>::from_slice(simd, &paths.void) + free;
    void.store_slice(&mut paths.void);
    let (depth, bottom) = (position.2, splat(bottom_of(layers)));
    let inside = depth.simd_ge(zero) & depth.simd_le(bottom);
    let shown = inside & depth.simd_le(splat(layers.shown_depth));
    let shown = shown.to_bitmask() as u32;
    if shown != 0 {
        paths.show_meetings(shown, layers, met);
    }

    // 2. The grain: where it lets the path out, and in which direction.
    let low = W::<S>::splat(simd, 0xFF);
    let rest = ((a & low) << 16) | ((b & low) << 8) | (c & low);
    let of = (layers.eta as f32, layers.polarisation);
    let mut passage =
        Grain::met(simd, of, unit_interval(simd, b), rest).pass(simd, unit_interval(simd, c));
    if !spheres {
        let layers = (&layers.scattering[..], &layers.bottoms[..]);
        let sphere = [passage.cos, passage.chords];
        [passage.cos, passage.chords] = replace(simd, layers, (depth, b), sphere);
        passage.sin = (one - passage.cos * passage.cos).max(zero).sqrt();
    }
    // The bit that chose the polarisation is not used again.
    let across = across(simd, direction, unit_interval(simd, rest << 9));
    let turned = direction.scaled(passage.cos).plus(across, passage.sin).straightened(simd);
    // What goes straight through keeps its direction to the last bit.
    let turns = if spheres { inside } else { inside & passage.cos.simd_lt(one) };
    Vector::choose(turns, turned, direction).store(&mut paths.direction, 0);
    if layers.extent == GrainExtent::Spheres {
        let left = leave(simd, position, direction, across, &passage, bottom);
        Vector::choose(inside, left, position).store(&mut paths.position, 0);
    }

    // 3. Its ice.
    let of = (&layers.bottoms[..], &layers.least_absorption[..]);
    let booked = paths.account.book(simd, (inside, depth, passage.chords), of);
    let far: M<S> = void.simd_gt(splat(MUCH));
    (!inside | booked | far).to_bitmask() as u32 & paths.flying
}

/// Where the path leaves the sphere, within the snow.
#[inline(always)]
fn leave<S: Simd>(
    simd: S,
    position: Vector<S>,
    direction: Vector<S>,
    across: Vector<S>,
    passage: &Passage<S>,
    bottom: F<S>,
) -> Vector<S> {
    let Vector(x, y, z) = position.plus(direction, passage.along).plus(across, passage.across);
    Vector(x, y, z.max(F::<S>::splat(simd, 0.0)).min(bottom))
}

/// A unit vector across a unit vector, turned about it by a part of a full turn: Duff et al. 2017,
/// "Building an Orthonormal Basis, Revisited", JCGT 6(1).
#[inline(always)]
fn across<S: Simd>(simd: S, Vector(x, y, z): Vector<S>, turn: F<S>) -> Vector<S> {
    let splat = |v: f32| F::<S>::splat(simd, v);
    let (zero, one) = (splat(0.0), splat(1.0));
    let sign = z.simd_lt(zero).select(splat(-1.0), one);
    let a = (zero - one) / (sign + z);
    let b = x * y * a;
    let first = Vector(one + sign * x * x * a, sign * b, zero - sign * x);
    let second = Vector(b, sign + y * y * a, zero - y);
    let [cos, sin] = cos_sin_of_turn(simd, turn);
    first.scaled(cos).plus(second, sin)
}
