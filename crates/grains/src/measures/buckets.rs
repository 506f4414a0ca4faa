//! Grains sorted into cubes, so that neighbours are found.

use super::bodies::{Bodies, Body};
use crate::GrainField;
use snowgrain_geometry::{GrainShape, QuantisedGrain};
use snowgrain_math::DVec3;

/// Quanta by which cubes exceed the diameter of the largest grain's bounding sphere, so that grains that nearly touch lie
/// in neighbouring cubes.
const SLACK: f64 = 8.0;

/// Grains in the order of the cubes that hold their centres, x fastest.
pub(crate) struct Buckets {
    low: [f64; 3],
    side: [f64; 3],
    counts: [i64; 3],
    /// Periods along x, y, z in quanta; 0 along axes that do not repeat.
    period: [i64; 3],
    starts: Vec<u32>,
    grains: Vec<QuantisedGrain>,
    bodies: Bodies,
    /// Of each grain its number in the field, where not all are spheres.
    numbers: Vec<u32>,
}

impl Buckets {
    pub(crate) fn new(field: &GrainField, period: Option<[f64; 2]>) -> Self {
        let quantum = field.quantisation.quantum();
        let [px, pz] = period.map_or([0, 0], |edges| edges.map(|p| (p / quantum).round() as i64));
        Self::repeating(field, [px, 0, pz])
    }

    /// The grains of a pack that repeats with these periods along x, y, z in quanta; 0 along axes where it
    /// does not.
    pub(crate) fn repeating(field: &GrainField, period: [i64; 3]) -> Self {
        let mut buckets = Self {
            low: [0.0; 3],
            side: [1.0; 3],
            counts: [1; 3],
            period,
            starts: Vec::new(),
            grains: Vec::new(),
            bodies: Bodies::of(field),
            numbers: Vec::new(),
        };
        buckets.choose_cubes(field);
        buckets.sort(field);
        buckets
    }

    /// Cubes of a grain's diameter, or larger where those would outnumber the grains by far.
    fn choose_cubes(&mut self, field: &GrainField) {
        let high = [0, 1, 2].map(|axis| {
            if self.period[axis] > 0 {
                return self.period[axis] as f64;
            }
            if field.is_empty() {
                return 1.0;
            }
            let coordinates = || field.quantised().map(|g| f64::from(g.center[axis]));
            self.low[axis] = coordinates().fold(f64::INFINITY, f64::min);
            coordinates().fold(f64::NEG_INFINITY, f64::max) + 1.0
        });
        let most = 4.0 * field.len() as f64 + 64.0;
        let mut side = 2.0 * self.bodies.largest_reach(field.quantised()) + SLACK;
        loop {
            let counts = [0, 1, 2].map(|a| ((high[a] - self.low[a]) / side).floor().max(1.0));
            if counts.iter().product::<f64>() <= most {
                self.counts = counts.map(|count| count as i64);
                self.side = [0, 1, 2].map(|a| (high[a] - self.low[a]) / counts[a]);
                return;
            }
            side *= 1.25;
        }
    }

    fn sort(&mut self, field: &GrainField) {
        let cubes = self.counts.iter().product::<i64>() as usize;
        let mut starts = vec![0u32; cubes + 1];
        let cube_of = |grain: QuantisedGrain| {
            let cube = self.cube(grain.center.map(f64::from));
            self.wrapped(cube).map_or(0, |(index, _)| index)
        };
        for grain in field.quantised() {
            starts[cube_of(grain) + 1] += 1;
        }
        for cube in 0..cubes {
            starts[cube + 1] += starts[cube];
        }
        let mut next = starts.clone();
        let empty = QuantisedGrain { center: [0; 3], radius: 0 };
        let mut grains = vec![empty; field.len()];
        let mut numbers = vec![0u32; if self.bodies.are_spheres() { 0 } else { field.len() }];
        for (number, grain) in field.quantised().enumerate() {
            let place = &mut next[cube_of(grain)];
            grains[*place as usize] = grain;
            if let Some(of) = numbers.get_mut(*place as usize) {
                *of = number as u32;
            }
            *place += 1;
        }
        for grain in &mut grains {
            for axis in 0..3 {
                let period = self.period[axis];
                if period > 0 {
                    grain.center[axis] = i64::from(grain.center[axis]).rem_euclid(period) as i32;
                }
            }
        }
        (self.starts, self.grains) = (starts, grains);
        self.bodies = core::mem::take(&mut self.bodies).in_order(&numbers);
        self.numbers = numbers;
    }

    /// Gives the grain of an index another shape.
    pub(crate) fn turn(&mut self, index: usize, shape: GrainShape) {
        self.bodies.turn(index, shape);
    }

    /// The shapes of all grains in the order of the field; none where all are spheres.
    pub(crate) fn shapes_in_order_of_field(&self) -> Vec<GrainShape> {
        let shape = |index| self.bodies.shape_of(index);
        let mut pairs: Vec<(u32, Option<GrainShape>)> = self
            .numbers
            .iter()
            .enumerate()
            .map(|(index, &number)| (number, shape(index)))
            .collect();
        pairs.sort_unstable_by_key(|(number, _)| *number);
        pairs.into_iter().filter_map(|(_, shape)| shape).collect()
    }

    /// Number in the field of the grain of an index, where not all are spheres.
    pub(crate) fn number(&self, index: usize) -> usize {
        self.numbers[index] as usize
    }

    /// Whether all grains are spheres.
    pub(crate) fn are_spheres(&self) -> bool {
        self.bodies.are_spheres()
    }

    /// Whether a point lies in the grain of an index that [`Self::around`] found.
    pub(crate) fn holds(&self, (index, center, radius): (usize, DVec3, f64), point: DVec3) -> bool {
        let reach = radius * self.bodies.reach(index);
        (center - point).length_squared() <= reach * reach && self.body(index, center).holds(point)
    }

    /// The grain of an index as it would be with another shape of the field.
    pub(crate) fn body_as(&self, index: usize, shape: GrainShape, center: DVec3) -> Body<'_> {
        self.bodies.body_as(shape, center, self.grains[index].radius.into())
    }

    /// The grain of an index that [`Self::around`] found at a centre.
    pub(crate) fn body(&self, index: usize, center: DVec3) -> Body<'_> {
        self.bodies.body(index, center, self.grains[index].radius.into())
    }

    /// All grains, in the order of their cubes, within the first period.
    pub(crate) fn grains(&self) -> &[QuantisedGrain] {
        &self.grains
    }

    /// Calls `found` with the index, the centre (at the nearest image) and the radius of every
    /// grain in the 27 cubes around `at`: all whose centres lie within a largest diameter (of bounding spheres) of it.
    #[inline]
    pub(crate) fn around(&self, at: DVec3, mut found: impl FnMut(usize, DVec3, f64)) {
        let cube = self.cube(at.to_array());
        for k in -1..=1 {
            for j in -1..=1 {
                for i in -1..=1 {
                    let near = [cube[0] + i, cube[1] + j, cube[2] + k];
                    let Some((index, shift)) = self.wrapped(near) else { continue };
                    for g in self.starts[index] as usize..self.starts[index + 1] as usize {
                        let [x, y, z] = self.grains[g].center.map(f64::from);
                        found(g, DVec3::new(x, y, z) + shift, self.grains[g].radius.into());
                    }
                }
            }
        }
    }

    fn cube(&self, at: [f64; 3]) -> [i64; 3] {
        [0, 1, 2].map(|a| ((at[a] - self.low[a]) / self.side[a]).floor() as i64)
    }

    /// Index of a cube, and how far its image lies from it; `None` outside.
    #[inline]
    fn wrapped(&self, mut cube: [i64; 3]) -> Option<(usize, DVec3)> {
        let mut shift = DVec3::ZERO;
        for axis in 0..3 {
            let count = self.counts[axis];
            if self.period[axis] > 0 {
                let turns = cube[axis].div_euclid(count);
                cube[axis] -= turns * count;
                shift[axis] = (turns * self.period[axis]) as f64;
            } else if !(0..count).contains(&cube[axis]) {
                return None;
            }
        }
        let [x, y, z] = cube;
        Some((((z * self.counts[1] + y) * self.counts[0] + x) as usize, shift))
    }
}
