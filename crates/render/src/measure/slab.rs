//! A slab of snow, periodic in x and z, lit on one face.

use super::{Estimate, Moments, in_tasks};
use crate::World;
use crate::transport::deep::Deep;
use crate::transport::medium::{Medium, ProxyInDepth, trace_in_medium};
use crate::transport::{NewPath, PathEnd, PathResult, PathSource, trace, trace_with};
use snowgrain_accel::SimdLevel;
use snowgrain_math::sampler::{PathKey, numbers};
use snowgrain_math::{DVec3, Ray, frame, trig};

/// Light on a face.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Incidence {
    /// The same radiance from every direction.
    Lambertian,
    /// Parallel light at this angle from the normal, degrees in [0, 90), azimuth along +x.
    Collimated {
        /// Angle from the normal, degrees.
        zenith_degrees: f64,
    },
}

/// What to measure.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SlabSettings {
    /// Height of the upper face, metres.
    pub top: f64,
    /// Height of the lower face, metres.
    pub bottom: f64,
    /// Period along x and z, metres: light enters uniformly over it.
    pub period: [f64; 2],
    /// How light arrives.
    pub incidence: Incidence,
    /// Whether light arrives at the lower face instead of the upper one.
    pub from_below: bool,
    /// Grey absorption of the ice, 1/m.
    pub absorption_per_metre: f64,
    /// Number of paths, >= 1.
    pub paths: u64,
    /// Seed.
    pub seed: u64,
    /// Instruction set of the kernels.
    pub level: SimdLevel,
}

impl SlabSettings {
    /// The path of that number, as it enters.
    pub(crate) fn path(&self, number: u64) -> NewPath<()> {
        let key = PathKey::new(self.seed, number, 0);
        let [u, v, _] = numbers(key, 0);
        let height = if self.from_below { self.bottom } else { self.top };
        let origin =
            DVec3::new(f64::from(u) * self.period[0], height, f64::from(v) * self.period[1]);
        let inward = if self.from_below { DVec3::Y } else { -DVec3::Y };
        let direction = match self.incidence {
            Incidence::Lambertian => {
                let [_, u, v] = numbers(key, 1);
                frame::cosine_hemisphere(inward, [f64::from(u), f64::from(v)])
            }
            Incidence::Collimated { zenith_degrees } => {
                let (sin, cos) = trig::sin_cos(zenith_degrees.to_radians());
                inward * cos + DVec3::X * sin
            }
        };
        NewPath { tag: (), ray: Ray::new(origin, direction), key, event: 2 }
    }
}

/// What a slab does to light.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct SlabMeasure {
    /// Paths traced.
    pub paths: u64,
    /// Reflected fraction.
    pub reflectance: Estimate,
    /// Transmitted fraction, straight light included.
    pub transmittance: Estimate,
    /// Arrivals at grains a path.
    pub grain_visits: Estimate,
    /// Fresnel decisions a path.
    pub interface_events: Estimate,
    /// Length in ice a path, metres (not weighted by absorption).
    pub ice_path: Estimate,
    /// Length in air between the faces a path, metres.
    pub void_path: Estimate,
    /// Fraction of paths by their number of grain visits: 0, 1, 2, ... and the last bin all others.
    pub visits_histogram: Vec<f64>,
    /// Reflected fraction by grain visits, same bins.
    pub reflected_by_visits: Vec<f64>,
    /// Paths that the guard against endless circling in ice let out.
    pub trapped_paths: u64,
}

/// Bins of the histograms by order; the last one collects the rest.
const ORDERS: usize = 33;

/// Measures the slab of the periodic grid in `world` between the faces.
///
/// The faces must enclose all grains. All sums are taken in a fixed order: the result does not
/// depend on threads.
#[must_use]
pub fn measure_slab(world: &World, settings: &SlabSettings) -> SlabMeasure {
    measure(settings, |source| trace(world, settings.level, source))
}

/// As [`measure_slab`], of light that meets the grains as a medium. That reaches a little beyond the grains, and light enters beyond
/// it: the faces are moved outwards, and air between them is void.
#[must_use]
pub fn measure_slab_in_medium(
    world: &World,
    medium: &Medium,
    settings: &SlabSettings,
) -> SlabMeasure {
    let [low, high] = medium.heights();
    let (bottom, top) = (settings.bottom.min(low), settings.top.max(high));
    let settings = SlabSettings { top, bottom, ..*settings };
    measure(&settings, |source| trace_in_medium(world, medium, source))
}

/// As [`measure_slab`], of light that goes on as the proxy where it is deep.
#[must_use]
pub fn measure_slab_in_depth(
    world: &World,
    proxy: &ProxyInDepth,
    settings: &SlabSettings,
) -> SlabMeasure {
    measure(settings, |source| {
        let deep = Some(Deep::Proxy(proxy));
        trace_with((world, world.eta), settings.level, (None, deep), source);
    })
}

fn measure(settings: &SlabSettings, follow: impl Fn(&mut SlabSource<'_>) + Sync) -> SlabMeasure {
    let parts = in_tasks(settings.paths, |first, count| {
        let mut source =
            SlabSource { settings, next: first, end: first + count, sums: Sums::default() };
        follow(&mut source);
        source.sums
    });
    let mut total = Sums::default();
    for part in &parts {
        total.merge(part);
    }
    total.measure(settings.paths)
}

#[derive(Clone, Debug)]
struct Sums {
    reflected: Moments,
    transmitted: Moments,
    visits: Moments,
    events: Moments,
    ice: Moments,
    void: Moments,
    by_visits: [u64; ORDERS],
    reflected_by_visits: [f64; ORDERS],
    trapped: u64,
}

impl Default for Sums {
    fn default() -> Self {
        let zero = Moments::default();
        Self {
            reflected: zero,
            transmitted: zero,
            visits: zero,
            events: zero,
            ice: zero,
            void: zero,
            by_visits: [0; ORDERS],
            reflected_by_visits: [0.0; ORDERS],
            trapped: 0,
        }
    }
}

impl Sums {
    fn merge(&mut self, other: &Self) {
        self.reflected.merge(&other.reflected);
        self.transmitted.merge(&other.transmitted);
        self.visits.merge(&other.visits);
        self.events.merge(&other.events);
        self.ice.merge(&other.ice);
        self.void.merge(&other.void);
        for order in 0..ORDERS {
            self.by_visits[order] += other.by_visits[order];
            self.reflected_by_visits[order] += other.reflected_by_visits[order];
        }
        self.trapped += other.trapped;
    }

    fn measure(&self, paths: u64) -> SlabMeasure {
        let n = paths as f64;
        SlabMeasure {
            paths,
            reflectance: self.reflected.estimate(paths),
            transmittance: self.transmitted.estimate(paths),
            grain_visits: self.visits.estimate(paths),
            interface_events: self.events.estimate(paths),
            ice_path: self.ice.estimate(paths),
            void_path: self.void.estimate(paths),
            visits_histogram: self.by_visits.iter().map(|&count| count as f64 / n).collect(),
            reflected_by_visits: self.reflected_by_visits.iter().map(|sum| sum / n).collect(),
            trapped_paths: self.trapped,
        }
    }
}

struct SlabSource<'a> {
    settings: &'a SlabSettings,
    next: u64,
    end: u64,
    sums: Sums,
}

impl PathSource for SlabSource<'_> {
    type Tag = ();

    fn next_path(&mut self) -> Option<NewPath<()>> {
        if self.next == self.end {
            return None;
        }
        let path = self.settings.path(self.next);
        self.next += 1;
        Some(path)
    }

    fn finish(&mut self, (): (), path: &PathResult) {
        let settings = self.settings;
        let sums = &mut self.sums;
        let weight = trig::exp(-settings.absorption_per_metre * path.ice_length);
        let order = (path.grain_visits as usize).min(ORDERS - 1);
        let (mut reflected, mut transmitted, mut beyond) = (0.0, 0.0, 0.0);
        match path.end {
            PathEnd::Escaped(ray) => {
                let up = ray.direction.y > 0.0;
                if up == settings.from_below {
                    transmitted = weight;
                } else {
                    reflected = weight;
                }
                let face = if up { settings.top } else { settings.bottom };
                beyond = (ray.origin.y - face) / ray.direction.y;
            }
            PathEnd::Emitted { .. } | PathEnd::Absorbed | PathEnd::Enclosed | PathEnd::Deep(_) => {}
        }
        sums.trapped += u64::from(path.releases > 0);
        sums.reflected.add(reflected);
        sums.transmitted.add(transmitted);
        sums.visits.add(f64::from(path.grain_visits));
        sums.events.add(f64::from(path.interface_events));
        sums.ice.add(path.ice_length);
        sums.void.add(path.air_length - beyond);
        sums.by_visits[order] += 1;
        sums.reflected_by_visits[order] += reflected;
    }
}
