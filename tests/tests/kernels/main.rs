//! The fast kernels against the oracle, on the same random numbers.
//!
//! A path's rounding errors grow by a factor at every grain, so whole long paths cannot agree; those
//! that end after a few interfaces must, in every number, and all paths must agree in the mean.

#![expect(clippy::unwrap_used, reason = "what cannot go on fails the test")]

mod case;
mod paths;
mod shapes;

use snowgrain_accel::{
    GrainGrid, GridError, Packing as Density, SimdLevel, SurfaceShape, Surfaces,
};
use snowgrain_geometry::{Grain, Quantisation, TriangleMesh, teapot};
use snowgrain_grains::{
    Amount, DepositRule, DepositSettings, GrainField, LatticeCell, LatticeKind, LatticeSettings,
    Radii, Snowfall,
};
use snowgrain_math::{DAffine3, DVec3};
use snowgrain_render::transport::PathResult;
use snowgrain_tests::{OracleShape, packs};
use std::sync::Arc;

use case::{Case, Packing, Starts};

const ETA: f64 = 1.31;

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
