//! Learning what paths bring.

use super::field::OutcomeField;
use super::levels::Cell;
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
use snowgrain_math::sampler::{PathKey, numbers};
use std::ops::Range;

/// Paths of one task.
const TASK: u64 = 1 << 13;
/// Times as many paths as asked for at most, where few of them meet snow.
const MOST_TIMES: f64 = 64.0;
/// What tells their random numbers from those of the picture.
const STREAM: u64 = 0xdee9_1ea4_7000_0000;
/// One arrival in so many is kept: those of a path all bring nearly the same.
const ARRIVALS_PER_SAMPLE: f32 = 16.0;
/// What tells the random numbers that choose them.
const CHOICE: u32 = 0xc401_ce00;

/// An arrival deep in the snow of a path that goes on.
#[derive(Clone, Copy)]
struct Vertex {
    /// The coarse cell where it counts.
    cell: Cell,
    event: u32,
    throughput: [f32; 3],
    ice_length: f64,
    ice_in_strata: [f64; STRATA],
}

/// Notes arrivals, and learns what followed.
pub(crate) struct Learner<'a> {
    pub(in crate::transport) field: &'a OutcomeField,
    quantum: f64,
    /// Of each lane.
    vertices: Vec<Vec<Vertex>>,
    /// What a lane found, while its path ends.
    order: Vec<usize>,
    samples: Samples,
}

impl<'a> Learner<'a> {
    fn new(field: &'a OutcomeField, quantum: f64) -> Self {
        let strata = if field.has_strata { STRATA } else { 0 };
        Self {
            field,
            quantum,
            vertices: vec![Vec::new(); LANES],
            order: Vec::new(),
            samples: Samples::new(field.slots, strata),
        }
    }

    /// A new path begins in a lane.
    pub(in crate::transport) fn begin(&mut self, lane: usize) {
        self.vertices[lane].clear();
    }

    pub(in crate::transport) fn relocate(&mut self, from: usize, to: usize) {
        self.vertices.swap(from, to);
    }

    /// A path arrives deep in the snow.
    pub(in crate::transport) fn note(&mut self, visit: &GrainVisit, state: &PathState) {
        let PathState { key, throughput } = *state;
        let key = PathKey { lo: key.lo ^ CHOICE, ..key };
        let chosen = numbers(key, visit.event)[0] * ARRIVALS_PER_SAMPLE < 1.0;
        if !chosen || throughput.contains(&0.0) || !self.field.is_deep(visit) {
            return;
        }
        self.vertices[visit.lane].push(Vertex {
            cell: self.field.place(visit).floor().as_ivec3().to_array(),
            event: visit.event,
            throughput,
            ice_length: f64::from(visit.ice_length) * self.quantum,
            ice_in_strata: visit.ice_in_strata.map(|length| f64::from(length) * self.quantum),
        });
    }

    /// A path has ended, with the light that it found.
    pub(in crate::transport) fn learn(&mut self, lane: usize, found: &[Contribution]) {
        self.order.clear();
        self.order.extend(0..found.len());
        self.order.sort_by_key(|&index| std::cmp::Reverse(found[index].event));
        let mut rest = self.order.iter().map(|&index| &found[index]).peekable();
        let mut running = vec![Running::default(); self.field.slots];
        for vertex in self.vertices[lane].iter().rev() {
            while let Some(light) = rest.next_if(|light| light.event >= vertex.event) {
                running[light.slot].add(light, self.field.unit);
            }
            let unit = self.field.unit;
            self.samples.push(vertex.cell, running.iter().map(|light| light.since(vertex, unit)));
        }
        self.vertices[lane].clear();
    }
}

/// Light found from the end of a path back to some arrival.
#[derive(Clone, Copy, Default)]
struct Running {
    weight: [f64; 3],
    /// Sum of the channels, times each power of the length from 0 to 3.
    powers: [f64; 4],
    in_strata: [f64; STRATA],
}

impl Running {
    fn add(&mut self, light: &Contribution, unit: f64) {
        let weight = light.weight.map(f64::from);
        let total: f64 = weight.iter().sum();
        self.weight.iter_mut().zip(weight).for_each(|(sum, weight)| *sum += weight);
        let length = light.ice_length / unit;
        let mut power = total;
        for sum in &mut self.powers {
            *sum += power;
            power *= length;
        }
        for (sum, length) in self.in_strata.iter_mut().zip(light.ice_in_strata) {
            *sum += total * length / unit;
        }
    }

    /// Light relative to the throughput at an arrival; powers of the length from there on.
    fn since(&self, vertex: &Vertex, unit: f64) -> ([f64; 3], [f64; 3], [f64; STRATA]) {
        let weight: [f64; 3] =
            std::array::from_fn(|c| self.weight[c] / f64::from(vertex.throughput[c]));
        let [s0, s1, s2, s3] = self.powers;
        if s0 <= 0.0 {
            return (weight, [0.0; 3], [0.0; STRATA]);
        }
        let scale = weight.iter().sum::<f64>() / s0;
        let l = vertex.ice_length / unit;
        let first = s1 - l * s0;
        let second = s2 - l * (2.0 * s1 - l * s0);
        let third = s3 - l * (3.0 * s2 - l * (3.0 * s1 - l * s0));
        let strata = std::array::from_fn(|s| {
            (self.in_strata[s] - s0 * vertex.ice_in_strata[s] / unit).max(0.0) * scale
        });
        (weight, [first, second, third].map(|sum| sum.max(0.0) * scale), strata)
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
        let field = Self::unlearnt(world, lights, settings, scale)?;
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
        let strata = if field.has_strata { STRATA } else { 0 };
        let mut samples = Samples::new(field.slots, strata);
        parts.into_iter().for_each(|(part, _)| samples.append(part));
        field.learnt(&samples)
    }
}
