//! How much of space is ice.

use super::buckets::Buckets;
use crate::GrainField;
use core::f64::consts::PI;
use snowgrain_math::DVec3;
use snowgrain_math::sampler::{PathKey, pcg3d};

/// A mean and its standard error.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Estimate {
    /// The mean.
    pub mean: f64,
    /// An upper bound of its standard error (stratification makes it smaller).
    pub standard_error: f64,
}

/// A box of space in which a pack is measured, metres.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Slab {
    /// Least corner.
    pub min: DVec3,
    /// Greatest corner.
    pub max: DVec3,
    /// Periods of the pack along x and z, where it repeats.
    pub period: Option<[f64; 2]>,
}

impl Slab {
    /// The part of a pack between the given parts of its depth. The depth of a pack that repeats
    /// runs from its lowest point to the mean height of its surface, seen from above; along x and z
    /// the slab takes the whole period. Of a pack that does not repeat, the same parts of its box
    /// are taken along all three axes.
    #[must_use]
    pub fn between_parts_of_depth(
        field: &GrainField,
        period: Option<[f64; 2]>,
        [low, high]: [f64; 2],
    ) -> Self {
        let mut bounds = field.bounds();
        if bounds.is_empty() {
            return Self { min: DVec3::ZERO, max: DVec3::ZERO, period };
        }
        if let Some(period) = period {
            bounds.max.y = mean_surface_height(field, period);
        }
        let (mut min, mut max) =
            (bounds.min + bounds.size() * low, bounds.min + bounds.size() * high);
        if let Some([px, pz]) = period {
            let origin = field.quantisation.origin();
            (min.x, min.z) = (origin.x, origin.z);
            (max.x, max.z) = (origin.x + px, origin.z + pz);
        }
        Self { min, max, period }
    }

    fn volume(&self) -> f64 {
        let size = (self.max - self.min).max(DVec3::ZERO);
        size.x * size.y * size.z
    }
}

/// Mean height, metres, at which vertical lines from above meet a pack that repeats with `period`
/// (metres along x and z), over a regular array of lines about a largest radius apart (at most
/// 1024 x 1024); lines that meet no grain count with the lowest point of the pack.
#[must_use]
pub fn mean_surface_height(field: &GrainField, period: [f64; 2]) -> f64 {
    let quantum = field.quantisation.quantum();
    let largest = f64::from(field.largest_radius_quanta().max(1)) * quantum;
    let counts = period.map(|edge| (edge / largest).round().clamp(1.0, 1024.0));
    let steps = [period[0] / counts[0], period[1] / counts[1]];
    let [columns, rows] = counts.map(|count| count as i64);
    let lowest = field.bounds().min.y;
    let mut heights = vec![lowest; (columns * rows) as usize];
    let origin = field.quantisation.origin();
    for grain in field.iter() {
        let (x, z) = (grain.center.x - origin.x, grain.center.z - origin.z);
        let covered = |at: f64, step: f64| {
            ((at - grain.radius) / step).ceil() as i64..=((at + grain.radius) / step).floor() as i64
        };
        for row in covered(z, steps[1]) {
            for column in covered(x, steps[0]) {
                let (dx, dz) = (column as f64 * steps[0] - x, row as f64 * steps[1] - z);
                let rise = (grain.radius * grain.radius - dx * dx - dz * dz).max(0.0).sqrt();
                let index = row.rem_euclid(rows) * columns + column.rem_euclid(columns);
                let height = &mut heights[index as usize];
                if rise > 0.0 {
                    *height = height.max(grain.center.y + rise);
                }
            }
        }
    }
    heights.iter().sum::<f64>() / heights.len() as f64
}

/// Fraction of `slab` that lies in at least one grain, from about `points` points, one in each of
/// as many equal boxes; a function of its arguments only.
#[must_use]
pub fn union_solid_fraction(field: &GrainField, slab: &Slab, points: u32, seed: u64) -> Estimate {
    in_buckets(field, &Buckets::new(field, slab.period), slab, points, seed)
}

fn in_buckets(
    field: &GrainField,
    buckets: &Buckets,
    slab: &Slab,
    points: u32,
    seed: u64,
) -> Estimate {
    let per_axis = (1u32..1625).take_while(|n| n * n <= points / n).last().unwrap_or(1);
    let layers = inside_by_layer((field, buckets), slab, [per_axis; 3], seed);
    let inside: u64 = layers.iter().sum();
    let all = f64::from(per_axis) * f64::from(per_axis) * f64::from(per_axis);
    let mean = inside as f64 / all;
    Estimate { mean, standard_error: (mean * (1.0 - mean) / all).sqrt() }
}

/// The same of a pack that repeats with these periods along x, y and z, quanta.
#[must_use]
pub fn union_solid_fraction_of_pack(
    field: &GrainField,
    period: [i64; 3],
    points: u32,
    seed: u64,
) -> Estimate {
    let (min, quantum) = (field.quantisation.origin(), field.quantisation.quantum());
    let max = min + DVec3::from_array(period.map(|edge| edge as f64)) * quantum;
    let slab = Slab { min, max, period: None };
    in_buckets(field, &Buckets::repeating(field, period), &slab, points, seed)
}

/// The union solid fraction of each of `layers` equal layers of `slab`, lowest first, from about
/// `points` points each.
#[must_use]
pub fn solid_fraction_profile(
    field: &GrainField,
    slab: &Slab,
    layers: u32,
    points: u32,
    seed: u64,
) -> Vec<f64> {
    // Four points deep in each layer, the rest side by side.
    const DEEP: u32 = 4;
    let wide = (f64::from(points) / f64::from(DEEP)).sqrt().ceil().max(1.0) as u32;
    let buckets = Buckets::new(field, slab.period);
    let counts = inside_by_layer((field, &buckets), slab, [wide, layers.max(1) * DEEP, wide], seed);
    let all = f64::from(wide) * f64::from(wide) * f64::from(DEEP);
    counts.chunks(DEEP as usize).map(|c| c.iter().sum::<u64>() as f64 / all).collect()
}

/// Sum of the grains' volumes within `slab` over its volume. Grains are cut exactly by the lower
/// and the upper face; across the sides a grain counts whole where its centre lies inside.
#[must_use]
pub fn nominal_solid_fraction(field: &GrainField, slab: &Slab) -> f64 {
    let volume = slab.volume();
    if volume == 0.0 {
        return 0.0;
    }
    let mut sum = 0.0;
    for grain in field.iter() {
        let c = grain.center;
        let beside = |axis: usize| !(slab.min[axis]..slab.max[axis]).contains(&c[axis]);
        if slab.period.is_none() && (beside(0) || beside(2)) {
            continue;
        }
        sum += volume_below(grain.radius, slab.max.y - c.y)
            - volume_below(grain.radius, slab.min.y - c.y);
    }
    sum / volume
}

/// Volume of the part of a sphere below height `h` from its centre.
fn volume_below(radius: f64, h: f64) -> f64 {
    let cap = h.clamp(-radius, radius) + radius;
    PI * cap * cap * (radius - cap / 3.0)
}

/// Points in ice in each of `counts[1]` layers, with one random point in each of the boxes into
/// which `counts` divides the slab.
fn inside_by_layer(
    (field, buckets): (&GrainField, &Buckets),
    slab: &Slab,
    counts: [u32; 3],
    seed: u64,
) -> Vec<u64> {
    let mut inside = vec![0; counts[1] as usize];
    if field.is_empty() {
        return inside;
    }
    let spheres = buckets.are_spheres();
    let (origin, quantum) = (field.quantisation.origin(), field.quantisation.quantum());
    let step =
        (slab.max - slab.min) / DVec3::new(counts[0].into(), counts[1].into(), counts[2].into());
    for j in 0..counts[1] {
        for k in 0..counts[2] {
            let row = u64::from(j) * u64::from(counts[2]) + u64::from(k);
            let key = PathKey::new(seed, row, 0);
            for i in 0..counts[0] {
                let [a, b, c] =
                    pcg3d(key.lo, key.hi, i).map(|word| f64::from(word) / 4_294_967_296.0);
                let cell = DVec3::new(f64::from(i) + a, f64::from(j) + b, f64::from(k) + c);
                let point = (slab.min + cell * step - origin) / quantum;
                let mut solid = false;
                buckets.around(point, |index, center, radius| {
                    solid |= if spheres {
                        (center - point).length_squared() <= radius * radius
                    } else {
                        !solid && buckets.holds((index, center, radius), point)
                    };
                });
                inside[j as usize] += u64::from(solid);
            }
        }
    }
    inside
}
