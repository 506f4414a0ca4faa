//! One grain in parallel light.

use crate::{ETA, assert_agrees, samples, world};
use snowgrain_accel::{GrainGrid, Packing, SimdLevel, Surfaces};
use snowgrain_geometry::Quantisation;
use snowgrain_math::sampler::{PathKey, numbers};
use snowgrain_math::{DVec3, Ray, trig};
use snowgrain_optics::{Dielectric, sphere};
use snowgrain_render::measure::Estimate;
use snowgrain_render::transport::{NewPath, PathEnd, PathResult, PathSource, trace};

const RADIUS: f64 = 0.7e-3;

/// Rays straight down over the disc of a grain at the origin; sums of numbers per path and of
/// their squares.
struct Beam<F, const K: usize> {
    next: u64,
    end: u64,
    values: F,
    sums: [[f64; 2]; K],
}

impl<F: Fn(&PathResult) -> [f64; K], const K: usize> PathSource for Beam<F, K> {
    type Tag = ();

    fn next_path(&mut self) -> Option<NewPath<()>> {
        if self.next == self.end {
            return None;
        }
        let key = PathKey::new(3, self.next, 0);
        self.next += 1;
        let [u, v, _] = numbers(key, 0).map(f64::from);
        let (sin, cos) = trig::sin_cos(core::f64::consts::TAU * v);
        let origin = DVec3::new(cos, 0.0, sin) * (u.sqrt() * RADIUS) + DVec3::Y * (3.0 * RADIUS);
        Some(NewPath { tag: (), ray: Ray::new(origin, -DVec3::Y), key, event: 1 })
    }

    fn finish(&mut self, (): (), path: &PathResult) {
        for (sum, value) in self.sums.iter_mut().zip((self.values)(path)) {
            sum[0] += value;
            sum[1] += value * value;
        }
    }
}

/// Means over `paths` paths of the numbers that `values` gives for each.
fn means<const K: usize>(
    eta: f64,
    paths: u64,
    values: impl Fn(&PathResult) -> [f64; K],
) -> [Estimate; K] {
    let quantisation = Quantisation::for_grains(DVec3::ZERO, RADIUS);
    let grain = quantisation.round(DVec3::ZERO, RADIUS).unwrap();
    let grid =
        GrainGrid::build(quantisation, &[grain], &Surfaces::default(), Packing::Fast).unwrap();
    let mut world = world(grid);
    world.eta = eta;
    let mut beam = Beam { next: 0, end: paths, values, sums: [[0.0; 2]; K] };
    trace(&world, SimdLevel::detect(), &mut beam);
    beam.sums.map(|[sum, squares]| {
        let n = paths as f64;
        let mean = sum / n;
        let variance = (squares / n - mean * mean).max(0.0);
        Estimate { mean, standard_error: (variance / (n - 1.0)).sqrt() }
    })
}

/// Index, g, E0 ... E5, B of section 1 of the project's physics (mean Fresnel reflectance redrawn
/// at each interface).
const TABLE: [[f64; 9]; 2] = [
    [1.31, 0.78166, 0.06274, 0.88805, 0.04141, 0.00523, 0.00140, 0.00054, 1.2535],
    [1.32, 0.77417, 0.06434, 0.88517, 0.04250, 0.00537, 0.00143, 0.00055, 1.2578],
];

#[test]
fn a_grain_scatters_as_its_closed_form_and_the_table_say() {
    for [eta, g, energies @ .., b] in TABLE {
        let ice = Dielectric { eta };
        let [order0, order1, order2, order3, order4, order5, cosine, chord, events] =
            means(eta, samples(2_000_000, 20_000_000), |path| {
                let PathEnd::Escaped(ray) = path.end else { panic!("{path:?}") };
                let order = path.interface_events - 1;
                let is = |p: u32| f64::from(u8::from(order == p));
                let chord = path.ice_length / (4.0 / 3.0 * RADIUS);
                let cosine = -ray.direction.y;
                let events = f64::from(path.interface_events);
                [is(0), is(1), is(2), is(3), is(4), is(5), cosine, chord, events]
            });
        let orders = [order0, order1, order2, order3, order4, order5];
        for (order, (measured, expected)) in (0..).zip(orders.into_iter().zip(energies)) {
            let closed = sphere::energy(ice, order);
            assert!((closed - expected).abs() < 0.0005, "E{order} of the closed form: {closed}");
            assert_agrees(&format!("E{order}"), measured, closed, 0.0);
        }
        assert!((sphere::asymmetry(ice) - g).abs() < 0.0005);
        assert_agrees("g", cosine, sphere::asymmetry(ice), 0.0);
        assert!((sphere::absorption_enhancement(ice) - b).abs() < 0.0005);
        // Radii are rounded to quanta, 4e-5 of them.
        assert_agrees("B", chord, sphere::absorption_enhancement(ice), 1e-4);
        assert_agrees("events a visit", events, 2.0, 0.0);
    }
}

/// Index, g and B of grains in denser surroundings, which reflect all light at grazing angles from
/// outside: ice in water and air in ice (`wet_relative_index.csv`; B below 1 is the index squared).
const IN_DENSER: [[f64; 3]; 2] = [[0.98275, 0.99617, 0.9658], [0.76336, 0.71251, 0.5827]];

#[test]
fn a_grain_in_denser_surroundings_scatters_as_its_closed_form_and_the_table_say() {
    for [eta, g, b] in IN_DENSER {
        let medium = Dielectric { eta };
        assert!((sphere::asymmetry(medium) - g).abs() < 0.0005);
        assert!((sphere::absorption_enhancement(medium) - b).abs() < 0.0005);
        let [cosine, chord] = means(eta, samples(2_000_000, 20_000_000), |path| {
            let PathEnd::Escaped(ray) = path.end else { panic!("{path:?}") };
            [-ray.direction.y, path.ice_length / (4.0 / 3.0 * RADIUS)]
        });
        assert_agrees("g", cosine, sphere::asymmetry(medium), 0.0);
        assert_agrees("B", chord, sphere::absorption_enhancement(medium), 1e-4);
    }
}

/// 1 - w = (4/3) gamma r B where little is absorbed.
#[test]
fn a_grain_absorbs_as_much_as_its_enhancement_says() {
    let gamma = 2e-4 / RADIUS;
    let [absorbed] = means(ETA, samples(1_000_000, 10_000_000), |path| {
        [1.0 - trig::exp(-gamma * path.ice_length)]
    });
    let b = sphere::absorption_enhancement(Dielectric { eta: ETA });
    let expected = 4.0 / 3.0 * gamma * RADIUS * b;
    // The next order of the exponential: half of gamma times a chord of 1.67 r and its variance.
    assert_agrees("1 - w", absorbed, expected, 2.5e-4 * expected);
}
