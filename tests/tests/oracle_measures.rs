//! What the oracle measures of whole slabs and cubes, against exact identities and tables.
//!
//! Statistical tests accept 4 standard errors: each such comparison fails by chance once in
//! 16 000 seeds, and the seeds are fixed.

use snowgrain_geometry::Grain;
use snowgrain_math::DVec3;
use snowgrain_optics::{Dielectric, sphere};
use snowgrain_tests::cube::LatticeCube;
use snowgrain_tests::packs;
use snowgrain_tests::reference::{CUBE_RADIANCE, SlabRow, TableLight, slab_rows as rows};
use snowgrain_tests::slab::{Illumination, Slab, SlabMeasure};

const SIGMAS: f64 = 4.0;
const ETA: f64 = 1.31;

fn check_identities(slab: &Slab, measure: &SlabMeasure) {
    let tau = slab.tau();
    let b = sphere::absorption_enhancement(Dielectric { eta: slab.eta });
    let (radius, phi) = (slab.grains[0].radius, slab.solid_fraction());
    assert_eq!(measure.trapped.mean, 0.0);
    assert!((measure.reflectance.mean + measure.transmittance.mean - 1.0).abs() < 1e-12);
    for (name, estimate, expected) in [
        ("visits", measure.visits, 2.0 * tau),
        ("events", measure.interface_events, 4.0 * tau),
        ("ice path", measure.ice_length, 2.0 * tau * 4.0 / 3.0 * b * radius),
        ("chord", measure.chord, 4.0 / 3.0 * radius * (1.0 - phi) / phi),
    ] {
        assert!(
            estimate.agrees_with(expected, 0.0, SIGMAS),
            "{name}: {estimate:?} against {expected}"
        );
    }
}

fn check_row(slab: &Slab, light: Illumination, row: &SlabRow, paths: u64) -> SlabMeasure {
    let measure = slab.measure(light, paths, 10);
    for (estimate, expected, error) in [
        (measure.reflectance, row.reflectance, row.standard_error),
        // The table gives no error of its visits; they vary by less than three times their mean.
        (measure.visits, row.visits, 3.0 * row.visits / 200_000f64.sqrt()),
    ] {
        assert!(estimate.agrees_with(expected, SIGMAS * error, SIGMAS), "{estimate:?} {row:?}");
    }
    measure
}

#[test]
fn lattice_slabs_under_diffuse_light_obey_the_identities_and_the_reference_table() {
    for row in &rows("sc", TableLight::Lambertian)[..3] {
        let slab = Slab::simple_cubic(row.layers(), ETA);
        let paths = paths_through(row.layers());
        check_identities(&slab, &check_row(&slab, Illumination::Lambertian, row, paths));
    }
    for row in &rows("fcc", TableLight::Lambertian)[..3] {
        let slab = Slab::face_centred_cubic(row.layers(), ETA);
        let paths = paths_through(row.layers());
        check_identities(&slab, &check_row(&slab, Illumination::Lambertian, row, paths));
    }
}

/// About the same work at every depth.
fn paths_through(layers: u32) -> u64 {
    u64::from(200_000 / layers).min(60_000)
}

#[test]
fn lattice_slabs_lit_straight_down_agree_with_the_reference_table() {
    let down = Illumination::Collimated(-DVec3::Y);
    for row in &rows("sc", TableLight::Parallel(1.0))[..2] {
        let paths = paths_through(row.layers()) / 2;
        check_row(&Slab::simple_cubic(row.layers(), ETA), down, row, paths);
    }
    for row in &rows("fcc", TableLight::Parallel(1.0))[..2] {
        let paths = paths_through(row.layers()) / 2;
        check_row(&Slab::face_centred_cubic(row.layers(), ETA), down, row, paths);
    }
}

#[test]
fn a_random_pack_of_two_sizes_shows_its_surface_in_visits() {
    // Grains kept apart by rejection; visits = 2 tau needs no equal radii.
    let size = DVec3::new(4.0, 3.0, 4.0);
    let mut grains: Vec<Grain> = Vec::new();
    for grain in packs::strewn(4000, size, [0.25, 0.45], 21) {
        let apart = |other: &Grain| {
            let mut way = (grain.center - other.center).abs();
            way.x = way.x.min(size.x - way.x);
            way.z = way.z.min(size.z - way.z);
            way.length() > grain.radius + other.radius
        };
        let inside = grain.center.y > grain.radius && grain.center.y < size.y - grain.radius;
        if inside && grains.iter().all(apart) {
            grains.push(grain);
        }
    }
    let slab = Slab { grains, period: [size.x, size.z], height: size.y, eta: 1.32 };
    let up = slab.measure(Illumination::Lambertian, 30_000, 11);
    let upside_down = slab
        .grains
        .iter()
        .map(|g| Grain { center: DVec3::new(g.center.x, size.y - g.center.y, g.center.z), ..*g })
        .collect();
    let down = Slab { grains: upside_down, ..slab.clone() };
    let down = down.measure(Illumination::Lambertian, 30_000, 12);
    let visits = 0.5 * (up.visits.mean + down.visits.mean);
    let sigma = 0.5 * (up.visits.standard_error.max(down.visits.standard_error)) * 2f64.sqrt();
    assert!((visits - 2.0 * slab.tau()).abs() < SIGMAS * sigma, "{visits}, {}", slab.tau());
    // Reciprocity: a slab transmits diffuse light alike from both sides.
    let (a, b) = (up.transmittance, down.transmittance);
    let sigma = a.standard_error.max(b.standard_error) * 2f64.sqrt();
    assert!((a.mean - b.mean).abs() < SIGMAS * sigma, "{a:?} {b:?}");
}

#[test]
fn no_light_is_trapped_in_a_dense_heap_of_overlapping_grains() {
    let period = [10.0, 10.0];
    let grains = packs::strewn(1400, DVec3::new(10.0, 20.0, 10.0), [0.5, 1.0], 31);
    let slab = Slab { grains, period, height: 21.0, eta: ETA };
    let measure = slab.measure(Illumination::Lambertian, 4000, 13);
    let visits = measure.visits.mean * 4000.0;
    assert!(visits > 2e4, "{visits}");
    assert_eq!(measure.trapped.mean, 0.0);
    assert!((measure.reflectance.mean + measure.transmittance.mean - 1.0).abs() < 1e-12);
    // Overlaps join grains: a visit makes more than the two events of a lone one.
    assert!(measure.interface_events.mean / measure.visits.mean > 2.05);
}

/// Visits = (total grain surface)/(4 x mean projected area of the hull) = pi N/6 for the cube.
#[test]
fn a_cube_lit_all_around_is_visited_pi_n_over_six_times() {
    let measure = LatticeCube::new(6, ETA).lit_all_around(40_000, 14);
    let expected = core::f64::consts::PI;
    assert!(measure.visits.agrees_with(expected, 0.0, SIGMAS), "{:?}", measure.visits);
    assert!(measure.interface_events.agrees_with(2.0 * expected, 0.0, SIGMAS));
    assert!(measure.radiance.agrees_with(0.5, 0.0, SIGMAS), "{:?}", measure.radiance);
    assert_eq!(measure.trapped.mean, 0.0);
}

#[test]
fn a_lattice_cube_under_the_sky_has_the_radiance_of_an_independent_walker() {
    let (side, radiance, _) = CUBE_RADIANCE[0];
    let measure = LatticeCube::new(side, ETA).seen_by_camera(256, 2, 15);
    assert!(measure.radiance.agrees_with(radiance, 0.0005, SIGMAS), "{:?}", measure.radiance);
    assert_eq!(measure.trapped.mean, 0.0);
}

/// The long checks, of the full profile only (`SNOWGRAIN_FULL=1`, see the README): about a minute of
/// both cores of a small machine.
#[test]
fn long_runs_trap_no_light_and_meet_the_reference_closely() {
    if std::env::var_os("SNOWGRAIN_FULL").is_none_or(|value| value != "1") {
        return;
    }
    let row = rows("sc", TableLight::Lambertian)[3];
    let slab = Slab::simple_cubic(row.layers(), ETA);
    check_identities(&slab, &check_row(&slab, Illumination::Lambertian, &row, 40_000));

    let (side, radiance, _) = CUBE_RADIANCE[0];
    let cube = LatticeCube::new(side, ETA).seen_by_camera(256, 40, 16);
    println!("cube {side}: {:?}", cube.radiance);
    assert!(cube.radiance.agrees_with(radiance, 0.0005, 3.0), "{:?}", cube.radiance);

    let grains = packs::strewn(1400, DVec3::new(10.0, 20.0, 10.0), [0.5, 1.0], 31);
    let heap = Slab { grains, period: [10.0; 2], height: 21.0, eta: ETA };
    let heap = heap.measure(Illumination::Lambertian, 400_000, 17);
    println!("heap: {} visits, trapped {:?}", heap.visits.mean * 4e5, heap.trapped);
    assert_eq!(heap.trapped.mean, 0.0);
}
