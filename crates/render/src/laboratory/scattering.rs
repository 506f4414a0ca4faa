//! Scattering by one grain of any shape, in all orientations alike, without diffraction.

use crate::World;
use crate::measure::{Estimate, Moments, in_tasks};
use crate::transport::{NewPath, PathEnd, PathResult, PathSource, trace};
use core::f64::consts::{PI, TAU};
use core::ops::Range;
use snowgrain_accel::{GrainGrid, Packing, ShapedGrains, SimdLevel, Surfaces};
use snowgrain_geometry::{GrainShape, Quantisation, Shape};
use snowgrain_math::sampler::{PathKey, numbers};
use snowgrain_math::{DVec3, Ray, frame, trig};
use snowgrain_optics::scatter::Scattered;

/// What one grain does to light that meets it.
#[derive(Clone, Debug, PartialEq)]
pub struct Scattering {
    /// Paths that met the grain.
    pub paths: u64,
    /// Mean cosine of the scattering angle.
    pub asymmetry: Estimate,
    /// Absorption enhancement B: the mean length in ice of light that meets the grain, times the mean projected
    /// area, by the volume; at most n^2 for convex bodies.
    pub enhancement: Estimate,
    /// Mean projected area, in squares of the radius of the sphere of equal volume.
    pub projected_area: Estimate,
    /// Fresnel decisions a path.
    pub interface_events: Estimate,
    /// Part of the light that is scattered into each of equal bins of the angle, 0 to 180 degrees.
    pub energy_by_angle: Vec<Estimate>,
}

/// Traces `paths` rays of an even field through the bounding sphere of a grain of relative index `eta` by the
/// kernel that traces snow; those that miss the grain tell its shadow.
///
/// # Panics
/// If there are no bins or no paths, or the machine does not have the level.
#[must_use]
pub fn scattering(
    shape: &Shape,
    eta: f64,
    bins: usize,
    (paths, seed): (u64, u64),
    level: SimdLevel,
) -> Scattering {
    let (world, radius) = lone_grain(shape, eta);
    let reach = shape.bounding_radius();
    let parts = in_tasks(paths, |first, count| {
        let sums = Sums { by_angle: vec![0; bins], ..Sums::default() };
        let mut source = Lines::new(reach * radius, seed, first..first + count, sums);
        trace(&world, level, &mut source);
        source.sums
    });
    let mut total = Sums { by_angle: vec![0; bins], ..Sums::default() };
    parts.iter().for_each(|part| total.merge(part));
    let met = total.met;
    let disc = PI * reach * reach;
    let shadow = met as f64 / paths as f64;
    let scaled = |estimate: Estimate, factor: f64| Estimate {
        mean: estimate.mean * factor,
        standard_error: estimate.standard_error * factor,
    };
    let part_of = |part: f64, of: u64| Estimate {
        mean: part,
        standard_error: (part * (1.0 - part) / of as f64).sqrt(),
    };
    // Length of all lines over the disc, whether they meet the grain or not: needs no shadow of its own.
    let length = scaled(total.length.estimate(paths), 1.0 / radius);
    Scattering {
        paths: met,
        asymmetry: total.cosine.estimate(met),
        enhancement: scaled(length, disc / Shape::VOLUME),
        projected_area: scaled(part_of(shadow, paths), disc),
        interface_events: total.events.estimate(met),
        energy_by_angle: total
            .by_angle
            .iter()
            .map(|&count| part_of(count as f64 / met as f64, met))
            .collect(),
    }
}

/// The same of shapes that are mixed, each with its part of the grains: light meets each as often as its part of all
/// shadows. `paths` are followed of each.
///
/// # Panics
/// As [`scattering`]; if there are no shapes.
#[must_use]
pub fn scattering_of_mix(
    shapes: &[(Shape, f64)],
    eta: f64,
    bins: usize,
    paths: (u64, u64),
    level: SimdLevel,
) -> Scattering {
    let found: Vec<(Scattering, f64)> = shapes
        .iter()
        .map(|(shape, part)| (scattering(shape, eta, bins, paths, level), *part))
        .collect();
    if let [(only, _)] = &found[..] {
        return only.clone();
    }
    let weighted = |of: &dyn Fn(&Scattering) -> Estimate, weight: &dyn Fn(usize) -> f64| {
        let all: f64 = (0..found.len()).map(weight).sum();
        let (mut mean, mut variance) = (0.0, 0.0);
        for (index, (one, _)) in found.iter().enumerate() {
            let (estimate, part) = (of(one), weight(index) / all);
            mean += part * estimate.mean;
            variance += (part * estimate.standard_error) * (part * estimate.standard_error);
        }
        Estimate { mean, standard_error: variance.sqrt() }
    };
    let by_number = |index: usize| found[index].1;
    // The shadows that are known exactly: those that were met are one estimate with the rest.
    let by_shadow = |index: usize| found[index].1 * shapes[index].0.mean_projected_area();
    let energy = |bin: usize| weighted(&|one| one.energy_by_angle[bin], &by_shadow);
    Scattering {
        paths: found.iter().map(|(one, _)| one.paths).sum(),
        asymmetry: weighted(&|one| one.asymmetry, &by_shadow),
        enhancement: weighted(&|one| one.enhancement, &by_number),
        projected_area: weighted(&|one| one.projected_area, &by_number),
        interface_events: weighted(&|one| one.interface_events, &by_shadow),
        energy_by_angle: (0..bins).map(energy).collect(),
    }
}

/// Light of an even field that met a grain, path by path.
///
/// # Panics
/// If the machine does not have the level.
pub(crate) fn scattered(
    shape: &Shape,
    eta: f64,
    paths: (u64, u64),
    level: SimdLevel,
) -> Vec<Scattered> {
    told(shape, eta, paths, level, &scattered_of)
}

/// What is told of each path of an even field around a grain: by the direction in which it came, what became of it, and the radius
/// of the grain; so many paths by their seed.
fn told<T: Send>(
    shape: &Shape,
    eta: f64,
    (paths, seed): (u64, u64),
    level: SimdLevel,
    tell: &(impl Fn(DVec3, &PathResult, f64) -> Option<T> + Sync),
) -> Vec<T> {
    let (world, radius) = lone_grain(shape, eta);
    let reach = shape.bounding_radius();
    let parts = in_tasks(paths, |first, count| {
        let each = Each { tell: |incident, path: &_| tell(incident, path, radius), told: vec![] };
        let mut source = Lines::new(reach * radius, seed, first..first + count, each);
        trace(&world, level, &mut source);
        let mut told = source.sums.told;
        told.sort_by_key(|&(tag, _)| tag);
        told
    });
    parts.into_iter().flatten().map(|(_, told)| told).collect()
}

/// The same of as many paths as are wanted of which something is told, as it is of those that meet the grain.
pub(super) fn told_of_met<T: Send>(
    shape: &Shape,
    eta: f64,
    (wanted, seed): (usize, u64),
    level: SimdLevel,
    tell: &(impl Fn(DVec3, &PathResult, f64) -> Option<T> + Sync),
) -> Vec<T> {
    let reach = shape.bounding_radius();
    // Lines over the bounding sphere, of which this part meets the grain, and some more.
    let met = shape.mean_projected_area() / (PI * reach * reach);
    let mut lines = (1.02 * wanted as f64 / met) as u64 + 1000;
    loop {
        let mut light = told(shape, eta, (lines, seed), level, tell);
        if light.len() >= wanted {
            light.truncate(wanted);
            return light;
        }
        lines += lines / 8;
    }
}

/// A world that holds one grain, and the radius of that.
fn lone_grain(shape: &Shape, eta: f64) -> (World, f64) {
    let quantisation = Quantisation::for_grains(DVec3::ZERO, shape.bounding_radius());
    let grain = quantisation.round(DVec3::ZERO, 1.0).expect("a grain fits its own lattice");
    let shapes = ShapedGrains {
        prototypes: std::slice::from_ref(shape),
        of_grains: &[GrainShape::upright(0)],
    };
    let surfaces = Surfaces::default();
    let grid = GrainGrid::build_shaped(
        quantisation,
        (&[grain], shapes),
        (&surfaces, &[]),
        None,
        Packing::Fast,
    )
    .expect("one grain can be packed");
    let radius = quantisation.grain(grain).radius;
    (World { grid, surfaces, materials: Vec::new(), emitters: Vec::new(), eta }, radius)
}

/// What is kept of paths around a lone grain.
trait Kept {
    /// A path that came along `incident`; it has met the grain if it has visits.
    fn add(&mut self, tag: u64, incident: DVec3, path: &PathResult);
}

#[derive(Clone, Debug, Default)]
struct Sums {
    met: u64,
    cosine: Moments,
    length: Moments,
    events: Moments,
    by_angle: Vec<u64>,
}

impl Sums {
    fn merge(&mut self, other: &Self) {
        self.met += other.met;
        self.cosine.merge(&other.cosine);
        self.length.merge(&other.length);
        self.events.merge(&other.events);
        self.by_angle.iter_mut().zip(&other.by_angle).for_each(|(mine, theirs)| *mine += theirs);
    }
}

impl Kept for Sums {
    fn add(&mut self, _: u64, incident: DVec3, path: &PathResult) {
        self.length.add(path.ice_length);
        let PathEnd::Escaped(ray) = path.end else { return };
        if path.grain_visits == 0 {
            return;
        }
        let cosine = ray.direction.dot(incident).clamp(-1.0, 1.0);
        self.met += 1;
        self.cosine.add(cosine);
        self.events.add(f64::from(path.interface_events));
        let bins = self.by_angle.len();
        let bin = (trig::acos(cosine) / PI * bins as f64) as usize;
        self.by_angle[bin.min(bins - 1)] += 1;
    }
}

/// What is told of each path, with its number.
struct Each<F, T> {
    tell: F,
    told: Vec<(u64, T)>,
}

impl<T, F: Fn(DVec3, &PathResult) -> Option<T>> Kept for Each<F, T> {
    fn add(&mut self, tag: u64, incident: DVec3, path: &PathResult) {
        self.told.extend((self.tell)(incident, path).map(|told| (tag, told)));
    }
}

/// How light left a grain of this radius that it met.
pub(super) fn scattered_of(incident: DVec3, path: &PathResult, radius: f64) -> Option<Scattered> {
    let PathEnd::Escaped(Ray { origin, direction, .. }) = path.end else { return None };
    if path.grain_visits == 0 {
        return None;
    }
    let cosine = direction.dot(incident).clamp(-1.0, 1.0);
    // Where the line leaves the sphere of equal volume, or is nearest to it.
    let middle = origin - direction * origin.dot(direction);
    let half2 = radius * radius - middle.length_squared();
    let place = middle + direction * half2.max(0.0).sqrt();
    let across = (direction - incident * cosine).try_normalize();
    let aside = across.map_or(0.0, |across| place.dot(across));
    let exit = trig::atan2(aside, place.dot(incident));
    Some(Scattered { cosine, exit, length: path.ice_length / radius })
}

/// Lines that are spread evenly over all that meet the bounding sphere.
struct Lines<K> {
    reach: f64,
    seed: u64,
    next: u64,
    end: u64,
    /// Directions of the paths from number `first` on.
    incident: Vec<DVec3>,
    first: u64,
    sums: K,
}

impl<K> Lines<K> {
    fn new(reach: f64, seed: u64, numbers: Range<u64>, sums: K) -> Self {
        let Range { start: first, end } = numbers;
        let incident = Vec::with_capacity((end - first) as usize);
        Self { reach, seed, next: first, end, incident, first, sums }
    }
}

impl<K: Kept> PathSource for Lines<K> {
    type Tag = u64;

    fn next_path(&mut self) -> Option<NewPath<u64>> {
        if self.next == self.end {
            return None;
        }
        let tag = self.next;
        self.next += 1;
        let key = PathKey::new(self.seed, tag, 0);
        let [a, b, c] = numbers(key, 0).map(f64::from);
        let d = f64::from(numbers(key, 1)[0]);
        let y = 1.0 - 2.0 * a;
        let ring = (1.0 - y * y).max(0.0).sqrt();
        let (sin, cos) = trig::sin_cos(TAU * b);
        let direction = DVec3::new(ring * cos, y, ring * sin).normalize();
        let (s, t) = frame::tangents(direction);
        let (sin, cos) = trig::sin_cos(TAU * d);
        let aside = (s * cos + t * sin) * (self.reach * c.sqrt());
        self.incident.push(direction);
        let ray = Ray::new(aside - direction * (4.0 * self.reach), direction);
        Some(NewPath { tag, ray, key, event: 2 })
    }

    fn finish(&mut self, tag: u64, path: &PathResult) {
        let incident = self.incident[(tag - self.first) as usize];
        self.sums.add(tag, incident, path);
    }
}
