//! Learning what paths bring.

use super::field::{Cell, OutcomeField, neighbours};
use super::outcome::Outcome;
use super::scale::Scale;
use super::{Deep, DeepSettings};
use crate::camera::Camera;
use crate::light::Lights;
use crate::transport::over_picture::PathsOverPicture;
use crate::transport::seek::{LightSearch, PathState, Seeker};
use crate::transport::{Contribution, trace_with};
use crate::world::World;
use rayon::prelude::*;
use rustc_hash::FxHashMap;
use snowgrain_accel::flight::LANES;
use snowgrain_geometry::Shape;
use snowgrain_accel::{GrainVisit, STRATA, SimdLevel};
use snowgrain_math::sampler::{PathKey, numbers};
use std::collections::BTreeMap;
use std::collections::btree_map::Entry;

/// Paths of one task.
const TASK: u64 = 1 << 13;
/// What tells their random numbers from those of the picture.
const STREAM: u64 = 0xdee9_1ea4_7000_0000;
/// One arrival in so many is kept: those of a path all bring nearly the same.
const ARRIVALS_PER_SAMPLE: f32 = 16.0;
/// What tells the random numbers that choose them.
const CHOICE: u32 = 0xc401_ce00;
/// Sums are whole numbers of so many parts of the unit of light, so that they do not depend on their order.
/// One of them holds 2^31 units: more than a path in millions brings.
const PARTS: f64 = (1u64 << 32) as f64;

/// An arrival deep in the snow of a path that goes on.
#[derive(Clone, Copy)]
struct Vertex {
    /// The coarse cell where it arrived, and the one where it counts.
    arrived: Cell,
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
    sums: Sums,
}

impl<'a> Learner<'a> {
    fn new(field: &'a OutcomeField, quantum: f64) -> Self {
        let strata = if field.has_strata { STRATA } else { 0 };
        let scale = f64::from(field.lights.greatest_radiance()).max(f64::MIN_POSITIVE);
        Self {
            field,
            quantum,
            vertices: vec![Vec::new(); LANES],
            order: Vec::new(),
            sums: Sums { scale, strata, ..Sums::default() },
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
            arrived: self.field.interior.coarse(visit.center.cell),
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
            self.sums.add(vertex, &running, self.field.unit);
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

/// Sums of what paths brought, by coarse cell and slot.
#[derive(Clone, Default)]
pub(super) struct Sums {
    /// Unit of light.
    scale: f64,
    /// Strata that are told apart.
    strata: usize,
    /// Arrivals that count there, and of each slot in turn whole numbers: light of three channels, three powers,
    /// lengths in strata.
    cells: BTreeMap<Cell, (u64, Vec<i128>)>,
    /// Of the cells where they arrived.
    arrivals: BTreeMap<Cell, u64>,
}

impl Sums {
    fn add(&mut self, vertex: &Vertex, running: &[Running], unit: f64) {
        let width = self.width();
        *self.arrivals.entry(vertex.arrived).or_default() += 1;
        let (count, sums) =
            self.cells.entry(vertex.cell).or_insert_with(|| (0, vec![0; running.len() * width]));
        *count += 1;
        let parts = PARTS / self.scale;
        for (sums, running) in sums.chunks_exact_mut(width).zip(running) {
            let (weight, powers, strata) = running.since(vertex, unit);
            let values = weight.into_iter().chain(powers).chain(strata);
            let parts_of = |value: f64| i128::from((value * parts).round() as i64);
            sums.iter_mut().zip(values).for_each(|(sum, value)| *sum += parts_of(value));
        }
    }

    fn merged(mut self, other: Self) -> Self {
        if self.cells.len() < other.cells.len() {
            return other.merged(self);
        }
        for (cell, count) in other.arrivals {
            *self.arrivals.entry(cell).or_default() += count;
        }
        for (cell, (count, sums)) in other.cells {
            match self.cells.entry(cell) {
                Entry::Vacant(free) => {
                    free.insert((count, sums));
                }
                Entry::Occupied(mut mine) => {
                    let (my_count, mine) = mine.get_mut();
                    *my_count += count;
                    for (mine, theirs) in mine.iter_mut().zip(&sums) {
                        *mine += theirs;
                    }
                }
            }
        }
        self
    }

    /// How often paths arrived in a coarse cell.
    pub(super) fn arrivals(&self, cell: Cell) -> u64 {
        self.arrivals.get(&cell).copied().unwrap_or(0)
    }

    /// The means of all cells, slot by slot; of those with few arrivals the means over their neighbours, too.
    pub(super) fn smoothed(&self, few: u64) -> FxHashMap<Cell, Vec<Outcome>> {
        let smoothed = self.cells.iter().map(|(&cell, (count, sums))| {
            if *count >= few {
                return (cell, self.means(*count, sums));
            }
            let (mut all, mut sum) = (0, vec![0; sums.len()]);
            for (count, sums) in neighbours(cell).filter_map(|near| self.cells.get(&near)) {
                all += count;
                sum.iter_mut().zip(sums).for_each(|(sum, more)| *sum += more);
            }
            (cell, self.means(all, &sum))
        });
        smoothed.collect()
    }

    fn width(&self) -> usize {
        6 + self.strata
    }

    fn means(&self, count: u64, sums: &[i128]) -> Vec<Outcome> {
        let per = self.scale / (PARTS * count as f64);
        let means = sums.chunks_exact(self.width()).map(|sums| {
            let mean = |index: usize| sums.get(index).map_or(0.0, |&sum| (sum as f64 * per) as f32);
            Outcome {
                weight: std::array::from_fn(mean),
                lengths: std::array::from_fn(|power| mean(3 + power)),
                in_strata: std::array::from_fn(|stratum| mean(6 + stratum)),
            }
        });
        means.collect()
    }
}

impl OutcomeField {
    /// Learns of light in a world, whose grains have these shapes where they are not all spheres, by paths of the camera over a picture of `size` pixels, on the threads of the current pool,
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
        let sums = (0..paths.div_ceil(TASK))
            .into_par_iter()
            .map(|task| {
                let range = task * TASK..((task + 1) * TASK).min(paths);
                let mut paths = PathsOverPicture { camera, size, seed: seed ^ STREAM, range };
                let seeker = search.map(|search| Seeker::new(world, camera, search, level));
                let learner = Learner::new(&field, world.grid.quantum());
                let (_, deep) = trace_with(
                    (world, world.eta),
                    level,
                    (seeker, Some(Deep::Learn(Box::new(learner)))),
                    &mut paths,
                );
                match deep {
                    Some(Deep::Learn(learner)) => learner.sums,
                    _ => Sums::default(),
                }
            })
            .reduce(Sums::default, Sums::merged);
        Some(field.learnt(&sums))
    }
}
