//! The fast kernels against the oracle, on the same random numbers.
//!
//! A path's rounding errors grow by a factor at every grain, so whole long paths cannot agree; those
//! that end after a few interfaces must, in every number, and all paths must agree in the mean.

#![expect(clippy::unwrap_used, reason = "what cannot go on fails the test")]

use snowgrain_accel::{
    GrainGrid, GridError, Packing as Density, SimdLevel, SurfaceShape, Surfaces,
};
use snowgrain_geometry::{Grain, Quantisation, QuantisedGrain, TriangleMesh, teapot};
use snowgrain_grains::{
    Amount, DepositRule, DepositSettings, GrainField, LatticeCell, LatticeKind, LatticeSettings,
    Radii, Snowfall,
};
use snowgrain_math::sampler::{PathKey, numbers};
use snowgrain_math::{DAffine3, DVec3, Ray, frame};
use snowgrain_render::transport::{self, NewPath, PathResult, PathSource};
use snowgrain_render::{Material, World};
use snowgrain_tests::{Oracle, OracleShape, OracleSurface, PathEnd, Search, packs};
use std::sync::Arc;

const ETA: f64 = 1.31;

/// Where the rays of a case come from.
#[derive(Clone, Copy)]
enum Starts {
    /// From a sphere around a point, aimed at points inside a smaller one.
    Around { center: DVec3, outer: f64, inner: f64 },
    /// From so far from a grain, aimed at it.
    AtGrains { distance: f64 },
    /// Lambertian, on the upper face of periodic snow.
    FromAbove { height: f64 },
}

/// How the grains are packed for the kernels.
enum Packing {
    Cells,
    /// Repeats along x and z with these periods, quanta.
    Periodic([i64; 2]),
    /// No cells at all.
    Lattice(LatticeCell),
}

struct Case {
    grains: Vec<QuantisedGrain>,
    quantisation: Quantisation,
    objects: Vec<(SurfaceShape, OracleShape, [f32; 3])>,
    starts: Starts,
    packing: Packing,
    density: Density,
    eta: f64,
    /// Of the grains, where any has one.
    strata: Vec<u8>,
}

/// A point on the unit sphere.
fn on_sphere([u, v, w]: [f32; 3]) -> DVec3 {
    let pole = if w < 0.5 { DVec3::Y } else { -DVec3::Y };
    frame::cosine_hemisphere(pole, [f64::from(u), f64::from(v)])
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

struct Recorder<'a> {
    case: &'a Case,
    next: u64,
    end: u64,
    results: Vec<Option<PathResult>>,
}

impl PathSource for Recorder<'_> {
    type Tag = u64;

    fn next_path(&mut self) -> Option<NewPath<u64>> {
        if self.next == self.end {
            return None;
        }
        let tag = self.next;
        self.next += 1;
        let key = PathKey::new(9, tag, 0);
        Some(NewPath { tag, ray: start(self.case, key), key, event: 2 })
    }

    fn finish(&mut self, tag: u64, result: &PathResult) {
        self.results[tag as usize] = Some(*result);
    }
}

impl Case {
    fn new(grains: &[Grain], largest: f64, starts: Starts) -> Self {
        let quantisation = Quantisation::for_grains(DVec3::ZERO, largest);
        let grains =
            grains.iter().map(|g| quantisation.round(g.center, g.radius).unwrap()).collect();
        Self::of_field(GrainField::new(quantisation, grains), starts)
    }

    fn of_field(field: GrainField, starts: Starts) -> Self {
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
    fn period(&self) -> Option<[f64; 2]> {
        match self.packing {
            Packing::Periodic(quanta) => {
                Some(quanta.map(|q| q as f64 * self.quantisation.quantum()))
            }
            Packing::Cells | Packing::Lattice(_) => None,
        }
    }

    fn world(&self) -> World {
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

    fn trace(&self, level: SimdLevel, paths: u64) -> Vec<PathResult> {
        let mut recorder =
            Recorder { case: self, next: 0, end: paths, results: vec![None; paths as usize] };
        transport::trace(&self.world(), level, &mut recorder);
        recorder.results.into_iter().map(Option::unwrap).collect()
    }

    /// Compares every short path number by number and all in the mean.
    fn agrees_with_oracle(&self, paths: u64) {
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
            let key = PathKey::new(9, tag as u64, 0);
            let start = start(self, key);
            let exact = oracle.trace(start.origin, start.direction, key, 2);
            released += fast.releases;
            let (fast_direction, fast_light) = match fast.end {
                transport::PathEnd::Escaped(ray) => (Some(ray.direction), fast.throughput),
                transport::PathEnd::Emitted { .. }
                | transport::PathEnd::Absorbed
                | transport::PathEnd::Enclosed => (None, [0.0; 3]),
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

fn cube_mesh(center: DVec3, half: f64) -> TriangleMesh {
    let positions = (0..8)
        .map(|i| {
            center
                + half
                    * DVec3::new(
                        if i & 1 == 0 { -1.0 } else { 1.0 },
                        if i & 2 == 0 { -1.0 } else { 1.0 },
                        if i & 4 == 0 { -1.0 } else { 1.0 },
                    )
        })
        .collect();
    let triangles = vec![
        [0, 4, 6],
        [0, 6, 2],
        [1, 3, 7],
        [1, 7, 5],
        [0, 1, 5],
        [0, 5, 4],
        [2, 6, 7],
        [2, 7, 3],
        [0, 2, 3],
        [0, 3, 1],
        [4, 5, 7],
        [4, 7, 6],
    ];
    TriangleMesh::new(positions, triangles).unwrap()
}

#[test]
fn separate_grains_agree_with_the_oracle() {
    let grains = packs::simple_cubic([8, 8, 8], 0.5);
    Case::new(&grains, 0.5, Starts::Around { center: DVec3::splat(4.0), outer: 12.0, inner: 4.0 })
        .agrees_with_oracle(20_000);
}

#[test]
fn overlapping_grains_of_many_sizes_agree_with_the_oracle() {
    let grains = packs::strewn(400, DVec3::splat(6.0), [0.1, 0.9], 3);
    let mut case = Case::new(
        &grains,
        0.9,
        Starts::Around { center: DVec3::splat(3.0), outer: 10.0, inner: 3.0 },
    );
    case.agrees_with_oracle(20_000);
    case.density = Density::Compact;
    case.agrees_with_oracle(20_000);
}

/// Ice in water: light is reflected wholly from outside, never from inside.
#[test]
fn grains_in_denser_surroundings_agree_with_the_oracle() {
    let around = |middle, inner| Starts::Around { center: middle, outer: 10.0, inner };
    let grains = packs::strewn(400, DVec3::splat(6.0), [0.1, 0.9], 3);
    let mut overlapping = Case::new(&grains, 0.9, around(DVec3::splat(3.0), 3.0));
    overlapping.eta = 0.983;
    overlapping.agrees_with_oracle(20_000);
    let grains = packs::simple_cubic([8, 8, 8], 0.5);
    let mut touching = Case::new(&grains, 0.5, around(DVec3::splat(4.0), 4.0));
    touching.eta = 0.75;
    touching.agrees_with_oracle(20_000);
}

/// Strata change no path, and the ice of all of them is the ice of the path.
#[test]
fn strata_share_the_ice_of_every_path_among_them() {
    let around = |middle, inner| Starts::Around { center: middle, outer: 10.0, inner };
    let mut grains = packs::strewn(400, DVec3::splat(6.0), [0.1, 0.9], 3);
    grains.extend(packs::strewn(200, DVec3::splat(6.0), [0.05, 0.1], 8));
    let mut case = Case::new(&grains, 0.9, around(DVec3::splat(3.0), 3.0));
    let mesh = cube_mesh(DVec3::new(3.0, 2.5, 3.2), 1.2);
    let triangles = (0..mesh.triangles.len()).map(|i| mesh.corners(i)).collect();
    case.objects.push((
        SurfaceShape::Mesh(Arc::new(mesh)),
        OracleShape::Triangles(triangles),
        [0.9, 0.2, 0.1],
    ));
    let level = SimdLevel::detect();
    let without = case.trace(level, 20_000);
    case.strata = (0..grains.len()).map(|grain| 1 + (grain % 7) as u8).collect();
    let all = case.trace(level, 20_000);
    // The same strata again, but the fourth is none.
    case.strata.iter_mut().for_each(|stratum| *stratum = if *stratum == 4 { 0 } else { *stratum });
    let some = case.trace(level, 20_000);
    let mut seen = [0.0; 7];
    for ((plain, all), some) in without.iter().zip(&all).zip(&some) {
        let sum: f64 = all.ice_in_strata.iter().sum();
        assert!((sum - plain.ice_length).abs() < 1e-4 * (1.0 + plain.ice_length), "{all:?}");
        assert!(all.ice_in_strata.iter().all(|&length| length > -1e-5), "{all:?}");
        let alike = PathResult { ice_in_strata: plain.ice_in_strata, ..*all };
        assert_eq!(format!("{alike:?}"), format!("{plain:?}"));
        let mut rest = all.ice_in_strata;
        rest[3] = 0.0;
        assert_eq!(some.ice_in_strata, rest);
        seen.iter_mut().zip(all.ice_in_strata).for_each(|(seen, length)| *seen += length);
    }
    assert!(seen.iter().all(|&length| length > 0.02 * seen.iter().sum::<f64>()), "{seen:?}");
    for level in SimdLevel::available() {
        assert_eq!(format!("{:?}", case.trace(level, 2_000)), format!("{:?}", &some[..2_000]));
    }
}

/// A heap of dust around and within two grains of a hundred times its radius: cells are far smaller
/// than the large grains.
#[test]
fn grains_of_sizes_1_to_100_agree_with_the_oracle() {
    let mut grains = packs::strewn(3000, DVec3::splat(0.4), [0.01, 0.02], 3);
    for grain in &mut grains {
        grain.center += DVec3::new(0.8, 0.3, -0.2);
    }
    grains.push(Grain { center: DVec3::ZERO, radius: 1.0 });
    grains.push(Grain { center: DVec3::new(1.9, 0.3, 0.0), radius: 1.0 });
    let starts = Starts::Around { center: DVec3::new(1.0, 0.5, 0.0), outer: 4.0, inner: 0.5 };
    let mut case = Case::new(&grains, 1.0, starts);
    case.agrees_with_oracle(50_000);
    case.density = Density::Compact;
    case.agrees_with_oracle(50_000);
}

#[test]
fn grains_that_meet_a_mesh_and_a_plane_agree_with_the_oracle() {
    let grains = packs::strewn(300, DVec3::splat(6.0), [0.3, 0.6], 5);
    let mut case = Case::new(
        &grains,
        0.6,
        Starts::Around { center: DVec3::splat(3.0), outer: 10.0, inner: 3.0 },
    );
    let mesh = cube_mesh(DVec3::new(3.0, 2.5, 3.2), 1.2);
    let triangles = (0..mesh.triangles.len()).map(|i| mesh.corners(i)).collect();
    case.objects.push((
        SurfaceShape::Mesh(Arc::new(mesh)),
        OracleShape::Triangles(triangles),
        [0.9, 0.2, 0.1],
    ));
    case.objects.push((
        SurfaceShape::Plane,
        OracleShape::Plane { point: DVec3::ZERO, normal: DVec3::Y },
        [0.7, 0.7, 0.3],
    ));
    case.agrees_with_oracle(20_000);
}

/// A fall of grains of .4 to .6 units.
fn fall(amount: Amount, rule: DepositRule) -> DepositSettings {
    DepositSettings {
        amount,
        radii: Radii::Uniform { mean: 0.5, variation: 0.1 },
        density: None,
        rule: Some(rule),
        max_slope_degrees: 80.0,
        direction: DepositSettings::DOWN,
        area: None,
        seed: 4,
    }
}

#[test]
fn a_teapot_under_the_paper_s_deposit_agrees_with_the_oracle() {
    let mut mesh = teapot::teapot(2);
    for position in &mut mesh.positions {
        *position *= 3.0;
    }
    let triangles = OracleShape::mesh(&mesh);
    let mesh = SurfaceShape::Mesh(Arc::new(mesh));
    let surfaces = Surfaces::new(&[(mesh.clone(), DAffine3::IDENTITY)]);
    let quantisation = Quantisation::for_grains(DVec3::ZERO, 0.6);
    let mut snow = Snowfall::on_surfaces(quantisation, &surfaces);
    snow.deposit(&fall(Amount::Grains(1500), DepositRule::Ray)).unwrap();
    let starts = Starts::Around { center: DVec3::new(0.0, 6.0, 0.0), outer: 40.0, inner: 9.0 };
    let mut case = Case::of_field(snow.into_field(), starts);
    case.objects.push((mesh, triangles, [0.8, 0.3, 0.2]));
    case.agrees_with_oracle(20_000);
}

#[test]
fn every_lattice_without_memory_agrees_with_the_oracle() {
    for kind in [LatticeKind::Sc, LatticeKind::Bcc, LatticeKind::Fcc, LatticeKind::Hcp] {
        // Touching, apart, and overlapping.
        for spacing in [None, Some(1.3), Some(0.85)] {
            let settings =
                LatticeSettings { kind, counts: [5, 4, 3], radius: 0.5, spacing, density: None };
            let quantisation = Quantisation::for_grains(DVec3::ZERO, 0.5);
            let cell = LatticeCell::new(&settings, &quantisation).unwrap();
            let grains = cell.grains().collect();
            let starts = Starts::Around { center: DVec3::splat(2.5), outer: 12.0, inner: 3.0 };
            let mut case = Case::of_field(GrainField::new(quantisation, grains), starts);
            case.packing = Packing::Lattice(cell);
            case.agrees_with_oracle(6_000);
            case.eta = 0.8;
            case.agrees_with_oracle(3_000);
        }
    }
}

/// Hexagonal cells are cut into pieces, as far as that goes; beyond, the caller packs the grains. The
/// others have no limit.
#[test]
fn lattices_of_grains_apart_agree_with_the_oracle_or_are_refused() {
    let quantisation = Quantisation::for_grains(DVec3::ZERO, 0.5);
    let cell = |kind, spacing| {
        let spacing = Some(spacing);
        let settings =
            LatticeSettings { kind, counts: [3; 3], radius: 0.5, spacing, density: None };
        LatticeCell::new(&settings, &quantisation).unwrap()
    };
    for (kind, spacing) in [
        (LatticeKind::Sc, 2.0),
        (LatticeKind::Fcc, 4.0),
        (LatticeKind::Bcc, 30.0),
        (LatticeKind::Hcp, 2.0),
    ] {
        let cell = cell(kind, spacing);
        let grains = cell.grains().collect();
        let field = GrainField::new(quantisation, grains);
        let mut case = Case::of_field(field, Starts::AtGrains { distance: 20.0 });
        case.packing = Packing::Lattice(cell);
        case.agrees_with_oracle(6_000);
    }
    let wide = cell(LatticeKind::Hcp, 30.0);
    let packed = snowgrain_accel::LatticeCell {
        side_quanta: wide.side_quanta,
        basis: wide.basis,
        radius_quanta: wide.radius,
    };
    assert_eq!(packed.pieces(), None);
    let refused = GrainGrid::lattice(quantisation, &packed, [3; 3], [0; 3], [false; 3]);
    assert_eq!(refused.unwrap_err(), GridError::WideLattice);
}

#[test]
fn snow_that_repeats_agrees_with_the_oracle() {
    let quantisation = Quantisation::for_grains(DVec3::ZERO, 0.6);
    for (rule, width) in [(DepositRule::Ray, 7.3), (DepositRule::Stick, 12.0)] {
        let mut snow = Snowfall::on_level_floor(quantisation, [width, 0.8 * width]).unwrap();
        snow.deposit(&fall(Amount::Depth(6.0), rule)).unwrap();
        let period = snow.period().unwrap().map(|p| (p / quantisation.quantum()).round() as i64);
        let mut case = Case::of_field(snow.into_field(), Starts::FromAbove { height: 20.0 });
        case.packing = Packing::Periodic(period);
        case.agrees_with_oracle(15_000);
    }
}

/// A period of one cell, in which every grain is its own neighbour on all sides.
#[test]
fn a_period_of_one_grain_agrees_with_the_oracle() {
    let grains = packs::face_centred_cubic_layers(7, 0.5);
    let mut case = Case::new(&grains, 0.5, Starts::FromAbove { height: 5.5 });
    let side = (1.0 / case.quantisation.quantum()).round() as i64;
    case.packing = Packing::Periodic([side; 2]);
    case.agrees_with_oracle(30_000);
}

#[test]
fn grains_far_apart_with_nothing_between_agree_with_the_oracle() {
    // Heaps of grains that overlap, and single ones, over a box of 2000 radii: nearly all bricks
    // are empty.
    let places = packs::strewn(40, DVec3::splat(600.0), [0.3, 0.6], 7);
    let grains: Vec<Grain> = places
        .iter()
        .enumerate()
        .flat_map(|(index, place)| {
            let near = packs::strewn(if index % 2 == 0 { 1 } else { 5 }, DVec3::ONE, [0.3, 0.6], 8);
            near.into_iter().map(|g| Grain { center: g.center + place.center, ..g })
        })
        .collect();
    Case::new(&grains, 0.6, Starts::AtGrains { distance: 300.0 }).agrees_with_oracle(20_000);
}

#[test]
fn every_simd_level_gives_the_same_bits() {
    let grains = packs::strewn(300, DVec3::splat(6.0), [0.2, 0.6], 5);
    let mut case = Case::new(
        &grains,
        0.6,
        Starts::Around { center: DVec3::splat(3.0), outer: 10.0, inner: 3.0 },
    );
    let mesh = cube_mesh(DVec3::splat(3.0), 1.2);
    case.objects.push((
        SurfaceShape::Mesh(Arc::new(mesh)),
        OracleShape::Triangles(Vec::new()),
        [0.9, 0.2, 0.1],
    ));
    let reference = format!("{:?}", case.trace(SimdLevel::detect(), 3000));
    for level in SimdLevel::available() {
        assert!(reference == format!("{:?}", case.trace(level, 3000)), "{level} differs");
    }
}
