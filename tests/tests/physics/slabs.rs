//! Slabs that repeat for ever: exact identities and the table of an independent program.

use crate::{ETA, SIGMAS, assert_agrees, lattice, periodic, samples};
use snowgrain_accel::SimdLevel;
use snowgrain_geometry::Quantisation;
use snowgrain_grains::{
    Amount, DepositRule, DepositSettings, GrainField, LatticeKind, Radii, Snowfall,
};
use snowgrain_math::{DVec3, trig};
use snowgrain_optics::{Dielectric, sphere};
use snowgrain_render::World;
use snowgrain_render::measure::{Estimate, Incidence, SlabMeasure, SlabSettings, measure_slab};
use snowgrain_tests::reference::{SlabRow, TableLight, slab_rows};
use snowgrain_tests::slab::Illumination;
use snowgrain_tests::{packs, slab};

/// Grains of one radius between two level faces.
struct Slab {
    world: World,
    period: [f64; 2],
    top: f64,
    radius: f64,
    grains: f64,
}

impl Slab {
    fn simple_cubic(layers: u32) -> Self {
        let world = lattice(LatticeKind::Sc, [1, layers, 1], [true, false, true]);
        let top = f64::from(layers);
        Self { world, period: [1.0; 2], top, radius: 0.5, grains: f64::from(layers) }
    }

    /// (001) layers of the face-centred cubic lattice: an even number of them needs no memory, an
    /// odd one is packed in a period of one grain.
    fn face_centred_cubic(layers: u32) -> Self {
        let top = 1.0 + f64::from(layers - 1) * core::f64::consts::FRAC_1_SQRT_2;
        if layers.is_multiple_of(2) {
            let side = core::f64::consts::SQRT_2;
            let world = lattice(LatticeKind::Fcc, [1, layers / 2, 1], [true, false, true]);
            let grains = f64::from(2 * layers);
            return Self { world, period: [side; 2], top: top + 1e-3, radius: 0.5, grains };
        }
        let quantisation = Quantisation::for_grains(DVec3::ZERO, 0.5);
        let grains = packs::face_centred_cubic_layers(layers, 0.5)
            .iter()
            .map(|grain| quantisation.round(grain.center, grain.radius).unwrap())
            .collect();
        let world = periodic(&GrainField::new(quantisation, grains), [1.0; 2]);
        Self { world, period: [1.0; 2], top: top + 1e-3, radius: 0.5, grains: f64::from(layers) }
    }

    /// A level cut out of a deep pile of falling spheres that stop at their first contact, over a
    /// floor `width` radii wide: the grains above the lowest 30 radii that make this `tau`.
    fn stuck(tau: f64, width: f64) -> Self {
        let radius = 0.5e-3;
        let quantisation = Quantisation::for_grains(DVec3::ZERO, radius);
        let mut snow = Snowfall::on_level_floor(quantisation, [width * radius; 2]).unwrap();
        let period = snow.period().unwrap();
        // A fill of .15, and room for the rough top.
        let depth = 30.0 + 4.0 / 3.0 * tau / 0.15 + 50.0;
        snow.deposit(&DepositSettings {
            amount: Amount::Depth(depth * radius),
            radii: Radii::Uniform { mean: radius, variation: 0.0 },
            density: None,
            rule: Some(DepositRule::Stick),
            max_slope_degrees: 90.0,
            direction: DepositSettings::DOWN,
            area: None,
            seed: 5,
        })
        .unwrap();
        let mut grains = snow.into_field().into_grains();
        let lowest = (30.0 * radius / quantisation.quantum()) as i32;
        grains.retain(|grain| grain.center[1] >= lowest);
        grains.sort_unstable_by_key(|grain| grain.center[1]);
        let disc = core::f64::consts::PI * radius * radius;
        grains.truncate((tau * period[0] * period[1] / disc).round() as usize);
        for grain in &mut grains {
            grain.center[1] -= lowest - i32::from(grain.radius);
        }
        let field = GrainField::new(quantisation, grains);
        let (top, grains) = (field.bounds().max.y, field.len() as f64);
        assert!(top < depth * radius, "the pile is not deep enough");
        Self { world: periodic(&field, period), period, top, radius, grains }
    }

    fn tau(&self) -> f64 {
        let disc = core::f64::consts::PI * self.radius * self.radius;
        self.grains * disc / (self.period[0] * self.period[1])
    }

    fn solid_fraction(&self) -> f64 {
        self.tau() * 4.0 / 3.0 * self.radius / self.top
    }

    fn settings(&self, incidence: Incidence, paths: u64) -> SlabSettings {
        SlabSettings {
            top: self.top,
            bottom: 0.0,
            period: self.period,
            incidence,
            from_below: false,
            absorption_per_metre: 0.0,
            paths,
            seed: 6,
            level: SimdLevel::detect(),
        }
    }

    fn measure(&self, incidence: Incidence, paths: u64) -> SlabMeasure {
        measure_slab(&self.world, &self.settings(incidence, paths))
    }
}

/// The mean of what light from above and light from below do.
fn of_both_faces(above: Estimate, below: Estimate) -> Estimate {
    let variance =
        above.standard_error * above.standard_error + below.standard_error * below.standard_error;
    let mean = 0.5 * (above.mean + below.mean);
    Estimate { mean, standard_error: 0.5 * variance.sqrt() }
}

fn assert_nothing_lost(measure: &SlabMeasure) {
    let count = |fraction: Estimate| (fraction.mean * measure.paths as f64).round() as u64;
    assert_eq!(count(measure.reflectance) + count(measure.transmittance), measure.paths);
    assert_eq!(measure.trapped_paths, 0);
}

/// The identities of diffuse light, for the mean over both faces; each path's void and visits go
/// together, so that the chord's error is no more than the sum of theirs.
fn assert_identities(slab: &Slab, above: &SlabMeasure, below: &SlabMeasure) {
    let (tau, phi, radius) = (slab.tau(), slab.solid_fraction(), slab.radius);
    let b = sphere::absorption_enhancement(Dielectric { eta: ETA });
    let mean = |part: fn(&SlabMeasure) -> Estimate| of_both_faces(part(above), part(below));
    let visits = mean(|measure| measure.grain_visits);
    let events = mean(|measure| measure.interface_events);
    let ice = mean(|measure| measure.ice_path);
    let void = mean(|measure| measure.void_path);
    let chord = Estimate {
        mean: void.mean / visits.mean,
        standard_error: void.standard_error / visits.mean,
    };
    let expected_ice = 2.0 * tau * 4.0 / 3.0 * b * radius;
    let expected_chord = 4.0 / 3.0 * radius * (1.0 - phi) / phi;
    for (what, estimate, expected) in [
        ("visits", visits, 2.0 * tau),
        ("events", events, 4.0 * tau),
        ("ice path", ice, expected_ice),
        ("chord", chord, expected_chord),
    ] {
        // Grains are rounded to quanta, 4e-5 of their radius.
        assert_agrees(what, estimate, expected, 2e-4 * expected);
        let ratio = estimate.mean / expected;
        assert!((ratio - 1.0).abs() < 0.01, "{what}: {ratio} times what it should be");
    }
    let per_visit = events.mean / visits.mean;
    assert!((per_visit - 2.0).abs() < 0.002, "{per_visit} events a visit");
}

fn assert_row(what: &str, transmittance: Estimate, row: &SlabRow) {
    let off = transmittance.mean - row.transmittance;
    let sigma = transmittance.standard_error.max(row.standard_error) * 2f64.sqrt();
    println!("{what}, tau {}: T = {:.5}, table {}", row.tau, transmittance.mean, row.transmittance);
    assert!(off.abs() < (SIGMAS * sigma).max(0.004), "{what}: {transmittance:?} {row:?}");
}

/// About the same work at every depth, and standard errors of visits below .25 %.
fn paths_through(tau: f64) -> u64 {
    let visits = samples(6_000_000, 100_000_000) as f64;
    ((visits / (2.0 * tau)) as u64).clamp(160_000, 1_600_000)
}

#[test]
fn lattice_slabs_in_diffuse_light_obey_the_identities_and_the_table() {
    let sc = Slab::simple_cubic as fn(u32) -> Slab;
    for (packing, slab) in [("sc", sc), ("fcc", Slab::face_centred_cubic)] {
        let rows = slab_rows(packing, TableLight::Lambertian);
        for row in rows.iter().filter(|row| row.tau < 50.0 || crate::is_full()) {
            let slab = slab(row.layers());
            assert!((slab.tau() - row.tau).abs() < 1e-3, "{} {}", slab.tau(), row.tau);
            let measure = slab.measure(Incidence::Lambertian, paths_through(row.tau));
            assert_nothing_lost(&measure);
            assert_row(packing, measure.transmittance, row);
            assert_identities(&slab, &measure, &measure);
        }
    }
}

#[test]
fn slabs_in_parallel_light_agree_with_the_table() {
    let straight = Incidence::Collimated { zenith_degrees: 0.0 };
    let slanting = Incidence::Collimated { zenith_degrees: 60.0 };
    let paths = samples(200_000, 1_000_000);
    // The table does not say where around a lattice its slanting light comes from; around a deposit
    // it does not matter.
    let sc = |row: &SlabRow| Slab::simple_cubic(row.layers());
    let fcc = |row: &SlabRow| Slab::face_centred_cubic(row.layers());
    let stuck = |row: &SlabRow| Slab::stuck(row.tau, 200.0);
    for (packing, cosine, light, slab) in [
        ("sc", 1.0, straight, sc as fn(&SlabRow) -> Slab),
        ("fcc", 1.0, straight, fcc),
        ("bd_stick", 1.0, straight, stuck),
        ("bd_stick", 0.5, slanting, stuck),
    ] {
        let rows = slab_rows(packing, TableLight::Parallel(cosine));
        for row in rows.iter().filter(|row| row.tau < 10.0 || crate::is_full() && row.tau < 50.0) {
            let measure = slab(row).measure(light, paths);
            assert_nothing_lost(&measure);
            assert_row(&format!("{packing} {cosine}"), measure.transmittance, row);
        }
    }
}

/// Slanting light along x meets a lattice's rows end on: the oracle says what it finds there.
#[test]
fn a_lattice_in_slanting_light_agrees_with_the_oracle() {
    let zenith_degrees = 60.0f64;
    let (sin, cos) = trig::sin_cos(zenith_degrees.to_radians());
    let direction = Illumination::Collimated(DVec3::new(sin, -cos, 0.0));
    let oracle = slab::Slab::simple_cubic(7, ETA).measure(direction, samples(30_000, 300_000), 7);
    let light = Incidence::Collimated { zenith_degrees };
    let fast = Slab::simple_cubic(7).measure(light, samples(300_000, 3_000_000));
    assert_nothing_lost(&fast);
    for (what, fast, oracle) in [
        ("T", fast.transmittance, oracle.transmittance),
        ("visits", fast.grain_visits, oracle.visits),
        ("ice path", fast.ice_path, oracle.ice_length),
    ] {
        assert_agrees(what, fast, oracle.mean, SIGMAS * oracle.standard_error);
    }
}

#[test]
fn stick_deposits_obey_the_identities_and_the_table() {
    for row in slab_rows("bd_stick", TableLight::Lambertian) {
        let slab = Slab::stuck(row.tau, 100.0);
        let settings = slab.settings(Incidence::Lambertian, paths_through(row.tau));
        let above = measure_slab(&slab.world, &settings);
        let below = measure_slab(&slab.world, &SlabSettings { from_below: true, ..settings });
        assert_nothing_lost(&above);
        assert_nothing_lost(&below);
        assert_row("bd_stick", of_both_faces(above.transmittance, below.transmittance), &row);
        assert_identities(&slab, &above, &below);
        // Reciprocity: diffuse light is transmitted alike both ways.
        let (a, b) = (above.transmittance, below.transmittance);
        let sigma = a.standard_error.max(b.standard_error) * 2f64.sqrt();
        assert!((a.mean - b.mean).abs() < SIGMAS * sigma, "{a:?} {b:?}");
    }
}

/// What is neither reflected nor transmitted was absorbed along the ice path, 2 tau (4/3) B r.
#[test]
fn a_slab_absorbs_in_proportion_to_its_ice_path() {
    let slab = Slab::simple_cubic(7);
    let gamma = 2e-5 / slab.radius;
    let paths = samples(400_000, 4_000_000);
    let settings =
        SlabSettings { absorption_per_metre: gamma, ..slab.settings(Incidence::Lambertian, paths) };
    let measure = measure_slab(&slab.world, &settings);
    let absorbed = 1.0 - measure.reflectance.mean - measure.transmittance.mean;
    let b = sphere::absorption_enhancement(Dielectric { eta: ETA });
    let expected = gamma * 2.0 * slab.tau() * 4.0 / 3.0 * b * slab.radius;
    let error = gamma * measure.ice_path.standard_error;
    // The next order of the exponential: gamma times half the mean square of the ice path over its
    // mean, some 20 r.
    let tolerance = 20.0 * gamma * slab.radius * expected;
    let estimate = Estimate { mean: absorbed, standard_error: error };
    assert_agrees("absorbed", estimate, expected, tolerance);
}
