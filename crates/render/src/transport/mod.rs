//! The exact walk: from a ray to where its light comes from.
//!
//! A path reflects or refracts at random at every interface (in `snowgrain_accel::Flight`), bounces
//! off objects or passes through them, and ends when it escapes, when it meets a luminous surface, when an object absorbs
//! it, or when unbiased roulette says so. There is no bounce cap. Absorption in ice does not end a path: the path carries
//! its length in ice, from which any absorption follows afterwards (white Monte Carlo).
//!
//! Light is found where a path escapes, or is looked for on the way ([`seek`]); a path may end deep in the snow
//! with what others brought from there ([`deep`]). Snow may stand for a medium in which no single grain is met ([`medium`]).

pub mod deep;
mod ice;
pub mod medium;
mod over_picture;
pub mod seek;
mod walk;

pub use walk::trace;
pub(crate) use walk::trace_with;

use seek::View;
use snowgrain_accel::STRATA;
use snowgrain_math::sampler::{PathKey, numbers};
use snowgrain_math::{DVec3, Ray};

/// What tells the further random number of a surface from others of its path.
const FURTHER: u32 = 0x71e_fa5e7;

/// A uniform number for a surface beside the three of its event.
fn further_number(key: PathKey, event: u32) -> f64 {
    f64::from(numbers(PathKey { lo: key.lo ^ FURTHER, ..key }, event)[0])
}

/// A path to be traced.
#[derive(Clone, Copy, Debug)]
pub struct NewPath<Tag> {
    /// Given back with the result.
    pub tag: Tag,
    /// Where it starts, in air.
    pub ray: Ray,
    /// Its random numbers.
    pub key: PathKey,
    /// The first event of them that is still unused.
    pub event: u32,
}

/// How a path ended.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum PathEnd {
    /// It escaped along this ray, which starts where it last left the box of the grains, bounced, or
    /// began.
    Escaped(Ray),
    /// It met a luminous surface on the side that shines.
    Emitted {
        /// Index of the light.
        light: usize,
        /// Where, metres.
        position: DVec3,
        /// Unit normal there, on the side of the path.
        normal: DVec3,
        /// Unit direction in which the path came.
        direction: DVec3,
    },
    /// A surface absorbed it, or roulette ended it.
    Absorbed,
    /// It ended deep in the snow, with what other paths brought from there ([`deep`]).
    Deep(Learnt),
    /// It bounced [`MAX_BOUNCES_WITHOUT_LOSS`] times off objects that absorb nothing: they enclose it,
    /// and it would go on for ever. A scene where this happens is refused.
    Enclosed,
}

/// What of the light that was found along a path is what others brought.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Learnt {
    /// The contributions from this one on.
    pub first: usize,
    /// Standard error of their sum, relative.
    pub relative_error: f64,
}

/// What a path met first.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FirstHit {
    /// Where, metres.
    pub position: DVec3,
    /// Unit normal on the side of the camera.
    pub normal: DVec3,
    /// Diffuse albedo there, or reflectance of a metal at normal incidence; 1 for ice and glass.
    pub albedo: [f32; 3],
    /// Whether it is a shadow catcher.
    pub is_shadow_catcher: bool,
}

/// A traced path.
#[derive(Clone, Copy, Debug)]
pub struct PathResult {
    /// How it ended.
    pub end: PathEnd,
    /// Product of the albedos met, and of all else that surfaces left (and of the roulette's weights).
    pub throughput: [f32; 3],
    /// Length in ice, metres.
    pub ice_length: f64,
    /// Of it, that in grains of each stratum from 1 on.
    pub ice_in_strata: [f64; STRATA],
    /// Length in air within the box of the grains, metres.
    pub air_length: f64,
    /// Arrivals at grains from air.
    pub grain_visits: u32,
    /// Fresnel decisions between air and ice.
    pub interface_events: u32,
    /// Bounces off objects and passages through their surfaces.
    pub surface_bounces: u32,
    /// Times that the guard against endless circling in ice let the path out, in a diffuse direction
    /// and without loss (`snowgrain_accel::flight::MAX_TURNS_IN_ICE`); 0 but for one path in millions.
    pub releases: u32,
    /// What it met first, if anything.
    pub first_hit: Option<FirstHit>,
}

/// Light that was found along a path.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Contribution {
    /// Slot of the light.
    pub slot: usize,
    /// Whether it is of a small light and came by the first one or two grains that the camera sees.
    pub glint: bool,
    /// The random event of the path at which it was found, later ones not being less; `u32::MAX` at its end.
    pub event: u32,
    /// Product of light and albedos, linear sRGB, before the ice.
    pub weight: [f32; 3],
    /// Length in ice, metres.
    pub ice_length: f64,
    /// Of it, that in grains of each stratum from 1 on.
    pub ice_in_strata: [f64; STRATA],
}

/// Where paths come from and where their results go.
pub trait PathSource {
    /// What ties a result to its path.
    type Tag: Copy;
    /// The next path, `None` when there are no more.
    fn next_path(&mut self) -> Option<NewPath<Self::Tag>>;
    /// How a camera sees the start of the path that was just given; `None` where none does.
    fn view(&self, _: Self::Tag) -> Option<View> {
        None
    }
    /// Takes a result; results come in any order.
    fn finish(&mut self, tag: Self::Tag, result: &PathResult);
    /// Takes a result where light was looked for, and what was found.
    fn finish_with_light(&mut self, tag: Self::Tag, result: &PathResult, _: &[Contribution]) {
        self.finish(tag, result);
    }
}

/// Bounces off objects after which a path whose throughput roulette still leaves alone counts as enclosed.
pub const MAX_BOUNCES_WITHOUT_LOSS: u32 = 200_000;

/// Throughput under which roulette decides: below it a path survives with probability
/// throughput / threshold and goes on at the threshold, which leaves the mean unchanged.
pub const ROULETTE_THRESHOLD: f32 = 0.1;
