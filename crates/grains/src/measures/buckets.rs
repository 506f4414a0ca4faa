//! Grains sorted into cubes, so that neighbours are found.

use crate::GrainField;
use snowgrain_geometry::QuantisedGrain;
use snowgrain_math::DVec3;

/// Quanta by which cubes exceed the largest grain's diameter, so that grains that nearly touch lie
/// in neighbouring cubes.
const SLACK: f64 = 8.0;

/// Grains in the order of the cubes that hold their centres, x fastest.
pub(super) struct Buckets {
    low: [f64; 3],
    side: [f64; 3],
    counts: [i64; 3],
    /// Periods along x, y, z in quanta; 0 along axes that do not repeat.
    period: [i64; 3],
    starts: Vec<u32>,
    grains: Vec<QuantisedGrain>,
}

impl Buckets {
    pub(super) fn new(field: &GrainField, period: Option<[f64; 2]>) -> Self {
        let quantum = field.quantisation.quantum();
        let [px, pz] = period.map_or([0, 0], |edges| edges.map(|p| (p / quantum).round() as i64));
        Self::repeating(field, [px, 0, pz])
    }

    /// The grains of a pack that repeats with these periods along x, y, z in quanta; 0 along axes where it
    /// does not.
    pub(super) fn repeating(field: &GrainField, period: [i64; 3]) -> Self {
        let mut buckets = Self {
            low: [0.0; 3],
            side: [1.0; 3],
            counts: [1; 3],
            period,
            starts: Vec::new(),
            grains: Vec::new(),
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
        let mut side = 2.0 * f64::from(field.largest_radius_quanta()) + SLACK;
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
        for grain in field.quantised() {
            let place = &mut next[cube_of(grain)];
            grains[*place as usize] = grain;
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
    }

    /// All grains, in the order of their cubes, within the first period.
    pub(super) fn grains(&self) -> &[QuantisedGrain] {
        &self.grains
    }

    /// Calls `found` with the index, the centre (at the nearest image) and the radius of every
    /// grain in the 27 cubes around `at`: all whose centres lie within a largest diameter of it.
    #[inline]
    pub(super) fn around(&self, at: DVec3, mut found: impl FnMut(usize, DVec3, f64)) {
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
