//! Light from the depth of snow, learnt from exact paths.
//!
//! A path that is deep in snow has forgotten where it came from: what it will bring depends on little but its
//! place. So paths of the camera are followed to their end first, and what they bring from where they first arrive deep in
//! the snow is kept in a coarse grid ([`OutcomeField`]). A path of the picture that has met
//! some grains and arrives deep in the snow ends there, with the mean of what such paths brought: the light
//! of each slot, and two lengths in ice that have the mean, the variance and the skewness of theirs.
//!
//! *Of whom*: the learning paths are paths of the same camera over the same picture, and each counts where one of the picture
//! would end. So what the field brings to the whole picture is what they brought, and is wrong by nothing but their
//! chance: a field learnt from all arrivals of a path has less noise, but not the mean of first ones. What is left is
//! that a cell has one mean, so that within it light is even.
//!
//! *Where*: not where the path arrives, but nearly one transport length further on along its direction. Light that
//! is scattered forward gets there on average before it has forgotten its direction, so that in a diffusive
//! medium what it brings depends on that place alone (as light that enters a slab acts like a source one
//! transport length below; Ishimaru 1978, "Wave Propagation and Scattering in Random Media", chapter 9).
//! The same is done when learning, so nothing rests on the theory but how much the outcomes within a cell differ.
//!
//! The field is a function of the scene, the seed and the number of paths that it is learnt from.

mod field;
mod learn;
mod levels;
mod outcome;
mod samples;
mod scale;
mod stored;

pub use field::OutcomeField;
pub(crate) use learn::Learner;
pub(super) use scale::Scale;
pub use stored::LearntStore;

use crate::light::Lights;

use super::medium::ProxyInDepth;
use super::{Contribution, PathEnd, PathResult};
use snowgrain_accel::{DeepAnswer, DeepWatch};

/// When a path of a picture ends deep in the snow, and how what it brings is learnt.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DeepSettings {
    /// Grains that a path meets exactly, at least, where a pixel is narrow ([`Self::NARROW`]) and where it is wide
    /// ([`Self::WIDE`]): of spheres of ice; of others as many as turn it as much.
    pub after_grains: [u32; 2],
    /// Distance from open air and surfaces at least, transport lengths.
    pub depth: f64,
    /// Edge of the cells of the field, transport lengths.
    pub cell: f64,
    /// Paths by which outcomes are learnt.
    pub learning_paths: u64,
}

impl DeepSettings {
    /// Of the errors that settings are known for: how many grains and how deep, and times the paths of the
    /// default (`cargo xtask deep` measures what is left, less than that).
    const BY_ERROR: [(f64, [u32; 2], f64, u64); 3] =
        [(0.01, [4, 2], 0.25, 1), (0.003, [4, 2], 0.5, 2), (0.001, [8, 4], 1.0, 4)];

    /// Learning paths of the default: pixels of eight radii are then within 1.4 % in the mean of squares.
    const PATHS: u64 = 3 << 18;

    /// Width of a pixel where it met the snow, in radii of the grains, up to which it is narrow, and from which on it is wide.
    /// What the first grains bring differs from grain to grain, which wide pixels do not show: two grains are as good there
    /// as four where a pixel is half a radius wide.
    pub const NARROW: f64 = 0.5;
    /// See [`Self::NARROW`].
    pub const WIDE: f64 = 1.5;

    /// Least error that settings are known for.
    pub const LEAST_ERROR: f64 = Self::BY_ERROR[2].0;

    /// Depth at least where suns and small lamps shine, whose light is patchy that much farther down: at half of it blocks of 8 x 8
    /// radii were 2 % off.
    const LEAST_DEPTH_OF_SMALL_LIGHTS: f64 = 0.5;

    /// The same where small lights shine: deeper, and of twice the paths, which bring more or less of such light by chance.
    #[must_use]
    pub fn under_small_lights(self) -> Self {
        let depth = self.depth.max(Self::LEAST_DEPTH_OF_SMALL_LIGHTS);
        Self { depth, learning_paths: 2 * self.learning_paths, ..self }
    }

    /// How wide a pixel is of so many radii of the grains, from 0, narrow, to 1, wide, and beyond either.
    #[must_use]
    pub fn width(pixel_radii: f64) -> f64 {
        (pixel_radii - Self::NARROW) / (Self::WIDE - Self::NARROW)
    }

    /// Settings by which the means of blocks of a picture differ by no more than this part, as measured;
    /// `None` for an error that none are known for.
    #[must_use]
    pub fn for_error(error: f64) -> Option<Self> {
        let fits = Self::BY_ERROR.into_iter().find(|&(known, ..)| known <= error)?;
        let (_, after_grains, depth, times) = fits;
        Some(Self { after_grains, depth, cell: 0.25, learning_paths: times * Self::PATHS })
    }
}

/// What a walk does with arrivals deep in the snow.
pub(crate) enum Deep<'a> {
    /// Ends paths there.
    HandOver(&'a OutcomeField),
    /// Lets them go on among spheres that are met at random.
    Proxy(&'a ProxyInDepth),
    /// Notes them.
    Learn(Box<Learner<'a>>),
}

impl<'a> Deep<'a> {
    /// The lights that paths find at their end, where those are told by what was found.
    pub(super) fn lights(&self) -> Option<&Lights> {
        match self {
            Self::HandOver(field) => Some(&field.lights),
            Self::Learn(learner) => Some(&learner.field.lights),
            Self::Proxy(_) => None,
        }
    }

    /// What a flight is to do.
    pub(super) fn watch(&self) -> DeepWatch<'a> {
        let of_field = |field: &'a OutcomeField, answer| DeepWatch {
            interior: &field.interior,
            after: field.after,
            answer,
        };
        match self {
            Self::HandOver(field) => of_field(field, DeepAnswer::Stop),
            Self::Learn(learner) => of_field(learner.field, DeepAnswer::Note),
            Self::Proxy(proxy) => DeepWatch {
                interior: &proxy.interior,
                after: proxy.after,
                answer: DeepAnswer::Stop,
            },
        }
    }

    /// The light of a path that has ended, where none is looked for on the way.
    pub(super) fn at_end(lights: &Lights, path: &PathResult, found: &mut Vec<Contribution>) {
        let mut radiances = vec![[0.0; 3]; lights.slots().len()];
        match path.end {
            PathEnd::Escaped(_) if path.first_hit.is_none() => {}
            PathEnd::Escaped(ray) => lights.add_radiances(ray.direction, &mut radiances),
            PathEnd::Emitted { light, .. } => lights.add_emission(light, &mut radiances),
            PathEnd::Absorbed | PathEnd::Enclosed | PathEnd::Deep(_) => {}
        }
        let lit = radiances.into_iter().enumerate().filter(|(_, light)| *light != [0.0; 3]);
        found.extend(lit.map(|(slot, light)| Contribution {
            slot,
            glint: false,
            event: u32::MAX,
            weight: std::array::from_fn(|c| light[c] * path.throughput[c]),
            ice_length: path.ice_length,
            ice_in_strata: path.ice_in_strata,
        }));
    }
}
