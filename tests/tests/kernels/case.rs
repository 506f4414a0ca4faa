//! Grains, what lies among them and where rays come from: for the kernels and for the oracle.

use super::ETA;
use super::paths::{self, on_sphere};
use snowgrain_accel::{GrainGrid, Packing as Density, SimdLevel, SurfaceShape, Surfaces};
use snowgrain_geometry::{Grain, Quantisation, QuantisedGrain};
use snowgrain_grains::{GrainField, LatticeCell};
use snowgrain_math::sampler::{PathKey, numbers};
use snowgrain_math::{DAffine3, DVec3, Ray, frame};
use snowgrain_render::transport::{self, PathResult};
use snowgrain_render::{Material, World};
use snowgrain_tests::{Oracle, OracleShape, OracleSurface, PathEnd, Search};

/// Where the rays of a case come from.
#[derive(Clone, Copy)]
pub(super) enum Starts {
    /// From a sphere around a point, aimed at points inside a smaller one.
    Around { center: DVec3, outer: f64, inner: f64 },
    /// From so far from a grain, aimed at it.
    AtGrains { distance: f64 },
    /// Lambertian, on the upper face of periodic snow.
    FromAbove { height: f64 },
}

/// How the grains are packed for the kernels.
pub(super) enum Packing {
    Cells,
    /// Repeats along x and z with these periods, quanta.
    Periodic([i64; 2]),
    /// No cells at all.
    Lattice(LatticeCell),
}

pub(super) struct Case {
    pub(super) grains: Vec<QuantisedGrain>,
    pub(super) quantisation: Quantisation,
    pub(super) objects: Vec<(SurfaceShape, OracleShape, [f32; 3])>,
    pub(super) starts: Starts,
    pub(super) packing: Packing,
    pub(super) density: Density,
    pub(super) eta: f64,
    /// Of the grains, where any has one.
    pub(super) strata: Vec<u8>,
}

/// The first ray of a path, which takes its events 0 and 1.
fn start(case: &Case, key: PathKey) -> Ray {
    let (first, second) = (numbers(key, 0), numbers(key, 1));
    match case.starts {
        Starts::Around { center, outer, inner } => {
            let origin = center + on_sphere(first) * outer;
            let target = center + on_sphere(second) * inner;
            Ray::new(origin, (target - origin).normalize())
        }
        Starts::AtGrains { distance } => {
            let index = (key.lo as usize) % case.grains.len();
            let grain = case.quantisation.grain(case.grains[index]);
            let origin = grain.center + on_sphere(first) * distance;
            let target = grain.center + on_sphere(second) * (0.99 * grain.radius);
            Ray::new(origin, (target - origin).normalize())
        }
        Starts::FromAbove { height } => {
            let [x, z] = case.period().expect("the snow is periodic");
            let [u, v, _] = first.map(f64::from);
            let [_, a, b] = second.map(f64::from);
            let direction = frame::cosine_hemisphere(-DVec3::Y, [a, b]);
            Ray::new(DVec3::new(u * x, height, v * z), direction)
        }
    }
}

impl Case {
    pub(super) fn new(grains: &[Grain], largest: f64, starts: Starts) -> Self {
        let quantisation = Quantisation::for_grains(DVec3::ZERO, largest);
        let grains =
            grains.iter().map(|g| quantisation.round(g.center, g.radius).unwrap()).collect();
        Self::of_field(GrainField::new(quantisation, grains), starts)
    }

    pub(super) fn of_field(field: GrainField, starts: Starts) -> Self {
        let (quantisation, grains) = (field.quantisation, field.into_grains());
        Self {
            grains,
            quantisation,
            objects: Vec::new(),
            starts,
            packing: Packing::Cells,
            density: Density::Fast,
            eta: ETA,
            strata: Vec::new(),
        }
    }

    /// Periods, metres.
    pub(super) fn period(&self) -> Option<[f64; 2]> {
        match self.packing {
            Packing::Periodic(quanta) => {
                Some(quanta.map(|q| q as f64 * self.quantisation.quantum()))
            }
            Packing::Cells | Packing::Lattice(_) => None,
        }
    }

    pub(super) fn world(&self) -> World {
        let shapes: Vec<_> =
            self.objects.iter().map(|(s, _, _)| (s.clone(), DAffine3::IDENTITY)).collect();
        let surfaces = Surfaces::new(&shapes);
        let quantisation = self.quantisation;
        let grid = match &self.packing {
            Packing::Cells => GrainGrid::build_in_strata(
                quantisation,
                &self.grains,
                &surfaces,
                self.density,
                &self.strata,
            ),
            Packing::Periodic(period) => {
                GrainGrid::build_periodic(quantisation, &self.grains, *period, self.density)
            }
            Packing::Lattice(cell) => {
                let packed = snowgrain_accel::LatticeCell {
                    side_quanta: cell.side_quanta,
                    basis: cell.basis.clone(),
                    radius_quanta: cell.radius,
                };
                GrainGrid::lattice(quantisation, &packed, cell.counts, [0; 3], [false; 3])
            }
        };
        let materials = self.objects.iter().map(|o| Material::diffuse(o.2)).collect();
        World { grid: grid.unwrap(), surfaces, materials, emitters: Vec::new(), eta: self.eta }
    }

    pub(super) fn trace(&self, level: SimdLevel, paths: u64) -> Vec<PathResult> {
        paths::trace(&self.world(), level, paths, |key| start(self, key))
    }

    /// Compares every short path number by number and all in the mean.
    pub(super) fn agrees_with_oracle(&self, paths: u64) {
        let grains: Vec<Grain> = self.grains.iter().map(|&g| self.quantisation.grain(g)).collect();
        let surfaces: Vec<_> = self
            .objects
            .iter()
            .map(|(_, shape, albedo)| OracleSurface {
                shape: shape.clone(),
                albedo: DVec3::from_array(albedo.map(f64::from)),
            })
            .collect();
        let search = self.period().map_or(Search::Cells, |period| Search::Periodic { period });
        let oracle = Oracle::new(&grains, &surfaces, self.eta, search);
        let unit = self.quantisation.largest_radius();
        let (mut short, mut wrong) = (0u32, 0u32);
        let mut sums = [[0.0f64; 5]; 2];
        let mut squares = 0.0;
        let mut released = 0;
        for (tag, fast) in self.trace(SimdLevel::detect(), paths).iter().enumerate() {
            let key = paths::key(tag as u64);
            let start = start(self, key);
            let exact = oracle.trace(start.origin, start.direction, key, 2);
            released += fast.releases;
            let (fast_direction, fast_light) = match fast.end {
                transport::PathEnd::Escaped(ray) => (Some(ray.direction), fast.throughput),
                transport::PathEnd::Emitted { .. }
                | transport::PathEnd::Absorbed
                | transport::PathEnd::Enclosed
                | transport::PathEnd::Deep(_) => (None, [0.0; 3]),
            };
            let exact_direction = exact.escaped_direction();
            assert!(exact.end != PathEnd::Trapped);
            let up = |d: Option<DVec3>, light: f64| {
                if d.is_some_and(|d| d.y > 0.0) { light } else { 0.0 }
            };
            let row =
                |sums: &mut [f64; 5], light: f64, direction, ice: f64, events: u32, visits: u32| {
                    sums[0] += up(direction, light);
                    sums[1] += ice / unit;
                    sums[2] += f64::from(events);
                    sums[3] += f64::from(visits);
                    sums[4] += 1.0;
                };
            row(
                &mut sums[0],
                f64::from(fast_light[0]),
                fast_direction,
                fast.ice_length,
                fast.interface_events,
                fast.grain_visits,
            );
            let exact_light = if exact_direction.is_some() { exact.throughput.x } else { 0.0 };
            row(
                &mut sums[1],
                exact_light,
                exact_direction,
                exact.ice_length,
                exact.interface_events,
                exact.grain_visits,
            );
            let difference =
                up(fast_direction, f64::from(fast_light[0])) - up(exact_direction, exact_light);
            squares += difference * difference;
            if exact.interface_events + exact.diffuse_bounces > 5 {
                continue;
            }
            short += 1;
            let same = fast.interface_events == exact.interface_events
                && fast.grain_visits == exact.grain_visits
                && fast.surface_bounces == exact.diffuse_bounces
                && (fast.ice_length - exact.ice_length).abs() < 2e-2 * unit
                && match (fast_direction, exact_direction) {
                    (Some(a), Some(b)) => (a - b).length() < 2e-2,
                    (a, b) => a.is_none() == b.is_none(),
                };
            if !same && wrong < 6 {
                println!(
                    "{tag} {fast:?}\n   {exact:?}\n {:#?}",
                    oracle.trace_events(start.origin, start.direction, key, 2).1
                );
            }
            wrong += u32::from(!same);
        }
        let n = paths as f64;
        assert!(short > 1000, "{short} short paths");
        // A decision can fall between the two roundings of a reflectance: once in 10^6 events; a hundred
        // times as often where light comes from the denser medium near the critical angle, at which the
        // reflectance is steep.
        let allowed = if self.eta < 1.0 { 8 } else { 2 };
        assert!(wrong <= allowed, "{wrong} of {short} short paths differ");
        // The paired difference of the light has this standard error; 4 sigma: 6e-5 a case.
        let sigma = (squares / n).sqrt() / n.sqrt();
        let bias = (sums[0][0] - sums[1][0]).abs() / n;
        assert!(bias < 0.0005 + 4.0 * sigma, "light differs by {bias}, sigma {sigma}");
        for (what, [fast, exact]) in
            [("ice", 1), ("events", 2), ("visits", 3)].map(|(what, at)| (what, sums.map(|s| s[at])))
        {
            let ratio = fast / exact;
            assert!((ratio - 1.0).abs() < 0.02, "{what}: ratio {ratio}");
        }
        assert_eq!(released, 0);
    }
}
