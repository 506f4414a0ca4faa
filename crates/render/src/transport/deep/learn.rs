//! Learning what paths bring.

use super::field::OutcomeField;
use super::outcome::PARTS;
use super::samples::Samples;
use super::scale::Scale;
use super::{Deep, DeepSettings};
use crate::camera::Camera;
use crate::light::Lights;
use crate::transport::over_picture::PathsOverPicture;
use crate::transport::seek::{LightSearch, PathState, Seeker};
use crate::transport::{Contribution, trace_with};
use crate::world::World;
use rayon::prelude::*;
use snowgrain_accel::flight::LANES;
use snowgrain_accel::{GrainVisit, STRATA, SimdLevel};
use snowgrain_geometry::Shape;
use snowgrain_math::DVec3;
use std::ops::Range;

/// Paths of one task.
const TASK: u64 = 1 << 13;
/// Times as many paths as asked for at most, where few of them meet snow.
const MOST_TIMES: f64 = 64.0;
/// What tells their random numbers from those of the picture.
const STREAM: u64 = 0xdee9_1ea4_7000_0000;

/// The first arrival deep in the snow of a path that goes on.
#[derive(Clone, Copy)]
struct Arrival {
    /// Where it counts, in coarse cells.
    place: DVec3,
    event: u32,
    throughput: [f32; 3],
    ice_length: f64,
    ice_in_strata: [f64; STRATA],
}

/// Notes where paths would end, and learns what they bring from there.
pub(crate) struct Learner<'a> {
    pub(in crate::transport) field: &'a OutcomeField,
    quantum: f64,
    /// Of each lane.
    arrivals: [Option<Arrival>; LANES],
    samples: Samples,
}

impl<'a> Learner<'a> {
    fn new(field: &'a OutcomeField, quantum: f64) -> Self {
        Self { field, quantum, arrivals: [None; LANES], samples: field.no_samples() }
    }

    /// A new path begins in a lane.
    pub(in crate::transport) fn begin(&mut self, lane: usize) {
        self.arrivals[lane] = None;
    }

    pub(in crate::transport) fn relocate(&mut self, from: usize, to: usize) {
        self.arrivals.swap(from, to);
    }

    /// A path arrives at a grain.
    pub(in crate::transport) fn note(&mut self, visit: &GrainVisit, state: &PathState) {
        if self.arrivals[visit.lane].is_some() || !self.field.is_deep(visit, state.key) {
            return;
        }
        self.arrivals[visit.lane] = Some(Arrival {
            place: self.field.place(visit),
            event: visit.event,
            throughput: state.throughput,
            ice_length: f64::from(visit.ice_length) * self.quantum,
            ice_in_strata: visit.ice_in_strata.map(|length| f64::from(length) * self.quantum),
        });
    }

    /// A path has ended, with the light that it found.
    pub(in crate::transport) fn learn(&mut self, lane: usize, found: &[Contribution]) {
        let Some(arrival) = self.arrivals[lane].take() else { return };
        let mut brought = vec![[0.0; PARTS]; self.field.slots];
        for light in found.iter().filter(|light| light.event >= arrival.event) {
            arrival.add(&mut brought[light.slot], light, self.field.unit);
        }
        self.samples.push(arrival.place, arrival.throughput, brought.into_iter());
    }
}

impl Arrival {
    /// Adds light that was found from there on to the parts of an outcome, lengths in a unit.
    fn add(&self, parts: &mut [f64; PARTS], light: &Contribution, unit: f64) {
        let weight = light.weight.map(f64::from);
        let total: f64 = weight.iter().sum();
        let length = ((light.ice_length - self.ice_length) / unit).max(0.0);
        let powers = [length, length * length, length * length * length];
        let strata = light.ice_in_strata.iter().zip(self.ice_in_strata);
        let in_strata = strata.map(|(&length, before)| (length - before).max(0.0) / unit);
        let lengths = powers.into_iter().chain(in_strata).map(|length| total * length);
        parts
            .iter_mut()
            .zip(weight.into_iter().chain(lengths))
            .for_each(|(sum, part)| *sum += part);
    }
}

impl OutcomeField {
    /// Learns of light in a world, whose grains have these shapes where they are not all spheres, by paths of the camera over a
    /// picture of `size` pixels, as many of which meet grains as the settings say, on the threads of the current pool,
    /// which do not show in the result; `None` where no snow is deep.
    #[must_use]
    pub fn learn(
        (world, prototypes, camera): (&World, &[Shape], &Camera),
        (lights, search): (&Lights, Option<&LightSearch>),
        settings: &DeepSettings,
        (size, seed): ([u32; 2], u64),
        level: SimdLevel,
    ) -> Option<Self> {
        let scale = Scale::of(world, prototypes, level)?;
        let field = Self::unlearnt((world, camera), lights, settings, scale)?;
        let paths = settings.learning_paths;
        let size = size.map(f64::from);
        let follow = |tasks: Range<u64>| -> Vec<(Samples, u64)> {
            let follow = |task| {
                let range = task * TASK..(task + 1) * TASK;
                let seed = seed ^ STREAM;
                let mut paths = PathsOverPicture { camera, size, seed, range, met: 0 };
                let seeker = search.map(|search| Seeker::new(world, camera, search, level));
                let learner = Learner::new(&field, world.grid.quantum());
                let deep = Some(Deep::Learn(Box::new(learner)));
                match trace_with((world, world.eta), level, (seeker, deep), &mut paths).1 {
                    Some(Deep::Learn(learner)) => (learner.samples, paths.met),
                    _ => (Samples::default(), 0),
                }
            };
            tasks.into_par_iter().map(follow).collect()
        };
        let first = paths.div_ceil(TASK);
        let mut parts = follow(0..first);
        let met: u64 = parts.iter().map(|(_, met)| met).sum();
        // Where snow is small in the picture most paths miss it, and cost next to nothing.
        let times = ((first * TASK) as f64 / met.max(1) as f64).min(MOST_TIMES);
        parts.extend(follow(first..(first as f64 * times) as u64));
        let mut samples = field.no_samples();
        parts.into_iter().for_each(|(part, _)| samples.append(part));
        field.learnt(&samples)
    }
}
