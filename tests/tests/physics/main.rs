//! What the renderer shows of physics, through the fast kernels: exact identities, closed forms and
//! figures that independent programs found.
//!
//! Statistical tests accept 4 standard errors: each such comparison fails by chance once in 16 000
//! seeds, and the seeds are fixed. `SNOWGRAIN_FULL=1` takes more samples (`tests/README.md`).

#![expect(clippy::unwrap_used, reason = "what cannot go on fails the test")]

mod colours;
mod cubes;
mod deep;
mod deposits;
mod dispersion;
mod glints;
mod grain;
mod lights;
mod pictures;
mod shapes;
mod slabs;
mod sun;
mod sun_images;
mod surfaces;
mod tiles;

use snowgrain_accel::{GrainGrid, Packing, Surfaces};
use snowgrain_geometry::Quantisation;
use snowgrain_grains::{GrainField, LatticeCell, LatticeKind, LatticeSettings};
use snowgrain_math::DVec3;
use snowgrain_render::World;
use snowgrain_render::measure::Estimate;

/// Standard errors by which a mean may miss what it should be.
const SIGMAS: f64 = 4.0;

/// Index of refraction of the reference tables.
const ETA: f64 = 1.31;

/// The number of samples: `quick`, or `full` where the environment asks for the full profile.
fn samples(quick: u64, full: u64) -> u64 {
    if is_full() { full } else { quick }
}

fn is_full() -> bool {
    std::env::var_os("SNOWGRAIN_FULL").is_some_and(|value| value == "1")
}

/// Asserts that `estimate` is `expected`, known to within `tolerance`.
fn assert_agrees(what: &str, estimate: Estimate, expected: f64, tolerance: f64) {
    let off = (estimate.mean - expected).abs();
    assert!(
        off <= tolerance + SIGMAS * estimate.standard_error,
        "{what}: {} +- {} instead of {expected} +- {tolerance}",
        estimate.mean,
        estimate.standard_error
    );
}

/// Grains alone, without surfaces.
fn world(grid: GrainGrid) -> World {
    World {
        grid,
        surfaces: Surfaces::default(),
        materials: Vec::new(),
        emitters: Vec::new(),
        eta: ETA,
    }
}

/// A lattice of touching grains of radius 1/2 that needs no memory.
fn lattice(kind: LatticeKind, counts: [u32; 3], periodic: [bool; 3]) -> World {
    let quantisation = Quantisation::for_grains(DVec3::ZERO, 0.5);
    let settings = LatticeSettings { kind, counts, radius: 0.5, spacing: None, density: None };
    let cell = LatticeCell::new(&settings, &quantisation).unwrap();
    let packed = snowgrain_accel::LatticeCell {
        side_quanta: cell.side_quanta,
        basis: cell.basis,
        radius_quanta: cell.radius,
    };
    world(GrainGrid::lattice(quantisation, &packed, counts, [0; 3], periodic).unwrap())
}

/// Grains that repeat along x and z with these periods, metres.
fn periodic(field: &GrainField, period: [f64; 2]) -> World {
    let quanta = period.map(|p| (p / field.quantisation.quantum()).round() as i64);
    world(
        GrainGrid::build_periodic(field.quantisation, &*field.grains(), quanta, Packing::Fast)
            .unwrap(),
    )
}
