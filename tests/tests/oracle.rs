//! The oracle against closed forms and exact identities, before it judges anything else.
//!
//! Statistical tests accept 4 standard errors: each such comparison fails by chance once in
//! 16 000 seeds, and the seeds are fixed.

use snowgrain_geometry::Grain;
use snowgrain_math::sampler::{PathKey, numbers};
use snowgrain_math::{DVec3, frame};
use snowgrain_optics::{Dielectric, sphere};
use snowgrain_tests::picture::Picture;
use snowgrain_tests::statistics::estimate;
use snowgrain_tests::{
    EventKind, Oracle, OracleShape, OracleSurface, PathEnd, PinholeCamera, Search, packs,
};

const SIGMAS: f64 = 4.0;
const ETA: f64 = 1.31;

/// Start of a line of an isotropic field, on the sphere of `radius` around `center`.
fn isotropic_start(center: DVec3, radius: f64, key: PathKey) -> (DVec3, DVec3) {
    let [u, v, _] = numbers(key, 0).map(f64::from);
    let [_, u1, u2] = numbers(key, 1).map(f64::from);
    let y = 1.0 - 2.0 * u;
    let (sin, cos) = snowgrain_math::trig::sin_cos(core::f64::consts::TAU * v);
    let ring = (1.0 - y * y).max(0.0).sqrt();
    let outward = DVec3::new(ring * cos, y, ring * sin).normalize();
    (center + outward * radius, frame::cosine_hemisphere(-outward, [u1, u2]))
}

/// A heap of overlapping grains on a plane, around a cube and over a ball, with these albedos.
fn heap(albedo: DVec3, search: Search) -> Oracle {
    let grains = packs::strewn(300, DVec3::new(8.0, 4.0, 8.0), [0.3, 0.9], 11);
    let surfaces = [
        OracleShape::Plane { point: DVec3::ZERO, normal: DVec3::Y },
        OracleShape::cube(DVec3::new(3.0, 1.2, 3.0), 1.0),
        OracleShape::Sphere { center: DVec3::new(5.5, 2.0, 5.0), radius: 1.3 },
    ]
    .map(|shape| OracleSurface { shape, albedo });
    Oracle::new(&grains, &surfaces, ETA, search)
}

/// Start of a path above the heap, with Lambertian directions.
fn heap_start(key: PathKey) -> (DVec3, DVec3) {
    let [x, z, _] = numbers(key, 0).map(f64::from);
    let [_, u1, u2] = numbers(key, 1).map(f64::from);
    (DVec3::new(8.0 * x, 5.0, 8.0 * z), frame::cosine_hemisphere(-DVec3::Y, [u1, u2]))
}

#[test]
fn white_grains_and_white_surfaces_lose_nothing() {
    let oracle = heap(DVec3::ONE, Search::Cells);
    let mut bounces_in_snow = 0;
    for index in 0..4000 {
        let key = PathKey::new(1, index, 0);
        let (origin, direction) = heap_start(key);
        let path = oracle.trace(origin, direction, key, 2);
        assert!(path.escaped_direction().is_some(), "path {index}: {path:?}");
        assert_eq!(path.throughput, DVec3::ONE);
        bounces_in_snow += u64::from(path.diffuse_bounces > 0 && path.grain_visits > 0);
    }
    assert!(bounces_in_snow > 1000, "{bounces_in_snow}");
}

#[test]
fn cells_find_what_testing_every_grain_finds() {
    let albedo = DVec3::new(0.9, 0.5, 0.2);
    let (cells, brute) = (heap(albedo, Search::Cells), heap(albedo, Search::Brute));
    for index in 0..1500 {
        let key = PathKey::new(2, index, 0);
        let (origin, direction) = heap_start(key);
        assert_eq!(
            cells.trace_events(origin, direction, key, 2),
            brute.trace_events(origin, direction, key, 2)
        );
    }
}

#[test]
fn periodic_cells_find_what_many_periods_of_grains_find() {
    let period = [3.0, 4.0];
    let one = packs::strewn(25, DVec3::new(period[0], 5.0, period[1]), [0.3, 0.6], 5);
    let mut many = Vec::new();
    for i in -8..=8 {
        for j in -8..=8 {
            let shift = DVec3::new(f64::from(i) * period[0], 0.0, f64::from(j) * period[1]);
            many.extend(one.iter().map(|g| Grain { center: g.center + shift, ..*g }));
        }
    }
    let periodic = Oracle::new(&one, &[], ETA, Search::Periodic { period });
    let finite = Oracle::new(&many, &[], ETA, Search::Cells);
    let mut compared = 0;
    for index in 0..800 {
        let key = PathKey::new(3, index, 0);
        let [x, z, _] = numbers(key, 0).map(f64::from);
        let origin = DVec3::new(x * period[0], 6.0, z * period[1]);
        let (_, a) = periodic.trace_events(origin, -DVec3::Y, key, 1);
        let (_, b) = finite.trace_events(origin, -DVec3::Y, key, 1);
        // Rounding grows by a constant factor at each grain, so only the first events are compared.
        for (a, b) in a.iter().zip(&b).take(8) {
            assert_eq!(a.kind, b.kind, "path {index}");
            assert!((a.direction - b.direction).length() < 1e-6);
            assert!((a.position.y - b.position.y).abs() < 1e-6);
            compared += 1;
        }
    }
    assert!(compared > 2000, "{compared}");
}

#[test]
fn every_event_obeys_its_law_and_every_stretch_its_medium() {
    let oracle = heap(DVec3::splat(0.8), Search::Cells);
    for index in 0..400 {
        let key = PathKey::new(4, index, 0);
        let (origin, direction) = heap_start(key);
        let (_, events) = oracle.trace_events(origin, direction, key, 2);
        let (mut position, mut direction, mut in_ice) = (origin, direction, false);
        for event in events {
            let way = event.position - position;
            for i in 1..16 {
                let point = position + way * (f64::from(i) / 16.0);
                assert!(
                    way.length() < 1e-9 || oracle.is_ice(point) == in_ice,
                    "path {index}: {event:?} after {position}"
                );
            }
            assert!((way - direction * way.length()).length() < 1e-12, "a bent stretch");
            let turn = event.direction - direction;
            match event.kind {
                EventKind::ReflectInside | EventKind::ReflectOutside => {
                    let normal = turn.normalize();
                    assert!((normal.dot(direction) + normal.dot(event.direction)).abs() < 1e-9);
                }
                EventKind::Enter | EventKind::Leave => {
                    // Snell: n1 d1 - n2 d2 is along the normal, of the length that Fermat gives.
                    let (n1, n2) =
                        if event.kind == EventKind::Enter { (1.0, ETA) } else { (ETA, 1.0) };
                    let jump = event.direction * n2 - direction * n1;
                    let normal = jump.normalize();
                    let sine = |d: DVec3| d.cross(normal).length();
                    assert!((n1 * sine(direction) - n2 * sine(event.direction)).abs() < 1e-9);
                    in_ice = event.kind == EventKind::Enter;
                }
                EventKind::DiffuseInAir => assert!(!in_ice),
                EventKind::DiffuseInIce => assert!(in_ice),
            }
            assert!((event.direction.length() - 1.0).abs() < 1e-14);
            (position, direction) = (event.position, event.direction);
        }
    }
}

#[test]
fn a_lone_grain_scatters_as_its_closed_form_says() {
    for eta in [1.31, 1.32] {
        let grain = Grain { center: DVec3::new(0.3, -0.2, 0.1), radius: 0.7 };
        let oracle = Oracle::new(&[grain], &[], eta, Search::Brute);
        let ice = Dielectric { eta };
        let means = estimate(200_000, |index| {
            let key = PathKey::new(5, index, 0);
            let [u, v, _] = numbers(key, 0).map(f64::from);
            let (sin, cos) = snowgrain_math::trig::sin_cos(core::f64::consts::TAU * v);
            let place = DVec3::new(cos, 0.0, sin) * (u.sqrt() * grain.radius);
            let origin = grain.center + place + DVec3::new(0.0, 5.0, 0.0);
            let path = oracle.trace(origin, -DVec3::Y, key, 1);
            let order = path.interface_events - 1;
            let is = |p: u32| f64::from(u8::from(order == p));
            let cosine = -path.escaped_direction().map_or(0.0, |d| d.y);
            let events = f64::from(path.interface_events);
            let ice = path.ice_length / (4.0 / 3.0 * grain.radius);
            [is(0), is(1), is(2), is(3), is(4), is(5), cosine, ice, events]
        });
        let expected = [
            sphere::energy(ice, 0),
            sphere::energy(ice, 1),
            sphere::energy(ice, 2),
            sphere::energy(ice, 3),
            sphere::energy(ice, 4),
            sphere::energy(ice, 5),
            sphere::asymmetry(ice),
            sphere::absorption_enhancement(ice),
            2.0,
        ];
        for (k, (mean, value)) in means.iter().zip(expected).enumerate() {
            assert!(mean.agrees_with(value, 0.0, SIGMAS), "{eta}, {k}: {mean:?} against {value}");
        }
    }
}

/// In an isotropic field lines cross a body's surface in proportion to its area and fill a volume
/// evenly, whatever scatters them, if scattering is reciprocal and loses nothing: visits and void
/// path follow from the exposed area and the volume of the union.
#[test]
fn an_overlapping_pair_shows_the_area_and_the_volume_of_the_union() {
    let (radius, distance, bound) = (1.0f64, 1.2f64, 2.0f64);
    let center = |side: f64| DVec3::new(0.36, 0.48, 0.8) * (side * distance / 2.0);
    let pair = [-1.0, 1.0].map(|side| Grain { center: center(side), radius });
    let oracle = Oracle::new(&pair, &[], ETA, Search::Brute);
    let cap = radius - distance / 2.0;
    let pi = core::f64::consts::PI;
    let area = 2.0 * (4.0 * pi * radius * radius - 2.0 * pi * radius * cap);
    let volume =
        2.0 * (4.0 / 3.0 * pi * radius * radius * radius - pi * cap * cap * (radius - cap / 3.0));
    let outer_area = 4.0 * pi * bound * bound;
    let void = 4.0 * (4.0 / 3.0 * pi * bound * bound * bound - volume) / outer_area;
    let means = estimate(200_000, |index| {
        let key = PathKey::new(6, index, 0);
        let (origin, direction) = isotropic_start(DVec3::ZERO, bound, key);
        let path = oracle.trace(origin, direction, key, 2);
        let out = path.escaped_direction().unwrap();
        let along = path.last_position.dot(out);
        let outside = path.last_position.length_squared() - bound * bound;
        let last = -along + (along * along - outside).sqrt();
        let cosine = (path.last_position + out * last).dot(out) / bound;
        [
            f64::from(path.grain_visits),
            path.void_length + last,
            out.x,
            out.y,
            out.z,
            cosine,
            path.ice_length,
        ]
    });
    let expected = [area / outer_area, void, 0.0, 0.0, 0.0, 2.0 / 3.0];
    for (k, (mean, value)) in means.iter().zip(expected).enumerate() {
        assert!(mean.agrees_with(value, 0.0, SIGMAS), "{k}: {mean:?} against {value}");
    }
    // In ice the field cannot exceed n^2 times the one outside; it does exceed that of two grains
    // apart with the same volume, B = 1.2535, because light meets new ways out at the neck.
    let enhancement = means[6].mean / (4.0 * volume / outer_area);
    assert!(enhancement > 1.2535 && enhancement < ETA * ETA, "{enhancement}");
}

/// Ice that does not refract hides nothing: light from a grey cube comes out as from a bare one.
#[test]
fn a_mesh_inside_ice_of_index_one_looks_bare() {
    let center = DVec3::new(0.1, 0.2, -0.3);
    let surface =
        OracleSurface { shape: OracleShape::cube(center, 0.5), albedo: DVec3::new(0.7, 0.4, 0.05) };
    let grains = [
        Grain { center, radius: 1.2 },
        Grain { center: center + DVec3::new(0.6, 0.0, 0.0), radius: 0.3 },
    ];
    let throughput = |grains: &[Grain]| {
        let oracle = Oracle::new(grains, std::slice::from_ref(&surface), 1.0, Search::Brute);
        estimate(60_000, |index| {
            let key = PathKey::new(7, index, 0);
            let (origin, direction) = isotropic_start(center, 2.0, key);
            let path = oracle.trace(origin, direction, key, 2);
            let weight =
                path.escaped_direction().map_or(DVec3::ZERO, |d| path.throughput * (1.0 + d.y));
            [weight.x, weight.y, weight.z, f64::from(path.diffuse_bounces)]
        })
    };
    for (with, without) in throughput(&grains).iter().zip(throughput(&[])) {
        let sigma = (with.standard_error * with.standard_error
            + without.standard_error * without.standard_error)
            .sqrt();
        assert!((with.mean - without.mean).abs() < SIGMAS * sigma, "{with:?} {without:?}");
    }
    // A convex grey body: each line that meets it, its area over the bounding area, loses 1 - a.
    let met = 6.0 / (4.0 * core::f64::consts::PI * 4.0);
    let [red, ..] = throughput(&[]);
    assert!(red.agrees_with(1.0 - 0.3 * met, 0.0, SIGMAS), "{red:?}");
}

/// Roulette changes no mean: in a uniform field a convex body of albedo a sends back a.
#[test]
fn roulette_on_dark_surfaces_is_unbiased() {
    let shape = OracleShape::Sphere { center: DVec3::ZERO, radius: 1.0 };
    let surface = OracleSurface { shape, albedo: DVec3::new(0.03, 0.01, 0.0) };
    let oracle = Oracle::new(&[], &[surface], ETA, Search::Cells);
    let means = estimate(200_000, |index| {
        let key = PathKey::new(8, index, 0);
        let (origin, direction) = isotropic_start(DVec3::ZERO, 1.0, key);
        let path = oracle.trace(origin * 1.0001, direction, key, 2);
        let weight = path.escaped_direction().map_or(DVec3::ZERO, |_| path.throughput);
        let hit = f64::from(path.diffuse_bounces);
        [weight.x - 0.03 * hit - (1.0 - hit), weight.y - 0.01 * hit - (1.0 - hit)]
    });
    for mean in means {
        assert!(mean.agrees_with(0.0, 0.0, SIGMAS), "{mean:?}");
    }
}

#[test]
fn a_black_surface_ends_a_path_and_a_start_in_ice_stays_in_ice() {
    let shape = OracleShape::Plane { point: DVec3::ZERO, normal: DVec3::Y };
    let black = OracleSurface { shape, albedo: DVec3::ZERO };
    let grain = Grain { center: DVec3::new(0.0, 0.5, 0.0), radius: 1.0 };
    let oracle = Oracle::new(&[grain], &[black], ETA, Search::Cells);
    let path = oracle.trace(DVec3::new(0.0, 0.7, 0.0), -DVec3::Y, PathKey::new(9, 0, 0), 1);
    assert_eq!(path.end, PathEnd::Absorbed);
    assert_eq!((path.ice_length, path.interface_events, path.diffuse_bounces), (0.7, 0, 1));
}

/// A camera inside a uniform field sees 1 everywhere, and grey ice dims it as its length says.
#[test]
fn a_picture_in_a_uniform_field_is_uniform_and_absorption_dims_it() {
    let oracle = heap(DVec3::ONE, Search::Cells);
    let camera =
        PinholeCamera::new(DVec3::new(12.0, 6.0, 4.0), DVec3::splat(4.0), DVec3::Y, 0.7, [16, 12]);
    let one: fn(DVec3) -> DVec3 = |_| DVec3::ONE;
    let white = Picture {
        oracle: &oracle,
        camera,
        width: 16,
        seed: 3,
        absorption: 0.0,
        light: one,
        backdrop: one,
    };
    let grey = Picture { absorption: 0.2, ..white };
    let pixels: Vec<u32> = (0..16 * 12).collect();
    for channel in white.mean(&pixels, 8) {
        assert_eq!((channel.mean, channel.standard_error), (1.0, 0.0));
    }
    let dimmed = grey.mean(&pixels, 8)[0].mean;
    assert!(dimmed > 0.0 && dimmed < 0.8, "{dimmed}");
}
